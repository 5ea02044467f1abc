#!/usr/bin/env python3
"""Writes the scenes of Eric Haines' Standard Procedural Databases (1987) as NFF files.

    python3 scripts/models/spd.py SCENE [--size N] [-o FILE.nff]
    python3 scripts/models/spd.py --check FOLDER

SCENE is balls, gears, jacks, lattice, mount, rings, shells, sombrero, teapot, tetra or tree. Without --size, a scene
has the size that published statistics use. --check compares with the files NAME.nff, NAME.s1.nff and NAME.s2.nff of a
folder, as Haines' own programs write them: the same items in the same order, with the same numbers within rounding.

The programs here are our own; they follow the published descriptions of the scenes. Numbers have six digits, as in
Haines' files, so that counts of a structure's cells are the same to the last one. docs/reproduction.md uses them.
"""

import argparse
import math
import sys
from math import cos, pi, sin, sqrt
from pathlib import Path

import spd_teapot

SKY = (0.078, 0.361, 0.753)
SHINY = 3.0827  # a Phong exponent that falls to a half at 37 degrees
DULL = 100000


# Vectors and turns.


def plus(a, b, scale=1.0):
    return tuple(x + scale * y for x, y in zip(a, b))


def turn(axis, angle):
    """The rotation by an angle about an axis (right-handed), as three rows."""
    length = sqrt(sum(a * a for a in axis))
    x, y, z = (a / length for a in axis)
    c, s = cos(angle), sin(angle)
    k = 1 - c
    return (
        (c + x * x * k, x * y * k - z * s, x * z * k + y * s),
        (y * x * k + z * s, c + y * y * k, y * z * k - x * s),
        (z * x * k - y * s, z * y * k + x * s, c + z * z * k),
    )


def turned(rows, point):
    return tuple(sum(a * b for a, b in zip(row, point)) for row in rows)


def product(a, b):
    columns = tuple(zip(*b))
    return tuple(turned(columns, row) for row in a)


def degrees(angle):
    return angle * pi / 180


# The text of a scene.


class Scene:
    """Lines of an NFF file."""

    def __init__(self, eye, target, up=(0, 0, 1), angle=45, hither=1.0, pixels=512, sky=SKY, lights=()):
        self.lines = []
        self.add("b", sky)
        self.lines.append("v")
        for word, values in (("from", eye), ("at", target), ("up", up), ("angle", [angle]), ("hither", [hither])):
            self.add(word, values)
        self.add("resolution", (pixels, pixels))
        for light in lights:
            self.add("l", light)

    def add(self, word, *values):
        self.lines.append(" ".join([word] + [f"{value:g}" for group in values for value in group]).strip())

    def fill(self, color, diffuse, mirror=0.0, shine=DULL, glass=0.0, index=0.0):
        self.add("f", color, (diffuse, mirror, shine, glass, index))

    def sphere(self, center, radius):
        self.add("s", center, [radius])

    def cone(self, base, base_radius, apex, apex_radius):
        self.add("c", base, [base_radius], apex, [apex_radius])

    def polygon(self, corners):
        self.add("p", [len(corners)])
        for corner in corners:
            self.add("", corner)

    def patch(self, corners):
        """A polygon of points with normals."""
        self.add("pp", [len(corners)])
        for point, normal in corners:
            self.add("", point, normal)

    def text(self):
        return "\n".join(self.lines) + "\n"


def square(half, z):
    return [(half, half, z), (-half, half, z), (-half, -half, z), (half, -half, z)]


# The scenes.


