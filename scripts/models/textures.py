"""Seamless textures. Values are linear light, the brightest near 1: a material's colour scales them."""

import math

import png
from mesh import lerp, smoothstep


def hashed(x, y, seed):
    """A number in [0, 1) for a lattice point."""
    h = (x * 0x9E3779B1 ^ y * 0x85EBCA77 ^ seed * 0xC2B2AE3D) & 0xFFFFFFFF
    h = ((h ^ h >> 15) * 0x2C1B3C6D) & 0xFFFFFFFF
    h = ((h ^ h >> 12) * 0x297A2D39) & 0xFFFFFFFF
    return (h ^ h >> 15) / 4294967296.0


def noise(u, v, nu, nv, seed):
    """Value noise with nu x nv cells over the unit square, periodic, in [0, 1]."""
    x, y = u * nu, v * nv
    i, j = math.floor(x), math.floor(y)
    s, t = x - i, y - j
    s, t = s * s * (3 - 2 * s), t * t * (3 - 2 * t)
    i0, i1, j0, j1 = i % nu, (i + 1) % nu, j % nv, (j + 1) % nv
    a = hashed(i0, j0, seed) * (1 - s) + hashed(i1, j0, seed) * s
    b = hashed(i0, j1, seed) * (1 - s) + hashed(i1, j1, seed) * s
    return a * (1 - t) + b * t


def fbm(u, v, nu, nv, seed, octaves):
    total, weight = 0.0, 0.0
    for k in range(octaves):
        a = .5 ** k
        total += a * noise(u, v, nu << k, nv << k, seed + k)
        weight += a
    return total / weight


def wood(name, size, rings, light, dark, pores, seed, contrast=1.0):
    """A plank with the grain along v: year rings cut lengthwise, fibres and pores."""

    def pixel(x, y):
        u, v = (x + .5) / size, (y + .5) / size
        sway = .16 * (fbm(u, v, 2, 1, seed, 2) - .5) + .05 * (fbm(u, v, 5, 2, seed + 9, 2) - .5)
        t = (u + sway) * rings
        ring = t - math.floor(t)
        late = smoothstep(.25, .93, ring) * smoothstep(1.0, .95, ring)
        strength = .35 + .65 * hashed(math.floor(t) % rings, 3, seed)
        fibre = noise(u, v, 128, 6, seed + 20) - .5
        broad = fbm(u, v, 3, 2, seed + 30, 3) - .5
        fine = .5 - .5 * math.cos(2.0 * math.pi * t * 5.0)
        k = contrast * (.50 * late * strength + .14 * fine * strength + .18 * fibre + .50 * broad)
        k += .10
        pore = smoothstep(.62, .95, noise(u, v, 240, 16, seed + 40)) * (.3 + .7 * late)
        colour = lerp(light, dark, min(max(k, 0.0), 1.0))
        return lerp(colour, (dark[0] * .55, dark[1] * .5, dark[2] * .45), pores * pore)

    png.write(name, size, size, pixel)


def linen(size):
    """A plain weave with uneven threads."""
    threads = 64

    def pixel(x, y):
        u, v = (x + .5) / size, (y + .5) / size
        a, b = u * threads, v * threads
        over = (math.floor(a) + math.floor(b)) % 2
        fu, fv = a - math.floor(a) - .5, b - math.floor(b) - .5
        bulge = 1.0 - (2.0 * (fu if over else fv)) ** 2 * .55 - (2.0 * (fv if over else fu)) ** 4 * .4
        thread = hashed(math.floor(a) if over else math.floor(b), over, 5)
        slub = noise(u, v, 12, threads, 7) if not over else noise(u, v, threads, 12, 8)
        k = (.74 + .26 * bulge) * (.86 + .08 * thread + .10 * slub)
        return (min(1.0, k), min(1.0, k * .985), min(1.0, k * .95))

    png.write("linen", size, size, pixel)


def petal(size):
    """A rose petal, base at v = 0: darker veins that fan out, a pale base, a warm rim."""

    def pixel(x, y):
        u, v = (x + .5) / size, 1.0 - (y + .5) / size
        fan = (u - .5) / (.35 + .65 * v)
        vein = fbm(fan * .5 + .5, v, 48, 2, 11, 2)
        mottled = fbm(u, v, 6, 6, 12, 3)
        k = .80 + .20 * vein + .22 * (mottled - .5)
        base = smoothstep(.30, .0, v)
        rim = smoothstep(.86, 1.0, v)
        r = k * (.93 + .07 * rim)
        g = k * (.62 + .38 * rim) + .38 * base
        b = k * (.66 + .34 * rim) + .10 * base
        return (min(r, 1.0), min(g, 1.0), min(b, 1.0))

    png.write("petal", size, size, pixel)


