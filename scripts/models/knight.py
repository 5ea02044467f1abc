"""The knight's head: a horse sculpted from a side view and its thickness.

Millimetres while sculpting: y forward, z up, x across. The solid is the set of points where
(x / thickness)^2 + (1 - depth / rounding)^2 < 1, `depth` being the distance inside the outline.
"""

import math

from decimate import decimate
from lathe import Profile, lathe
from mesh import Mesh, smoothstep, unit
from nets import gradient, surface

CELL = .72
VERTICES = 4600

# Side view, from the front of the foot over chest, muzzle, ears and crest to the back of the foot.
# A third value of 1 marks a corner.
OUTLINE = [
    (11.6, -2.0, 1), (12.2, 3.0), (12.3, 7.5), (11.0, 12.5), (8.7, 17.0), (6.9, 20.6),
    (5.9, 23.2), (6.6, 24.8), (8.8, 24.7), (10.9, 23.6), (12.6, 22.3), (14.2, 22.2), (15.0, 23.4),
    (15.2, 24.5, 1), (16.5, 24.9), (17.3, 26.6), (16.9, 28.8), (15.2, 31.4), (13.2, 34.4),
    (11.4, 37.6), (10.0, 40.4), (8.2, 43.0), (5.8, 45.0), (3.0, 46.4), (.2, 47.0),
    (-2.8, 46.4), (-6.0, 44.4), (-9.0, 40.8),
    (-11.2, 35.8), (-12.4, 29.8), (-12.8, 23.4), (-12.5, 16.6), (-11.9, 9.6), (-11.6, 3.6),
    (-11.8, -2.0, 1),
]

# Half thickness and rounding of the edge at points of the side view.
BODY = [
    (0.0, -2.0, 11.8, 11.6), (8.0, 2.0, 11.2, 9.5), (-8.0, 2.0, 11.2, 9.5), (0.0, 8.0, 9.6, 9.0),
    (9.0, 10.0, 8.4, 7.5), (-9.0, 10.0, 8.2, 6.5), (0.0, 17.0, 7.6, 7.5), (-9.0, 20.0, 6.8, 5.5),
    (5.0, 20.0, 6.8, 5.0), (-3.0, 28.0, 6.4, 6.0), (-9.0, 32.0, 5.9, 5.0), (-4.0, 38.0, 5.6, 5.0),
    (-5.0, 43.0, 4.8, 4.5), (0.0, 43.0, 5.2, 4.0), (6.0, 29.5, 6.9, 4.0), (5.5, 34.0, 6.7, 4.0),
    (9.5, 28.5, 5.8, 3.6), (13.0, 27.0, 4.6, 3.2), (16.0, 27.0, 4.4, 3.2), (13.6, 23.4, 3.6, 2.6),
    (10.0, 33.0, 5.6, 3.4), (13.0, 32.0, 4.2, 3.4), (8.0, 39.0, 6.2, 3.6), (5.0, 42.0, 5.8, 3.6),
    (2.0, 45.0, 5.2, 3.8),
]


def spline(points):
    """Catmull-Rom through the points, broken at corners."""
    out = []
    for i in range(len(points) - 1):
        p1, p2 = points[i], points[i + 1]
        p0 = p1 if len(p1) > 2 or i == 0 else points[i - 1]
        p3 = p2 if len(p2) > 2 or i + 2 == len(points) else points[i + 2]
        for k in range(4):
            t = k / 4.0
            out.append(tuple(
                .5 * (2 * p1[a] + (p2[a] - p0[a]) * t
                      + (2 * p0[a] - 5 * p1[a] + 4 * p2[a] - p3[a]) * t * t
                      + (3 * p1[a] - p0[a] - 3 * p2[a] + p3[a]) * t * t * t) for a in (0, 1)))
    out.append(points[-1][:2])
    return out


EDGE = spline(OUTLINE)
CREST_START = 25 * 4


def nearest(y, z):
    """Signed depth inside the outline and the arc length of the nearest crest point."""
    best, where, odd = 1e9, 0.0, False
    run = 0.0
    for i in range(len(EDGE)):
        ay, az = EDGE[i - 1]
        by, bz = EDGE[i]
        dy, dz = by - ay, bz - az
        square = dy * dy + dz * dz
        t = ((y - ay) * dy + (z - az) * dz) / square
        t = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
        ey, ez = ay + dy * t - y, az + dz * t - z
        d = ey * ey + ez * ez
        size = math.sqrt(square)
        if d < best and i > 0:
            best, where = d, (i, run + size * t)
        run += size
        if (az > z) != (bz > z) and y < ay + (z - az) * dy / dz:
            odd = not odd
    depth = math.sqrt(best)
    return (depth if odd else -depth), where


def bump(y, z, cy, cz, ry, rz, turn=0.0):
    """1 at the centre of an ellipse, 0 outside it."""
    c, s = math.cos(turn), math.sin(turn)
    u, v = ((y - cy) * c + (z - cz) * s) / ry, ((z - cz) * c - (y - cy) * s) / rz
    return smoothstep(1.0, 0.0, math.sqrt(u * u + v * v))


