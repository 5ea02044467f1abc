"""Meshes, the pattern of the china and the sky of scenes/still_life.txt."""

import math
import os

import png
from lathe import Profile, lathe
from mesh import ROOT, Mesh, add, cross, lerp, mul, smoothstep, unit
from textures import fbm, noise

SEGMENTS = 64


def vase():
    """A baluster of china, 17 cm high; u runs round it and v up."""
    p = Profile(0, .5).line(3.1, .5, .2).line(3.4, 0, .1).line(3.9, 0, .15).line(3.9, .5, .2)
    p.curve(3.5, 1.6, 6.4, 4.6, 6.6, 8.6, 16).curve(6.8, 12.2, 3.1, 12.6, 2.7, 14.8, 14)
    p.curve(2.6, 15.6, 3.1, 16.4, 3.9, 16.9, 8).arc(3.7, 17.1, .9)
    p.curve(2.9, 16.5, 2.4, 15.8, 2.4, 14.8, 8).curve(2.6, 12.4, 6.2, 12.2, 6.2, 8.6, 10)
    p.curve(6, 4.8, 3.4, 2.2, 0, 1.6, 10)
    mesh = lathe(p, SEGMENTS)
    return wrap_uv(mesh, 17.0)


def wrap_uv(mesh, height):
    """Sets u by the angle and v by the height, with a seam of doubled vertices."""
    mesh.map_uv(lambda q: ((math.atan2(q[1], q[0]) / math.tau) % 1.0, q[2] / height))
    faces = []
    for face in mesh.faces:
        us = [mesh.uvs[i][0] for i in face]
        if max(us) - min(us) > .5:
            face = tuple(i if mesh.uvs[i][0] > .5 else
                         mesh.vertex(mesh.positions[i], mesh.normals[i],
                                     (mesh.uvs[i][0] + 1.0, mesh.uvs[i][1])) for i in face)
        faces.append(face)
    mesh.faces = faces
    return mesh


def jug():
    """A copper jug with a handle, 18 cm high; the handle points along +x."""
    p = Profile(0, 0).line(4.6, 0, .2).line(4.8, .4, .2)
    p.curve(5.9, 1.6, 7.0, 3.4, 7.0, 6.0, 16).curve(7.0, 9.6, 3.9, 10.8, 3.6, 13.6, 16)
    p.line(3.85, 13.75, .05).line(3.85, 14.05, .05).line(3.6, 14.2)
    p.curve(3.7, 15.6, 4.4, 17.0, 5.0, 18.0, 10).arc(4.8, 18.1, .9)
    p.curve(4.2, 17.0, 3.4, 15.6, 3.4, 14.2, 8).curve(3.6, 11.0, 6.7, 9.8, 6.7, 6.0, 10)
    p.curve(6.7, 3.4, 5.6, 1.4, 0, .5, 10)
    mesh = lathe(p, SEGMENTS)
    return mesh.add(tube([(4.5, 0, 17.2), (8.6, 0, 19.4), (12.2, 0, 11.6), (6.5, 0, 8.2)], .36, .62))


def carafe():
    """A carafe of thick glass, 22 cm high."""
    p = Profile(0, .3).line(3.9, 0, .2).line(4.6, .1, .3)
    p.curve(5.6, .6, 6.0, 2.0, 5.8, 4.4, 14).curve(5.4, 9.4, 2.0, 10.6, 1.9, 15.0, 18)
    p.curve(1.9, 18.0, 2.2, 20.0, 2.9, 21.7, 12).arc(2.6, 21.8, 1.0)
    p.curve(1.9, 20.0, 1.6, 18.0, 1.6, 15.0, 12).curve(1.7, 10.4, 5.0, 9.2, 5.35, 4.4, 16)
    p.curve(5.5, 2.2, 4.6, 1.1, 0, 1.0, 12)
    return lathe(p, SEGMENTS)


