"""Meshes and tiles of scenes/pool.txt: a basin with its deck, a ladder, a rubber ring and waves. Metres."""

import math
import random

import png
import ply
from mesh import Mesh, add, cross, lerp, mul, smoothstep, sub, unit
from still_life import srgb
from textures import fbm, hashed

LEFT, RIGHT, NEAR, FAR = -3.0, 3.0, -2.2, 2.0
FLOOR, DECK = -1.35, .14
TILES = 16              # tiles in a texture
TILE = .06              # side of a tile


def waves():
    """The surface of the water: a sum of small waves in all directions, long ones higher."""
    hand = random.Random(7)
    parts = []
    for k in range(26):
        number = 3.2 * 1.13 ** k * hand.uniform(.93, 1.07)          # radians per metre
        if number > 26:
            break
        turn = .5 + hand.gauss(0, 1.1)
        parts.append((number * math.cos(turn), number * math.sin(turn), hand.uniform(0, math.tau),
                      .040 / number ** 1.15))

    def point(i, j):
        x, y = LEFT + (RIGHT - LEFT) * i / 136, NEAR + (FAR - NEAR) * j / 96
        return x, y, sum(a * math.sin(kx * x + ky * y + p) for kx, ky, p, a in parts)

    ply.write_mesh("pool_water", *ply.grid(136, 96, point), digits=5)


def wall(mesh, a, b, low, high):
    """A wall from a to b, seen from its left; uvs count textures."""
    size = TILES * TILE
    width = math.dist(a, b) / size
    mesh.polygon([(*a, low), (*b, low), (*b, high), (*a, high)], None,
                 [(0, low / size), (width, low / size), (width, high / size), (0, high / size)])


def basin():
    """The floor and the walls up to the water line, and a band of dark tiles above it."""
    corners = [(RIGHT, NEAR), (LEFT, NEAR), (LEFT, FAR), (RIGHT, FAR), (RIGHT, NEAR)]
    pale, band = Mesh(), Mesh()
    size = TILES * TILE
    pale.polygon([(x, y, FLOOR) for x, y in reversed(corners[:4])], None,
                 [(x / size, y / size) for x, y in reversed(corners[:4])])
    for a, b in zip(corners, corners[1:]):
        wall(pale, b, a, FLOOR, -.12)
        wall(band, b, a, -.12, DECK - .03)
    for y in (-.35, 1.05):                                         # two lanes of dark tiles on the floor
        z = FLOOR + .002
        band.polygon([(LEFT, y - .12, z), (RIGHT, y - .12, z), (RIGHT, y + .12, z), (LEFT, y + .12, z)], None,
                     [(LEFT / size, -.125), (RIGHT / size, -.125), (RIGHT / size, .125), (LEFT / size, .125)])
    pale.write("pool_basin")
    band.write("pool_band")


def slab(x0, y0, x1, y1, z, bevel):
    """The visible polygons of a slab: top, bevels and a little of its sides."""
    loops = []
    for inset, depth in ((bevel, 0), (0, bevel), (0, .06)):
        loops.append([(x0 + inset, y0 + inset, z - depth), (x1 - inset, y0 + inset, z - depth),
                      (x1 - inset, y1 - inset, z - depth), (x0 + inset, y1 - inset, z - depth)])
    return [loops[0]] + [[lower[k], lower[(k + 1) % 4], upper[(k + 1) % 4], upper[k]]
                         for upper, lower in zip(loops, loops[1:]) for k in range(4)]


def stones():
    """A rim of stones around the water."""
    mesh, edge, over = Mesh(), .34, .03

    def stone(*corners):
        for points in slab(*corners, DECK, .012):
            mesh.polygon(points)
    for k in range(10):
        x = LEFT + (RIGHT - LEFT) * k / 10
        for y0, y1 in ((FAR - over, FAR + edge), (NEAR - edge, NEAR + over)):
            stone(x + .003, y0, x + .597, y1)
    long = FAR - NEAR - 2 * over
    for k in range(7):
        y = NEAR + over + long * k / 7
        for x0, x1 in ((LEFT - edge, LEFT + over), (RIGHT - over, RIGHT + edge)):
            stone(x0, y, x1, y + long / 7 - .003)
    for x0, x1 in ((LEFT - edge, LEFT), (RIGHT, RIGHT + edge)):
        stone(x0, FAR, x1, FAR + edge)
        stone(x0, NEAR - edge, x1, NEAR)
    mesh.write("pool_stones")


def planks():
    """A deck of planks beyond the stones, each with its own piece of the wood."""
    hand, edge = random.Random(3), .345
    points, uvs, faces = [], [], []

    def plank(x0, y0, x1, y1):
        u, v = hand.random(), hand.random()
        for polygon in slab(x0, y0, x1, y1, DECK - .02, .006):
            faces.append(tuple(range(len(points), len(points) + 4)))
            points.extend(polygon)
            uvs.extend((u + (y - y0) * .9, v + (x - x0) * .45) for x, y, _ in polygon)
    for k in range(22):                                            # behind the pool, along x
        y = FAR + edge + k * .125
        x = -7.0 - hand.random() * 2
        while x < 7:
            plank(x, y, x + 2.4, y + .12)
            x += 2.405
    for k in range(6):                                             # before it, up to the camera
        y = NEAR - edge - .13 - k * .125
        plank(-3.3, y, .2 * k, y + .12)
        plank(.2 * k + .005, y, 3.3, y + .12)
    for k in range(34):                                            # on both sides
        y = NEAR - edge + k * .14
        plank(-7, y, LEFT - edge, y + .135)
        plank(RIGHT + edge, y, 7, y + .135)
    ply.write_mesh("pool_planks", points, faces, uvs, 3)


