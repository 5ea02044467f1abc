# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts Blender's meshes to triangles, with numpy throughout."""

from dataclasses import dataclass, replace

import numpy as np

from ..format.fingerprint import fingerprint
from ..format.slo_mesh import MeshArrays

# Corner normals whose components differ by less count as equal.
NORMAL_STEP = 1e-4


class Triangles:
    """The triangles of a mesh: `geometry`, arrays without uvs, and the `material` index of each triangle.

    `rest` (3, 3) is applied to vertices and normals; if it mirrors, triangles are reversed. `bends`:
    the mesh changes its shape, so corners whose normals are equal only now keep vertices of their own.
    Valid as long as the mesh exists.
    """

    def __init__(self, mesh, rest=None, bends=False):
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        self._mesh = mesh
        self._corner_vertex = _corner_vertex(mesh)
        self._corners = _read(mesh.loop_triangles, "loops", count, 3, np.int32)
        self.material = _materials(mesh, count)
        if rest is not None and not is_flat(rest) and np.linalg.det(rest) < 0.0:
            self._corners = self._corners[:, ::-1]
        vertex_of_corner, self._source = _split(mesh, self._corner_vertex, bends)
        self._faces = vertex_of_corner[self._corners]
        vertices, normals = self._source.read(mesh, rest)
        self.geometry = MeshArrays(vertices, self._faces, normals=normals)

    def arrays(self, uv_map, is_needed):
        """Returns the geometry with the named uv map: "" for the render uv map, None for none.

        If there is no uv map but it `is_needed`, all uvs are the same point, as in Blender.
        """
        uvs, corner_uv = _uvs(self._mesh, self._corner_vertex, uv_map, is_needed)
        if uvs is None:
            return self.geometry
        return replace(self.geometry, uvs=uvs, face_uvs=corner_uv[self._corners])

    def skin(self, uv_map, is_needed, chosen=None):
        """Returns the `Skin` of the triangles for which `chosen` (m,) is true, or of all."""
        corners = self._corners if chosen is None else self._corners[chosen]
        faces = self._faces if chosen is None else self._faces[chosen]
        uvs, corner_uv = _uvs(self._mesh, self._corner_vertex, uv_map, is_needed)
        if uvs is None:
            faces, used = _compact(faces, len(self.geometry.vertices))
            return Skin(self._source.part(used), faces, None)
        # One vertex for each pair of vertex and uv.
        pairs = faces.astype(np.int64) * len(uvs) + corner_uv[corners]
        distinct, faces = np.unique(pairs, return_inverse=True)
        source = self._source.part(distinct // len(uvs))
        return Skin(source, faces.reshape(-1, 3).astype(np.int32), uvs[distinct % len(uvs)])


@dataclass
class Source:
    """Where vertices of triangles come from: the number of the vertex in the mesh, and of the corner
    that has its normal. Without `corner`, normals are those of vertices, if it `is_smooth`."""

    vertex: np.ndarray | None
    corner: np.ndarray | None
    is_smooth: bool

    def part(self, chosen):
        """Returns the source of the vertices with the numbers `chosen`."""
        vertex = chosen if self.vertex is None else self.vertex[chosen]
        return Source(vertex, None if self.corner is None else self.corner[chosen], self.is_smooth)

    def read(self, mesh, rest=None):
        """Returns the vertices and normals (or None) of a mesh; `rest` (3, 3) is applied to them."""
        return self.take(*read_shape(mesh), rest)

    def take(self, positions, normals, rest=None):
        """Does `read` for a mesh with the results of `read_shape`."""
        vertices = positions if self.vertex is None else positions[self.vertex]
        if not self.is_smooth:
            normals = None
        elif self.corner is not None:
            normals = normals[self.corner]
        elif self.vertex is not None:
            normals = normals[self.vertex]
        if rest is None:
            return vertices, normals
        vertices = (vertices @ rest.T).astype(np.float32)
        if normals is not None and is_flat(rest):
            normals = None
        return vertices, None if normals is None else _unit(normals @ np.linalg.inv(rest))


@dataclass
class Skin:
    """The triangles of a mesh that changes its shape: `faces` (m, 3) and `uvs` of vertices (n, 2) or
    None stay, and `source` finds the vertices."""

    source: Source
    faces: np.ndarray
    uvs: np.ndarray | None

    def shape(self, positions, normals, rest=None):
        """Returns the arrays of one shape; see `Source.take`."""
        vertices, normals = self.source.take(positions, normals, rest)
        uvs = self.uvs
        return MeshArrays(vertices, self.faces, uvs, None if uvs is None else self.faces, normals)


def read_shape(mesh):
    """Returns the positions (n, 3) of a mesh, and the normals of its corners, or else of its vertices, or
    None for flat faces."""
    positions = _attribute(mesh, "position", "vector", 3, np.float32)
    domain = mesh.normals_domain
    if domain == "FACE":
        return positions, None
    if domain == "POINT":
        return positions, _read(mesh.vertex_normals, "vector", len(positions), 3, np.float32)
    count = len(mesh.corner_normals)
    return positions, _read(mesh.corner_normals, "vector", count, 3, np.float32)


def topology(mesh):
    """Returns a hash of what meshes must have in common to be shapes of one mesh."""
    starts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    numbers = np.concatenate([_corner_vertex(mesh), starts, [len(mesh.vertices)]])
    return mesh.normals_domain.encode() + fingerprint(numbers.astype(np.int32))


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


def _corner_vertex(mesh):
    return _attribute(mesh, ".corner_vert", "value", 1, np.int32)[:, 0]


def _split(mesh, corner_vertex, bends):
    """Returns the vertex of each corner, and the `Source` of the vertices. Vertices whose corners have
    different normals are split; if the mesh `bends`, all vertices are."""
    domain = mesh.normals_domain
    if domain != "CORNER":
        return corner_vertex, Source(None, None, domain == "POINT")
    count = len(corner_vertex)
    if bends:
        every = np.arange(count, dtype=np.int32)
        return every, Source(corner_vertex, every, True)
    at_corner = _read(mesh.corner_normals, "vector", count, 3, np.float32)
    steps = np.rint(at_corner / NORMAL_STEP).astype(np.int64) + 16384
    packed = (steps[:, 0] << 30) | (steps[:, 1] << 15) | steps[:, 2]
    _, normal_index = np.unique(packed, return_inverse=True)
    pairs = corner_vertex.astype(np.int64) * count + normal_index
    _, corner, vertex_of_corner = np.unique(pairs, return_index=True, return_inverse=True)
    return vertex_of_corner.astype(np.int32), Source(corner_vertex[corner], corner, True)


def _unit(vectors):
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return (vectors / np.maximum(length, 1e-30)).astype(np.float32)
