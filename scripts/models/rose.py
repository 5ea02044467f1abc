"""A garden rose: bloom, hip with sepals, stem with thorns, compound leaves, a bud and dew.

The bloom's axis is z, its petals spring from about z = 0; the open flower is 9 cm wide.
"""

import math
import random

from lathe import Profile, lathe
from mesh import Mesh, add, cross, dot, lerp, mul, smoothstep, sub, unit

GOLDEN = math.pi * (3.0 - math.sqrt(5.0))


def sheet(mesh, rows, columns, point):
    """A curved sheet: point(u, v) for u in [-1, 1], v in [0, 1]; uv has v from base to tip."""
    grid = []
    for j in range(rows + 1):
        v = j / rows
        grid.append([mesh.vertex(point(2.0 * i / columns - 1.0, v), None, (i / columns, v))
                     for i in range(columns + 1)])
    for low, high in zip(grid, grid[1:]):
        for i in range(columns):
            mesh.quad(low[i], low[i + 1], high[i + 1], high[i])


def petal(k, count, hand):
    """point(u, v) of the k-th petal from the heart outwards."""
    age = k / (count - 1.0)
    phase = k * GOLDEN + hand.uniform(-.12, .12)
    length = 3.2 + 1.5 * age ** .8 + hand.uniform(-.12, .12)
    width = 1.25 + 1.75 * age ** .7 + hand.uniform(-.1, .1)
    start = .16 + .52 * age
    # Heading of the middle line above the horizontal: at the base, the belly and the tip.
    base = math.radians(64.0 - 34.0 * age + hand.uniform(-3, 3))
    belly = math.radians(97.0 - 27.0 * age ** 1.6 + hand.uniform(-3, 3))
    tip = math.radians(100.0 - 128.0 * age ** 2.0 + hand.uniform(-8, 8))
    roll = .04 + .55 * age + hand.uniform(-.05, .08)
    wave = [(hand.uniform(0, 6.28), hand.uniform(.7, 1.3)) for _ in range(2)]
    spiral = .16 - .08 * age
    rise = .55 * (1.0 - age)
    steps = 40
    line = [(start, rise)]
    for i in range(steps):
        t = (i + .5) / steps
        if t < .45:
            heading = base + (belly - base) * smoothstep(0.0, .45, t)
        else:
            heading = belly + (tip - belly) * smoothstep(.45, 1.05, t) ** 1.3
        r, z = line[-1]
        line.append((max(.10, r + math.cos(heading) * length / steps),
                     z + math.sin(heading) * length / steps))

    def middle(t):
        x = min(max(t, 0.0), 1.0) * steps
        i = min(int(x), steps - 1)
        return lerp(line[i], line[i + 1], x - i)

    def point(u, v):
        side = abs(u)
        reach = 1.0 - .24 * side ** 2.6 + .03 * math.exp(-(u / .12) ** 2) * age
        t = v * reach
        r, z = middle(t)
        half = width * (.22 + .78 * smoothstep(-.12, .62, t) * (1.0 - .18 * smoothstep(.75, 1, t)))
        angle = min(half / max(r, .42), 2.35)
        edge = smoothstep(.55, 1.0, side) * smoothstep(.25, .9, v)
        rim = smoothstep(.70, 1.0, v)
        r += roll * .75 * edge * edge - .10 * age * edge
        ripple = (math.sin(3.2 * u + wave[0][0]) * .5 * wave[0][1]
                  + math.sin(7.1 * u + wave[1][0]) * .22 * wave[1][1])
        r += (.05 + .17 * age) * ripple * rim
        z += (.03 + .09 * age) * ripple * rim - .18 * roll * edge
        r *= 1.0 + spiral * u
        phi = phase + u * angle
        return (r * math.cos(phi), r * math.sin(phi), z)

    return point


def bloom(count=40, seed=8, rows=15, columns=18):
    hand = random.Random(seed)
    heart, outer = Mesh(), Mesh()
    for k in range(count):
        point = petal(k, count, hand)
        sheet(heart if k < 18 else outer, rows, columns, point)
    return heart, outer


def hip():
    """The green cup under the petals."""
    return lathe(Profile(0, -1.55).line(.24, -1.5).curve(.34, -1.2, .80, -1.0, .72, -.35, 8)
                 .curve(.66, -.10, .60, .1, .50, .25, 4).line(0, .3), 28)


def sepal(turn, droop):
    def point(u, v):
        half = .42 * (1.0 - v) ** .7 * (.55 + .9 * v * (1.3 - v)) + .012
        out = .62 + 2.3 * (math.sin(v * 1.5 * droop) / (1.5 * droop))
        z = -.30 - droop * 1.15 * v * v + .12 * (u * u) * (1.0 - v)
        y = u * half
        c, s = math.cos(turn), math.sin(turn)
        return (out * c - y * s, out * s + y * c, z)
    return point


def calyx():
    mesh = Mesh()
    mesh.add(hip().map_uv(lambda p: (p[0] * .2 + .5, p[2] * .2)))
    for i in range(5):
        sheet(mesh, 10, 4, sepal(2.0 * math.pi * i / 5.0 + .3, 1.25 + .22 * (i % 3)))
    return mesh


def bezier(points, t):
    while len(points) > 1:
        points = [lerp(a, b, t) for a, b in zip(points, points[1:])]
    return points[0]


