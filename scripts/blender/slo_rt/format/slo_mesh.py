# SPDX-License-Identifier: GPL-3.0-or-later
"""`.slo` mesh files."""

import hashlib
import os
from dataclasses import dataclass

import numpy as np

from .decimal_text import decimal_lines, integer_lines

VERTEX_DIGITS = 9  # digits that single precision needs
NORMAL_DIGITS = 6
UV_DIGITS = 8


@dataclass
class MeshArrays:
    """Triangles in the space of their object.

    `vertices` (n, 3) and `faces` (m, 3), counter-clockwise seen from outside; `uvs` (k, 2) with
    `face_uvs` (m, 3), or neither; `normals` (n, 3) of unit length, or None for flat triangles.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uvs: np.ndarray | None = None
    face_uvs: np.ndarray | None = None
    normals: np.ndarray | None = None

    @property
    def smooth(self):
        """Whether normals are interpolated."""
        return self.normals is not None

    def digest(self):
        """Hash of the contents of a file of this mesh, as 32 hexadecimal digits."""
        hasher = hashlib.blake2b(digest_size=16)
        for array in (self.vertices, self.faces, self.uvs, self.face_uvs, self.normals):
            if array is not None:
                hasher.update(repr((array.shape, array.dtype.str)).encode())
                hasher.update(np.ascontiguousarray(array))
            hasher.update(b";")
        return hasher.hexdigest()


def write(path, mesh):
    """Writes `mesh` to the file `path`; whole or not at all.

    # Errors
    `OSError` if the file cannot be written; `ValueError` if a number is not finite.
    """
    for name in ("vertices", "uvs", "normals"):
        array = getattr(mesh, name)
        if array is not None and not np.isfinite(array).all():
            raise ValueError(f"a number in the {name} is not finite")
    partial = f"{path}.part"
    with open(partial, "wb") as file:
        file.write(b"slo_mesh 1\n")
        _section(file, "vertices", decimal_lines(mesh.vertices, VERTEX_DIGITS))
        _section(file, "faces", integer_lines(mesh.faces))
        if mesh.uvs is not None:
            _section(file, "uvs", decimal_lines(mesh.uvs, UV_DIGITS))
            _section(file, "face_uvs", integer_lines(mesh.face_uvs))
        if mesh.normals is not None:
            _section(file, "normals", decimal_lines(mesh.normals, NORMAL_DIGITS))
    os.replace(partial, path)


def _section(file, name, pieces):
    file.write(f"{name} {{\n".encode())
    for piece in pieces:
        file.write(piece)
    file.write(b"}\n")
