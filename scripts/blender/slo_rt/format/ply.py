# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary `.ply` files: shapes of meshes, and placements of copies."""

import os

import numpy as np

_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])


def write_mesh(path, mesh):
    """Writes `MeshArrays` whose uvs, if any, belong to vertices, to the file `path`; whole or not at all.

    # Errors `OSError` if the file cannot be written.
    """
    columns = {"x y z": mesh.vertices, "nx ny nz": mesh.normals, "s t": mesh.uvs}
    faces = np.empty(len(mesh.faces), _FACE)
    faces["count"], faces["corners"] = 3, mesh.faces
    _write(
        path,
        columns,
        [f"element face {len(faces)}", "property list uchar int vertex_indices"],
        faces,
    )


def write_placements(path, positions, turns=None, scales=None):
    """Writes where copies are: `positions` (n, 3), `turns` (n, 4) as unit quaternions w, x, y, z, or None,
    and `scales` (n, 3), or None; whole or not at all.

    # Errors `OSError` if the file cannot be written.
    """
    columns = {"x y z": positions, "qw qx qy qz": turns}
    if scales is not None and (scales == scales[:, :1]).all():
        columns["scale"] = scales[:, :1]
    else:
        columns["sx sy sz"] = scales
    _write(path, columns)


def _write(path, columns, more=(), rest=None):
    columns = {names: values for names, values in columns.items() if values is not None}
    vertices = np.hstack([np.asarray(values, "<f4") for values in columns.values()])
    names = " ".join(columns).split()
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    lines += [*(f"property float {name}" for name in names), *more, "end_header\n"]
    partial = f"{path}.part"
    with open(partial, "wb") as file:
        file.write("\n".join(lines).encode())
        file.write(vertices.tobytes())
        if rest is not None:
            file.write(rest.tobytes())
    os.replace(partial, path)