def wine_glass():
    """A wine glass, 17 cm high."""
    p = Profile(0, .1).line(3.2, 0).arc(3.2, .22, 1.0).curve(1.8, .35, .6, .5, .42, 1.6, 12)
    p.curve(.34, 3.2, .34, 5.0, .42, 6.8, 10).curve(.7, 7.6, 2.6, 8.0, 3.4, 10.4, 14)
    p.curve(3.9, 12.2, 3.3, 15.0, 2.9, 17.0, 12).arc(2.76, 17.0, 1.0)
    p.curve(3.16, 15.0, 3.76, 12.2, 3.26, 10.4, 12).curve(2.5, 8.3, .8, 8.1, 0, 8.0, 14)
    return lathe(p, SEGMENTS)


def bowl():
    """A silver bowl on a foot, 7.5 cm high."""
    p = Profile(0, .5).line(3.2, 0, .1).line(3.9, 0, .1).line(3.9, .35, .12)
    p.curve(3.0, .6, 1.6, 1.2, 1.5, 2.0, 10).curve(1.6, 2.6, 6.6, 2.4, 8.6, 7.3, 18)
    p.arc(8.4, 7.4, 1.0).curve(6.4, 2.9, 2.2, 2.9, 0, 2.8, 16)
    return lathe(p, SEGMENTS)


def cup():
    """A tea cup with a handle along +x, 6 cm high."""
    p = Profile(0, .4).line(1.9, .4, .1).line(2.0, 0, .1).line(2.4, 0, .1).line(2.4, .5, .1)
    p.curve(3.8, 1.0, 4.2, 3.0, 4.5, 6.0, 16).arc(4.3, 6.0, 1.0)
    p.curve(4.0, 3.2, 3.6, 1.4, 0, 1.1, 16)
    mesh = lathe(p, SEGMENTS)
    mesh.add(tube([(4.2, 0, 4.9), (7.4, 0, 6.6), (7.0, 0, 1.6), (3.6, 0, 1.9)], .26, .4))
    return wrap_uv(mesh, 6.0)


def saucer():
    p = Profile(0, .3).line(3.2, .3, .1).line(3.3, 0, .1).line(3.8, 0, .1).line(3.9, .3, .1)
    p.curve(5.2, .5, 6.6, 1.0, 7.4, 1.6, 10).arc(7.3, 1.8, 1.0)
    p.curve(6.4, 1.2, 5.0, .8, 3.0, .7, 10).line(0, .65)
    return wrap_uv(lathe(p, SEGMENTS), 2.0)


def lemon():
    """A lemon along z, its middle at 0, 7.4 cm long."""
    p = Profile(0, -3.9).curve(.5, -3.9, .5, -3.4, .9, -3.1, 6)
    p.curve(2.3, -2.5, 2.65, -1.2, 2.65, 0, 12).curve(2.65, 1.4, 2.2, 2.5, 1.0, 3.1, 12)
    p.curve(.6, 3.3, .6, 3.8, 0, 3.8, 6)

    def dents(r, z, angle):
        wave = .05 * math.sin(3 * angle + z) + .04 * math.sin(5 * angle - 2 * z)
        return r * (1 + .4 * wave) if r > 1e-6 else 0.0, z + .3 * wave * r
    return lathe(p, 48, dents)


def tube(points, thickness, width):
    """A strap along a Bezier curve in the xz plane."""
    mesh, steps, sides = Mesh(), 28, 16
    rings = []
    for i in range(steps + 1):
        t = i / steps
        s = 1 - t
        w = (s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t)
        d = (-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t)
        centre = tuple(sum(k * q[a] for k, q in zip(w, points)) for a in range(3))
        along = unit(tuple(sum(k * q[a] for k, q in zip(d, points)) for a in range(3)))
        out = unit(cross(along, (0.0, 1.0, 0.0)))
        grow = 1 + .35 * abs(2 * t - 1) ** 3
        row = []
        for j in range(sides):
            a = math.tau * j / sides
            c, e = math.cos(a), math.sin(a)
            at = add(centre, add(mul(out, c * thickness * grow), (0, e * width * grow, 0)))
            n = unit(add(mul(out, c / thickness), (0, e / width, 0)))
            row.append(mesh.vertex(at, n))
        rings.append(row)
    for low, high in zip(rings, rings[1:]):
        for j in range(sides):
            k = (j + 1) % sides
            mesh.quad(low[j], high[j], high[k], low[k])
    return mesh


