# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything visible at one moment: things with triangles, lights, and notes on the rest."""

from dataclasses import dataclass, field

import numpy as np

from ..fit.rigid import FLAT, split_matrix
from ..format.names import plain
from . import limits
from . import mesh as meshes
from .bending import Bending
from .checks import finite
from .places import Places

SOLID = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# Types that are never visible themselves. The surfaces of curves, texts and metaballs are instances
# of meshes.
UNSEEN = SOLID | {"EMPTY", "ARMATURE", "LATTICE", "CAMERA", "SPEAKER", "LIGHT", "LIGHT_PROBE"}
# Triangles whose area is a smaller fraction of their squared size are ignored.
NO_AREA = 1e-12
NOTHING = "is scaled to nothing and left out"


@dataclass
class Look:
    """What a material needs from a mesh: a uv map ("" for the render uv map, None for none), and whether
    it has a texture."""

    uv_map: str | None
    is_textured: bool


@dataclass
class Part:
    """Triangles of one material: the `bpy` material, or None, and whether they are smooth. `filename` is
    the file's path in the scene; `shapes`, of a mesh that changes its shape, holds times in frames
    and the paths of their files."""

    material: object
    smooth: bool
    filename: str | None = None
    shapes: list | None = None


@dataclass
class Original:
    """What things that look alike show: `parts`; the lower and upper corner of the `box` around them, in
    the space of the mesh; and how large the triangles are at most across each axis (`areas`). If
    it may change its shape, `bending` follows it."""

    name: str
    parts: list
    box: np.ndarray
    areas: np.ndarray
    bending: object = None

    @property
    def reach(self):
        """How far it extends along each axis (3,)."""
        return np.abs(self.box).max(axis=0)


@dataclass
class Thing:
    """A thing with triangles: its `placement` (pivot, up, right, scale), which shows its `original` in
    world space. If it shines, its light belongs to the light group `group`. An instance hangs in the
    space of its instancer (`frame`), by its `local_placement`, if it is sheared in world space but not
    there."""

    key: tuple
    name: str
    sources: list
    matrix: np.ndarray
    placement: np.ndarray
    rest: np.ndarray
    original: Original
    group: str = ""
    is_instance: bool = False
    frame: str | None = None
    local_placement: np.ndarray | None = None

    @property
    def subject(self):
        """What notes call it."""
        return f'object "{self.name}"'

    @property
    def parts(self):
        """Its triangles by material."""
        return self.original.parts


