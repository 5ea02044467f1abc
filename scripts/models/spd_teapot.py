"""Newell's teapot for spd.py: 32 Bézier patches, as triangles with normals.

Martin Newell's control points of 1975 are in the public domain. All but handle and spout are turned about the axis, so
those need a profile only.
"""

from math import sqrt

# Profiles (distance from the axis, height) of what is turned, each four patches: a quarter of a circle each.
RIM = ((1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4))
UPPER_BODY = ((1.5, 2.4), (1.75, 1.875), (2, 1.35), (2, 0.9))
LOWER_BODY = ((2, 0.9), (2, 0.45), (1.5, 0.225), (1.5, 0.15))
KNOB = ((0, 3.15), (0.8, 3.15), (0, 2.85), (0.2, 2.7))
LID = ((0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4))
BOTTOM = ((0, 0), (1.425, 0), (1.5, 0.075), (1.5, 0.15))
CIRCLE = 0.56  # where the inner control points of a quarter of a circle are
KNOB_CIRCLE = 0.5625  # the same for the widest row of the knob

# Rows of half of the handle and of the spout: (x, z) at one edge, (x, z) at the other, half of the width.
HANDLES = (
    (
        ((-1.6, 2.025), (-1.5, 2.25), 0.3),
        ((-2.3, 2.025), (-2.5, 2.25), 0.3),
        ((-2.7, 2.025), (-3, 2.25), 0.3),
        ((-2.7, 1.8), (-3, 1.8), 0.3),
    ),
    (
        ((-2.7, 1.8), (-3, 1.8), 0.3),
        ((-2.7, 1.575), (-3, 1.35), 0.3),
        ((-2.5, 1.125), (-2.65, 0.9375), 0.3),
        ((-2, 0.9), (-1.9, 0.6), 0.3),
    ),
)
SPOUTS = (
    (
        ((1.7, 1.425), (1.7, 0.6), 0.66),
        ((2.6, 1.425), (3.1, 0.825), 0.66),
        ((2.3, 2.1), (2.4, 2.025), 0.25),
        ((2.7, 2.4), (3.3, 2.4), 0.25),
    ),
    (
        ((2.7, 2.4), (3.3, 2.4), 0.25),
        ((2.8, 2.475), (3.525, 2.49375), 0.25),
        ((2.9, 2.475), (3.45, 2.5125), 0.15),
        ((2.8, 2.4), (3.2, 2.4), 0.15),
    ),
)


def quarters(profile, backward=False):
    """The four patches of a profile that is turned about the axis."""
    found = []
    for quarter in range(4):
        rows = []
        for number, (radius, height) in enumerate(profile):
            inner = radius * (KNOB_CIRCLE if profile is KNOB and number == 1 else CIRCLE)
            row = [(radius, 0.0), (radius, inner), (inner, radius), (0.0, radius)]
            if not backward:
                row = [(x, -y) for x, y in row]
            for _ in range(quarter):
                row = [(-y, x) if backward else (y, -x) for x, y in row]
            rows.append([(x, y, height) for x, y in row])
        found.append(rows)
    return found


def halves(rows):
    """The two patches of a part that is the same on both sides."""
    front = [[(a, 0.0, b), (a, -w, b), (c, -w, d), (c, 0.0, d)] for (a, b), (c, d), w in rows]
    back = [[(c, 0.0, d), (c, w, d), (a, w, b), (a, 0.0, b)] for (a, b), (c, d), w in rows]
    return [front, back]


def patches():
    found = quarters(RIM) + quarters(UPPER_BODY) + quarters(LOWER_BODY)
    for part in HANDLES + SPOUTS:
        found += halves(part)
    return found + quarters(KNOB) + quarters(LID) + quarters(BOTTOM, backward=True)


def weights(t):
    """Bernstein's cubic polynomials and their derivatives."""
    s = 1 - t
    return (
        (s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t),
        (-3 * s * s, 3 * s * (s - 2 * t), 3 * t * (2 * s - t), 3 * t * t),
    )


def point(rows, u, v):
    """Returns point and unit normal of a patch."""

    def sum_of(along, across):
        return [
            sum(along[i] * across[j] * rows[i][j][axis] for i in range(4) for j in range(4)) for axis in range(3)
        ]

    (p, dp), (q, dq) = weights(u), weights(v)
    place, du, dv = sum_of(p, q), sum_of(dp, q), sum_of(p, dq)
    normal = [du[k - 2] * dv[k - 1] - du[k - 1] * dv[k - 2] for k in range(3)]
    length = sqrt(sum(n * n for n in normal))
    if length < 1e-9:  # a pole, at the top or at the bottom
        return place, (0.0, 0.0, 1.0 if place[2] > 1 else -1.0)
    return place, [-n / length for n in normal]


def triangles(count):
    """Each patch as count * count pairs of triangles; at the poles, one of a pair is left out."""
    for rows in patches():
        grid = [[point(rows, i / count, j / count) for j in range(count + 1)] for i in range(count + 1)]
        for i in range(count):
            for j in range(count):
                a, b, c, d = grid[i][j], grid[i][j + 1], grid[i + 1][j + 1], grid[i + 1][j]
                if max(abs(p - q) for p, q in zip(a[0], b[0])) > 1e-9:
                    yield a, b, c
                yield c, d, a
