"""Scenes with a chess board, written from a position: scenes/default.txt, table.txt and table_light.txt."""

import math
import os
import random

from mesh import ROOT, number

SQUARE = 5.5
NAMES = {"p": "pawn", "n": "knight", "b": "bishop", "r": "rook", "q": "queen", "k": "king"}


def vector(*values):
    return "{ %s }" % " ".join(number(v, 3) for v in values)


def centre(file, rank, flipped=False):
    """Middle of a square; file and rank count from 0. If flipped, black sits on the near side."""
    x, y = (file - 3.5) * SQUARE, (rank - 3.5) * SQUARE
    return (-x, -y) if flipped else (x, y)


def placed(name, mesh, material, x, y, z, turn):
    right = (math.cos(turn), math.sin(turn), 0.0)
    return ("mesh %s {\n    filename ../meshes/%s.slo smooth_normals 1 material %s\n"
            "    addKframe { time 0 key { pivot %s up { 0 0 1 } right %s } }\n}\n"
            % (name, mesh, material, vector(x, y, z), vector(*right)))


def position(fen, flipped, seed, colours=("boxwood", "ebony")):
    """One mesh element for each piece, placed a little carelessly."""
    hand = random.Random(seed)
    out = []
    for row, text in enumerate(fen.split("/")):
        file = 0
        for c in text:
            if c.isdigit():
                file += int(c)
                continue
            white = c.isupper()
            x, y = centre(file, 7 - row, flipped)
            turn = (0.0 if white else math.pi) + (math.pi if flipped else 0.0)
            turn += hand.uniform(-.35, .35)
            x, y = x + hand.uniform(-.25, .25), y + hand.uniform(-.25, .25)
            name = "%s_%s_%s%d" % ("white" if white else "black", NAMES[c.lower()],
                                   "abcdefgh"[file], 8 - row)
            out.append(placed(name, NAMES[c.lower()], colours[0 if white else 1], x, y, 0.0, turn))
            file += 1
    return "".join(out)


BOARD = """
mesh board_dark { filename ../meshes/board_dark.slo smooth_normals 0 material dark_square }
mesh board_light { filename ../meshes/board_light.slo smooth_normals 0 material light_square }
mesh board_inlay { filename ../meshes/board_inlay.slo smooth_normals 0 material light_square }
mesh board_frame { filename ../meshes/board_frame.slo smooth_normals 1 material frame }
"""

WOODS = """
texture boxwood { filename ../textures/boxwood.png }
texture walnut { filename ../textures/walnut.png }

phong_info boxwood {
    ambient { .02 .014 .008 } diffuse { .66 .42 .19 } specular { .22 .22 .22 } shininess 60
    reflectance .045 diffuse_reflection .08
}
phong_info ebony {
    ambient { .004 .003 .003 } diffuse { .052 .028 .022 } specular { .25 .25 .25 } shininess 70
    reflectance .06 diffuse_reflection .06
}
phong_info light_square {
    ambient { .014 .010 .006 } diffuse { .62 .43 .24 } specular { .06 .06 .06 } shininess 40
    reflectance .10 diffuse_reflection .05
}
phong_info dark_square {
    ambient { .004 .003 .002 } diffuse { .115 .052 .026 } specular { .06 .06 .06 } shininess 40
    reflectance .10 diffuse_reflection .05
}
phong_info frame {
    ambient { .004 .002 .001 } diffuse { .13 .045 .022 } specular { .15 .15 .15 } shininess 50
    reflectance .09 diffuse_reflection .05
}
material_texture boxwood { phong_info boxwood texture boxwood scale_U 1 scale_V 1 }
material_texture ebony { phong_info ebony texture walnut scale_U 1 scale_V 1 }
material_texture light_square { phong_info light_square texture boxwood scale_U 1 scale_V 1 }
material_texture dark_square { phong_info dark_square texture walnut scale_U 1 scale_V 1 }
material_texture frame { phong_info frame texture walnut scale_U 1 scale_V 1 }
"""