def groove(y, z, points, width):
    """1 on a polyline, falling to 0 at `width` from it."""
    best = 1e9
    for (ay, az), (by, bz) in zip(points, points[1:]):
        dy, dz = by - ay, bz - az
        t = min(max(((y - ay) * dy + (z - az) * dz) / (dy * dy + dz * dz), 0.0), 1.0)
        best = min(best, math.hypot(ay + dy * t - y, az + dz * t - z))
    return smoothstep(width, 0.0, best)


def relief(y, z, depth, where):
    """Height of the carving on the side, in millimetres; negative where it is cut away."""
    h = 0.0
    # The jaw stands out from the neck.
    jaw = math.hypot((y - 6.4) / 1.0, (z - 31.0) / 1.12)
    back = smoothstep(8.4, 6.6, jaw) if z < 40.0 else 0.0
    h += .9 * back * smoothstep(40.0, 36.0, z) * smoothstep(-3.5, 0.5, y)
    h -= .8 * groove(y, z, [(5.2, 22.8), (2.2, 24.2), (-.3, 27.4), (-1.3, 31.0), (-.8, 35.0),
                            (1.0, 39.0), (2.2, 42.0)], 1.7)
    # Muzzle: mouth, nostril, the hollow between cheek and nose.
    h -= 1.0 * groove(y, z, [(15.8, 24.4), (14.2, 25.2), (12.2, 25.6)], .95)
    h += .5 * bump(y, z, 15.6, 28.0, 2.4, 2.0, .8)
    h -= 1.5 * bump(y, z, 15.7, 27.9, 1.5, 1.0, .9)
    h -= .7 * bump(y, z, 11.6, 31.6, 4.2, 1.9, 2.15)
    # Eye under its brow.
    h -= .9 * bump(y, z, 8.4, 38.2, 3.4, 2.5, .55)
    h += 1.3 * bump(y, z, 8.5, 38.1, 2.0, 1.5, .5)
    h += .8 * groove(y, z, [(6.0, 39.6), (7.8, 40.6), (9.4, 40.4)], 1.3)
    return h + mane(y, z, depth, where)


def mane(y, z, depth, where):
    """Locks that hang from the crest, parted by grooves."""
    i, run = where
    if depth < -1.0 or i < CREST_START:
        return 0.0
    fade = smoothstep(5.0, 13.0, z) * smoothstep(.5, -2.5, y)
    lock = .5 - .5 * math.cos(2.0 * math.pi * (run + .75 * depth) / 5.4)
    ridge = smoothstep(8.6 + lock, 5.4 + lock, depth)
    return fade * ridge * (1.7 * (lock + .02) ** .42 - .55)


def profile(y, z):
    """Depth, half thickness and rounding at a point of the side view."""
    depth, where = nearest(y, z)
    total = thick = round_ = 0.0
    for cy, cz, t, r in BODY:
        w = math.exp(-((y - cy) ** 2 + (z - cz) ** 2) / 26.0) + 1e-9
        total, thick, round_ = total + w, thick + w * t, round_ + w * r
    thick, round_ = thick / total, round_ / total
    return depth, thick + relief(y, z, depth, where), round_


def field(p, cache={}):
    """Signed distance, approximately in millimetres near the surface; negative inside."""
    key = (p[1], p[2])
    if key not in cache:
        if len(cache) > 20000:
            cache.clear()
        cache[key] = profile(*key)
    depth, thick, rounding = cache[key]
    edge = max(0.0, 1.0 - depth / rounding)
    x = abs(p[0])
    f = (math.sqrt((x / thick) ** 2 + edge ** 2) - 1.0) * min(thick, rounding)
    return max(f, -1.0 - p[2])


def head():
    """The head in centimetres, its cut foot at z = -0.1."""
    low, high = (-13.3, -14.0, -2.1), (13.3, 19.0, 48.6)
    mesh = decimate(surface(field, low, high, CELL), VERTICES)
    mesh.normals = [unit(gradient(field, p, .25)) for p in mesh.positions]
    for side in (-1.0, 1.0):
        mesh.add(ear(side))
    return mesh.scaled(.1)


def ear(side):
    """A pointed leaf, hollow in front, that leans forward and outward."""
    outline = Profile(0, -1.5).curve(2.6, -1.5, 2.5, 2.4, 0, 6.4, 12)
    leaf = lathe(outline, 20, lambda r, z, angle: (r, z))

    def place(p):
        x, y, z = p[0] * 1.3, p[1] * .9, p[2]
        if y > 0.0:
            y = y * .25 - .55 * max(0.0, 1.0 - (x / 1.9) ** 2) * smoothstep(-1.0, 1.5, z) \
                * smoothstep(6.4, 3.0, z)
        y, z = y + .20 * z, z
        x = side * (2.7 + x * side * 1.0 + .16 * z)
        return (x, 2.6 + y, 45.2 + z)

    out = Mesh().add(leaf, place)
    out.normals = [None] * len(out.positions)
    return out.compute_normals()


if __name__ == "__main__":
    head().write("knight_head")
