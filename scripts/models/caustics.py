"""Meshes of scenes/ring.txt, scenes/glass_of_water.txt and scenes/torus_in_glass.txt. Centimetres."""

import math

from board import bevelled_box
from lathe import Profile, lathe
from mesh import Mesh, add
from rose import tube


def band():
    """A plain ring that lies on z = 0, upright inside and round outside."""
    p = Profile(.90, 0).line(.96, 0).curve(1.02, .08, 1.02, .28, .96, .36, 10)
    p.line(.89, .36, .02).line(.86, .33, .02).line(.86, .03, .03).line(.90, 0)
    return lathe(p, 160)


def solitaire():
    """The ring that holds the diamond: a thin hoop about z, six claws along +x."""
    mesh = lathe(Profile(.86, -.085).arc(.86, .085, 1).arc(.86, -.085, 1), 96)
    for k in range(6):
        turn = math.tau * (k + .5) / 6
        c, s = math.cos(turn), math.sin(turn)
        path = [(x, r * c, r * s) for x, r in ((.90, .05), (1.06, .24), (1.14, .31), (1.40, .355))]
        mesh.add(tube(path, lambda t: .034 - .010 * t, 14, 10))
        mesh.add(ball((1.37, .335 * c, .335 * s), .040))
    collar = lathe(Profile(.215, -.025).arc(.215, .025, 1).arc(.215, -.025, 1), 48)
    return mesh.add(collar, lambda p: (p[2] + 1.10, p[0], p[1]), lambda n: (n[2], n[0], n[1]))


def ball(center, radius):
    mesh = lathe(Profile(0, -radius).arc(0, radius, 1), 12)
    return Mesh().add(mesh, lambda p: add(p, center))


def diamond(radius):
    """A brilliant of 57 facets, its table towards +z, its girdle on z = 0."""
    girdle, crown, pavilion = .018, math.tan(math.radians(34.5)), math.tan(math.radians(40.75))

    def at(r, turn, z):
        a = math.radians(turn)
        return (r * math.cos(a) * radius, r * math.sin(a) * radius, z * radius)

    def star(k):                # on the main facets of the crown on both sides
        return at(.76, 45 * k + 22.5, girdle + (1 - .76 * math.cos(math.radians(22.5))) * crown)

    def low(k):
        return at(.24, 45 * k + 22.5, -girdle - (1 - .24 * math.cos(math.radians(22.5))) * pavilion)

    def top(k):
        return at(.53, 45 * k, girdle + .47 * crown)

    def rim(j, z):
        return at(1, 22.5 * j, z)

    mesh, culet = Mesh(), at(0, 0, -girdle - pavilion)
    mesh.polygon([top(k) for k in range(8)])
    for k in range(8):
        j = 2 * k
        mesh.polygon([top(k), star(k - 1), rim(j, girdle), star(k)])
        mesh.polygon([top(k), star(k), top(k + 1)])
        mesh.polygon([culet, low(k), rim(j, -girdle), low(k - 1)])
        for i in (j, j + 1):
            mesh.polygon([star(k), rim(i, girdle), rim(i + 1, girdle)])
            mesh.polygon([low(k), rim(i + 1, -girdle), rim(i, -girdle)])
            mesh.polygon([rim(i, -girdle), rim(i + 1, -girdle), rim(i + 1, girdle), rim(i, girdle)])
    return mesh


LEVEL = 6.7


def tumbler():
    """A tumbler with twelve facets as three open surfaces: glass to air, glass to water, water to air.

    The first two are one curve that is cut where the water ends, so that no gap opens between them.
    """
    dry = Profile(0, .12).line(2.5, .12, .1).line(2.6, 0, .1).line(3.05, 0, .18).line(3.62, 9.6, .12)
    dry.line(3.42, 9.6, .1).line(3.2035, LEVEL)
    wet = Profile(3.2035, LEVEL).line(2.80, 1.35, .9).line(0, 1.15)
    water = Profile(3.2035, LEVEL).curve(3.12, LEVEL - .14, 3.0, LEVEL - .16, 2.7, LEVEL - .16, 10).line(0, LEVEL - .16)

    def facets(r, z, angle):
        part = (angle / math.tau * 12) % 1 - .5
        flat = math.cos(math.pi / 12) / math.cos(part * math.tau / 12)
        low = min(max((6.1 + .55 * math.cos(math.tau * part) - z) / .35, 0), 1)
        outside = r > 2.62 + .057 * z
        return r * (1 + 1.5 * (flat - 1) * low) if outside else r, z
    return lathe(dry, 168, facets), lathe(wet, 96), lathe(water, 96)


SPRIG = [(1.3, .9, 1.55), (.2, .5, 6.0), (-1.2, -.3, 9.0), (-3.1, -1.6, 14.2)]


def sprig():
    """The stem of a bud that leans in the tumbler."""
    return tube(SPRIG, lambda t: .15 + .03 * math.cos(7 * t) - .03 * t, 36, 14)


def torus(big, small, columns=96, rows=36):
    mesh = Mesh()
    ids = []
    for j in range(rows):
        b = math.tau * j / rows
        ids.append([])
        for i in range(columns):
            a = math.tau * i / columns
            c, s, r = math.cos(a), math.sin(a), big + small * math.cos(b)
            ids[j].append(mesh.vertex((r * c, r * s, small * math.sin(b)),
                                      (math.cos(b) * c, math.cos(b) * s, math.sin(b))))
    for j in range(rows):
        for i in range(columns):
            k, m = (j + 1) % rows, (i + 1) % columns
            mesh.quad(ids[j][i], ids[j][m], ids[k][m], ids[k][i])
    return mesh


def build():
    band().write("gold_band", 4)
    solitaire().write("solitaire", 4)
    diamond(.335).write("diamond", 4)
    for name, mesh in zip(("tumbler", "tumbler_wet", "tumbler_water"), tumbler()):
        mesh.write(name, 3)
    sprig().write("sprig")
    torus(2.0, .72).write("torus")
    bevelled_box((7, 7, 7), .12, 3).write("glass_block")


if __name__ == "__main__":
    build()
