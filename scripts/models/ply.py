"""Binary PLY files: meshes of polygons, and placements of copies. Values are rounded, so that they
are the same on every machine."""

import os
import struct

from mesh import ROOT


def write_mesh(name, points, faces, uvs=None, digits=4, folder="meshes"):
    """Write FOLDER/NAME.ply: a third of the size of `.slo`. Smooth normals are left to the renderer."""
    large = len(points) > 65535
    header = ["element vertex %d" % len(points)] + ["property float " + c for c in ("xyzst" if uvs else "xyz")]
    header += ["element face %d" % len(faces),
               "property list uchar %s vertex_indices" % ("uint" if large else "ushort")]
    data = bytearray()
    for i, point in enumerate(points):
        row = (*point, *uvs[i]) if uvs else point
        data += struct.pack("<%df" % len(row), *(round(x, digits) for x in row))
    for face in faces:
        data += struct.pack("<B%d%s" % (len(face), "I" if large else "H"), len(face), *face)
    save(os.path.join(ROOT, folder, name + ".ply"), header, data)


def write_placements(name, properties, rows, digits=4, folder="meshes"):
    """Write FOLDER/NAME.ply: one vertex for each copy, all properties floats."""
    header = ["element vertex %d" % len(rows)] + ["property float " + p for p in properties]
    data = bytearray()
    for row in rows:
        data += struct.pack("<%df" % len(properties), *(round(x, digits) for x in row))
    save(os.path.join(ROOT, folder, name + ".ply"), header, data)


def save(path, header, data):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    text = "\n".join(["ply", "format binary_little_endian 1.0"] + header + ["end_header", ""])
    with open(path, "wb") as file:
        file.write(text.encode("ascii") + data)
    print("%s: %s, %d KB" % (os.path.relpath(path, ROOT), header[0].split(" ", 1)[1],
                             os.path.getsize(path) // 1024))


def grid(columns, rows, point):
    """Points and quads of a sheet; point(i, j) for i in 0..columns and j in 0..rows."""
    points = [point(i, j) for j in range(rows + 1) for i in range(columns + 1)]
    n = columns + 1
    return points, [(k, k + 1, k + n + 1, k + n)
                    for j in range(rows) for k in range(j * n, j * n + columns)]