def coloured_cube(where, note, quarter, turns):
    """The spinning cube on one of its corners: seven meshes that share their key frames."""
    parts = [("body", "cube_black"), ("left", "cube_green"), ("right", "cube_blue"),
             ("front", "cube_red"), ("back", "cube_orange"), ("down", "cube_yellow"),
             ("up", "cube_white")]
    out = ["# %s\n" % note]
    for part, material in parts:
        out.append("mesh cube_%s {\n    filename ../meshes/cube_%s.slo smooth_normals 1 "
                   "material %s\n%s}\n" % (part, part, material,
                                         key_frames(where, quarter, turns)))
    return "".join(out)


def key_frames(where, quarter, turns):
    """Turns about the vertical of a cube that stands on its corner, `quarter` seconds for a
    quarter of one: a key frame each, with the handles of a circle."""
    tilt = math.acos(1.0 / math.sqrt(3.0))
    handle = 4.0 / 3.0 * (math.sqrt(2.0) - 1.0)

    def axis(i, k, along):
        # Body diagonal upright: x and z axes of the cube at equal angles about it.
        b = math.pi / 2.0 * i + 2.0 * math.pi * k / 3.0
        return vector(math.sin(tilt) * (math.cos(b) - along * handle * math.sin(b)),
                      math.sin(tilt) * (math.sin(b) + along * handle * math.cos(b)),
                      math.cos(tilt))

    def state(i, along):
        return "up %s right %s" % (axis(i, 2, along), axis(i, 0, along))

    return "".join("    addKframe { time %s pre { %s } key { pivot %s %s } nex { %s } }\n" % (
        number(i * quarter, 3), state(i, -1.0), vector(*where), state(i, 0.0), state(i, 1.0))
        for i in range(4 * turns + 1))


CUBE_COLOURS = """
phong_info cube_black { ambient { .002 .002 .002 } diffuse { .02 .02 .02 } specular { .2 .2 .2 } shininess 40 }
""" + "".join("""phong_info cube_%s { diffuse { %s } specular { .25 .25 .25 } shininess 60 reflectance .04 }
""" % row for row in (("green", ".02 .34 .09"), ("blue", ".02 .10 .50"), ("red", ".55 .025 .025"),
                      ("orange", ".75 .20 .01"), ("yellow", ".78 .55 .02"), ("white", ".75 .75 .72"))) + \
    "".join("material_phong cube_%s { phong_info cube_%s }\n" % (c, c) for c in (
        "black", "green", "blue", "red", "orange", "yellow", "white"))


def write(name, text):
    path = os.path.join(ROOT, "scenes", name + ".txt")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8", newline="\n") as file:
        file.write(text)
    print("scenes/%s.txt: %d lines" % (name, text.count("\n")))


def lamp(name, x, y, z, radius, colour):
    return "sphere %s { center %s radius %s material %s }\n" % (
        name, vector(x, y, z), number(radius, 2), colour)


