"""A wet street at night and its thousand lamps: meshes, textures and scenes/street.txt. Metres, z up."""

import math
import random

import png
from chess_scenes import vector, write
from lathe import Profile, lathe
from mesh import Mesh, lerp, number, smoothstep
from still_life import sky
from textures import fbm, hashed, noise

GROUND, STOREY, OPENING, SILL = 4.2, 3.3, 2.0, .75
FACADE = 6.4
# name, width, bays, storeys above the shops
HOUSES = {"a": (9.0, 3, 3), "b": (12.0, 4, 3), "c": (10.5, 3, 4)}


def box(mesh, low, high):
    """A box along the axes."""
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        for side, at in ((-1.0, low), (1.0, high)):
            corners = [(low, low), (high, low), (high, high), (low, high)]
            points = []
            for s, t in corners if side > 0 else corners[::-1]:
                p = [0.0, 0.0, 0.0]
                p[axis], p[b], p[c] = at[axis], s[b], t[c]
                points.append(tuple(p))
            mesh.polygon(points)


def openings(house):
    """The windows of a house: y and z of two corners, and whether it is a shop's."""
    width, bays, storeys = HOUSES[house]
    bay = width / bays
    out = []
    for i in range(bays):
        middle = (i + .5) * bay
        out.append((middle - bay * .38, .45, middle + bay * .38, 3.1, True))
        for k in range(storeys):
            z = GROUND + k * STOREY + SILL
            out.append((middle - .62, z, middle + .62, z + OPENING, False))
    return out


def house(name):
    """Plaster, trim (sills, cornices, frames), panes, shops and goods; the front is the plane x = 0, facing +x."""
    hand = random.Random(name)
    width, bays, storeys = HOUSES[name]
    height = GROUND + storeys * STOREY + .3
    wall, trim, panes, shops, goods = Mesh(), Mesh(), Mesh(), Mesh(), Mesh()
    holes = openings(name)
    ys = sorted({0, width, *(h[0] for h in holes), *(h[2] for h in holes)})
    zs = sorted({0, height, *(h[1] for h in holes), *(h[3] for h in holes)})
    for y0, y1 in zip(ys, ys[1:]):
        for z0, z1 in zip(zs, zs[1:]):
            y, z = (y0 + y1) / 2, (z0 + z1) / 2
            if not any(h[0] < y < h[2] and h[1] < z < h[3] for h in holes):
                wall.polygon([(0, y0, z0), (0, y1, z0), (0, y1, z1), (0, y0, z1)])
    for y0, z0, y1, z1, shop in holes:
        deep = -.35 if shop else -.22
        wall.polygon([(deep, y0, z0), (deep, y1, z0), (0, y1, z0), (0, y0, z0)])
        wall.polygon([(0, y0, z1), (0, y1, z1), (deep, y1, z1), (deep, y0, z1)])
        wall.polygon([(0, y0, z0), (0, y0, z1), (deep, y0, z1), (deep, y0, z0)])
        wall.polygon([(deep, y1, z0), (deep, y1, z1), (0, y1, z1), (0, y1, z0)])
        if shop:
            inside(shops, goods, y0, z0, y1, z1, hand)
        else:
            panes.polygon([(deep, y0, z0), (deep, y1, z0), (deep, y1, z1), (deep, y0, z1)])
        middle, f = (y0 + y1) / 2, .05
        for a, b in (((y0, z0), (y0 + f, z1)), ((y1 - f, z0), (y1, z1)), ((y0, z0), (y1, z0 + f)),
                     ((y0, z1 - f), (y1, z1)), ((middle - f / 2, z0), (middle + f / 2, z1)),
                     ((y0, z1 - .62), (y1, z1 - .62 + f))):
            box(trim, (deep + .06, *a), (deep + .12, *b))
        if not shop:
            box(trim, (-.02, y0 - .12, z0 - .1), (.14, y1 + .12, z0))
            box(trim, (-.02, y0 - .14, z1), (.05, y1 + .14, z1 + .12))
            box(trim, (-.02, y0 - .18, z1 + .12), (.12, y1 + .18, z1 + .2))
            for y in (y0 - .14, y1):
                box(trim, (-.02, y, z0), (.05, y + .14, z1))
    for k, out in [(0, .22)] + [(i, .07) for i in range(1, storeys)]:
        z = GROUND + k * STOREY - .1
        box(trim, (-.02, 0, z), (out, width, z + .22))
    for z, out in ((height, .2), (height + .18, .36), (height + .36, .5)):
        box(trim, (-.3, -.02, z), (out, width + .02, z + .18))
    top = height + .54
    for y, turn in ((0, 1), (width, -1)):
        side = [(0, y, 0), (0, y, top), (-9, y, top), (-9, y, 0)]
        wall.polygon(side[::turn])
    wall.polygon([(0, 0, top), (0, width, top), (-2.2, width, top + 3), (-2.2, 0, top + 3)])
    wall.polygon([(-2.2, 0, top + 3), (-2.2, width, top + 3), (-9, width, top + 3.4), (-9, 0, top + 3.4)])
    for mesh, kind in ((wall, "wall"), (trim, "trim"), (panes, "panes"), (shops, "shops"), (goods, "goods")):
        mesh.write("house_%s_%s" % (name, kind))