@dataclass
class Lamp:
    """A light and its matrix to world space, which consists of its `placement` (pivot, up, right) and
    the rest of its transform (`shape`). `group` is its light group."""

    key: tuple
    name: str
    sources: list
    light: object
    matrix: np.ndarray
    camera_visible: bool = False
    group: str = ""
    placement: np.ndarray = None
    shape: np.ndarray = None

    def __post_init__(self):
        if not meshes.is_flat(self.matrix[:3, :3]):
            self.placement, self.shape = split_matrix(self.matrix)
            return
        # A point that is scaled to nothing is a point.
        self.placement = np.concatenate([self.matrix[:3, 3], (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
        self.shape = np.eye(3)

    @property
    def subject(self):
        """What notes call it."""
        return f'light "{self.name}"'

    @property
    def local(self):
        """The matrix to the space in which key frames move it."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.shape
        return matrix


@dataclass
class Inventory:
    """Everything that was found: the keys of all visible instances, things, things that are scaled to
    `nothing`, and lights."""

    keys: list = field(default_factory=list)
    things: list = field(default_factory=list)
    nothing: list = field(default_factory=list)
    lamps: list = field(default_factory=list)


class Collector:
    """Collects the contents of an evaluated scene; meshes go to `store(name, arrays) -> filename`.

    `look_of(material)` returns the `Look` of a material, or None if it is invisible. `is_blurred`
    tells whether the shutter is open for longer than a moment. `may_bend(name)` tells whether the
    mesh of the object with this full name may change its shape.
    """

    def __init__(self, store, look_of, is_blurred, may_bend, report):
        self._store = store
        self._look_of = look_of
        self._is_blurred = is_blurred
        self._may_bend = may_bend
        self._report = report
        self._known = {}  # originals by what they have in common
        self._looks = {}  # originals by object, data and what is done to vertices
        self._names = {}
        self._parents = {}
        self._noted = set()

    def take_stock(self, depsgraph):
        """Returns the things and lights of `depsgraph` in their current state. Things that are scaled to
        nothing are `found.nothing`.

        # Errors `ValueError` if a position is not finite.
        """
        found = Inventory()
        layer = depsgraph.view_layer
        places = Places(depsgraph)
        for row, instance in enumerate(depsgraph.object_instances):
            thing, is_shown = instance.object, places.shown[row]
            self._note_limits(thing, is_shown, places.has_particles[row], layer)
            if not is_shown:
                continue
            original, key, sources = self._identity(thing, instance)
            found.keys.append(key)
            kind = thing.type
            if kind == "MESH" and layer.use_solid:
                shown = self._original(thing, original, places, row, layer.material_override)
                if shown is not None:
                    places.check(row, thing)
                    found.things.append(_thing(places, row, key, thing.name, sources, *shown))
            elif kind == "LIGHT":
                places.check(row, thing)
                found.lamps += self._lamp(thing, key, sources, places.matrices[row])
            elif kind not in UNSEEN and not limits.is_empty(thing):
                kind = kind.lower().replace("_", " ")
                self._report.note(f'object "{thing.name}"', f"{kind} objects are not carried")
        _set_nothing_aside(found)
        return found

    def _identity(self, thing, instance):
        """Returns the original object, the key as `instance_key`, and the objects that an instance's motion
        depends on."""
        original = thing.original
        pointer = original.as_pointer()
        if pointer not in self._names:
            self._names[pointer] = original.name_full
        name = self._names[pointer]
        if not instance.is_instance:
            return original, (name, "", ()), [original]
        parent = instance.parent
        pointer = parent.as_pointer()
        if pointer not in self._parents:
            self._parents[pointer] = parent.original, parent.original.name_full
        parent, parent_name = self._parents[pointer]
        return original, (name, parent_name, tuple(instance.persistent_id)), [original, parent]

    def _note_limits(self, thing, is_shown, has_particles, layer):
        """Notes the settings that slo-rt lacks, once for all instances of an object."""
        what = thing.name, is_shown, has_particles
        if what in self._noted:
            return
        self._noted.add(what)
        if has_particles and layer.use_strand:
            limits.note_particles(thing, self._report)
        if is_shown and thing.type in SOLID | {"LIGHT"}:
            limits.note_object(thing, layer, self._report)
            if self._is_blurred:
                limits.note_blur(thing, self._report)

    def _lamp(self, thing, key, sources, matrix):
        if thing.data.type != "POINT" and meshes.is_flat(matrix[:3, :3]):
            self._report.note(f'light "{thing.name}"', NOTHING)
            return []
        return [
            Lamp(
                key=key,
                name=thing.name,
                sources=sources,
                light=thing.data.original,
                matrix=matrix,
                camera_visible=thing.visible_camera,
                group=_group(thing),
            )
        ]

    def _original(self, thing, original, places, row, override):
        """Returns what an instance shows and its light group; None for nothing."""
        pointers = original.as_pointer(), thing.data.as_pointer(), places.codes[row]
        if pointers not in self._looks:
            rest = places.rests[row]
            key = (*_alike(thing), rest.tobytes())
            if key not in self._known:
                self._known[key] = self._read(thing, rest, override)
            shown = self._known[key]
            self._looks[pointers] = None if shown is None else (shown, _group(thing))
        return self._looks[pointers]

    def _read(self, thing, rest, override):
        """Returns the `Original` of a thing, or None if nothing of it is visible."""
        mesh = thing.to_mesh()
        if mesh is None:
            return None
        try:
            if not meshes.has_faces(mesh):
                return None
            materials = materials_of(thing, mesh)
            if override:
                materials = [override] * len(materials)
            rest = None if np.array_equal(rest, np.eye(3)) else rest
            pieces = self._pieces(thing.name, meshes.Triangles(mesh, rest), materials)
            bending = None
            if pieces and self._may_bend(thing.original.name_full):
                bending = self._bending(thing.name, mesh, rest, materials)
        finally:
            thing.to_mesh_clear()
        if not pieces:
            return None
        all_arrays = [arrays for _, _, arrays in pieces]
        for arrays in all_arrays:
            for what in ("vertices", "uvs", "normals"):
                array = getattr(arrays, what)
                if array is not None:
                    finite(array, f'object "{thing.name}"', f"a number of its {what}")
        box = _box(all_arrays)
        areas = np.max([_areas(arrays) for arrays in all_arrays], axis=0)
        parts = [Part(material, arrays.smooth) for _, material, arrays in pieces]
        if bending:
            bending.begin(pieces, box)
        else:
            for part, (name, _, arrays) in zip(parts, pieces):
                part.filename = self._store(name, arrays)
        return Original(thing.name, parts, box, areas, bending)

    def bending(self, thing, rest, override):
        """Returns a `Bending` of an evaluated object whose shear changes, and its parts."""
        mesh = thing.to_mesh()
        try:
            materials = materials_of(thing, mesh)
            if override:
                materials = [override] * len(materials)
            pieces = self._pieces(thing.name, meshes.Triangles(mesh, rest), materials)
            bending = self._bending(thing.name, mesh, rest, materials)
            bending.begin(pieces, _box([arrays for _, _, arrays in pieces]))
            shape = meshes.read_shape(mesh)
        finally:
            thing.to_mesh_clear()
        return bending, [Part(material, arrays.smooth) for _, material, arrays in pieces], shape

    def _bending(self, name, mesh, rest, materials):
        triangles = meshes.Triangles(mesh, rest, bends=True)
        skins = []
        for piece, _, look, chosen in self._visible(name, triangles, materials):
            skins.append((piece, triangles.skin(look.uv_map, look.is_textured, chosen)))
        return Bending(name, meshes.topology(mesh), skins)

    def _pieces(self, name, triangles, materials):
        """Returns `(name, material, arrays)` of the triangles of each visible material."""
        pieces = []
        for piece, material, look, chosen in self._visible(name, triangles, materials):
            arrays = triangles.arrays(look.uv_map, look.is_textured)
            if chosen is not None:
                arrays = meshes.part(arrays, chosen)
            pieces.append((piece, material, arrays))
        return pieces

    def _visible(self, name, triangles, materials):
        """Yields name, material, look and triangles (m,) of each visible material, None for all triangles."""
        first_like = np.array([materials.index(material) for material in materials])
        material_index = first_like[np.clip(triangles.material, 0, len(materials) - 1)]
        used = np.unique(material_index)
        for index in used:
            material = materials[index]
            look = self._look_of(material)
            if look is None:
                continue
            if len(used) > 1:
                piece = f"{name}_{material.name if material else index}"
                yield piece, material, look, material_index == index
            else:
                yield name, material, look, None


def _thing(places, row, key, name, sources, original, group):
    """Returns the `Thing` of an instance."""
    return Thing(
        key,
        name,
        sources,
        places.matrices[row],
        places.placements[row],
        places.rests[row],
        original,
        group,
        bool(key[1]),
        places.frames.get(row),
        places.local.get(row),
    )


def _alike(thing):
    """Returns what things that look alike have in common."""
    materials = tuple(
        slot.material.name_full if slot.material else "" for slot in thing.material_slots
    )
    return thing.data.as_pointer(), materials


def _set_nothing_aside(found):
    """Moves things whose triangles have no area to `found.nothing`."""
    if not found.things:
        return
    placements = np.array([thing.placement for thing in found.things])
    areas = np.array([thing.original.areas for thing in found.things])
    boxes = np.array([thing.original.box for thing in found.things])
    linear = np.array([thing.matrix[:3, :3] for thing in found.things])
    lengths = np.linalg.norm(linear, axis=1)
    scale = np.where(lengths > FLAT * lengths.max(axis=1, keepdims=True), placements[:, 9:], 0.0)
    across = (areas * scale[:, (1, 2, 0)] * scale[:, (2, 0, 1)]).max(axis=1)
    size = np.linalg.norm((boxes[:, 1] - boxes[:, 0]) * scale, axis=1)
    is_nothing = ~(across > NO_AREA * size * size)
    for row in np.flatnonzero(is_nothing):
        found.nothing.append(found.things[row])
    found.things = [thing for thing, empty in zip(found.things, is_nothing) if not empty]


def _group(thing):
    """Returns the name of an object's light group as a word, or nothing."""
    return plain(thing.lightgroup) if thing.lightgroup else ""


def _box(pieces):
    """Returns the lower and upper corner of the box around the vertices of `MeshArrays`."""
    low = np.min([arrays.vertices.min(axis=0) for arrays in pieces], axis=0)
    high = np.max([arrays.vertices.max(axis=0) for arrays in pieces], axis=0)
    return np.array([low, high], np.float64)


def _areas(triangles):
    """Returns the largest double area of a triangle across each axis (3,)."""
    a, b, c = (triangles.vertices[triangles.faces[:, i]].astype(np.float64) for i in range(3))
    return np.abs(np.cross(b - a, c - a)).max(axis=0)


def materials_of(thing, mesh):
    """Returns the materials of a thing by index, at least one; None for an empty slot."""
    slots = [slot.material for slot in thing.material_slots]
    inner = list(mesh.materials)
    materials = [
        slots[i] if i < len(slots) else inner[i] for i in range(max(len(slots), len(inner)))
    ]
    return [material.original if material else None for material in materials] or [None]