def balls(size):
    """A sphereflake: each sphere has nine children of a third of its radius."""
    scene = Scene((2.1, 1.3, 1.7), (0, 0, 0), hither=0.01, lights=[(4, 3, 2), (1, -4, 4), (-3, 1, 5)])
    scene.fill((1, 0.75, 0.33), 0.8, index=1)
    scene.polygon(square(12, -0.5))
    scene.fill((1, 0.9, 0.7), 0.5, 0.5, SHINY, index=1)

    tilt = turn((1, -1, 0), math.asin(2 / sqrt(6)))
    trio = [turned(tilt, [a / sqrt(2) for a in v]) for v in ((1, 1, 0), (1, 0, -1), (0, 1, -1))]
    directions = [turned(turn((0, 0, 1), degrees(120 * k)), v) for k in range(3) for v in trio]

    def flake(depth, center, radius, direction):
        scene.sphere(center, radius)
        if depth == 0:
            return
        if direction[2] > 1 - 1e-9:
            upright = turn((0, 0, 1), 0)
        elif direction[2] < -1 + 1e-9:
            upright = turn((0, 1, 0), pi)
        else:
            upright = turn((-direction[1], direction[0], 0), math.acos(direction[2]))
        for child in directions:
            way = turned(upright, child)
            flake(depth - 1, plus(center, way, radius * 4 / 3), radius / 3, way)

    flake(size, (0, 0, 0), 0.5, (0, 0, 1))
    return scene


def gears(size):
    """A cube of gears, each of two faces with 144 corners and 144 rectangles; every fifth is of glass."""
    lights = [(2, 4, 4), (-2, 4, 3), (2, -2.5, 2.5), (-1, -4, 2), (-1.111, -2.121, 2.626)]
    scene = Scene((-1.1, -2.1, 2.6), (0, 0, 0), lights=lights)
    scene.fill((1, 0.85, 0.7), 0.3, 0.6, SHINY)
    scene.polygon(square(2, 0))
    outer = 1 / (size - (size - 1) * 0.05)
    thick = min(0.1, 1 / (2 * size))
    # The share of a tooth's 10 degrees, and the radius, of its four corners.
    tooth = ((-0.19, 0.995), (0.19, 0.995), (0.3, 0.9), (0.7, 0.9))
    for iz in range(size):
        for iy in range(size):
            for ix in range(size):
                color = [
                    0.01 + (3 * a + 2 * b + c + 1) * f / 7 % 1
                    for a, b, c, f in ((ix, iy, iz, 5), (iy, iz, ix, 3), (iz, ix, iy, 2))
                ]
                color = [c / max(color) for c in color]
                if (4 * ix + 2 * iy + iz) % 5 == 0:
                    scene.fill(color, 0.2, glass=0.8, index=1.1)
                else:
                    scene.fill(color, 1)
                center = (-1 + outer + ix * 1.9 * outer, -1 + outer + iy * 1.9 * outer, 1 - iz / size)
                first = pi / 36 if (ix + iy + iz) % 2 else 0
                outline = [
                    (
                        center[0] + outer * radius * cos(first + degrees(10 * (k + share))),
                        center[1] + outer * radius * sin(first + degrees(10 * (k + share))),
                    )
                    for k in range(36)
                    for share, radius in tooth
                ]
                top, bottom = center[2], center[2] - thick
                scene.polygon([(x, y, top) for x, y in outline])
                for (x, y), (u, v) in zip(outline, outline[1:] + outline[:1]):
                    scene.polygon([(x, y, top), (x, y, bottom), (u, v, bottom), (u, v, top)])
                scene.polygon([(x, y, bottom) for x, y in outline[1::-1] + outline[:1:-1]])
    return scene


def jacks(size):
    """Jacks of three cylinders and six spheres, each with eight children of half its size."""
    scene = Scene(
        (0, 0, -8), (0, 0, 0), (0, 1, 0), 25, 0.001, 256, sky=(0.2, 0.05, 0.2), lights=[(-10, 3, -20)]
    )
    scene.fill((0.737, 0.561, 0.561), 0.7, 0.7, 11.1434, index=1)
    whole = product(turn((1, 0, 0), degrees(-30)), turn((0, 1, 0), degrees(-20)))

    def jack(depth, center, scale):
        ends = [turned(whole, [0.75 * scale * (axis == k) for k in range(3)]) for axis in range(3)]
        for end in ends:
            scene.cone(plus(center, end, -1), 0.075 * scale, plus(center, end), 0.075 * scale)
        for side in (1, -1):
            for end in ends:
                scene.sphere(plus(center, end, side), 0.15 * scale)
        if depth > 1:
            for corner in range(8):
                way = [scale * (0.5 if corner >> k & 1 else -0.5) for k in (2, 1, 0)]
                jack(depth - 1, plus(center, turned(whole, way)), scale / 2)

    jack(size, (0, 0, 0), 1)
    return scene