def tube(path, radius, steps=28, sides=14):
    """A round tube along a Bezier curve; radius(t)."""
    mesh = Mesh()
    grid = []
    for i in range(steps + 1):
        t = i / steps
        p = bezier(path, t)
        d = unit(sub(bezier(path, min(1.0, t + .01)), bezier(path, max(0.0, t - .01))))
        a = unit(cross(d, (.31, .95, .05)))
        b = cross(d, a)
        ring = []
        for j in range(sides + 1):
            w = 2.0 * math.pi * j / sides
            n = add(mul(a, math.cos(w)), mul(b, math.sin(w)))
            ring.append(mesh.vertex(add(p, mul(n, radius(t))), n, (j / sides * .3 + .1, t * 2.0)))
        grid.append(ring)
    for low, high in zip(grid, grid[1:]):
        for j in range(sides):
            mesh.quad(low[j], low[j + 1], high[j + 1], high[j])
    return mesh


def thorn(base, out, along):
    """A hooked thorn: a flattened cone that leans down the stem."""
    mesh = Mesh()
    side = cross(out, along)
    sides, rings = 10, 5
    grid = []
    for i in range(rings + 1):
        t = i / rings
        centre = add(base, add(mul(out, .46 * t), mul(along, -.22 * t * t)))
        size = .19 * (1.0 - t) ** 1.4 + .004
        grid.append([mesh.vertex(add(centre, add(mul(along, math.cos(w) * size * 1.3),
                                                 mul(side, math.sin(w) * size * .55))), None,
                                 (.4, .5)) for w in (2 * math.pi * j / sides
                                                     for j in range(sides))])
    for low, high in zip(grid, grid[1:]):
        for j in range(sides):
            mesh.quad(low[j], high[j], high[(j + 1) % sides], low[(j + 1) % sides])
    return mesh


STEM = [(0.0, 0.0, -1.45), (.1, .3, -7.0), (-1.2, .2, -13.0), (-.6, -.6, -24.0)]


def stem():
    mesh = tube(STEM, lambda t: .21 + .05 * t + .07 * math.exp(-(t / .03) ** 2))
    hand = random.Random(5)
    for t in (.18, .27, .41, .52, .66, .8):
        p = bezier(STEM, t)
        along = unit(sub(bezier(STEM, t - .01), bezier(STEM, t + .01)))
        w = hand.uniform(0, 2 * math.pi)
        out = unit(cross(along, (math.cos(w), math.sin(w), .1)))
        mesh.add(thorn(add(p, mul(out, .17)), out, along))
    return mesh


def leaflet(mesh, base, forward, up, size, bend):
    """A serrated leaf blade folded at its midrib; `up` is its upper side."""
    side = cross(forward, up)
    columns, rows = 8, 22

    def point(u, v):
        outline = math.sin(math.pi * v ** .82) ** .8 * (1.0 - .25 * v)
        half = .36 * size * outline
        tooth = (v * 13.0) % 1.0
        half *= 1.0 + .10 * (tooth - .5) * smoothstep(.6, 1.0, abs(u)) * (v < .97)
        along = v * size + .03 * size * tooth * smoothstep(.8, 1.0, abs(u))
        lift = .22 * half * abs(u) ** 1.2 - bend * size * v * v
        lift += .02 * size * math.sin(v * 21.0) * abs(u) * (1.0 - v)
        return add(base, add(add(mul(forward, along), mul(side, u * half)), mul(up, lift)))

    sheet(mesh, rows, columns, point)


def compound_leaf(seed, blades=5):
    """A leaf of five on its stalk: springs from the origin along +x, upper side +z."""
    hand = random.Random(seed)
    path = [(0, 0, 0), (2.0, 0, .9), (4.2, .2, 1.0), (6.0, .3, .3)]
    mesh = tube(path, lambda t: .085 - .03 * t, 14, 8)
    spots = [(1.0, 0.0, 4.6), (.66, 1.0, 3.9), (.66, -1.0, 3.9), (.34, 1.0, 3.1), (.34, -1.0, 3.1)]
    for t, way, size in spots[:blades]:
        p = bezier(path, t)
        ahead = unit(sub(bezier(path, min(1.0, t + .02)), bezier(path, t - .02)))
        forward = unit(add(mul(ahead, 1.0 if way == 0.0 else .62), (0.0, way * .80, -.12)))
        up = unit(sub((hand.uniform(-.2, .2), hand.uniform(-.2, .2) - .25 * way, 1.0),
                      mul(forward, dot(forward, (0, 0, 1)))))
        up = unit(sub(up, mul(forward, dot(up, forward))))
        leaflet(mesh, p, forward, up, size * hand.uniform(.92, 1.06), hand.uniform(.10, .24))
    return mesh


def bud():
    """A closed bud on its own cup."""
    hand = random.Random(21)
    mesh = Mesh()
    for k in range(9):
        sheet(mesh, 12, 14, petal(k, 60, hand))
    # Down into the cup, and as wide as it.
    mesh.positions = [(1.45 * x, 1.45 * y, z - .62) for x, y, z in mesh.positions]
    return mesh


def dew(seed, count):
    """(x, y, z, radius) of drops that sit on the outer petals of the bloom."""
    hand = random.Random(8)
    points = [petal(k, 40, hand) for k in range(40)]
    pick = random.Random(seed)
    out = []
    while len(out) < count:
        point = points[pick.randrange(26, 40)]
        u, v = pick.uniform(-.75, .75), pick.uniform(.45, .96)
        p = point(u, v)
        n = unit(cross(sub(point(u + .02, v), p), sub(point(u, v - .02), p)))
        if n[2] < 0.0:
            n = mul(n, -1.0)
        if n[2] > .45:
            r = pick.choice((.06, .075, .09, .12, .15))
            out.append((*add(p, mul(n, r * .55)), r))
    return out


def build():
    heart, outer = bloom()
    heart.write("rose_heart")
    outer.write("rose_outer")
    calyx().write("rose_calyx")
    stem().write("rose_stem")
    compound_leaf(3).write("rose_leaf")
    bud().write("rose_bud")
