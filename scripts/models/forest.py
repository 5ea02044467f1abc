"""Trees, ground and placements of scenes/forest.txt. Metres.

    python3 scripts/models/forest.py                        the small forest, in meshes/
    python3 scripts/models/forest.py FOLDER [TREES]         the same scene with 200000 trees of 50000 triangles each
    slo-rt -s FOLDER/scenes/forest.txt
"""

import math
import os
import random
import shutil
import sys

import ply
from mesh import ROOT, add, cross, lerp, mul, smoothstep, unit
from still_life import sky
from textures import fbm, hashed

EYE, VIEW = (-200.0, -430.0), (.42, .908)      # where the camera stands at first, and in which direction it looks


class Tree:
    """Points and polygons; `wood` and `green` are separate meshes."""

    def __init__(self):
        self.points, self.faces = [], []

    def polygon(self, points):
        base = len(self.points)
        self.points += points
        self.faces.append(tuple(range(base, base + len(points))))

    def leaf(self, at, along, side, long, wide):
        """A rhombus: two triangles."""
        tip, middle = add(at, mul(along, long)), add(at, mul(along, long * .45))
        self.polygon([at, add(middle, mul(side, wide)), tip, add(middle, mul(side, -wide))])

    def limb(self, a, b, thick, thin, sides=5):
        """A tapering branch."""
        along = unit((b[0] - a[0], b[1] - a[1], b[2] - a[2]))
        x = unit(cross(along, (.37, .21, .9)))
        y = cross(along, x)
        base = len(self.points)
        for p, r in ((a, thick), (b, thin)):
            for k in range(sides):
                w = math.tau * k / sides
                self.points.append(add(p, add(mul(x, r * math.cos(w)), mul(y, r * math.sin(w)))))
        for k in range(sides):
            m = (k + 1) % sides
            self.faces.append((base + k, base + m, base + sides + m, base + sides + k))


def direction(hand):
    z, a = hand.uniform(-1, 1), hand.uniform(0, math.tau)
    r = math.sqrt(1 - z * z)
    return (r * math.cos(a), r * math.sin(a), z)


def conifer(seed, polygons, height, reach, droop):
    """A trunk with whorls of boughs; each bough is a row of twigs to both sides."""
    hand = random.Random(seed)
    wood, green = Tree(), Tree()
    wood.limb((0, 0, -.6), (0, 0, height * .96), .30, .03, 6)
    boughs = []
    z = height * .10
    while z < height * .985:
        part = (z / height - .10) / .90
        size = reach * (1 - part) ** .85 * hand.uniform(.85, 1.1) + .25
        count = 5 if part < .8 else 4
        start = hand.uniform(0, math.tau)
        boughs += [(z + hand.uniform(-.2, .2), start + math.tau * (k + hand.uniform(-.2, .2)) / count,
                    size * hand.uniform(.8, 1.1)) for k in range(count)]
        z += .34 + .30 * (1 - part)
    total = sum(size for _, _, size in boughs)
    for z, turn, size in boughs:
        c, s = math.cos(turn), math.sin(turn)
        twigs = max(2, round(polygons * size / total))
        lean = droop * hand.uniform(.7, 1.3)
        for k in range(twigs):
            t = math.sqrt((k + hand.random()) / twigs) * .98 + .02
            r = size * t
            at = (c * r, s * r, z - lean * r * t + .16 * size * t * t * t)
            way = hand.choice((-1, 1)) * hand.uniform(.35, 1.25)
            along = unit((math.cos(turn + way), math.sin(turn + way), -lean * t + hand.uniform(-.35, .15)))
            side = unit(add(cross(along, (0, 0, 1)), mul(direction(hand), .5)))
            long = size * (.16 + .26 * (1 - t)) * (900 / polygons) ** .3
            green.leaf(at, along, side, long + .05, (.30 * long + .02))
    return wood, green


def broadleaf(seed, polygons, height, width):
    """A trunk that divides, and leaves in clumps about the ends of the limbs."""
    hand = random.Random(seed)
    wood, green = Tree(), Tree()
    wood.limb((0, 0, -.6), (.1, 0, height * .45), .30, .16, 6)
    clumps = []
    while len(clumps) < 70:
        d = direction(hand)
        r = hand.uniform(.45, 1) ** .5
        p = (d[0] * r * width, d[1] * r * width, height * .62 + d[2] * r * height * .36)
        if p[2] > height * .24:
            clumps.append((p, hand.uniform(.9, 1.7) * width / 4.2))
    for p, size in clumps[::2]:
        wood.limb((.05, 0, height * hand.uniform(.2, .44)), p, .09, .02, 4)
    each = polygons // len(clumps)
    for p, size in clumps:
        for _ in range(each):
            d = direction(hand)
            at = add(p, mul((d[0], d[1], d[2] * .7), size * hand.random() ** .4))
            along = unit(add(direction(hand), (d[0], d[1], -.35)))
            side = unit(cross(along, direction(hand)))
            long = .62 * (1500 / polygons) ** .42 * hand.uniform(.7, 1.2)
            green.leaf(at, along, side, long, long * .36)
    return wood, green


