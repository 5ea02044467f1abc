"""The chess board, the table's glass, the spinning cube and plain bevelled blocks."""

import math
import random

from mesh import Mesh, add, cross, lerp, mul, sub, unit

SQUARE = 5.5
HALF = 4.0 * SQUARE
FRAME = 3.4
THICK = 2.2


def bevelled_box(size, bevel, steps=4, grain=None):
    """A box about the origin with rounded edges and corners; `grain(p, n)` gives uv."""
    half = [s / 2.0 - bevel for s in size]
    mesh = Mesh()
    for axis in range(3):
        for sign in (-1.0, 1.0):
            face(mesh, half, bevel, axis, sign, steps)
    if grain:
        mesh.uvs = [grain(p, n) for p, n in zip(mesh.positions, mesh.normals)]
    return mesh


def face(mesh, half, bevel, axis, sign, steps):
    """Adds a flat side with its part (up to 45 degrees) of the rounded edges."""
    ticks = [(-1.0, -math.pi / 4.0 * (1.0 - i / steps)) for i in range(steps + 1)]
    ticks += [(1.0, math.pi / 4.0 * i / steps) for i in range(steps + 1)]
    b, c = (axis + 1) % 3, (axis + 2) % 3
    grid = []
    for sb, ab in ticks:
        row = []
        for sc, ac in ticks:
            n = [0.0, 0.0, 0.0]
            n[axis], n[b], n[c] = sign, math.tan(ab), math.tan(ac)
            size = math.sqrt(sum(x * x for x in n))
            n = [x / size for x in n]
            p = [0.0, 0.0, 0.0]
            p[axis], p[b], p[c] = sign * half[axis], sb * half[b], sc * half[c]
            row.append(mesh.vertex(tuple(q + bevel * m for q, m in zip(p, n)), tuple(n)))
        grid.append(row)
    for low, high in zip(grid, grid[1:]):
        for j in range(len(low) - 1):
            quad = [low[j], high[j], high[j + 1], low[j + 1]]
            mesh.quad(*(quad if sign > 0.0 else quad[::-1]))


def squares(parity):
    """The squares of one colour on z = 0, each a veneer with its own grain; a1 is dark."""
    pick = random.Random(40 + parity)
    mesh = Mesh()
    for file in range(8):
        for rank in range(8):
            if (file + rank) % 2 != parity:
                continue
            x, y = file * SQUARE - HALF, rank * SQUARE - HALF
            u, v = round(pick.random(), 2), round(pick.random(), 2)
            flip = pick.choice((-1.0, 1.0))
            w, h = .55 * flip, .42
            mesh.polygon([(x, y, 0.0), (x + SQUARE, y, 0.0), (x + SQUARE, y + SQUARE, 0.0),
                          (x, y + SQUARE, 0.0)], (0.0, 0.0, 1.0),
                         [(u, v), (u + w, v), (u + w, v + h), (u, v + h)])
    return mesh


def strip(inner, outer, profile, scale):
    """Four mitred lengths of a moulding; profile is (0..1 across, z, normal across, normal z)."""
    mesh = Mesh()
    for side in range(4):
        c, s = round(math.cos(side * math.pi / 2)), round(math.sin(side * math.pi / 2))

        def turned(p):
            return (p[0] * c - p[1] * s, p[0] * s + p[1] * c, p[2])

        rows = []
        for t, z, nx, nz in profile:
            x = inner + (outer - inner) * t
            n = turned((nx, 0.0, nz))
            across = (x + .5 * z) / scale + side * .37
            rows.append([mesh.vertex(turned((x, y, z)), n, (across, y / (2.0 * scale) + side * .21))
                         for y in (-x, x)])
        for low, high in zip(rows, rows[1:]):
            mesh.quad(low[0], low[1], high[1], high[0])
    return mesh


def rounded_profile(radius, thick):
    """Inner top edge to outer bottom edge of the frame, rounded at the top outside."""
    width = FRAME
    rows = [(0.0, 0.0, 0.0, 1.0)]
    for i in range(7):
        a = math.pi / 2.0 * (1.0 - i / 6.0)
        rows.append((1.0 + (math.cos(a) - 1.0) * radius / width, (math.sin(a) - 1.0) * radius,
                     math.cos(a), math.sin(a)))
    rows += [(1.0, -thick + .12, 1.0, 0.0), (1.0 - .12 / width, -thick, .7, -.7)]
    return rows[::-1]


def frame():
    inner = HALF + .45
    return strip(inner, HALF + FRAME, rounded_profile(.45, THICK), 7.0)


def inlay():
    """The thin light line between the squares and the frame."""
    return strip(HALF, HALF + .45, [(1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)], 5.0)


def cube(size=4.4, bevel=.22, gap=.14):
    """Six faces of 3 x 3 tiles: (body, tiles of each side in the order -x +x -y +y -z +z)."""
    body = bevelled_box((size, size, size), bevel, 3)
    tile = (size - 2.0 * bevel - 2.0 * gap) / 3.0
    tiles = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            side = Mesh()
            for i in range(-1, 2):
                for j in range(-1, 2):
                    extent = [tile, tile, tile]
                    extent[axis] = .12
                    centre = [0.0, 0.0, 0.0]
                    centre[axis] = sign * size / 2.0
                    centre[(axis + 1) % 3] = i * (tile + gap)
                    centre[(axis + 2) % 3] = j * (tile + gap)
                    side.add(bevelled_box(extent, .055, 1), lambda p, c=centre: add(p, c))
            tiles.append(side)
    return body, tiles


