"""Triangle meshes with explicit normals and texture coordinates, and the `.slo` writer.

Lengths are centimetres, z points up, faces run counter-clockwise seen from outside. One uv per
vertex: a seam is made by doubling vertices.
"""

import math
import os

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def mul(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def unit(a):
    n = length(a)
    return mul(a, 1.0 / n) if n > 1e-12 else (0.0, 0.0, 1.0)


def lerp(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def smoothstep(lo, hi, x):
    t = min(max((x - lo) / (hi - lo), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def area(p, q, r):
    return length(cross(sub(q, p), sub(r, p)))


class Mesh:
    """Vertices, one normal and one uv each, and triangles."""

    def __init__(self):
        self.positions, self.normals, self.uvs, self.faces = [], [], [], []

    def vertex(self, position, normal=None, uv=None):
        """Add a vertex and return its index; a normal of None is computed by `compute_normals`."""
        self.positions.append(position)
        self.normals.append(normal)
        self.uvs.append(uv)
        return len(self.positions) - 1

    def triangle(self, a, b, c):
        p, q, r = self.positions[a], self.positions[b], self.positions[c]
        if area(p, q, r) > 1e-9:
            self.faces.append((a, b, c))

    def quad(self, a, b, c, d):
        self.triangle(a, b, c)
        self.triangle(a, c, d)

    def polygon(self, points, normal=None, uvs=None):
        """Add a flat convex polygon with vertices of its own."""
        if normal is None:
            normal = unit(cross(sub(points[1], points[0]), sub(points[2], points[0])))
        uvs = uvs or [None] * len(points)
        ids = [self.vertex(p, normal, uv) for p, uv in zip(points, uvs)]
        for i in range(1, len(ids) - 1):
            self.triangle(ids[0], ids[i], ids[i + 1])

    def add(self, other, place=lambda p: p, turn=None):
        """Append another mesh, moved by `place`; `turn` moves its normals."""
        turn = turn or (lambda n: n)
        base = len(self.positions)
        self.positions += [place(p) for p in other.positions]
        self.normals += [turn(n) if n else None for n in other.normals]
        self.uvs += other.uvs
        self.faces += [(a + base, b + base, c + base) for a, b, c in other.faces]
        return self

    def compute_normals(self):
        """Fill the missing normals with the angle-weighted mean of the faces around a vertex."""
        sums = [(0.0, 0.0, 0.0)] * len(self.positions)
        for face in self.faces:
            p = [self.positions[i] for i in face]
            n = unit(cross(sub(p[1], p[0]), sub(p[2], p[0])))
            for k in range(3):
                e0 = unit(sub(p[(k + 1) % 3], p[k]))
                e1 = unit(sub(p[(k + 2) % 3], p[k]))
                angle = math.acos(min(max(dot(e0, e1), -1.0), 1.0))
                sums[face[k]] = add(sums[face[k]], mul(n, angle))
        self.normals = [n or unit(s) for n, s in zip(self.normals, sums)]
        return self

    def map_uv(self, function):
        """Set the uv of every vertex by a function of its position."""
        self.uvs = [function(p) for p in self.positions]
        return self

    def scaled(self, s):
        self.positions = [mul(p, s) for p in self.positions]
        return self

    def write(self, name, digits=3):
        """Write meshes/NAME.slo; unused vertices are dropped, equal ones merged."""
        self.compute_normals()
        with_uv = all(uv is not None for uv in self.uvs)
        seen, order, remap = {}, [], {}
        for i in sorted({i for f in self.faces for i in f}):
            row = (row_text(self.positions[i], digits), row_text(self.normals[i], 3),
                   row_text(self.uvs[i], 3) if with_uv else "")
            if row not in seen:
                seen[row] = len(order)
                order.append(row)
            remap[i] = seen[row]
        faces = [tuple(remap[i] for i in f) for f in self.faces]
        points = [tuple(float(x) for x in r[0].split()) for r in order]
        faces = [f for f in faces if area(*(points[i] for i in f)) > 1e-9]
        lines = ["slo_mesh 1", "vertices {"] + [r[0] for r in order] + ["}"]
        lines += ["normals {"] + [r[1] for r in order] + ["}"]
        if with_uv:
            lines += ["uvs {"] + [r[2] for r in order] + ["}"]
        lines += ["faces {"] + ["%d %d %d" % f for f in faces] + ["}", ""]
        path = os.path.join(ROOT, "meshes", name + ".slo")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="ascii", newline="\n") as file:
            file.write("\n".join(lines))
        print("meshes/%s.slo: %d vertices, %d faces, %d KB"
              % (name, len(order), len(faces), os.path.getsize(path) // 1024))


def number(x, digits):
    """Shortest text of x with at most that many decimals: .5 -.25 3 0"""
    text = ("%.*f" % (digits, x)).rstrip("0").rstrip(".") if digits else "%d" % round(x)
    if text in ("-0", ""):
        return "0"
    if text.startswith("0."):
        return text[1:]
    if text.startswith("-0."):
        return "-" + text[2:]
    return text


def row_text(values, digits):
    return " ".join(number(v, digits) for v in values)