def inside(shops, goods, y0, z0, y1, z1, hand):
    """A shop behind its window: a room with shelves, and what is sold on them."""
    near, back = -.35, -1.9
    shops.polygon([(back, y0, z0), (back, y1, z0), (back, y1, z1), (back, y0, z1)])
    shops.polygon([(back, y0, z0), (near, y0, z0), (near, y1, z0), (back, y1, z0)])
    shops.polygon([(back, y0, z1), (back, y1, z1), (near, y1, z1), (near, y0, z1)])
    shops.polygon([(near, y0, z0), (back, y0, z0), (back, y0, z1), (near, y0, z1)])
    shops.polygon([(back, y1, z0), (near, y1, z0), (near, y1, z1), (back, y1, z1)])
    for shelf in (.35, 1.0, 1.62):
        z, depth = z0 + shelf, .5 if shelf < .4 else .34
        x = back + (.7 if shelf < .4 else .02)
        box(shops, (x, y0 + .1, z - .05), (x + depth, y1 - .1, z))
        y = y0 + .16
        while y < y1 - .45:
            w, h = hand.uniform(.08, .3), hand.uniform(.12, .46)
            if hand.random() < .8:
                box(goods if hand.random() < .6 else shops, (x + .06, y, z), (x + depth - .06, y + w, z + h))
            y += w + hand.uniform(.02, .12)


def wire():
    """The wire of a garland across the street, from x = -1 to 1 times FACADE."""
    mesh, rings = Mesh(), []
    for i in range(49):
        x = FACADE * (i / 24 - 1)
        z = sag(x)
        rings.append([mesh.vertex((x, .008 * math.cos(a), z + .008 * math.sin(a)))
                      for a in (0.0, math.tau / 3, 2 * math.tau / 3)])
    for low, high in zip(rings, rings[1:]):
        for j in range(3):
            mesh.quad(low[j], low[(j + 1) % 3], high[(j + 1) % 3], high[j])
    mesh.write("wire")


def sag(x):
    return 1.1 * ((x / FACADE) ** 2 - 1)


def post():
    """A lamp post, 4.4 m high."""
    p = Profile(0, 0).line(.2, 0, .02).line(.2, .25, .03).line(.13, .4, .05).line(.12, .9, .02)
    p.line(.065, 1.0, .04).line(.05, 3.7, .02).line(.1, 3.8, .02).line(.05, 3.95, .02).line(.16, 4.02, .02)
    return lathe(p.line(0, 4.1), 20)


def post_cap():
    return lathe(Profile(0, 4.38).line(.24, 4.38, .01).line(.1, 4.6, .05).line(.02, 4.75, .01).line(0, 4.76), 20)