def lattice(size):
    """Spheres on a grid, and cylinders along its edges."""
    middle = (size // 2 + 0.5) / size
    near, far = 1 - 0.5 / size, -1 - 0.5 / size
    lights = [tuple(value if axis == k else 0.5 for k in range(3)) for axis in range(3) for value in (2, -1)]
    scene = Scene((middle, 1, near), (middle, -1, far), (0.2, 1, 0), 60, 0, lights=lights)
    inset = 0.12375 / size
    colors = ((0.9, 0.1, 0.1), (0.1, 0.9, 0.1), (0.1, 0.1, 0.9))
    steps = range(size + 1)
    for cell in ((x, y, z) for x in steps for y in steps for z in steps):
        place = [c / size for c in cell]
        scene.fill((0.9, 0.9, 0.9), 0.5, 0.5, SHINY)
        scene.sphere(place, 0.25 / size)
        for axis, color in enumerate(colors):
            if cell[axis] < size:
                scene.fill(color, 0.99)
                along = [inset * (axis == k) for k in range(3)]
                end = [(c + (axis == k)) / size for k, c in enumerate(cell)]
                scene.cone(plus(place, along), 1 / (16 * size), plus(end, along, -1), 1 / (16 * size))
    return scene


def mount(size):
    """A fractal mountain by displaced midpoints, and four balls of glass."""
    scene = Scene((-1.6, 1.6, 1.7), (0, 0, 0), hither=0.01, lights=[(-100, -100, 100)])
    scene.fill((1, 1, 1), 0.1, 0.1, 101.148, 0.9, 1.5)
    around = sqrt(1.5) * 0.17
    low, wide = -around / 3, around * sqrt(8) / 3
    scene.sphere((-0.8, 0.8, 1 + around), 0.17)
    for k in range(3):
        angle = degrees(-45 + 120 * k)
        scene.sphere((-0.8 + wide * cos(angle), 0.8 + wide * sin(angle), 1 + low), 0.17)
    scene.fill((0.5, 0.45, 0.35), 1)
    ratio = 2 / 2 ** (1 / 1.2)
    roughness = sqrt(ratio * ratio - 1)
    cells = 2**size
    heights = {(x, y): 0.0 for x in (0, cells) for y in (0, cells)}

    def deviate(x, y):
        state = 21 + (((x << 23 >> size) + (y << 15 >> size) + (x << 7 >> size)) & 0xFFFF)
        while True:
            pair = []
            for _ in range(2):
                state = (28411 + 8121 * state) % 134456
                pair.append(2 * state / 134456 - 1)
            square = pair[0] ** 2 + pair[1] ** 2
            if 0 < square < 1:
                return pair[0] * sqrt(-2 * math.log(square) / square)

    def displaced(x, y, amount, *ends):
        if (x, y) not in heights:
            heights[x, y] = sum(heights[end] for end in ends) / len(ends) + amount * deviate(x, y)
        return x, y

    def surface(x, y, cells_left, amount):
        half = cells_left // 2
        a, b, c, d = corners = (x, y), (x + cells_left, y), (x + cells_left, y + cells_left), (x, y + cells_left)
        if half == 0:
            points = [(-1 + 2 * i / cells, -1 + 2 * j / cells, heights[i, j]) for i, j in corners]
            scene.polygon(points[:3])
            scene.polygon([points[2], points[3], points[0]])
            return
        displaced(x + half, y + half, amount * 1.4142136, *corners)
        for (i, j), (k, l) in ((a, b), (b, c), (c, d), (d, a)):
            displaced((i + k) // 2, (j + l) // 2, amount, (i, j), (k, l))
        for i, j in ((x, y), (x + half, y), (x + half, y + half), (x, y + half)):
            surface(i, j, half, amount / 2)

    surface(0, 0, cells, roughness)
    return scene


def rings(size):
    """A pyramid of objects of six rings, each ring five spheres and five cylinders."""
    spacing = 1 / sin(pi / 8)
    lights = [(3, -spacing, 3), (-4, -spacing, 1), (2, -spacing, -4)]
    scene = Scene((-1, -spacing, 0.5), (-1, 1 - spacing, 0.5), lights=lights)
    scene.fill((1, 1, 1), 1)
    back = spacing * (size + 1)
    half = 1.01 * (back + spacing) * math.tan(pi / 8)
    scene.polygon([(-1 + half * a, back, 0.5 + half * b) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))])
    radius = 0.07412
    scale = 1 / (1 + radius)
    tilt = turn((1, 0, 0), 2 * math.acos(cos(degrees(60)) / sin(degrees(36))))
    turns = [turn((0, 0, 1), 0)]
    turns += [product(turn((0, 0, 1), degrees(36 + 72 * k)), tilt) for k in range(5)]
    pentagon = [(scale * cos(degrees(72 * k)), scale * sin(degrees(72 * k)), 0) for k in range(5)]
    colors = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 1), (1, 0, 1), (1, 1, 0))
    for layer in range(size):
        for z in range(-layer, layer + 1, 2):
            for x in range(-layer, layer + 1, 2):
                center = (x, spacing * (layer + 1), z)
                for color, way in zip(colors, turns):
                    scene.fill(color, 0.5, 0.2, SHINY)
                    corners = [plus(center, turned(way, corner)) for corner in pentagon]
                    for before, corner in zip(corners[-1:] + corners, corners):
                        scene.cone(corner, radius, before, radius)
                        scene.sphere(corner, radius)
    return scene