def table():
    text = """# The chess table: the end of the "immortal game" (Anderssen - Kieseritzky, London 1851), seen from
# behind the mated king; a coloured cube spins on the frosted glass. Centimetres, z up, the
# playing surface is z = 0. Written by scripts/models/chess_scenes.py.

settings quality {
    imageSamples 128 dofSamples 1 softShadowSamples 1
    diffuseReflectionSamples 1 diffuseRefractionSamples 2
    recursion 4 shadow TRANSPARENT background { .004 .004 .005 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix table_ output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { -15 -66 17 } addPosition { -23 -64 17 }
        addTarget { 13.2 -12 1.6 }
        skyStart { 0 0 1 } fovStart .238
        dofStart 50 lensRadiusStart .6 blurDuration .03
    }
}

# Key from the upper left, a cool window on the right, a warm rim from behind.
light_rectangle key { color { 1.12 1.0 .82 } vertex0 { -75 -10 70 } vertex1 { -45 -10 95 } vertex2 { -45 35 95 } }
light_rectangle window { color { .34 .42 .56 } vertex0 { 90 -40 20 } vertex1 { 90 30 20 } vertex2 { 90 30 80 } }
light_rectangle rim { color { .60 .44 .27 } vertex0 { -15 95 45 } vertex1 { 55 95 45 } vertex2 { 55 95 75 } }
""" + WOODS + CUBE_COLOURS + """
phong_info frosted_glass {
    ambient { .003 .006 .006 } diffuse { .022 .038 .036 } specular { .3 .3 .3 } shininess 50
    reflectance .20 diffuse_reflection .03 refraction .64 diffuse_refraction .10 refraction_index 1.5
}
phong_info chrome { diffuse { .08 .08 .09 } specular { .6 .6 .6 } shininess 120 reflectance .7 }
phong_info carpet { ambient { .012 .004 .003 } diffuse { .34 .09 .05 } }
phong_info wall { ambient { .10 .055 .028 } diffuse { .10 .07 .05 } }
phong_info glow_warm { ambient { 1.0 .62 .26 } }
phong_info glow_pale { ambient { .9 .78 .55 } }
phong_info glow_blue { ambient { .22 .35 .60 } }
material_phong frosted_glass { phong_info frosted_glass }
material_phong chrome { phong_info chrome }
texture linen { filename ../textures/linen.png }
material_texture carpet { phong_info carpet texture linen scale_U 1 scale_V 1 }
texture backdrop { filename ../textures/backdrop.png }
material_texture wall { phong_info wall texture backdrop scale_U 1 scale_V 1 }
material_phong glow_warm { phong_info glow_warm }
material_phong glow_pale { phong_info glow_pale }
material_phong glow_blue { phong_info glow_blue }
"""
    text += "\n# The board\n" + BOARD
    text += """
# The table: a slab of frosted glass on chrome legs, a carpet below, the room behind
mesh glass { filename ../meshes/glass_top.slo smooth_normals 1 material frosted_glass
    addKframe { time 0 key { pivot { 12 8 -3.23 } } } }
cylinder leg_a { base { -30 -22 -72 } top { -30 -22 -4.3 } radius 2.2 material chrome }
cylinder leg_b { base { 56 -22 -72 } top { 56 -22 -4.3 } radius 2.2 material chrome }
cylinder leg_c { base { -30 40 -72 } top { -30 40 -4.3 } radius 2.2 material chrome }
cylinder leg_d { base { 56 40 -72 } top { 56 40 -4.3 } radius 2.2 material chrome }
mesh carpet { filename ../meshes/sheet.slo smooth_normals 0 material carpet
    addKframe { time 0 key { pivot { 0 100 -72 } } } }
mesh wall { filename ../meshes/sheet.slo smooth_normals 0 material wall
    addKframe { time 0 key { pivot { 170 430 60 } up { 0 -1 0 } right { 1 0 0 } } } }
"""
    hand = random.Random(9)
    lamps = [(i, hand.uniform(-10, 330), hand.uniform(280, 380), hand.uniform(-16, 40),
              hand.uniform(1.6, 3.6), hand.choice(("glow_warm", "glow_warm", "glow_pale",
                                                   "glow_blue"))) for i in range(26)]
    for n, x, y, z, r, c in lamps:
        text += lamp("lamp_%d" % n, x, y, z, r, c)
    text += "\n# The spinning cube\n" + coloured_cube(
        (18.6, -33.0, -2.23 + (2.2 - .22) * math.sqrt(3.0) + .22),
        "4.4 cm, on its rounded corner, two turns a second", .125, 8)
    text += "\n# 1-0\n" + position("r1bk3r/p2pBpNp/n4n2/1p1NP2P/6P1/3P4/P1P1K3/q5b1", True, 7)
    write("table", text)


