"""Six Staunton chess pieces; the king is 9.5 cm high and stands on a foot of 4 cm.

Every piece stands on z = 0 about the z axis; the knight looks along +y. Their wood runs along z:
uv is the position on the xz plane, as in a piece turned from one plank.
"""

import math

import knight
from clip import section, subtract
from lathe import Profile, lathe
from mesh import Mesh, add, dot, mul, unit

SEGMENTS = 56
WOOD_CM = 6.0


def wood(p):
    """A plank's grain: the same through the depth of the piece, slightly turned."""
    x = p[0] * 0.94 + p[1] * 0.34
    return (x / WOOD_CM + 0.5, p[2] / (2.2 * WOOD_CM))


def foot(radius):
    """The base that all pieces share, in millimetres: plinth, bead, step and cavetto."""
    r = radius
    return (Profile(0, 0).line(r - .7, 0).line(r, .7).line(r, 3.0, .5).line(r - .7, 3.4)
            .arc(r - 2.0, 6.6, .42)
            .line(r - 2.9, 6.6).line(r - 2.9, 7.3)
            .arc(r - 3.8, 8.6, .42))


def disc(p, r, z, thickness):
    """A thin round-edged disc on the stem: from the current end to radius r and height z."""
    return p.line(r - .5, z).arc(r - .5, z + thickness, .8)


def king():
    p = foot(20.0)
    p.line(15.4, 8.9).curve(10.2, 11.4, 7.6, 23.0, 6.5, 47.6, 12)
    disc(p.line(8.6, 48.2, .2).line(8.6, 49.6, .2).line(8.0, 50.0), 11.0, 50.8, 2.2)
    disc(p.line(8.6, 53.8), 8.9, 54.2, 1.8)
    p.line(6.6, 56.6).curve(6.9, 64.0, 8.6, 72.5, 9.7, 79.4, 10)
    p.line(10.2, 80.0, .3).line(10.2, 80.9, .3).line(8.9, 82.0)
    p.curve(8.0, 84.6, 4.4, 86.0, 2.6, 86.3, 8).line(2.2, 87.6).line(0, 87.6)
    mesh = lathe(p.scaled(.1), SEGMENTS)
    return mesh.add(cross_pattee()).map_uv(wood)


def cross_pattee():
    """The king's cross: four arms that widen outwards, bevelled on both faces."""
    w, h, arm = .135, .40, .26
    z = 8.66
    outline = [(w * .95, z), (w * 1.15, z + .06), (w * .62, z + .27)]
    outline += [(arm * 1.05, z + .235), (arm * 1.65, z + .20), (arm * 1.65, z + .46),
                (arm * 1.05, z + .425), (w * .62, z + .39)]
    top = z + .33 + h + .11
    outline += [(w * 1.25, top - .03), (w * 1.15, top)]
    outline += [(-x, y) for x, y in reversed(outline)]
    return bevelled_plate(outline, .15, .035)


def bevelled_plate(outline, half, bevel):
    """A plate in the xz plane, 2 * half thick, its outline (counter-clockwise) star-shaped."""
    inner = inset(outline, bevel)
    n = len(outline)
    cx = sum(p[0] for p in outline) / n
    cz = sum(p[1] for p in outline) / n
    mesh = Mesh()
    for i in range(n):
        j = (i + 1) % n
        a, b = outline[i], outline[j]
        c, d = inner[i], inner[j]
        mesh.polygon([(a[0], -half + bevel, a[1]), (b[0], -half + bevel, b[1]),
                      (b[0], half - bevel, b[1]), (a[0], half - bevel, a[1])])
        mesh.polygon([(c[0], -half, c[1]), (d[0], -half, d[1]),
                      (b[0], -half + bevel, b[1]), (a[0], -half + bevel, a[1])])
        mesh.polygon([(a[0], half - bevel, a[1]), (b[0], half - bevel, b[1]),
                      (d[0], half, d[1]), (c[0], half, c[1])])
        mesh.polygon([(cx, -half, cz), (d[0], -half, d[1]), (c[0], -half, c[1])][::-1])
        mesh.polygon([(cx, half, cz), (d[0], half, d[1]), (c[0], half, c[1])])
    return mesh


