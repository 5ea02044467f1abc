"""Profiles of lines, arcs and curves, and the surface of revolution about z."""

import math

from mesh import Mesh

ARC_STEP = math.radians(19.0)
CREASE = math.cos(math.radians(24.0))


class Profile:
    """A curve in the (r, z) half plane, from the bottom upwards, the solid on its left."""

    def __init__(self, r, z):
        self.pieces = []
        self.end = (r, z)

    def line(self, r, z, fillet=0.0):
        """A straight line; `fillet` rounds its far corner if another line follows."""
        self.pieces.append(("line", self.end, (r, z), fillet))
        self.end = (r, z)
        return self

    def arc(self, r, z, bulge):
        """A circular arc; bulge = tan(angle / 4), positive bends outwards."""
        self.pieces.append(("arc", self.end, (r, z), bulge))
        self.end = (r, z)
        return self

    def curve(self, r1, z1, r2, z2, r, z, steps=10):
        """A cubic Bezier curve."""
        self.pieces.append(("curve", self.end, (r, z), ((r1, z1), (r2, z2), steps)))
        self.end = (r, z)
        return self

    def scaled(self, s):
        """The profile scaled by s."""
        def p(a):
            return (a[0] * s, a[1] * s)
        copy = Profile(*p(self.end))
        for kind, a, b, x in self.pieces:
            if kind == "line":
                x = x * s
            elif kind == "curve":
                x = (p(x[0]), p(x[1]), x[2])
            copy.pieces.append((kind, p(a), p(b), x))
        return copy

    def rows(self):
        """Lists of (r, z, tangent r, tangent z); the surface is smooth inside each list."""
        runs = [[]]
        for points in map(sample, fillet_pieces(self.pieces)):
            if runs[-1]:
                last, first = runs[-1][-1], points[0]
                if last[2] * first[2] + last[3] * first[3] < CREASE:
                    runs.append([])
                else:
                    tr, tz = last[2] + first[2], last[3] + first[3]
                    n = math.hypot(tr, tz)
                    runs[-1][-1] = (last[0], last[1], tr / n, tz / n)
                    points = points[1:]
            runs[-1] += points
        return runs


def fillet_pieces(pieces):
    pieces = list(pieces)
    out = []
    for i, (kind, a, b, x) in enumerate(pieces):
        if kind != "line" or x <= 0.0 or i + 1 == len(pieces) or pieces[i + 1][0] != "line":
            out.append((kind, a, b, 0.0 if kind == "line" else x))
            continue
        _, _, c, next_fillet = pieces[i + 1]
        u, v = direction(b, a), direction(b, c)
        angle = math.acos(min(max(u[0] * v[0] + u[1] * v[1], -1.0), 1.0))
        back = x / math.tan(angle / 2.0)
        p = (b[0] + u[0] * back, b[1] + u[1] * back)
        q = (b[0] + v[0] * back, b[1] + v[1] * back)
        side = u[0] * v[1] - u[1] * v[0]
        bulge = math.tan((math.pi - angle) / 4.0) * (-1.0 if side > 0.0 else 1.0)
        out.append(("line", a, p, 0.0))
        out.append(("arc", p, q, bulge))
        pieces[i + 1] = ("line", q, c, next_fillet)
    return out


def direction(a, b):
    d = math.hypot(b[0] - a[0], b[1] - a[1])
    return ((b[0] - a[0]) / d, (b[1] - a[1]) / d)


def sample(piece):
    kind, a, b, x = piece
    if kind == "line":
        t = direction(a, b)
        return [(*a, *t), (*b, *t)]
    if kind == "arc":
        return sample_arc(a, b, x)
    c1, c2, steps = x
    out = []
    for i in range(steps + 1):
        t = i / steps
        s = 1.0 - t
        w = (s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t)
        d = (-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t)
        p = [sum(k * q[axis] for k, q in zip(w, (a, c1, c2, b))) for axis in (0, 1)]
        g = [sum(k * q[axis] for k, q in zip(d, (a, c1, c2, b))) for axis in (0, 1)]
        n = math.hypot(*g)
        out.append((p[0], p[1], g[0] / n, g[1] / n))
    return out


def sample_arc(a, b, bulge):
    """Going up along the chord, a positive bulge lies to its right, which is outwards."""
    angle = 4.0 * math.atan(bulge)
    chord = direction(a, b)
    steps = max(2, math.ceil(abs(angle) / ARC_STEP))
    start = math.atan2(chord[1], chord[0]) - angle / 2.0
    radius = math.hypot(b[0] - a[0], b[1] - a[1]) / (2.0 * math.sin(angle / 2.0))
    out = []
    for i in range(steps + 1):
        heading = start + angle * i / steps
        # The centre is to the left of the start direction at distance radius.
        cr = a[0] - math.sin(start) * radius
        cz = a[1] + math.cos(start) * radius
        out.append((cr + math.sin(heading) * radius, cz - math.cos(heading) * radius,
                    math.cos(heading), math.sin(heading)))
    return out


def lathe(profile, segments=64, bend=None):
    """Surface of revolution; `bend(r, z, angle)` may move a point to a new (r, z)."""
    mesh = Mesh()
    for run in profile.rows():
        rings = [ring(mesh, row, segments, bend) for row in run]
        for low, high in zip(rings, rings[1:]):
            for j in range(segments):
                k = (j + 1) % segments
                mesh.quad(low[j], low[k], high[k], high[j])
    return mesh


def ring(mesh, row, segments, bend):
    r, z, tr, tz = row
    if abs(r) < 1e-6 and bend is None:
        pole = mesh.vertex((0.0, 0.0, z), (0.0, 0.0, -1.0 if tr > 0.0 else 1.0))
        return [pole] * segments
    ids = []
    for j in range(segments):
        angle = 2.0 * math.pi * j / segments
        c, s = math.cos(angle), math.sin(angle)
        if bend:
            br, bz = bend(r, z, angle)
            ids.append(mesh.vertex((br * c, br * s, bz)))
        else:
            ids.append(mesh.vertex((r * c, r * s, z), (tz * c, tz * s, -tr)))
    return ids