def ground(x, y):
    """Height above the lake, whose surface is z = 0: a valley along y between wooded hills."""
    u, v = x / 3200 + .5, y / 3200 + .5
    middle = 40 * math.sin(y / 260 + .6) + 30
    away = abs(x - middle)
    lake = 95 + 45 * math.sin(y / 190) + 30 * math.sin(y / 77)
    rise = 115 * smoothstep(lake * .7, 760, away) + 55 * smoothstep(300, 1500, y) * smoothstep(30, 500, away)
    end = 160 * smoothstep(950, 2100, y)
    hills = 70 * (fbm(u, v, 7, 7, 3, 4) - .42) * smoothstep(lake * .9, lake + 260, away + .4 * max(y - 900, 0))
    shore = 5.5 * smoothstep(lake - 25, lake + 40, away + .5 * max(y - 900, 0)) - 3
    return shore + rise + end + hills + 4 * (fbm(u, v, 60, 60, 9, 2) - .5)


def placements(count):
    """The `count` trees that matter most to the camera: x y z, turn, size, kind and tint."""
    hand = random.Random(12)
    cell = 4.25
    spots = []
    for j in range(int(2900 / cell)):
        for i in range(int(2600 / cell)):
            x, y = -1300 + (i + hand.random()) * cell, -700 + (j + hand.random()) * cell
            draws = [hand.random() for _ in range(7)]
            dx, dy = x - EYE[0], y - EYE[1]
            ahead, across = dx * VIEW[0] + dy * VIEW[1], abs(dx * VIEW[1] - dy * VIEW[0])
            if across < 70 + .72 * (ahead + 50):               # in the picture, or it throws shadows into it
                far = math.hypot(ahead, across)
                # Few trees are not all in front: their number falls with the square of the distance
                rank = far if count > 100000 else -math.log(1 - hashed(i, j, 5)) * far * far
                spots.append((rank, x, y, draws))
    spots.sort()
    rows = []
    for _, x, y, (turn, size, which, red, green, dark, thin) in spots:
        if len(rows) == count:
            break
        z = ground(x, y)
        grove = fbm(x / 3200 + .5, y / 3200 + .5, 26, 26, 40, 3)
        if z < .7 or thin < .10:
            continue
        leafy = smoothstep(.44, .60, grove + .12 * (which - .5)) - .25 * smoothstep(30, 110, z)
        kind = 0 if which > leafy else 1 if draws_gold(x, y, which, leafy) else 2
        grow = (.62 + .55 * size) * (1 - .35 * smoothstep(3, 0, z))
        tint = .72 + .5 * dark
        r, g = tint * (.85 + .3 * red), tint * (.88 + .24 * green)
        half = math.pi * turn
        lean = .05 * (dark - .5), .05 * (red - .5)
        rows.append((x, y, z, math.cos(half), *lean, math.sin(half), grow, kind, r, g, tint))
    return rows


def draws_gold(x, y, which, leafy):
    """Golden and red trees stand in groups."""
    return fbm(x / 3200 + .5, y / 3200 + .5, 70, 70, 55, 2) > .5


LIGHT = unit((-.82, .30, .34))


def autumn(d):
    """A clear evening: warm haze above the hills, warmest around the sun."""
    e = math.asin(d[2])
    near = math.acos(max(-1, min(1, sum(a * b for a, b in zip(d, LIGHT)))))
    u, v = math.atan2(d[1], d[0]) / math.tau + .5, e / math.pi + .5
    color = lerp((.06, .14, .36), (.62, .56, .52), math.exp(-max(e, 0) / .16))
    color = add(color, mul((1.5, .85, .36), math.exp(-near / .42)))
    veil = smoothstep(.46, .74, fbm(u, v * 3.0, 6, 19, 77, 4)) * smoothstep(.03, .16, e)
    color = lerp(color, add((.52, .47, .50), mul((1.4, .8, .4), math.exp(-near / .6))), .6 * veil)
    return lerp((.10, .09, .07), color, smoothstep(-.03, .0, e))


def build():
    sky("autumn", 256, 128, autumn)
    forest(ROOT, 2000, 2400)


def forest(folder, trees, polygons):
    meshes = os.path.join(folder, "meshes")
    for name, parts in (("spruce", conifer(1, polygons, 19, 3.4, .42)),
                        ("birch", broadleaf(2, polygons, 15, 3.9)),
                        ("maple", broadleaf(3, polygons, 14, 4.8))):
        for part, tree in zip(("wood", "green"), parts):
            ply.write_mesh("forest_%s_%s" % (name, part), tree.points, tree.faces, None, 3, meshes)
    cells = 96

    def point(i, j):
        # Finer near the camera
        y = -760 + 2900 * (j / cells) ** 1.6
        x = EYE[0] + (i / cells * 2 - 1) * (240 + .72 * (y + 760))
        return x, y, ground(x, y) - .15
    ply.write_mesh("forest_ground", *ply.grid(cells, cells, point), None, 2, meshes)
    rows = placements(trees)
    properties = "x y z qw qx qy qz scale kind r g b".split()
    ply.write_placements("forest", properties, rows, 3, meshes)
    return len(rows)


def main():
    folder = os.path.abspath(sys.argv[1])
    for part in ("scenes/forest.txt", "textures/autumn.hdr"):
        os.makedirs(os.path.join(folder, os.path.dirname(part)), exist_ok=True)
        shutil.copy(os.path.join(ROOT, part), os.path.join(folder, part))
    count = forest(folder, int(sys.argv[2]) if len(sys.argv) > 2 else 200000, 25000)
    print("%d trees" % count)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main()
    else:
        build()
