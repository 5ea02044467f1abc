"""Meshes and the label of scenes/perfume.txt: a flacon, a jar and a lipstick."""

import math

import png
from board import bevelled_box
from lathe import Profile, lathe
from mesh import lerp, smoothstep

SEGMENTS = 144


def square(r, z, angle):
    """Makes wide rings rectangular with round corners, and leaves the neck round."""
    w = smoothstep(1.15, 2.1, r)
    deep, power = 1 - .4 * w, 2 + 5 * w
    c, s = abs(math.cos(angle)), abs(math.sin(angle)) / deep
    return r * (c ** power + s ** power) ** (-1 / power), z


def flacon():
    """Thick glass, 10 cm high; the hollow inside begins above the perfume."""
    p = Profile(0, .2).line(2.5, .2, .1).line(2.7, 0, .1).line(3.0, 0, .22).line(3.0, 8.3, .7)
    p.line(1.0, 8.8, .25).line(1.0, 10, .12).line(.6, 10, .1).line(.6, 8.6, .3)
    p.line(2.3, 8.0, .4).line(2.3, 6.7, .12).line(0, 6.7)
    return lathe(p, SEGMENTS, square)


def perfume():
    """The perfume in the flacon, which has the refractive index of the glass around it."""
    p = Profile(0, 1.25).line(2.3, 1.25, .35).line(2.3, 6.68, .1).line(0, 6.68)
    return lathe(p, SEGMENTS, square)


def collar():
    p = Profile(1.02, 8.88).line(1.5, 8.88, .1).line(1.5, 9.25, .1).line(1.28, 9.25, .06).line(1.28, 9.9)
    return lathe(p.line(1.02, 9.9), 64)


def jar():
    p = Profile(0, 0).line(2.5, 0, .3).line(2.7, 2.3, .25).line(2.35, 2.5, .05).line(2.35, 2.7).line(0, 2.7)
    return lathe(p, 96)


def jar_lid():
    p = Profile(0, 2.62).line(2.62, 2.62, .06).line(2.62, 3.7, .16).line(2.25, 3.78, .1).line(0, 3.72)
    return lathe(p, 96)


def lipstick_case():
    p = Profile(0, 0).line(.95, 0, .06).line(.95, 2.9, .08).line(.8, 2.9).line(0, 2.9)
    return lathe(p, 64)


def lipstick_tube():
    p = Profile(.8, 2.85).line(.8, 4.3, .06).line(.66, 4.3, .04).line(.66, 4.0)
    return lathe(p, 64)


def lipstick():
    """The colour itself, cut aslant."""
    p = Profile(0, 3.8).line(.64, 3.8).line(.64, 5.1).line(.64, 5.6, .12).line(0, 5.65)

    def cut(r, z, angle):
        return r, z + .75 * r * math.cos(angle) / .64 * smoothstep(4.6, 5.5, z)
    return lathe(p, 64, cut)


def lipstick_cap():
    p = Profile(0, 0).line(.95, 0, .1).line(.95, 3.3, .05).line(.84, 3.3, .05).line(.84, .2).line(0, .2)
    return lathe(p, 64)


def plate():
    """A metal label in the xz plane, with uvs on its front."""
    size = (2.5, .14, 1.5)
    return bevelled_box(size, .05, 3, lambda p, n: (p[0] / size[0] + .5, p[2] / size[2] + .5))


def stroke(x, y, points):
    """Distance from a polyline."""
    best = 9.0
    for (ax, ay), (bx, by) in zip(points, points[1:]):
        dx, dy = bx - ax, by - ay
        t = min(max(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy), 0), 1)
        best = min(best, math.hypot(x - ax - t * dx, y - ay - t * dy))
    return best


def label():
    """SLO in a thin frame, engraved: dark on light."""
    def arc(cx, cy, r, start, end, squeeze=1.0):
        steps = [math.radians(start + (end - start) * i / 24) for i in range(25)]
        return [(cx + squeeze * r * math.cos(a), cy + r * math.sin(a)) for a in steps]

    shapes = [arc(.48, .565, .095, 20, 270) + arc(.48, .375, .095, 84, -160),
              [(.77, .66), (.77, .28), (.94, .28)],
              arc(1.19, .47, .19, 0, 360, .85)]

    def pixel(px, py):
        x, y = (px + .5) / 384 * 5 / 3, 1 - (py + .5) / 230
        d = min(stroke(x, y, shape) for shape in shapes) - .014
        edge = abs(max(abs(x - 5 / 6) - 5 / 6, abs(y - .5) - .5) + .09) - .004
        return lerp((1, 1, 1), (.03, .02, .015), smoothstep(.007, -.003, min(d, edge)))
    png.write("label", 384, 230, pixel)


def build():
    flacon().write("flacon")
    perfume().write("perfume")
    collar().write("flacon_collar")
    bevelled_box((3.1, 2.3, 3.3), .3, 5).write("flacon_cap")
    plate().write("flacon_label")
    jar().write("jar")
    jar_lid().write("jar_lid")
    lipstick_case().write("lipstick_case")
    lipstick_tube().write("lipstick_tube")
    lipstick().write("lipstick")
    lipstick_cap().write("lipstick_cap")
    label()


if __name__ == "__main__":
    build()