def sweep(mesh, path, radius, sides=16):
    """A round tube along points."""
    rings = []
    up = (0.0, 1.0, 0.0)
    for i, p in enumerate(path):
        along = unit(sub(path[min(i + 1, len(path) - 1)], path[max(i - 1, 0)]))
        a = unit(cross(along, up))
        b = cross(along, a)
        rings.append([mesh.vertex(add(p, mul(n, radius)), n) for n in
                      (add(mul(a, math.cos(w)), mul(b, math.sin(w)))
                       for w in (math.tau * j / sides for j in range(sides)))])
    for low, high in zip(rings, rings[1:]):
        for j in range(sides):
            k = (j + 1) % sides
            mesh.quad(low[j], low[k], high[k], high[j])


def ladder():
    """Two bent tubes and three steps at the wall x = 0; +x is over the water."""
    mesh = Mesh()
    for y in (-.25, .25):
        path = [(-.42, y, 0), (-.42, y, .4)]
        path += [(-.17 - .25 * math.cos(math.radians(a)), y, .45 + .25 * math.sin(math.radians(a)))
                 for a in range(0, 181, 12)]
        path += [(.08, y, .4), (.08, y, -.3), (.08, y, -.7), (.08, y, -1.05)]
        sweep(mesh, path, .021)
    for z in (-.35, -.65, -.95):
        for x in (.05, .11):
            rail = Mesh()
            sweep(rail, [(0, 0, -.25), (0, 0, .25)], .017, 12)
            mesh.add(rail, lambda p, x=x, z=z: (p[0] + x, p[2], p[1] + z), lambda n: (n[0], n[2], n[1]))
    mesh.write("pool_ladder", 4)


def ring():
    """A rubber ring; u runs round it, v round its tube."""
    columns, rows, big, small = 72, 28, .40, .145
    mesh = Mesh()

    def point(i, j):
        a, b = math.tau * i / columns, math.tau * j / rows
        c, s = math.cos(a), math.sin(a)
        r = big + small * math.cos(b)
        return mesh.vertex((r * c, r * s, small * math.sin(b)), (math.cos(b) * c, math.cos(b) * s, math.sin(b)),
                           (i / columns, j / rows))
    ids, quads = ply.grid(columns, rows, point)
    for quad in quads:
        mesh.quad(*(ids[k] for k in quad))
    mesh.write("pool_ring")


def tiles(name, low, high, seed, spread):
    """Mosaic of TILES x TILES tiles with pale joints."""
    size = 384
    pitch = size / TILES

    def pixel(x, y):
        i, j = int(x / pitch), int(y / pitch)
        fx, fy = (x + .5) / pitch - i, (y + .5) / pitch - j
        k = .5 + spread * (hashed(i, j, seed) - .5) + .25 * (hashed(i, j, seed + 1) - .5)
        color = lerp(low, high, min(max(k, 0), 1))
        color = mul(color, .93 + .14 * fbm((x + .5) / size, (y + .5) / size, 24, 24, seed + 2, 2))
        joint = smoothstep(.045, .085, min(fx, fy, 1 - fx, 1 - fy))
        return tuple(srgb(c) for c in lerp((.62, .66, .64), color, joint))
    png.write(name, size, size, pixel)


def stripes():
    """Red and white around the rubber ring."""
    def pixel(x, y):
        u = (x + .5) / 256 * 4 % 1
        k = smoothstep(.245, .255, abs(u - .5))
        return tuple(srgb(c) for c in lerp((.72, .045, .03), (.85, .84, .80), k))
    png.write("pool_ring", 256, 2, pixel)


def ball():
    """A beach ball: six segments round its axis, and a white cap at each pole."""
    colors = [(.80, .78, .72), (.85, .10, .04), (.80, .78, .72), (.95, .55, .02), (.80, .78, .72), (.02, .22, .55)]

    def pixel(x, y):
        u, v = (x + .5) / 384 * 6, (y + .5) / 192
        k = int(u)
        near = (u - k) if u - k < .5 else (u - k - 1)
        color = lerp(colors[k], colors[(k - 1 if near > 0 else k + 1) % 6], smoothstep(.03, -.03, abs(near)))
        cap = smoothstep(.115, .105, min(v, 1 - v))
        return tuple(srgb(c) for c in lerp(color, colors[0], cap))
    png.write("beach_ball", 384, 192, pixel)


def build():
    waves()
    basin()
    stones()
    planks()
    ladder()
    ring()
    tiles("tiles_pale", (.13, .50, .60), (.34, .74, .78), 11, .9)
    tiles("tiles_dark", (.012, .07, .17), (.03, .16, .30), 21, 1.0)
    stripes()
    ball()


if __name__ == "__main__":
    build()