def inset(outline, by):
    out = []
    n = len(outline)
    for i in range(n):
        a, b, c = outline[i - 1], outline[i], outline[(i + 1) % n]
        u = unit((b[0] - a[0], b[1] - a[1], 0.0))
        v = unit((c[0] - b[0], c[1] - b[1], 0.0))
        m = (-u[1] - v[1], u[0] + v[0])
        k = by * 2.0 / max(m[0] * m[0] + m[1] * m[1], 0.6)
        out.append((b[0] + m[0] * k, b[1] + m[1] * k))
    return out


def queen():
    p = foot(19.0)
    p.line(14.4, 8.9).curve(9.6, 11.2, 7.1, 21.5, 5.9, 42.6, 12)
    disc(p.line(8.0, 43.2, .2).line(8.0, 44.6, .2).line(7.4, 45.0), 10.2, 45.8, 2.1)
    disc(p.line(8.0, 48.7), 8.2, 49.1, 1.7)
    p.line(5.9, 51.4).curve(6.1, 57.0, 6.9, 63.0, 8.4, 69.0, 8)
    crown = Profile(8.4, 69.0).curve(8.9, 71.0, 9.6, 73.0, 10.3, 74.6, 7)
    crown.line(10.3, 75.6, .3).line(9.2, 75.6, .3).line(7.6, 72.6)
    dome = Profile(7.6, 72.6).curve(6.8, 75.6, 4.6, 77.6, 2.0, 78.4, 8)
    dome.arc(0, 82.66, ball_bulge(2.0, 1.66))
    mesh = lathe(p.scaled(.1), SEGMENTS).add(lathe(crown.scaled(.1), 72, coronet))
    return mesh.add(lathe(dome.scaled(.1), 44)).map_uv(wood)


def coronet(r, z, angle):
    """Nine gouges across the rim of the queen's crown, deepest outside."""
    if r < .80 or z < 7.05:
        return r, z
    gouge = max(0.0, math.cos(angle * 9.0)) ** .75
    return r, z - .17 * gouge * min(1.0, (z - 7.05) / .4)


def bishop():
    p = foot(16.5)
    p.line(12.0, 8.9).curve(8.2, 11.0, 5.9, 19.0, 4.9, 36.0, 12)
    disc(p.line(6.8, 36.5, .2).line(6.8, 37.7, .2).line(6.2, 38.0), 9.0, 38.7, 2.0)
    disc(p.line(6.8, 41.4), 7.0, 41.7, 1.6)
    p.line(4.6, 43.8).line(0, 43.8)
    body = lathe(p.scaled(.1), SEGMENTS)
    head = Profile(0, 43.8).line(4.8, 43.8).curve(9.4, 47.0, 9.0, 54.0, 5.6, 59.6, 12)
    head.curve(4.2, 61.9, 2.6, 63.9, 1.6, 64.8, 6).line(0, 64.8)
    solid = lathe(head.scaled(.1), SEGMENTS)
    body.add(mitre_cut(solid))
    ball = Profile(0, 63.6).line(1.5, 64.5).arc(0, 68.3, ball_bulge(1.5, 1.61))
    return body.add(lathe(ball.scaled(.1), 36)).map_uv(wood)


def mitre_cut(solid):
    """The head with its slanting saw cut, 1.5 mm wide."""
    across = unit((0.0, -.62, .78))
    along = unit((0.0, .78, .62))
    middle = dot(across, (0.0, .18, 5.55))
    low = (across, middle - .075)
    high = (mul(across, -1.0), -(middle + .075))
    depth = (along, dot(along, (0.0, .02, 5.42)))
    out = subtract(solid, [low, high, depth])
    out.add(section(solid, low, [depth], across))
    out.add(section(solid, high, [depth], mul(across, -1.0)))
    out.add(section(solid, depth, [low, high], along))
    return out