def pillar():
    """A pillar for posters, 3.4 m high: its trim, and the drum that the posters are on."""
    trim = lathe(Profile(0, 0).line(.78, 0, .02).line(.78, .35, .04).line(.66, .45, .02).line(.66, .5), 48)
    trim.add(lathe(Profile(.6, 2.75).line(.8, 2.8, .03).line(.8, 2.95, .03).curve(.78, 3.4, .3, 3.4, .1, 3.75, 10)
                   .line(.1, 3.9, .03).line(0, 3.95), 48))
    trim.write("pillar_trim")
    drum = Mesh()
    for i in range(49):
        a = math.tau * i / 48
        for z in (.5, 2.78):
            drum.vertex((.62 * math.cos(a), .62 * math.sin(a), z), (math.cos(a), math.sin(a), 0), (3 * i / 48, (z - .5) / 2.28))
    for i in range(48):
        drum.quad(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1)
    drum.write("pillar")


def stone(x, y):
    """Height of cobbles in a tile of 12 x 12 stones, and the number of the stone."""
    row = math.floor(y * 12)
    s = x * 12 + .5 * (row % 2)
    u, v = s - math.floor(s) - .5, y * 12 - row - .5
    d = max(abs(u), abs(v)) ** 4 + .6 * (u * u + v * v) ** 2
    return 1 - min(1, 14 * d), (math.floor(s) % 12, row % 12)


def cobbles():
    """Colour of wet cobbles, and their normals."""
    size = 384

    def color(px, py):
        x, y = px / size, py / size
        h, (i, j) = stone(x, y)
        shade = .45 + .5 * hashed(i, j, 5) + .25 * (noise(x, y, 64, 64, 9) - .5)
        return lerp((.25, .24, .22), (shade, shade * .96, shade * .93), smoothstep(.05, .5, h))
    png.write("cobbles", size, size, color)

    def height(x, y):
        h, (i, j) = stone(x % 1, y % 1)
        return .5 * h + .25 * hashed(i, j, 7) * h + .10 * noise(x % 1, y % 1, 40, 40, 3)

    def normal(px, py):
        x, y, e = px / size, 1 - py / size, .5 / size
        slope = 1 / 48
        gx = (height(x + e, y) - height(x - e, y)) / (2 * e) * slope
        gy = (height(x, y + e) - height(x, y - e)) / (2 * e) * slope
        n = 1 / math.sqrt(1 + gx * gx + gy * gy)
        return .5 - .5 * gx * n, .5 - .5 * gy * n, .5 + .5 * n
    png.write("cobbles_normal", size, size, normal)


def puddles():
    """Roughness of the wet ground: low where water stands."""
    def pixel(px, py):
        x, y = px / 256, py / 256
        return lerp((.22,) * 3, (.5,) * 3, smoothstep(.36, .62, fbm(x, y, 5, 5, 31, 4)))
    png.write("puddles", 256, 256, pixel)


def dusk_sky(d):
    """The blue hour: the last light low over the end of the street."""
    e = math.asin(d[2])
    near = math.exp(-((math.atan2(d[0], d[1])) / 1.2) ** 2)
    low = math.exp(-max(e, 0) / .22)
    color = lerp((.010, .022, .070), (.040, .070, .150), low)
    color = tuple(c + near * low * w for c, w in zip(color, (.15, .075, .055)))
    return color if e > -.05 else (.004, .005, .008)


