# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything visible at one moment: things with triangles, lights, and notes on the rest."""

import hashlib
from dataclasses import dataclass, field

import numpy as np

from ..fit.rigid import axes_of, split_matrix
from ..format.names import plain
from . import limits
from . import mesh as meshes
from .checks import finite
from .motion import instance_key

SOLID = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# Types that are never visible themselves. The surfaces of curves, texts and metaballs are instances
# of meshes.
UNSEEN = SOLID | {"EMPTY", "ARMATURE", "LATTICE", "CAMERA", "SPEAKER", "LIGHT", "LIGHT_PROBE"}
# Triangles whose area is a smaller fraction of their squared size are ignored.
NO_AREA = 1e-12


@dataclass
class Look:
    """What a material needs from a mesh: a uv map ("" for the render uv map, None for none), and whether
    it has a texture."""

    uv_map: str | None
    is_textured: bool


@dataclass
class Part:
    """Triangles of one material: the file's path in the scene and the `bpy` material, or None."""

    filename: str
    material: object
    smooth: bool


@dataclass
class Thing:
    """A thing with triangles: its `placement` (pivot, up, right), the rest of its transform (`shape`,
    baked into its files), the lower and upper corner of the `box` around the contents of its files,
    and, if its vertices may move in its own space, a hash of them (`outline`). If it shines, its light
    belongs to the light group `group`."""

    key: tuple
    name: str
    sources: list
    placement: np.ndarray
    shape: np.ndarray
    parts: list
    box: np.ndarray
    outline: bytes | None
    group: str = ""

    @property
    def subject(self):
        """What notes call it."""
        return f'object "{self.name}"'

    @property
    def diagonal(self):
        """Length of the diagonal of its box."""
        return float(np.linalg.norm(self.box[1] - self.box[0]))

    @property
    def center(self):
        """The middle of its box in world space."""
        placement = self.placement
        return placement[:3] + axes_of(placement[3:6], placement[6:9]) @ self.box.mean(axis=0)


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
    """Everything that was found."""

    things: list = field(default_factory=list)
    lamps: list = field(default_factory=list)


class Collector:
    """Collects the contents of an evaluated scene; meshes go to `store(name, arrays) -> filename`.

    `look_of(material)` returns the `Look` of a material, or None if it is invisible. `is_blurred`
    tells whether the shutter is open for longer than a moment.
    """

    def __init__(self, store, look_of, is_blurred, report):
        self._store = store
        self._look_of = look_of
        self._is_blurred = is_blurred
        self._report = report
        self._known = {}
        self._noted = set()

    def take_stock(self, depsgraph):
        """Returns the things and lights of `depsgraph` in their current state.

        # Errors `ValueError` if a position is not finite.
        """
        found = Inventory()
        layer = depsgraph.view_layer
        override = layer.material_override
        for instance in depsgraph.object_instances:
            thing = instance.object
            self._note_limits(instance, layer)
            if not instance.show_self:
                continue
            if thing.type == "MESH" and layer.use_solid:
                found.things += self._solid(instance, override)
            elif thing.type == "LIGHT":
                found.lamps += self._lamp(instance)
            elif thing.type not in UNSEEN and not limits.is_empty(thing):
                kind = thing.type.lower().replace("_", " ")
                self._report.note(f'object "{thing.name}"', f"{kind} objects are not carried")
        return found

    def _note_limits(self, instance, layer):
        """Notes the settings that slo-rt lacks, once for all instances of an object."""
        thing = instance.object
        what = thing.name, instance.show_self, instance.show_particles
        if what in self._noted:
            return
        self._noted.add(what)
        if instance.show_particles and layer.use_strand:
            limits.note_particles(thing, self._report)
        if instance.show_self and thing.type in SOLID | {"LIGHT"}:
            limits.note_object(thing, layer, self._report)
            if self._is_blurred:
                limits.note_blur(thing, self._report)

    def _lamp(self, instance):
        thing = instance.object
        matrix = _matrix(instance)
        if thing.data.type != "POINT" and meshes.is_flat(matrix[:3, :3]):
            self._note_nothing(thing)
            return []
        return [
            Lamp(
                key=instance_key(instance),
                name=thing.name,
                sources=_sources(instance),
                light=thing.data.original,
                matrix=matrix,
                camera_visible=thing.visible_camera,
                group=_group(thing),
            )
        ]

    def _note_nothing(self, thing):
        subject = "light" if thing.type == "LIGHT" else "object"
        self._report.note(f'{subject} "{thing.name}"', "is scaled to nothing and left out")

    def _solid(self, instance, override):
        thing = instance.object
        placement, shape = split_matrix(_matrix(instance))
        if np.allclose(shape, np.eye(3), rtol=0.0, atol=1e-6):
            shape = np.eye(3)
        key = self._shape_key(thing, shape)
        if key not in self._known:
            self._known[key] = self._files(thing, shape, override)
        parts, box, outline = self._known[key]
        if not parts:
            return []
        return [
            Thing(
                key=instance_key(instance),
                name=thing.name,
                sources=_sources(instance),
                placement=placement,
                shape=shape,
                parts=parts,
                box=box,
                outline=outline,
                group=_group(thing),
            )
        ]

    @staticmethod
    def _shape_key(thing, shape):
        materials = tuple(
            slot.material.name_full if slot.material else "" for slot in thing.material_slots
        )
        return thing.data.as_pointer(), materials, tuple(np.round(shape, 6).ravel())

    def _files(self, thing, shape, override):
        """Returns the parts of a thing, its box, and its outline."""
        nothing = [], np.zeros((2, 3)), None
        mesh = thing.to_mesh()
        if mesh is None:
            return nothing
        try:
            if not meshes.has_faces(mesh):
                return nothing
            materials = materials_of(thing, mesh)
            if override:
                materials = [override] * len(materials)
            scale = None if np.array_equal(shape, np.eye(3)) else shape
            pieces = self._pieces(thing.name, meshes.Triangles(mesh, scale), materials)
            outline = _hash(mesh) if may_deform(thing) else None
        finally:
            thing.to_mesh_clear()
        if not pieces:
            return nothing
        for _, _, arrays in pieces:
            for what in ("vertices", "uvs", "normals"):
                array = getattr(arrays, what)
                if array is not None:
                    finite(array, f'object "{thing.name}"', f"a number of its {what}")
        box = _box([arrays for _, _, arrays in pieces])
        if all(_has_no_area(arrays, box) for _, _, arrays in pieces):
            self._note_nothing(thing)
            return nothing
        parts = [Part(self._store(n, arrays), m, arrays.smooth) for n, m, arrays in pieces]
        return parts, box, outline

    def _pieces(self, name, triangles, materials):
        """Returns `(name, material, arrays)` of the triangles of each visible material."""
        first_like = np.array([materials.index(material) for material in materials])
        material_index = first_like[np.clip(triangles.material, 0, len(materials) - 1)]
        used = np.unique(material_index)
        pieces = []
        for index in used:
            material = materials[index]
            look = self._look_of(material)
            if look is None:
                continue
            arrays, piece_name = triangles.arrays(look.uv_map, look.is_textured), name
            if len(used) > 1:
                arrays = meshes.part(arrays, material_index == index)
                piece_name = f"{name}_{material.name if material else index}"
            pieces.append((piece_name, material, arrays))
        return pieces


