"""PLY meshes as NFF scenes: each triangle a polygon, seen from the front and above, with one light."""

import gzip
from pathlib import Path

import numpy as np

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4",
    "float64": "f8",
}  # fmt: skip


def read(path):
    """Returns corners and triangles. Vertices come first in the file, then faces with one list."""
    data = Path(path).read_bytes()
    if data[:2] == b"\x1f\x8b":
        data = gzip.decompress(data)
    end = data.index(b"end_header\n") + len(b"end_header\n")
    kind, elements = None, []
    for line in data[:end].decode("ascii", "replace").splitlines():
        match line.split():
            case ["format", kind, *_]:
                pass
            case ["element", name, count]:
                elements.append((name, int(count), []))
            case ["property", *words]:
                elements[-1][2].append(words)
    (_, vertices, columns), (_, faces, rows) = elements[:2]
    places = [[words[-1] for words in columns].index(axis) for axis in "xyz"]
    if kind == "ascii":
        numbers = np.array(data[end:].split(), float)
        points = numbers[: vertices * len(columns)].reshape(vertices, -1)[:, places]
        triangles = numbers[vertices * len(columns) :][: 4 * faces].reshape(faces, 4)[:, 1:].astype(int)
        return points, triangles
    order = "<" if "little" in kind else ">"
    vertex = np.dtype([(words[-1], order + TYPES[words[0]]) for words in columns])
    points = np.frombuffer(data, vertex, vertices, end)
    face = np.dtype([("count", order + TYPES[rows[0][1]]), ("corners", order + TYPES[rows[0][2]], 3)])
    triangles = np.frombuffer(data, face, faces, end + vertices * vertex.itemsize)["corners"]
    return np.stack([points[axis] for axis in "xyz"], axis=1).astype(float), triangles.astype(int)


def scene(path, folder):
    """Writes a mesh as NFF, once. y is up."""
    out = Path(folder) / f"{Path(path).name.split('.')[0]}.nff"
    if out.exists():
        return out
    points, triangles = read(path)
    used = points[np.unique(triangles)]
    low, high = used.min(axis=0), used.max(axis=0)
    middle, reach = (low + high) / 2, np.linalg.norm(high - low)
    eye = middle + reach * np.array([0.25, 0.25, 1.1])
    light = middle + reach * np.array([2.0, 3.0, 2.0])

    def vector(v):
        return " ".join(f"{c:.9g}" for c in v)

    lines = ["b 0 0 0", "v", f"from {vector(eye)}", f"at {vector(middle)}", "up 0 1 0", "angle 45", "hither 0.001"]
    lines += ["resolution 512 512", f"l {vector(light)}", "f .8 .8 .8 1 0 1 0 0"]
    for corners in points[triangles]:
        lines += ["p 3", *map(vector, corners)]
    out.write_text("\n".join(lines) + "\n", encoding="ascii")
    return out
