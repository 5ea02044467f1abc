# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts Blender's meshes to triangles, with numpy throughout."""

from dataclasses import replace

import numpy as np

from ..format.slo_mesh import MeshArrays

# Corner normals whose components differ by less count as equal.
NORMAL_STEP = 1e-4


class Triangles:
    """The triangles of a mesh: `geometry`, arrays without uvs, and the `material` index of each triangle.

    `shape` (3, 3) is applied to vertices and normals; if it mirrors, triangles are reversed. Valid as
    long as the mesh exists.
    """

    def __init__(self, mesh, shape=None):
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        self._mesh = mesh
        vertices = _attribute(mesh, "position", "vector", 3, np.float32)
        self._corner_vertex = _attribute(mesh, ".corner_vert", "value", 1, np.int32)[:, 0]
        self._corners = _read(mesh.loop_triangles, "loops", count, 3, np.int32)
        self.material = _materials(mesh, count)
        flattened = shape is not None and is_flat(shape)
        mirrored = shape is not None and not flattened and np.linalg.det(shape) < 0.0
        if mirrored:
            self._corners = self._corners[:, ::-1]
        vertex_of_corner, source, normals = _normals(mesh, self._corner_vertex)
        if source is not None:
            vertices = vertices[source]
        if shape is not None:
            vertices = (vertices @ shape.T).astype(np.float32)
            normals = (
                None if normals is None or flattened else _unit(normals @ np.linalg.inv(shape))
            )
        self.geometry = MeshArrays(vertices, vertex_of_corner[self._corners], normals=normals)

    def arrays(self, uv_map, is_needed):
        """Returns the geometry with the named uv map: "" for the render uv map, None for none.

        If there is no uv map but it `is_needed`, all uvs are the same point, as in Blender.
        """
        uvs, corner_uv = _uvs(self._mesh, self._corner_vertex, uv_map, is_needed)
        if uvs is None:
            return self.geometry
        return replace(self.geometry, uvs=uvs, face_uvs=corner_uv[self._corners])


def has_faces(mesh):
    """Whether a mesh has triangles."""
    return len(mesh.polygons) > 0


def is_flat(matrix):
    """Whether a matrix (3, 3) is singular."""
    lengths = np.linalg.norm(matrix, axis=0)
    return abs(np.linalg.det(matrix)) <= 1e-9 * np.prod(lengths)


def part(mesh, chosen):
    """Returns the triangles of a mesh for which `chosen` (m,) is true, with the vertices that they use."""
    faces, vertices = _compact(mesh.faces[chosen], len(mesh.vertices))
    result = MeshArrays(mesh.vertices[vertices], faces)
    if mesh.normals is not None:
        result.normals = mesh.normals[vertices]
    if mesh.uvs is not None:
        result.face_uvs, uvs = _compact(mesh.face_uvs[chosen], len(mesh.uvs))
        result.uvs = mesh.uvs[uvs]
    return result


def _compact(indices, count):
    used = np.zeros(count, bool)
    used[indices.ravel()] = True
    new_index = np.cumsum(used, dtype=np.int32) - 1
    return new_index[indices], np.flatnonzero(used)


def _attribute(mesh, name, field, width, kind):
    """Returns the values of an attribute, many times faster than vertex by vertex or corner by corner."""
    values = mesh.attributes[name].data
    return _read(values, field, len(values), width, kind)


def _materials(mesh, count):
    """Returns the material index of each triangle."""
    if "material_index" not in mesh.attributes:
        return np.zeros(count, np.int32)
    of_face = _attribute(mesh, "material_index", "value", 1, np.int32)[:, 0]
    return of_face[_read(mesh.loop_triangle_polygons, "value", count, 1, np.int32)[:, 0]]


def _read(collection, attribute, count, width, kind):
    values = np.empty(count * width, kind)
    collection.foreach_get(attribute, values)
    return values.reshape(count, width)


def _uvs(mesh, corner_vertex, uv_map, is_needed):
    """Returns the distinct uv coordinates, and their index for each corner; `(None, None)` without uvs."""
    layers = mesh.uv_layers
    layer = layers.get(uv_map) if uv_map else None
    if uv_map == "":
        layer = next((each for each in layers if each.active_render), None)
    if layer is None and is_needed:
        return np.zeros((1, 2), np.float32), np.zeros(len(corner_vertex), np.int32)
    if layer is None:
        return None, None
    at_corner = _read(layer.uv, "vector", len(corner_vertex), 2, np.float32)
    at_vertex = np.zeros((len(mesh.vertices), 2), np.float32)
    at_vertex[corner_vertex] = at_corner
    if np.array_equal(at_vertex[corner_vertex], at_corner):
        return at_vertex, corner_vertex
    packed = np.ascontiguousarray(at_corner).view(np.uint64)[:, 0]
    distinct, index = np.unique(packed, return_inverse=True)
    return distinct.view(np.float32).reshape(-1, 2), index.astype(np.int32)


def _normals(mesh, corner_vertex):
    """`(vertex of each corner, source vertices, normals)`.

    Vertices whose corners have different normals are split. `source` holds the original of each
    vertex, or is None if none was split. Normals are None for flat meshes.
    """
    domain = mesh.normals_domain
    if domain == "FACE":
        return corner_vertex, None, None
    if domain == "POINT":
        count = len(mesh.vertices)
        return corner_vertex, None, _read(mesh.vertex_normals, "vector", count, 3, np.float32)
    at_corner = _read(mesh.corner_normals, "vector", len(corner_vertex), 3, np.float32)
    steps = np.rint(at_corner / NORMAL_STEP).astype(np.int64) + 16384
    packed = (steps[:, 0] << 30) | (steps[:, 1] << 15) | steps[:, 2]
    _, normal_index = np.unique(packed, return_inverse=True)
    pairs = corner_vertex.astype(np.int64) * len(packed) + normal_index
    _, corner, vertex_of_corner = np.unique(pairs, return_index=True, return_inverse=True)
    return vertex_of_corner.astype(np.int32), corner_vertex[corner], at_corner[corner]


def _unit(vectors):
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return (vectors / np.maximum(length, 1e-30)).astype(np.float32)