def _sources(instance):
    """Returns the objects that an instance's motion depends on."""
    parent = [instance.parent.original] if instance.parent else []
    return [instance.object.original, *parent]


def _group(thing):
    """Returns the name of an object's light group as a word, or nothing."""
    return plain(thing.lightgroup) if thing.lightgroup else ""


def _box(pieces):
    """Returns the lower and upper corner of the box around the vertices of `MeshArrays`."""
    low = np.min([arrays.vertices.min(axis=0) for arrays in pieces], axis=0)
    high = np.max([arrays.vertices.max(axis=0) for arrays in pieces], axis=0)
    return np.array([low, high], np.float64)


def _matrix(instance):
    subject = "light" if instance.object.type == "LIGHT" else "object"
    matrix = np.array(instance.matrix_world, np.float64)
    return finite(matrix, f'{subject} "{instance.object.name}"')


def _has_no_area(triangles, box):
    """Whether no triangle has an area, for example if the thing is scaled to a point or a line."""
    a, b, c = (triangles.vertices[triangles.faces[:, i]].astype(np.float64) for i in range(3))
    size = np.linalg.norm(box[1] - box[0])
    doubled = np.linalg.norm(np.cross(b - a, c - a), axis=1).max()
    return not doubled > NO_AREA * size * size


def may_deform(thing):
    """Whether the vertices of an object may move in its own space from frame to frame."""
    original = thing.original
    data = original.data
    shape_keys = getattr(data, "shape_keys", None)
    return bool(original.type != "MESH" or original.modifiers or shape_keys or data.animation_data)


def outlines(depsgraph, keys):
    """Returns hashes of the current vertices of the things with these keys."""
    found = {}
    for instance in depsgraph.object_instances:
        key = instance_key(instance) if instance.object.type == "MESH" else None
        if key in keys:
            found[key] = _hash(instance.object.to_mesh())
            instance.object.to_mesh_clear()
    return found


def _hash(mesh):
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", vertices)
    return hashlib.blake2b(vertices, digest_size=16).digest()


def materials_of(thing, mesh):
    """Returns the materials of a thing by index, at least one; None for an empty slot."""
    slots = [slot.material for slot in thing.material_slots]
    inner = list(mesh.materials)
    materials = [
        slots[i] if i < len(slots) else inner[i] for i in range(max(len(slots), len(inner)))
    ]
    return [material.original if material else None for material in materials] or [None]