def table_light():
    text = """# The chess table in physical light: lamps in watts, polished wood, a table of dark glass, and the light
# that goes from one to another; the cube spins. Centimetres, z up, the playing surface is z = 0.
# Written by scripts/models/chess_scenes.py.

settings light { integrator PATH  imageSamples 1024  noise .012  recursion 8 }

Camera main {
    fps 25
    Film film { width 1280  height 720  prefix table_light_  toneMap AGX  exposure .9 }
    CamSegment still {
        videoStart 0  videoEnd 1
        addPosition { -15 -66 17 }  addTarget { 13.2 -12 1.6 }
        fovStart .238
        dofStart 50  lensRadiusStart .6  blurDuration .03
    }
}

# A warm softbox on the upper left, a cool window on the right, a warm one behind
lamp_rectangle key    { radiance { 13 10.4 7.4 }  vertex0 { -45 -10 95 }  vertex1 { -75 -10 70 }  vertex2 { -75 35 70 } }
lamp_rectangle window { radiance { 1.7 2.3 3.4 }  vertex0 { 90 30 20 }    vertex1 { 90 -40 20 }   vertex2 { 90 -40 80 } }
lamp_rectangle rim    { radiance { 9 6 3.2 }      vertex0 { -15 95 45 }   vertex1 { 55 95 45 }    vertex2 { 55 95 75 } }
environment dusk { radiance { .025 .022 .022 } }

# These images hold linear light
texture boxwood { filename ../textures/boxwood.png  encoding RAW }
texture walnut { filename ../textures/walnut.png  encoding RAW }
texture linen { filename ../textures/linen.png  encoding RAW }
texture backdrop { filename ../textures/backdrop.png  encoding RAW }

material_principled boxwood { base_color { .70 .44 .20 }  base_color_texture boxwood  roughness .4  coat .6  coat_roughness .12 }
material_principled ebony { base_color { .055 .030 .024 }  base_color_texture walnut  roughness .35  coat .7  coat_roughness .1 }
material_principled light_square { base_color { .64 .44 .25 }  base_color_texture boxwood  roughness .4  coat .5  coat_roughness .1 }
material_principled dark_square { base_color { .125 .056 .028 }  base_color_texture walnut  roughness .4  coat .5  coat_roughness .1 }
material_principled frame { base_color { .15 .052 .026 }  base_color_texture walnut  roughness .4  coat .7  coat_roughness .08 }
material_principled dark_glass { base_color { .008 .014 .015 }  roughness .3 }
material_principled carpet { base_color { .30 .08 .05 }  base_color_texture linen  roughness .9  specular_ior_level .1 }
material_principled wall { base_color { 0 0 0 }  emission_color { .11 .058 .03 }  emission_color_texture backdrop
                           emission_strength 1  specular_ior_level 0 }
material_principled cube_black { base_color { .02 .02 .02 }  roughness .35 }
"""
    for name, colour in (("green", ".02 .34 .09"), ("blue", ".02 .10 .50"), ("red", ".55 .025 .025"),
                         ("orange", ".75 .20 .01"), ("yellow", ".78 .55 .02"), ("white", ".75 .75 .72")):
        text += "material_principled cube_%s { base_color { %s }  roughness .25 }\n" % (name, colour)
    text += "\n# The board\n" + BOARD + """
# The table, a carpet below, the room behind
mesh glass { filename ../meshes/glass_top.slo smooth_normals 1 material dark_glass
    addKframe { time 0 key { pivot { 12 8 -3.23 } } } }
mesh carpet { filename ../meshes/sheet.slo smooth_normals 0 material carpet
    addKframe { time 0 key { pivot { 0 100 -72 } } } }
mesh wall { filename ../meshes/sheet.slo smooth_normals 0 material wall sampled 0
    addKframe { time 0 key { pivot { 170 430 60 } up { 0 -1 0 } right { 1 0 0 } } } }

# Lamps of the room, far behind
"""
    hand = random.Random(9)
    glow = {"warm": (1.0, .56, .22), "pale": (.9, .74, .50), "blue": (.25, .42, .80)}
    for n in range(26):
        where = hand.uniform(-10, 330), hand.uniform(280, 380), hand.uniform(-16, 40)
        r, c = hand.uniform(1.6, 3.6), glow[hand.choice(("warm", "warm", "pale", "blue"))]
        power = [round(2.6 * 4 * math.pi ** 2 * r * r * x) for x in c]
        text += "lamp_point lamp_%d { power %s  position %s  radius %s }\n" % (
            n, vector(*power), vector(*where), number(r, 2))
    text += "\n# The spinning cube\n" + coloured_cube(
        (18.6, -33.0, -2.23 + (2.2 - .22) * math.sqrt(3.0) + .22),
        "4.4 cm, on its rounded corner, two turns a second", .125, 2)
    text += "\n# 1-0\n" + position("r1bk3r/p2pBpNp/n4n2/1p1NP2P/6P1/3P4/P1P1K3/q5b1", True, 7)
    write("table_light", text)


