# SPDX-License-Identifier: GPL-3.0-or-later
"""What is visible at one moment: things with triangles, lights, and what is neither."""

import hashlib
from dataclasses import dataclass, field

import numpy as np

from ..fit.rigid import axes_of, split_matrix
from . import limits
from . import mesh as meshes
from .checks import finite
from .motion import instance_key

SOLID = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
# What is never seen itself. The surfaces of curves, texts and metaballs are instances of meshes.
UNSEEN = SOLID | {"EMPTY", "ARMATURE", "LATTICE", "CAMERA", "SPEAKER", "LIGHT", "LIGHT_PROBE"}
# Triangles with a smaller part of their size squared as area are none.
NO_AREA = 1e-12


@dataclass
class Look:
    """What a material wants of a mesh: a uv map, "" that for rendering, None for none; and whether a
    texture lies on it."""

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
    """A thing with triangles: where it is (`placement`: pivot, up, right), what is left of its
    transform (`shape`, baked into its files), the low and the high corner of the `box` around what
    is in its files, and, where its vertices may move in its own space, a hash of them
    (`outline`)."""

    key: tuple
    name: str
    sources: list
    placement: np.ndarray
    shape: np.ndarray
    parts: list
    box: np.ndarray
    outline: bytes | None

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
    """A light and its matrix to world space."""

    key: tuple
    name: str
    light: object
    matrix: np.ndarray


@dataclass
class Inventory:
    """All that was found."""

    things: list = field(default_factory=list)
    lamps: list = field(default_factory=list)


class Collector:
    """Takes stock of an evaluated scene; meshes go to `store(name, arrays) -> filename`.

    `look_of(material)` is the `Look` of a material, or None if it is not seen. `is_blurred`: whether
    the shutter is open for a while.
    """

    def __init__(self, store, look_of, is_blurred, report):
        self._store = store
        self._look_of = look_of
        self._is_blurred = is_blurred
        self._report = report
        self._known = {}
        self._noted = set()

    def take_stock(self, depsgraph):
        """The things and lights of `depsgraph` as they are now.

        # Errors `ValueError` where a place is no finite number.
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
        """Notes what slo-rt has no word for, once for all instances of an object."""
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
        return [Lamp(instance_key(instance), thing.name, thing.data.original, matrix)]

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
        parent = [instance.parent.original] if instance.parent else []
        return [
            Thing(
                key=instance_key(instance),
                name=thing.name,
                sources=[thing.original, *parent],
                placement=placement,
                shape=shape,
                parts=parts,
                box=box,
                outline=outline,
            )
        ]

    @staticmethod
    def _shape_key(thing, shape):
        materials = tuple(
            slot.material.name_full if slot.material else "" for slot in thing.material_slots
        )
        return thing.data.as_pointer(), materials, tuple(np.round(shape, 6).ravel())

    def _files(self, thing, shape, override):
        """Parts of a thing, its box, and its outline."""
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
        """`(name, material, arrays)` of the triangles of each material that is seen."""
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


def _box(pieces):
    """The low and the high corner of the box around the vertices of `MeshArrays`."""
    low = np.min([arrays.vertices.min(axis=0) for arrays in pieces], axis=0)
    high = np.max([arrays.vertices.max(axis=0) for arrays in pieces], axis=0)
    return np.array([low, high], np.float64)


def _matrix(instance):
    subject = "light" if instance.object.type == "LIGHT" else "object"
    matrix = np.array(instance.matrix_world, np.float64)
    return finite(matrix, f'{subject} "{instance.object.name}"')


def _has_no_area(triangles, box):
    """Whether no triangle has an area, as where all is scaled to a point or a line."""
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
    """Hashes of the vertices, as they are now, of the things with these keys."""
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
    """Materials of a thing by index, at least one; None where a slot is empty."""
    slots = [slot.material for slot in thing.material_slots]
    inner = list(mesh.materials)
    materials = [
        slots[i] if i < len(slots) else inner[i] for i in range(max(len(slots), len(inner)))
    ]
    return [material.original if material else None for material in materials] or [None]