def shells(size):
    """Spheres along a spiral, each overlapping many others."""
    scene = Scene((-6, -60, 35), (0, 8, -15), hither=0.5, lights=[(-100, -100, 100)])
    scene.fill((1, 0.8, 0.4), 0.8, 0.2, 45.2776, index=1)
    steps = 180 * 2**size
    for step in range(-2 * steps // 3, steps // 3 + 1):
        angle = 18 * pi * step / steps
        radius = math.exp(0.15 * angle)
        scene.sphere((radius * sin(angle), radius * cos(angle), -2 * radius), radius)
    return scene


def sombrero(size):
    """A height field. Its function is sampled at slightly other places than its points, as in Haines' program."""
    scene = Scene((0, 5, -8), (0, 0, 0), angle=40, hither=0.01, lights=[(10, 10, -10)])
    scene.fill((1, 0.1, 0.1), 0.8, 0, 2.60078, index=1)
    count = 32 * 2 ** (size - 1)

    def point(i, j):
        away = math.hypot(-4 + 8 * i / count, -4 + 8 * j / count)
        height = -3 + cos(2 * pi * away) * math.exp(-away)
        return -4 + 8 * i / (count - 1), height, -4 + 8 * j / (count - 1)

    for j in range(count - 1):
        for i in range(count - 1):
            scene.polygon([point(i, j), point(i + 1, j + 1), point(i + 1, j)])
            scene.polygon([point(i, j), point(i, j + 1), point(i + 1, j + 1)])
    return scene


def teapot(size):
    """Newell's teapot on a chess board."""
    scene = Scene((4.86, 7.2, 5.4), (0, 0, 0), lights=[(-3.1, 9.8, 12.1), (11.3, 5.1, 8.8)])
    side = 8 / size
    for color in (1, 0.5):
        scene.fill((color, color, color), 0.5, 0.5, 4.81884)
        for i in range(size):
            for j in range(size):
                if (i + j) % 2 == (color == 1):
                    x, y = -4 + side * i, -4 + side * j
                    scene.polygon([(x, y, 0), (x + side, y, 0), (x + side, y + side, 0), (x, y + side, 0)])
    scene.fill((1, 0.5, 0.1), 0.75, 0.25, SHINY)
    for triangle in spd_teapot.triangles(size):
        scene.patch(triangle)
    return scene


def tetra(size):
    """A tetrahedron of tetrahedra, after Sierpinski."""
    scene = Scene(
        (1.022846, -3.177154, -2.174512),
        (-0.004103, -0.004103, 0.216539),
        (-0.816497, -0.816497, 0.816497),
        lights=[(2, -18, -5)],
    )
    scene.fill((1, 0.2, 0.2), 1)
    corners = [(-1, -1, 1), (-1, 1, -1), (1, -1, -1), (1, 1, 1)]

    def part(depth, center, half):
        if depth > 1:
            for corner in corners:
                part(depth - 1, plus(center, corner, half / 2), half / 2)
            return
        a, b, c, d = (plus(center, corner, half) for corner in corners)
        for face in ((a, b, c), (d, c, b), (c, d, a), (b, a, d)):
            scene.polygon(face)

    part(size, (0, 0, 0), 1)
    return scene


def tree(size):
    """A tree of cones with spheres at their ends; each branch ends in two."""
    lights = [
        (-5, 5, 50), (30, -30, 30), (-40, -30, 20), (10, 30, 40), (-30, 40, 10), (50, 25, 20), (-10, -60, 30)
    ]  # fmt: skip
    scene = Scene((4.5, 0.4, 2), (0, 0, 1.5), lights=lights)
    scene.fill((0.2, 0.7, 0.2), 1)
    scene.polygon(square(50, 0))
    scene.fill((0.55, 0.4, 0.2), 1)
    branches = [
        (product(turn((0, 0, 1), degrees(around)), turn((1, 0, 0), degrees(tilt))), length)
        for around, tilt, length in ((90, 40, 0.65), (230, 25, 0.7))
    ]

    def branch(depth, base, way, length, radius):
        end = plus(base, turned(way, (0, 0, length)))
        scene.cone(base, radius, end, radius * 0.67)
        scene.sphere(end, radius * 0.67)
        if depth > 0:
            for turning, shorter in branches:
                branch(depth - 1, end, product(way, turning), length * shorter, radius * 0.67)

    branch(size, (0, 0, 0), turn((0, 0, 1), 0), 1, 0.15)
    return scene


# Each scene, and the size that published statistics use.
SCENES = {
    balls: 4, gears: 4, jacks: 4, lattice: 12, mount: 6, rings: 7, shells: 5, sombrero: 1, teapot: 12, tetra: 6, tree: 11
}  # fmt: skip
BY_NAME = {scene.__name__: (scene, size) for scene, size in SCENES.items()}
# Sizes of files without a size in their names, where they are others.
OF_FILES = {"jacks": 1, "teapot": 6}


def text(name, size=None):
    """Returns a scene as NFF."""
    scene, usual = BY_NAME[name]
    return scene(usual if size is None else size).text()


def difference(ours, theirs):
    """Returns the largest difference of numbers, relative to 1 or to larger numbers, or words if the items differ."""
    ours, theirs = ours.split(), theirs.split()
    if len(ours) != len(theirs):
        return f"{len(ours)} words instead of {len(theirs)}"
    worst = 0.0
    for place, (a, b) in enumerate(zip(ours, theirs)):
        if a[0].isalpha() or b[0].isalpha():
            if a != b:
                return f"word {place}: {a} instead of {b}"
        else:
            worst = max(worst, abs(float(a) - float(b)) / max(1.0, abs(float(b))))
    return worst


def check(folder):
    """Compares with a folder of files. Returns whether all agree."""
    agree, files = True, sorted(folder.glob("*.nff"))
    for file in files:
        name, _, size = file.stem.partition(".s")
        if name not in BY_NAME:
            continue
        ours = text(name, int(size) if size else OF_FILES.get(name))
        found = difference(ours, file.read_text())
        same = isinstance(found, float) and found < 2e-5
        agree &= same
        print(f"{file.name:20} {'same' if same else 'DIFFERS'}: {found}")
    return agree and bool(files)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n\n")[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("scene", nargs="?", choices=sorted(BY_NAME), help="the scene")
    parser.add_argument("--size", type=int, metavar="N", help="size factor; by default that of published statistics")
    parser.add_argument("-o", "--output", metavar="FILE", help="file to write; without it, standard output")
    parser.add_argument("--check", metavar="FOLDER", type=Path, help="compare with the files of a folder")
    options = parser.parse_args()
    if options.check:
        sys.exit(0 if check(options.check) else 1)
    if not options.scene:
        parser.error("which scene?")
    if options.size is not None and options.size < (1 if options.scene in ("gears", "sombrero", "jacks") else 0):
        parser.error("the size is too small")
    written = text(options.scene, options.size)
    if options.output:
        Path(options.output).write_text(written, encoding="ascii")
    else:
        sys.stdout.write(written)


if __name__ == "__main__":
    main()