def plank(p, n):
    """Grain along x."""
    return ((p[1] + .7 * p[2] + .1 * n[0]) / 9.0, p[0] / 26.0)


def sheet(half, repeats, cells=1):
    """A square cloth on z = 0, `repeats` of its texture along a side."""
    mesh = Mesh()
    for i in range(cells):
        for j in range(cells):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            mesh.polygon([(half * (2 * a / cells - 1), half * (2 * b / cells - 1), 0.0)
                          for a, b in corners], (0.0, 0.0, 1.0),
                         [(a * repeats / cells, b * repeats / cells) for a, b in corners])
    return mesh


def cove(width, front, back, radius, height, steps=24):
    """A photographer's sweep: a floor along y that curves up into a wall."""
    mesh = Mesh()
    rows = [(front, 0.0, 0.0, 1.0)]
    for i in range(steps + 1):
        a = math.pi / 2.0 * i / steps
        rows.append((back - radius + math.sin(a) * radius, radius - math.cos(a) * radius,
                     -math.sin(a), math.cos(a)))
    rows.append((back, height, -1.0, 0.0))
    lines = []
    for k, (y, z, ny, nz) in enumerate(rows):
        lines.append([mesh.vertex((x, y, z), (0.0, ny, nz), (u, k / (len(rows) - 1.0)))
                      for x, u in ((-width / 2.0, 0.0), (width / 2.0, 1.0))])
    for low, high in zip(lines, lines[1:]):
        mesh.quad(low[0], low[1], high[1], high[0])
    return mesh


def torus(ring, tube, around, across):
    mesh = Mesh()
    grid = []
    for i in range(around):
        a = 2.0 * math.pi * i / around
        row = []
        for j in range(across):
            b = 2.0 * math.pi * j / across
            n = (math.cos(a) * math.cos(b), math.sin(a) * math.cos(b), math.sin(b))
            row.append(mesh.vertex((ring * math.cos(a) + tube * n[0],
                                    ring * math.sin(a) + tube * n[1], tube * n[2]), n))
        grid.append(row)
    for i in range(around):
        for j in range(across):
            k, m = (i + 1) % around, (j + 1) % across
            mesh.quad(grid[i][j], grid[k][j], grid[k][m], grid[i][m])
    return mesh


def strings(family, count=44, radius=7.4, low=.6, high=18.4, twist=2.15, thin=.045):
    """Straight strings of one family of a hyperboloid: six-sided, cut to short lengths."""
    mesh = Mesh()
    cuts = 8
    for i in range(count):
        a = 2.0 * math.pi * (i + (.5 if family < 0 else 0)) / count
        b = a + family * twist
        p = (radius * math.cos(a), radius * math.sin(a), low)
        q = (radius * math.cos(b), radius * math.sin(b), high)
        d = unit(sub(q, p))
        u = unit(cross(d, (0.0, 0.0, 1.0)))
        v = cross(d, u)
        rings = []
        for k in range(cuts + 1):
            c = lerp(p, q, k / cuts)
            ring = []
            for j in range(6):
                w = 2.0 * math.pi * j / 6
                n = add(mul(u, math.cos(w)), mul(v, math.sin(w)))
                ring.append(mesh.vertex(add(c, mul(n, thin)), n))
            rings.append(ring)
        for lower, upper in zip(rings, rings[1:]):
            for j in range(6):
                mesh.quad(lower[j], lower[(j + 1) % 6], upper[(j + 1) % 6], upper[j])
    return mesh


def standing(width, height):
    """A picture that stands on z = 0 and faces -y."""
    mesh = Mesh()
    w = width / 2.0
    mesh.polygon([(-w, 0.0, 0.0), (w, 0.0, 0.0), (w, 0.0, height), (-w, 0.0, height)],
                 (0.0, -1.0, 0.0), [(0, 0), (1, 0), (1, 1), (0, 1)])
    return mesh


PLATE = 76.0
"""Distance of the middle of a plate from the point that its sides run to."""


def plate():
    """A bar that narrows towards a point `PLATE` before its middle."""
    mesh = bevelled_box((10.1, 64.0, 1.0), .2, 3)
    mesh.positions = [(x * (1.0 + y / PLATE), y, z) for x, y, z in mesh.positions]
    return mesh


def build():
    standing(320.0, 180.0).write("backdrop")
    strings(1.0).write("strings_right")
    strings(-1.0).write("strings_left")
    bevelled_box((190.0, 110.0, 3.0), .6, 4, plank).write("table_top")
    cove(500.0, -160.0, 130.0, 70.0, 260.0).write("cove")
    torus(1.0, .4, 10, 5).write("torus_100")
    torus(1.0, .12, 72, 16).write("ring")
    torus(7.4, .38, 80, 14).write("hoop")
    bevelled_box((12.8, .8, 13.8), .25, 4).write("pane")
    bevelled_box((39.0, 15.0, 1.8), .35, 4, plank).write("stand")
    bevelled_box((43.0, 2.6, 1.2), .2, 3).write("rail")
    plate().write("plate")
    sheet(500.0, 1).write("sheet")
    sheet(600.0, 24).write("floor")
    squares(0).write("board_dark")
    squares(1).write("board_light")
    frame().write("board_frame")
    inlay().write("board_inlay")
    bevelled_box((120.0, 90.0, 2.0), .7, 5).write("glass_top")
    body, tiles = cube()
    body.write("cube_body")
    for name, side in zip(("left", "right", "front", "back", "down", "up"), tiles):
        side.write("cube_" + name)