def rook():
    p = foot(16.5)
    p.line(12.6, 8.9).curve(9.6, 11.0, 8.4, 19.0, 7.7, 33.2, 12)
    disc(p.line(9.4, 33.7, .2).line(9.4, 34.9, .2).line(8.9, 35.2), 11.0, 35.8, 2.0)
    p.line(8.6, 38.6).curve(8.6, 41.0, 9.2, 42.6, 10.9, 43.4, 6)
    p.line(11.3, 43.8, .3).line(11.6, 49.6).line(8.4, 49.6, .2).line(8.0, 47.2).line(0, 46.6)
    mesh = lathe(p.scaled(.1), SEGMENTS)
    for i in range(6):
        mesh.add(merlon(.8, 1.16, 4.90, 5.45, math.pi * (i / 3.0 + .04), math.pi / 3.0 * .70))
    return mesh.map_uv(wood)


def merlon(r0, r1, z0, z1, start, sweep, steps=10, bevel=.035):
    """One tooth of the battlement: a curved block with a bevelled top and sides."""
    mesh = Mesh()
    side = bevel / r1
    rows = [(r1, z0, 0, (1, 0)), (r1, z1 - bevel, 0, (1, 0)), (r1 - bevel, z1, 1, (0, 1)),
            (r0 + bevel, z1, 1, (0, 1)), (r0, z1 - bevel, 0, (-1, 0)), (r0, z0, 0, (-1, 0))]
    grid = []
    for j in range(steps + 1):
        line = []
        for r, z, _, (nr, nz) in rows:
            a = start + side + (sweep - 2.0 * side) * j / steps
            c, s = math.cos(a), math.sin(a)
            line.append(mesh.vertex((r * c, r * s, z), (nr * c, nr * s, float(nz))))
        grid.append(line)
    for low, high in zip(grid, grid[1:]):
        for i in range(len(rows) - 1):
            mesh.quad(low[i], high[i], high[i + 1], low[i + 1])
    for a, sign, edge in ((start, -1.0, grid[0]), (start + sweep, 1.0, grid[-1])):
        t = (-math.sin(a) * sign, math.cos(a) * sign, 0.0)
        shrink = [(r1 - bevel, z0), (r1 - bevel, z1 - 2 * bevel), (r1 - 2 * bevel, z1 - bevel),
                  (r0 + 2 * bevel, z1 - bevel), (r0 + bevel, z1 - 2 * bevel), (r0 + bevel, z0)]
        cap = [mesh.vertex((r * math.cos(a), r * math.sin(a), z), t) for r, z in shrink]
        for i in range(len(cap) - 1):
            order = [edge[i], edge[i + 1], cap[i + 1], cap[i]]
            mesh.quad(*(order if sign < 0.0 else order[::-1]))
        for i in range(1, len(cap) - 1):
            order = [cap[0], cap[i], cap[i + 1]]
            mesh.triangle(*(order if sign < 0.0 else order[::-1]))
    return mesh


def pawn():
    p = foot(14.5)
    p.line(10.0, 8.8).curve(6.8, 10.6, 5.2, 16.5, 4.4, 28.2, 12)
    disc(p.line(5.6, 28.6, .2), 8.2, 29.2, 2.1)
    p.line(5.0, 32.0, .2).line(4.6, 34.3)
    p.arc(0, 48.4, ball_bulge(4.6, 6.3))
    return lathe(p.scaled(.1), SEGMENTS).map_uv(wood)


def ball_bulge(r, drop):
    """Bulge of the arc from radius r, `drop` below a ball's centre, to the ball's top."""
    return math.tan((math.pi / 2.0 + math.atan2(drop, r)) / 4.0)


def knight_piece():
    p = foot(16.5)
    p.line(13.0, 8.9, .2).line(13.0, 10.2, .3).line(12.0, 11.4).line(0, 11.4)
    mesh = lathe(p.scaled(.1), SEGMENTS)
    return mesh.add(knight.head(), lambda q: add(q, (0.0, 0.0, 1.08))).map_uv(wood)


def build():
    for name, piece in (("pawn", pawn), ("rook", rook), ("bishop", bishop), ("queen", queen),
                        ("king", king), ("knight", knight_piece)):
        piece().write(name)