def scene():
    hand = random.Random(41)
    text = """# A street after rain, lit by a thousand lamps: bulbs on wires, lanterns, shops, windows and a clock.
# Metres, z up. Written by scripts/models/street.py.

settings light { integrator PATH  imageSamples 1024  noise .015  recursion 8 }

Camera main {
    fps 25
    Film film { width 1280  height 720  prefix street_  toneMap AGX  exposure .7 }
    CamSegment still {
        videoStart 0  videoEnd 1
        addPosition { -1.3 -3 1.5 }  addTarget { .75 30 4.4 }
        fovStart .42
        lensRadiusStart .012  dofStart 14
    }
}

texture blue_hour { filename ../textures/blue_hour.hdr }
environment sky { texture blue_hour  strength 1  light_group sky }

texture cobbles { filename ../textures/cobbles.png }
texture cobbles_normal { filename ../textures/cobbles_normal.png }
texture puddles { filename ../textures/puddles.png }
texture linen { filename ../textures/linen.png }
texture poster { filename ../textures/dusk.png }

material_principled wet_cobbles {
    base_color { .16 .15 .14 }  base_color_texture { texture cobbles  scale_U 5  scale_V 60 }
    normal_texture { texture cobbles_normal  scale_U 5  scale_V 60 }  normal_strength .3
    roughness_texture { texture puddles  scale_U 1.1  scale_V 12 }
}
material_principled wet_slabs { base_color { .14 .135 .13 }  roughness_texture { texture puddles  scale_U .4  scale_V 14 } }
material_principled curb   { base_color { .20 .19 .18 }  roughness .35 }
material_principled cream  { base_color { .55 .47 .36 }  roughness .9  specular_ior_level .2 }
material_principled ochre  { base_color { .52 .33 .15 }  roughness .9  specular_ior_level .2 }
material_principled rose   { base_color { .48 .26 .20 }  roughness .9  specular_ior_level .2 }
material_principled slate  { base_color { .24 .29 .33 }  roughness .9  specular_ior_level .2 }
material_principled trim   { base_color { .58 .54 .48 }  roughness .7  specular_ior_level .3 }
material_principled panes  { base_color { .012 .015 .02 }  roughness .08 }
material_principled iron   { base_color { .02 .025 .022 }  roughness .35 }
material_principled green  { base_color { .02 .09 .06 }  roughness .3 }
material_principled red    { base_color { .42 .04 .03 }  base_color_texture { texture linen  scale_U 2  scale_V 2 }  roughness .8 }
material_principled wine   { base_color { .30 .03 .03 }  roughness .5 }
material_principled canvas { base_color { .62 .50 .34 }  roughness .8  specular_ior_level .2 }
material_principled wood   { base_color { .22 .12 .06 }  roughness .4 }
material_principled shelves { base_color { .50 .36 .22 }  roughness .6  specular_ior_level .3 }
material_principled poster { base_color_texture poster  roughness .5 }

# The ground
rectangle road  { vertex0 { -4 -8 0 }  vertex1 { 4 -8 0 }  vertex2 { 4 112 0 }  material wet_cobbles }
box pavement1   { vertex0 { -7 -8 0 }  vertex1 { -4.25 -8 0 }  vertex2 { -4.25 112 0 }  height .14  material wet_slabs }
box pavement2   { vertex0 { 4.25 -8 0 }  vertex1 { 7 -8 0 }  vertex2 { 7 112 0 }  height .14  material wet_slabs }
box curb1       { vertex0 { -4.25 -8 0 }  vertex1 { -4 -8 0 }  vertex2 { -4 112 0 }  height .15  material curb }
box curb2       { vertex0 { 4 -8 0 }  vertex1 { 4.25 -8 0 }  vertex2 { 4.25 112 0 }  height .15  material curb }

# The church at the end, and its clock
box tower { vertex0 { -3.5 98 0 }  vertex1 { 3.5 98 0 }  vertex2 { 3.5 105 0 }  height 23  material cream }
box ledge { vertex0 { -3.9 97.6 23 }  vertex1 { 3.9 97.6 23 }  vertex2 { 3.9 105.4 23 }  height .5  material trim }
box belt  { vertex0 { -3.8 97.7 15.5 }  vertex1 { 3.8 97.7 15.5 }  vertex2 { 3.8 105.3 15.5 }  height .5  material trim }
cone spire { base { 0 101.5 23.5 }  apex { 0 101.5 36 }  radius 3.9  material slate }
box nave  { vertex0 { -14 103 0 }  vertex1 { 14 103 0 }  vertex2 { 14 125 0 }  height 13  material cream }
"""
    lamps = []

    def lamp(kind, name, body, group):
        lamps.append("lamp_%s %s { %s  light_group %s }\n" % (kind, name, body, group))

    lamp("disc", "clock", "radiance { 1.8 1.5 1 }  center { 0 97.9 19.6 }  normal { 0 -1 0 }  radius 1.7", "windows")
    for i, x in enumerate((-3.2, 3.2)):
        lamp("spot", "flood%d" % i, "power { 900 640 380 }  position { %s 92 1 }  target { %s 98 14 }  "
             "angle_deg 70  blend 1  radius .2" % (number(x, 1), number(x * .3, 1)), "windows")
    text += "\n# Houses: the left row and the right one\n"
    shops = 0
    for side in (-1, 1):
        y, k = (-7.0 if side < 0 else -4.0), 0
        order = "bacabcbacb" if side < 0 else "cabcabacbb"
        while y < 96:
            name = order[k % 10]
            width = HOUSES[name][0]
            color = ("ochre", "slate", "cream", "rose")[(k * 3 + (side > 0) + k // 4) % 4]
            x = side * FACADE
            pivot = (x, y if side < 0 else y + width, .14)
            for part, material in (("wall", color), ("trim", "trim"), ("panes", "panes"), ("shops", "shelves"),
                                   ("goods", hand.choice(("wine", "canvas", "rose", "green")))):
                text += "mesh %s%d_%s { filename ../meshes/house_%s_%s.slo  material %s  addKframe { time 0  key { pivot %s  right { %d 0 0 } } } }\n" % (
                    "right" if side > 0 else "left", k, part, name, part, material, vector(*pivot), -side)
            for n, (y0, z0, y1, z1, shop) in enumerate(openings(name)):
                if not shop and hand.random() > .5:
                    continue
                deep = .2
                a, b = (pivot[1] + y0, pivot[1] + y1) if side < 0 else (pivot[1] - y1, pivot[1] - y0)
                low, high = z0 + .14, z1 + .14
                if not shop and hand.random() < .35:
                    high -= hand.choice((.62, 1.0))
                xx = x + side * deep
                if shop:
                    low = high = z1 + .1
                    ring = [(x + side * .6, b, low), (x + side * 1.5, b, low), (x + side * 1.5, a, low)]
                    ring = ring if side > 0 else ring[::-1]
                else:
                    ring = [(xx, a, low), (xx, b, low), (xx, b, high)] if side < 0 else [(xx, b, low), (xx, a, low), (xx, a, high)]
                warm = hand.random()
                tone = lerp((1, .50, .17), (1, .74, .44), warm)
                bright = hand.uniform(4, 9) if shop else hand.choice((.3, .5, .8, 1.2))
                lamp("rectangle", "%s%d_%d" % ("right" if side > 0 else "left", k, n),
                     "radiance %s  vertex0 %s  vertex1 %s  vertex2 %s" % (
                         vector(*(round(bright * c, 2) for c in tone)), *(vector(*p) for p in ring)),
                     "shops" if shop else "windows")
                if shop and hand.random() < .5:
                    shops += 1
                    aw = side * (FACADE - 1.25)
                    text += ("rectangle awning%d { vertex0 %s  vertex1 %s  vertex2 %s  material %s }\n" % (
                        shops, vector(x, a - .15, 3.75), vector(x, b + .15, 3.75), vector(aw, b + .15, 2.95),
                        hand.choice(("red", "red", "green", "canvas"))))
            y += width
            k += 1
    text += "\n# Lamp posts\n"
    n = 0
    for k in range(9):
        for side in (-1, 1):
            x, y = side * 4.7, 7.5 + k * 10.5 + (5.2 if side > 0 else 0)
            n += 1
            text += ("mesh post%d { filename ../meshes/post.slo  smooth_normals 1  material iron  addKframe { time 0  key { pivot %s } } }\n"
                     "mesh cap%d { filename ../meshes/post_cap.slo  smooth_normals 1  material iron  addKframe { time 0  key { pivot %s } } }\n" % (
                         n, vector(x, y, .14), n, vector(x, y, .14)))
            lamp("point", "lantern%d" % n, "power { 150 100 52 }  position %s  radius .15" % vector(x, y, 4.4), "lanterns")
    text += "\n# A pillar with posters, and the tables of a café\n"
    text += """mesh pillar      { filename ../meshes/pillar.slo  smooth_normals 1  material poster  addKframe { time 0  key { pivot { 5.2 12.6 .14 }  right { -.5 -.86 0 } } } }
mesh pillar_trim { filename ../meshes/pillar_trim.slo  smooth_normals 1  material green  addKframe { time 0  key { pivot { 5.2 12.6 .14 } } } }
"""
    for k, y in enumerate((8.2, 11.6, 15.0, 18.4)):
        x = -5.35
        text += ("cone parasol%d { base %s  apex %s  radius 1.15  material %s }\n"
                 "cylinder pole%d { base %s  top %s  radius .025  material wood }\n"
                 "cylinder top%d { base %s  top %s  radius .38  material wood }\n" % (
                     k, vector(x, y, 2.45), vector(x, y, 2.95), "red" if k % 2 == 0 else "canvas",
                     k, vector(x, y, .14), vector(x, y, 2.5), k, vector(x, y, .88), vector(x, y, .92)))
        lamp("point", "candle%d" % k, "power { 3 1.7 .6 }  position %s  radius .05" % vector(x + .2, y - .2, 1.02), "bulbs")
        for j, (dx, dy) in enumerate(((-.05, -.75), (.1, .75))):
            text += ("box seat%d_%d { vertex0 %s  vertex1 %s  vertex2 %s  height .04  material green }\n"
                     "box backrest%d_%d { vertex0 %s  vertex1 %s  vertex2 %s  height .5  material green }\n"
                     "cylinder leg%d_%d { base %s  top %s  radius .03  material iron }\n" % (
                         k, j, vector(x + dx - .2, y + dy - .2, .6), vector(x + dx + .2, y + dy - .2, .6), vector(x + dx + .2, y + dy + .2, .6),
                         k, j, vector(x + dx - .2, y + dy + (.18 if dy > 0 else -.21), .64), vector(x + dx + .2, y + dy + (.18 if dy > 0 else -.21), .64),
                         vector(x + dx + .2, y + dy + (.21 if dy > 0 else -.18), .64),
                         k, j, vector(x + dx, y + dy, .14), vector(x + dx, y + dy, .6)))
    text += "\n# Wires across the street\n"
    rows = [4.6 + 5.4 * k for k in range(17)]
    left = 1000 - len(lamps)
    for k, y in enumerate(rows):
        z = 6.6 + (.5 if k % 2 else 0)
        text += "mesh wire%d { filename ../meshes/wire.slo  material iron  addKframe { time 0  key { pivot %s } } }\n" % (k, vector(0, y, z))
        count = left // len(rows) + (k < left % len(rows))
        for j in range(count):
            x = FACADE * (2 * (j + .5) / count - 1)
            lamp("point", "bulb%d_%d" % (k, j), "power { 3 1.75 .75 }  position %s  radius .055" % vector(
                x, round(y + hand.uniform(-.02, .02), 2), round(z + sag(x) - .06, 2)), "bulbs")
    text += "\n# The %d lamps\n" % len(lamps) + "".join(lamps)
    write("street", text)


def build():
    for name in HOUSES:
        house(name)
    wire()
    post().write("post")
    post_cap().write("post_cap")
    pillar()
    cobbles()
    puddles()
    sky("blue_hour", 128, 64, dusk_sky)
    scene()


if __name__ == "__main__":
    build()
