# SPDX-License-Identifier: GPL-3.0-or-later
"""What is visible at one moment: things with triangles, lights, and what is neither."""

import hashlib
from dataclasses import dataclass, field

import numpy as np

from ..fit.rigid import split_matrix
from . import mesh as meshes
from .motion import instance_key

SOLID = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
UNSEEN = {"EMPTY", "ARMATURE", "LATTICE", "CAMERA", "SPEAKER", "LIGHT", "LIGHT_PROBE"}


@dataclass
class Part:
    """Triangles of one material: the file's path in the scene and the `bpy` material, or None."""

    filename: str
    material: object
    smooth: bool


@dataclass
class Thing:
    """A thing with triangles: where it is (`placement`: pivot, up, right), what is left of its
    transform (`shape`, baked into its files), its diagonal and middle in world units, and, where
    its vertices may move in its own space, a hash of them (`outline`)."""

    key: tuple
    name: str
    sources: list
    placement: np.ndarray
    shape: np.ndarray
    parts: list
    diagonal: float
    center: np.ndarray
    outline: bytes | None


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
    """Takes stock of an evaluated scene; meshes go to `store(name, arrays) -> filename`."""

    def __init__(self, store, uv_map_of, report):
        self._store = store
        self._uv_map_of = uv_map_of
        self._report = report
        self._known = {}

    def take_stock(self, depsgraph):
        """The things and lights of `depsgraph` as they are now."""
        found = Inventory()
        for instance in depsgraph.object_instances:
            thing = instance.object
            if not instance.show_self:
                continue
            if thing.type in SOLID:
                found.things += self._solid(instance)
            elif thing.type == "LIGHT":
                matrix = np.array(instance.matrix_world, np.float64)
                found.lamps.append(
                    Lamp(instance_key(instance), thing.name, thing.data.original, matrix)
                )
            elif thing.type not in UNSEEN:
                kind = thing.type.lower().replace("_", " ")
                self._report.note(f'object "{thing.name}"', f"{kind} objects are not carried")
        return found

    def _solid(self, instance):
        thing = instance.object
        placement, shape = split_matrix(np.array(instance.matrix_world, np.float64))
        if abs(np.linalg.det(shape)) < 1e-18:
            self._report.note(f'object "{thing.name}"', "is scaled to nothing and left out")
            return []
        if np.allclose(shape, np.eye(3), rtol=0.0, atol=1e-6):
            shape = np.eye(3)
        key = self._shape_key(thing, shape)
        if key not in self._known:
            self._known[key] = self._files(thing, shape)
        parts, diagonal, center, outline = self._known[key]
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
                diagonal=diagonal,
                center=np.array(instance.matrix_world, np.float64)[:3, :3] @ center + placement[:3],
                outline=outline,
            )
        ]

    @staticmethod
    def _shape_key(thing, shape):
        materials = tuple(
            slot.material.name_full if slot.material else "" for slot in thing.material_slots
        )
        data = thing.data.as_pointer() if thing.type == "MESH" else thing.as_pointer()
        return data, materials, tuple(np.round(shape, 6).ravel())

    def _files(self, thing, shape):
        """Parts of a thing, its diagonal, its middle in object space, and its outline."""
        nothing = [], 0.0, np.zeros(3), None
        mesh = thing.to_mesh()
        if mesh is None:
            return nothing
        try:
            materials = materials_of(thing, mesh)
            uv_map = self._uv_map_of(materials)
            scale = None if np.array_equal(shape, np.eye(3)) else shape
            result = meshes.arrays(mesh, scale, uv_map)
            outline = _hash(mesh) if may_deform(thing) else None
        finally:
            thing.to_mesh_clear()
        if result is None:
            return nothing
        triangles, material_index = result
        low, high = triangles.vertices.min(axis=0), triangles.vertices.max(axis=0)
        center = np.linalg.solve(shape, (low + high).astype(np.float64) / 2.0)
        parts = list(self._parts(thing.name, triangles, material_index, materials))
        return parts, float(np.linalg.norm(high - low)), center, outline

    def _parts(self, name, triangles, material_index, materials):
        used = np.unique(np.clip(material_index, 0, len(materials) - 1))
        for index in used:
            material = materials[index]
            piece, piece_name = triangles, name
            if len(used) > 1:
                chosen = np.clip(material_index, 0, len(materials) - 1) == index
                piece = meshes.part(triangles, chosen)
                piece_name = f"{name}_{material.name if material else index}"
            yield Part(self._store(piece_name, piece), material, piece.smooth)


def may_deform(thing):
    """Whether the vertices of an object may move in its own space from frame to frame."""
    data = thing.original.data
    shape_keys = getattr(data, "shape_keys", None)
    return bool(thing.type != "MESH" or thing.modifiers or shape_keys or data.animation_data)


def outlines(depsgraph, keys):
    """Hashes of the vertices, as they are now, of the things with these keys."""
    found = {}
    for instance in depsgraph.object_instances:
        key = instance_key(instance) if instance.object.type in SOLID else None
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
