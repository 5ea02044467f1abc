"""Shapes and pictures of scenes/flag.txt: a flag in the wind, one shape for each 24th of a second. Metres."""

import math

import png
import ply
from mesh import add, lerp, mul, smoothstep, unit
from still_life import sky, srgb
from textures import fbm, noise

LONG, HIGH = 1.5, .95
COLUMNS, ROWS, SHAPES = 48, 20, 24


def cloth(time):
    """The flag at a time; it is back where it was after one second.

    Each thread bends by an angle that runs along it as a wave and grows toward the free end. Positions are
    the sum of small steps in these directions, so the cloth does not stretch.
    """
    points, step = [], LONG / COLUMNS
    for j in range(ROWS + 1):
        v = j / ROWS
        x = y = 0.0
        for i in range(COLUMNS + 1):
            u = i / COLUMNS
            wave = math.sin(math.tau * (1.15 * u - 3 * time + .14 * v))
            wave += .45 * math.sin(math.tau * (2.4 * u - 4 * time - .35 * v) + 1.0)
            wave += .25 * math.sin(math.tau * (.7 * u - 2 * time + .5 * v) + 2.0)
            angle = (.25 + .75 * smoothstep(0, .7, u)) * wave
            sag = .10 * u * u * (1.2 - .4 * v) + .03 * u * math.sin(math.tau * (u - time))
            points.append((x, y, HIGH * v - sag))
            x += step * math.cos(angle)
            y += step * math.sin(angle)
    n = COLUMNS + 1
    faces = [(k, k + 1, k + n + 1, k + n) for j in range(ROWS) for k in range(j * n, j * n + COLUMNS)]
    return points, faces


UVS = [(i / COLUMNS, j / ROWS) for j in range(ROWS + 1) for i in range(COLUMNS + 1)]


def designs():
    """Five flags: a sun over waves, and four of plain figures."""
    ink, cream, coral = (.012, .035, .11), (.86, .80, .66), (.72, .07, .035)
    gold, sea = (.86, .42, .03), (.01, .20, .24)

    def sun(x, y):
        d, a = math.hypot(x - .75, y - .55), math.atan2(y - .55, x - .75)
        rays = smoothstep(.012, .0, abs(d - .27) - .055) * smoothstep(-.12, .12, math.cos(16 * a) - .2)
        wave = smoothstep(-.006, .006, .22 + .035 * math.sin(x * 21) - y)
        line = smoothstep(.006, -.006, abs(.30 + .035 * math.sin(x * 21) - y) - .02)
        color = lerp(ink, gold, max(smoothstep(.195, .185, d), rays))
        return lerp(lerp(color, coral, wave), cream, line)

    def cross(x, y):
        return cream if min(abs(x - .55), abs(y - .475)) < .09 else coral

    def rings(x, y):
        return (cream, sea)[int(math.hypot(x - .75, y - .475) / .135) % 2]

    def chevrons(x, y):
        return (gold, ink)[int((x + abs(y - .475) + .1) / .26) % 2]

    def checks(x, y):
        return (cream, coral)[(int(x / .25) + int(y / .2375)) % 2]

    for name, design, width in (("flag_sun", sun, 480), ("flag_cross", cross, 240), ("flag_rings", rings, 240),
                                ("flag_chevrons", chevrons, 240), ("flag_checks", checks, 240)):
        height = width * 19 // 30

        def pixel(px, py):
            total = (0.0, 0.0, 0.0)
            for k in range(4):
                x, y = (px + .25 + k % 2 / 2) / width, 1 - (py + .25 + k // 2 / 2) / height
                total = add(total, design(x * LONG, y * HIGH))
            return tuple(srgb(c / 4) for c in total)
        png.write(name, width, height, pixel)


SUN = unit((-.55, -.62, .56))


def summer(d):
    """A blue sky with fair-weather clouds above a hazy horizon."""
    e = math.asin(d[2])
    u, v = math.atan2(d[1], d[0]) / math.tau + .5, e / math.pi + .5
    near = math.acos(max(-1, min(1, sum(a * b for a, b in zip(d, SUN)))))
    color = lerp((.075, .19, .50), (.50, .66, .86), math.exp(-max(e, 0) / .30))
    color = add(color, mul((.9, .75, .5), math.exp(-near / .22)))
    cover = fbm(u, v * 2.6, 9, 17, 31, 4)
    body = smoothstep(.50, .68, cover) * smoothstep(.02, .14, e) * smoothstep(1.2, .5, e)
    shade = smoothstep(.52, .86, fbm(u, v * 2.6 + .035, 9, 17, 31, 4))
    color = lerp(color, lerp((1.05, 1.03, 1.0), (.55, .60, .70), shade), .92 * body)
    ground = lerp((.10, .12, .07), (.16, .17, .13), noise(u, v, 40, 40, 5))
    return lerp(lerp((.46, .55, .62), ground, smoothstep(0, -.16, e)), color, smoothstep(-.012, .012, e))


def build():
    for k in range(SHAPES + 1):
        points, faces = cloth(k / SHAPES)
        ply.write_mesh("flag_%02d" % k, points, faces, UVS if k == 0 else None)
    designs()
    sky("summer", 256, 128, summer)


if __name__ == "__main__":
    build()