def falling(height=9.5, start=2.0, step=.002, end=97.0):
    """(time, angle) of a piece that tips over its rim like a rod; time is 0 at 24 degrees."""
    rows, t, angle, speed = [], 0.0, math.radians(start), 0.0
    while angle < math.radians(end):
        rows.append((t, angle))
        speed += step * 1.5 * 981.0 / height * math.sin(angle)
        angle += step * speed
        t += step
    rows.append((t, math.radians(end)))
    zero = min(rows, key=lambda r: abs(r[1] - math.radians(24.0)))[0]
    keys = rows[::15]
    keys += [] if keys[-1] == rows[-1] else [rows[-1]]
    return [(-.6, 0.0)] + [(t - zero, angle) for t, angle in keys]


def default():
    text = """# The scene inside the program. Mate by queen and knight: the black king falls, blurred by motion,
# on a polished board in soft light. Frames -15 to 25 are the whole fall. Centimetres, z up.
# Written by scripts/models/chess_scenes.py.

settings quality {
    imageSamples 64 imageMinSamples 8 noise .02 recursion 2 background { .004 .005 .006 }
}

Camera main {
    fps 25
    Film film { width 640 height 360 prefix default_ output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart -.6 videoEnd 1
        addPosition { -20 50 10.5 } addTarget { 13.0 15.6 4.7 }
        skyStart { 0 0 1 } fovStart .142
        dofStart 46.5 lensRadiusStart .6 blurDuration .024
    }
}

# A warm window before the board, a cool one behind it
light_rectangle key { color { 1.08 .94 .74 } vertex0 { 25 72 50 } vertex1 { 47 50 50 } vertex2 { 37 40 72 } }
light_rectangle rim { color { .44 .54 .70 } vertex0 { 30 -60 38 } vertex1 { 62 -28 38 } vertex2 { 62 -28 68 } }
""" + WOODS + """
phong_info table { diffuse { .020 .022 .026 } reflectance .16 diffuse_reflection .05 }
material_phong table { phong_info table }
texture backdrop { filename ../textures/backdrop.png }
phong_info wall { ambient { .15 .22 .30 } }
material_texture wall { phong_info wall texture backdrop scale_U 1 scale_V 1 }
"""
    text += BOARD + """
mesh table { filename ../meshes/sheet.slo smooth_normals 0 material table
    addKframe { time 0 key { pivot { 0 0 -2.2 } } } }
mesh wall { filename ../meshes/backdrop.slo smooth_normals 0 material wall
    addKframe { time 0 key { pivot { 245 -108 -95 } right { -.702 -.712 0 } } } }

# The king tips over the rim of its foot, faster and faster
mesh black_king {
    filename ../meshes/king.slo smooth_normals 1 material ebony
"""
    x, y = centre(6, 7)
    for t, a in falling():
        c, s = math.cos(a), math.sin(a)
        text += "    addKframe { time %s key { pivot %s up %s right %s } }\n" % (
            number(t, 3), vector(x + 2.0 - 2.0 * c, y, 2.0 * s), vector(s, 0, c), vector(c, 0, -s))
    text += "}\n# Qg7 mate\n" + position("8/5pQ1/8/7N/8/8/5PPP/6K1", False, 5)
    write("default", text)


def build():
    default()
    table()
    table_light()