def leaf(size):
    """A rose leaf, midrib along v at u = .5, side veins, a lighter underside tone at the veins."""

    def pixel(x, y):
        u, v = (x + .5) / size, 1.0 - (y + .5) / size
        side = abs(u - .5) * 2.0
        rib = smoothstep(.035, .0, side)
        t = (v - side * .32) * 9.0
        branch = smoothstep(.13, .0, abs(t - round(t)) * (.7 + side)) * smoothstep(1.05, .2, side)
        cell = fbm(u, v, 40, 40, 3, 2)
        k = .62 + .30 * cell + .10 * (fbm(u, v, 4, 4, 6, 2) - .5)
        vein = max(rib, .55 * branch)
        return lerp((k * .72, k, k * .55), (.95, 1.0, .62), vein * .75)

    png.write("leaf", size, size, pixel)


def garden(width, height):
    """Foliage far out of focus: patches of light and shade in greens, brighter at the top left."""

    def pixel(x, y):
        u, v = (x + .5) / width, 1.0 - (y + .5) / height
        patch = fbm(u, v, 9, 7, 71, 3)
        bright = smoothstep(.42, .78, patch) * (.25 + .75 * smoothstep(.35, .8, v))
        gap = smoothstep(.66, .80, fbm(u, v, 14, 11, 81, 2)) * smoothstep(.35, .75, v)
        dark, green, pale = (.012, .030, .010), (.16, .30, .065), (.86, .92, .62)
        colour = lerp(lerp(dark, green, bright), pale, .8 * gap)
        grain = (hashed(x, y, 27) + hashed(x, y, 28) - 1.0) / 255.0
        return tuple(c + grain for c in colour)

    png.write("garden", width, height, pixel)


def checker(size, squares, light, dark):
    """A chequered floor with a little wear."""

    def pixel(x, y):
        u, v = (x + .5) / size, (y + .5) / size
        odd = (x * squares // size + y * squares // size) % 2
        wear = 1.0 - .12 * fbm(u, v, 6, 6, 60 + odd, 4)
        return tuple(c * wear for c in (dark if odd else light))

    png.write("checker", size, size, pixel)


def glow(name, width, height, low, high, centre, reach):
    """A backdrop: a soft light on a dark wall, in 16 bits, since dark gradients would show steps in 8."""

    def pixel(x, y):
        u, v = (x + .5) / width, 1.0 - (y + .5) / height
        d = math.hypot((u - centre[0]) * width / height, v - centre[1]) / reach
        return lerp(low, high, math.exp(-d * d))

    png.write(name, width, height, pixel, 16)


def dusk(width, height):
    """The sky after sunset for the inside of a sphere: u is the longitude, v the latitude, the
    sun below the horizon at u = .225."""

    def pixel(x, y):
        u, v = (x + .5) / width, 1.0 - (y + .5) / height
        high = max(0.0, v - .5) * 180.0
        side = abs((u - .225 + .5) % 1.0 - .5) * 360.0
        near = math.exp(-(side / 38.0) ** 2)
        colour = lerp((.030, .058, .150), (.20, .17, .27), math.exp(-high / 22.0))
        colour = lerp(colour, (.66, .27, .12), math.exp(-high / 10.0) * (.30 + .70 * near))
        return lerp(colour, (1.0, .62, .27), math.exp(-(high / 7.0) ** 2) * near)

    png.write("dusk", width, height, pixel, 16)


def along(name, size, stops):
    """Colours along v: stops are (v, colour), rising."""

    def pixel(_, y):
        v = 1.0 - (y + .5) / size
        for (a, low), (b, high) in zip(stops, stops[1:]):
            if v <= b:
                return lerp(low, high, smoothstep(a, b, v))
        return stops[-1][1]

    png.write(name, 4, size, pixel, 16)


def build():
    wood("boxwood", 512, 9, (1.0, .97, .90), (.62, .47, .30), .22, 101, .8)
    wood("walnut", 512, 8, (1.0, .86, .72), (.30, .19, .13), .5, 202)
    linen(384)
    checker(256, 4, (1.0, .97, .90), (.10, .17, .20))
    garden(256, 256)
    petal(256)
    leaf(256)
    glow("backdrop", 128, 72, (.02, .02, .03), (1.0, .9, .75), (.62, .55), .55)
    dusk(384, 192)
    along("wax", 128, [(0.0, (.10, .018, .006)), (.45, (.30, .075, .022)), (.80, (.72, .30, .09)),
                       (1.0, (1.0, .62, .27))])
    along("flame", 64, [(0.0, (.08, .10, .45)), (.16, (.65, .30, .10)), (.42, (1.0, .86, .52)),
                        (.72, (1.0, .62, .20)), (1.0, (.85, .28, .04))])