# Feet that the cloth lies flat under: x, y, radius
FEET = [(-10, 6, 5), (11, 8, 6), (1, 15, 6), (0.5, -2, 5.5), (19, -1, 4.5), (-16, -7, 5.5),
        (9, -12, 4), (-3, -13, 4)]
CLOTH_TURN = math.radians(-14)


def cloth():
    """A cloth with folds, turned on the table; flat under the things that stand on it."""
    mesh, nx, ny = Mesh(), 120, 78
    c, s = math.cos(CLOTH_TURN), math.sin(CLOTH_TURN)
    ids = []
    for j in range(ny + 1):
        for i in range(nx + 1):
            a, b = -33 + 62 * i / nx, -25 + 42 * j / ny
            a += .25 * math.sin(b * .37) + .12 * math.sin(b * 1.1)
            b += .3 * math.sin(a * .29 + 1) + .12 * math.sin(a * .9)
            x, y = a * c - b * s, a * s + b * c
            free = 1.0
            for fx, fy, r in FEET:
                free *= smoothstep(r * .8, r * 1.9, math.hypot(x - fx, y - fy))
            edge = min(1.0, max(abs(a + 2) / 31, abs(b + 4) / 21))
            z = fold(x + .35 * y, y, free) * (.45 + .55 * edge)
            z += .10 + .06 * free * fbm(a / 60, b / 60, 9, 9, 5, 2)
            ids.append(mesh.vertex((x, y, z), None, (a / 9, b / 9)))
    for j in range(ny):
        for i in range(nx):
            k = j * (nx + 1) + i
            mesh.quad(ids[k], ids[k + 1], ids[k + nx + 2], ids[k + nx + 1])
    return mesh


def fold(x, y, free):
    """Soft ridges that run out among the things."""
    bend = 3 * math.sin(y * .09 + 1.3) + 1.6 * math.sin(y * .21)
    ridge = math.exp(-((x + 27 + bend) / 1.5) ** 2) * 1.1
    ridge += math.exp(-((x + 6 - bend * .8 + .25 * y) / 1.2) ** 2) * .75
    ridge += math.exp(-((x - 16 + bend * .6 - .35 * y) / 1.3) ** 2) * .9
    ridge += math.exp(-((x - 25 + bend) / 1.1) ** 2) * .6
    ridge += math.exp(-((y + 20 - .12 * x + .8 * math.sin(x * .2)) / 1.1) ** 2) * .7
    return ridge * free


def blue_and_white():
    """Cobalt on white glaze, round a vase: bands, petals, and tendrils between them."""
    white, blue = (.86, .87, .86), (.035, .08, .36)

    def pixel(px, py):
        u, v = (px + .5) / 512, 1 - (py + .5) / 512
        ink = 0.0
        for low, high in ((.045, .058), (.19, .198), (.205, .222), (.70, .712), (.718, .725), (.86, .868),
                          (.955, .975)):
            ink = max(ink, smoothstep(low - .003, low, v) - smoothstep(high, high + .003, v))
        # petals above the foot and below the neck, with a rim and a light heart
        for base, top, count in ((.06, .185, 16), (.845, .73, 14)):
            t = (v - base) / (top - base)
            if 0 < t < 1:
                x = abs((u * count) % 1 - .5) * 2
                half = .92 * math.sqrt(max(0, 1 - t ** 2.2))
                ink = max(ink, .95 * smoothstep(.16, .10, abs(x - half)), .6 * smoothstep(.55, .45, x / max(half, 1e-3))
                          * smoothstep(.9, .8, t))
        # flowers on the belly
        for k in range(5):
            for dv, du, size in ((.46, 0, .105), (.60, .1, .05), (.32, .1, .055)):
                du2 = ((u - k / 5 - du + .5) % 1 - .5) * 2.35
                r, a = math.hypot(du2, v - dv), math.atan2(v - dv, du2)
                edge = size * (.72 + .28 * abs(math.cos(3.5 * a if size > .1 else 2.5 * a)))
                wash = smoothstep(edge, edge - .006, r)
                shade = .35 + .65 * (r / edge) ** 2 if edge else 0
                line = smoothstep(.006, .003, abs(r - edge))
                heart = smoothstep(size * .26, size * .2, r)
                ink = max(ink, wash * shade * .8 * (1 - heart), line)
                ink = max(ink, heart * .25)
            # tendrils
            w = (u * 5 - k) % 5
            if w < 1:
                for side, mid in ((1, .46), (-1, .46)):
                    at = mid + side * .135 * math.sin(math.pi * w) ** .8 * (1 if side > 0 else 1.02)
                    ink = max(ink, .85 * smoothstep(.008, .004, abs(v - at) * (1 - .5 * abs(math.cos(math.pi * w)))))
        ink *= .82 + .36 * noise(u, v, 40, 40, 3) * .5
        c = lerp(white, blue, min(ink, 1))
        return tuple(srgb(x) for x in c)
    png.write("blue_and_white", 512, 512, pixel)


def srgb(x):
    return 12.92 * x if x <= .0031308 else 1.055 * x ** (1 / 2.4) - .055


def sky(name, width, height, radiance):
    """Write textures/NAME.hdr: radiance(direction), equirectangular, z up, +x in the middle."""
    data = bytearray(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width))
    for row in range(height):
        up = math.pi * (.5 - (row + .5) / height)
        for column in range(width):
            turn = math.tau * (.5 - (column + .5) / width)
            color = radiance((math.cos(up) * math.cos(turn), math.cos(up) * math.sin(turn), math.sin(up)))
            _, exponent = math.frexp(max(*color, 1e-9))
            data += bytes(min(255, int(math.ldexp(c, 8 - exponent))) for c in color) + bytes([exponent + 128])
    with open(os.path.join(ROOT, "textures", name + ".hdr"), "wb") as file:
        file.write(data)
    print("textures/%s.hdr: %dx%d, %d KB" % (name, width, height, len(data) // 1024))


GLOW = unit((-.80, .48, .36))


def evening(d):
    """An evening with high, thin clouds: the sun glows through them, low on the left."""
    e = math.asin(d[2])
    near = math.acos(max(-1, min(1, sum(a * b for a, b in zip(d, GLOW)))))
    u, v = math.atan2(d[1], d[0]) / math.tau + .5, e / math.pi + .5
    warm = math.exp(-near / .7)
    low = math.exp(-max(e + .05, 0) / .12)
    color = lerp((.045, .10, .26), (.80, .27, .10), low)
    color = add(color, mul((1.9, .92, .34), warm * (.35 + .65 * low)))
    clouds = smoothstep(.44, .70, fbm(u, v * 2.2, 7, 13, 11, 4)) * smoothstep(.03, .25, e)
    color = lerp(color, add((.26, .24, .30), mul((2.4, 1.5, .9), warm)), .7 * clouds)
    color = add(color, mul((5.0, 3.5, 2.0), math.exp(-(near / .34) ** 2)))
    # hills and a garden below the horizon
    hill = -.085 + .075 * fbm(u, .3, 13, 3, 21, 3)
    ground = lerp((.012, .022, .016), (.055, .06, .028), smoothstep(.35, .65, fbm(u, v, 36, 26, 31, 3)))
    ground = add(ground, mul((.34, .16, .05), warm * fbm(u, v, 64, 40, 8, 2)))
    far = add((.03, .045, .08), mul((.5, .2, .08), warm))
    below = lerp(far, ground, smoothstep(-.05, -.14, e))
    return lerp(below, color, smoothstep(hill - .022, hill + .022, e))


def build():
    vase().write("vase")
    jug().write("jug")
    carafe().write("carafe")
    wine_glass().write("wine_glass")
    bowl().write("silver_bowl")
    cup().write("cup")
    saucer().write("saucer")
    lemon().write("lemon")
    cloth().write("cloth")
    blue_and_white()
    sky("evening", 256, 128, evening)


if __name__ == "__main__":
    build()
