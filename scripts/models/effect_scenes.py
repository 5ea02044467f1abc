"""Scenes of single effects that are long lists: strings, crayons, pawns, a cradle."""

import math
import random

import board
import candle
from chess_scenes import number, placed, vector, write

HEADER = "# %s\n# Centimetres, z up. Written by scripts/models/effect_scenes.py.\n\n"


def phong(name, diffuse=None, **rest):
    """A phong_info and a plain material of the same name."""
    parts = []
    if diffuse:
        parts.append("diffuse %s" % vector(*diffuse))
    for key, value in rest.items():
        parts.append("%s %s" % (key, vector(*value) if isinstance(value, tuple) else
                                number(value, 4)))
    return "phong_info %s { %s }\nmaterial_phong %s { phong_info %s }\n" % (
        name, " ".join(parts), name, name)


def grey(x):
    return (x, x, x)


def supersampling():
    text = HEADER % ("Supersampling: strings thinner than a pixel, and a chequered floor that\n"
                     "# runs to the horizon. Try --samples 1.")
    text += """settings quality {
    imageSamples 256 imageMinSamples 64 imageContrastLimit .08
    recursion 3 background { .03 .06 .15 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix supersampling_ output PNG_IMAGE encoding SRGB }
    CamSegment around {
        videoStart 0 videoEnd 8 sceneStart 0 sceneEnd 8
        addPosition { -13 -42 8.5 } addPosition { 13 -42 8.5 }
        addTarget { 0 0 9.3 }
        skyStart { 0 0 1 } fovStart .29
    }
}

light_rectangle sun { color { 1.0 .72 .44 } vertex0 { 56 -34 40 } vertex1 { 70 -8 40 } vertex2 { 70 -8 70 } }
light_rectangle sky { color { .46 .44 .46 } vertex0 { -70 -50 60 } vertex1 { -40 -70 60 } vertex2 { -40 -70 100 } }

texture checker { filename ../textures/checker.png }
"""
    text += textured("floor", "checker", (.55, .55, .55), 40, 40, ambient=(.02, .02, .025),
                     reflectance=.16)
    text += "texture dusk { filename ../textures/dusk.png }\n"
    text += textured("dusk", "dusk", None, ambient=grey(1.0))
    text += phong("gold", (.50, .29, .07), ambient=(.03, .02, .01), specular=(.6, .5, .3),
                  shininess=60, reflectance=.25)
    text += phong("copper", (.50, .17, .07), ambient=(.03, .012, .006), specular=(.5, .35, .3),
                  shininess=60, reflectance=.15)
    text += phong("pearl", (.03, .03, .03), specular=grey(.6), shininess=150, reflectance=.9)
    text += """
plane floor { normal { 0 0 1 } position { 0 0 0 } material floor }

# The inside of a ball is the sky
sphere dusk { center { 0 0 0 } radius 480 material dusk }

# The strings: two families of straight lines on a hyperboloid
mesh strings_right { filename ../meshes/strings_right.slo smooth_normals 1 material gold }
mesh strings_left { filename ../meshes/strings_left.slo smooth_normals 1 material copper }
"""
    low, high = .6, 18.4
    text += "\n# A pearl in the waist, rings that hold the strings\n"
    text += "sphere pearl { center { 0 0 9.5 } radius 2.7 material pearl }\n"
    for name, z in (("low", low), ("high", high)):
        text += ("mesh ring_%s { filename ../meshes/hoop.slo smooth_normals 1 material gold\n"
                 "    addKframe { time 0 key { pivot { 0 0 %s } } } }\n" % (name, number(z, 2)))
    write("supersampling", text)


CANDLES = (("middle", -2.35, 89.0), ("tall", -.05, 93.5), ("low", 2.35, 87.0))
"""Which candle, how many degrees right of the middle of its plate and how far from the camera."""


def glossy_reflection():
    text = HEADER % ("Glossy reflection: candles on five metal plates, from a mirror on the left\n"
                     "# to brushed metal on the right; what is farther from a plate blurs more.")
    text += """settings quality {
    imageSamples 256 recursion 3 background { .004 .005 .008 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix glossy_reflection_ output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { 0 0 27 } addTarget { 0 82 2.6 }
        skyStart { 0 0 1 } fovStart .204
    }
}

# The candles shine by the ambient colour of their materials; this is the evening around them
light_rectangle window { color { .30 .38 .58 } vertex0 { -60 170 84 } vertex1 { 20 190 84 } vertex2 { 20 190 140 } }
light_rectangle room { color { .10 .085 .07 } vertex0 { -60 10 80 } vertex1 { -20 10 80 } vertex2 { -20 30 100 } }

texture wax { filename ../textures/wax.png }
texture flame { filename ../textures/flame.png }
"""
    text += textured("wax", "wax", (.45, .45, .45), ambient=(.80, .80, .80), specular=grey(.06),
                     shininess=20)
    text += textured("flame", "flame", None, ambient=(1.9, 1.9, 1.9))
    text += phong("wick", (.02, .015, .012))
    for i, sigma in enumerate((0, .035, .08, .16, .36)):
        text += phong("metal_%d" % i, (.020, .021, .025), reflectance=.72, diffuse_reflection=sigma)
    text += phong("cove", (.060, .066, .085), ambient=(.004, .005, .008))
    text += """
mesh cove { filename ../meshes/cove.slo smooth_normals 1 material cove
    addKframe { time 0 key { pivot { 0 80 -1.1 } } } }

# The plates run towards the camera, so that a candle and its image are on the same one
"""
    for i in range(5):
        angle = math.radians((i - 2) * 7.95)
        c, d = math.cos(angle), math.sin(angle)
        text += ("mesh plate_%d { filename ../meshes/plate.slo smooth_normals 1 material metal_%d\n"
                 "    addKframe { time 0 key { pivot %s right %s } } }\n" % (
                     i, i, vector(board.PLATE * d, board.PLATE * c, -.5), vector(c, -d, 0)))
        for height, right, away in CANDLES:
            a = angle + math.radians(right)
            text += lit_candle("%s_%d" % (height, i), height, away * math.sin(a),
                               away * math.cos(a))
    write("glossy_reflection", text)


def lit_candle(name, height, x, y):
    top = candle.HEIGHTS[height] - candle.DIP
    return ("mesh %s { filename ../meshes/candle_%s.slo smooth_normals 1 material wax\n"
            "    addKframe { time 0 key { pivot %s } } }\n"
            "cylinder %s_wick { base %s top %s radius .06 material wick }\n"
            "mesh %s_flame { filename ../meshes/flame.slo smooth_normals 1 material flame\n"
            "    addKframe { time 0 key { pivot %s } } }\n" % (
                name, height, vector(x, y, 0), name, vector(x, y, top), vector(x, y, top + .6),
                name, vector(x, y, top + .4)))


def glossy_refraction():
    text = HEADER % ("Glossy refraction: the same three pieces behind clear, satin and frosted glass;\n"
                     "# what is farther behind a pane blurs more.")
    text += """settings quality {
    imageSamples 256 diffuseRefractionSamples 2 recursion 4 shadow TRANSPARENT
    background { .72 .71 .68 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix glossy_refraction_ output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { -9 -80 15 } addTarget { -.5 0 6.2 }
        skyStart { 0 0 1 } fovStart .150
    }
}

light_rectangle key { color { 1.24 1.17 1.05 } vertex0 { -70 -20 60 } vertex1 { -40 -45 60 } vertex2 { -40 -45 95 } }
light_rectangle fill { color { .22 .25 .30 } vertex0 { 80 -60 30 } vertex1 { 80 -10 30 } vertex2 { 80 -10 75 } }

"""
    for name, colour in (("red", (.66, .028, .022)), ("blue", (.012, .060, .30)),
                         ("yellow", (.85, .50, .015))):
        text += phong(name, colour, ambient=tuple(.05 * v for v in colour), specular=grey(.3),
                      shininess=60, reflectance=.04)
    for i, sigma in enumerate((0, .04, .10)):
        text += phong("glass_%d" % i, (.012, .020, .019), ambient=(.002, .004, .004),
                      specular=grey(.25), shininess=80, reflectance=.06, refraction=.92,
                      diffuse_refraction=sigma, refraction_index=1.5)
    text += phong("cove", (.64, .625, .60), ambient=(.04, .04, .042))
    text += phong("rail", (.035, .030, .030), specular=grey(.2), shininess=60, reflectance=.06,
                  diffuse_reflection=.06)
    text += """
mesh cove { filename ../meshes/cove.slo smooth_normals 1 material cove }
mesh rail { filename ../meshes/rail.slo smooth_normals 1 material rail
    addKframe { time 0 key { pivot { 0 0 .6 } } } }
"""
    for i in range(3):
        x = (i - 1) * 13.9
        text += ("mesh pane_%d { filename ../meshes/pane.slo smooth_normals 1 material glass_%d\n"
                 "    addKframe { time 0 key { pivot { %s 0 7.5 } } } }\n" % (i, i, number(x, 2)))
        for piece, colour, right, back, turn in (("knight", "red", 3.6, 4.4, .5 * math.pi),
                                                 ("pawn", "yellow", -3.2, 2.6, 0.0),
                                                 ("king", "blue", .6, 8.6, .3)):
            text += placed("%s_%d" % (piece, i), piece, colour, x + right, back, 0.0, turn)
    write("glossy_refraction", text)


WOOD = """
texture boxwood { filename ../textures/boxwood.png }
texture walnut { filename ../textures/walnut.png }
"""


def textured(name, texture, diffuse, u=1, v=1, **rest):
    info, _ = phong(name, diffuse, **rest).split("\n", 1)
    return info + "\nmaterial_texture %s { phong_info %s texture %s scale_U %s scale_V %s }\n" % (
        name, name, texture, number(u, 3), number(v, 3))


def depth_of_field():
    text = HEADER % ("Depth of field: one red pawn is sharp, its file and the lamps of the room are not.")
    text += """settings quality {
    imageSamples 256 recursion 2 background { .003 .003 .004 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix depth_of_field_ output PNG_IMAGE encoding SRGB }
    CamSegment pull {
        # the focus wanders from the red pawn to the end of the row
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { -5 -32 7.4 } addTarget { 1.9 -4 4.2 }
        skyStart { 0 0 1 } fovStart .225
        dofStart 24.6 dofEnd 60 lensRadiusStart .62
    }
}

light_rectangle key { color { 1.05 .86 .62 } vertex0 { -46 4 34 } vertex1 { -36 -20 34 } vertex2 { -36 -20 58 } }
light_rectangle rim { color { .40 .46 .62 } vertex0 { 20 70 40 } vertex1 { 70 50 40 } vertex2 { 70 50 65 } }
"""
    text += WOOD
    text += textured("boxwood", "boxwood", (.64, .42, .20), ambient=(.02, .014, .008),
                     specular=grey(.2), shininess=60, reflectance=.04, diffuse_reflection=.08)
    text += textured("table", "walnut", (.24, .095, .045), ambient=(.004, .002, .001),
                     reflectance=.14, diffuse_reflection=.06)
    text += phong("red", (.62, .018, .018), ambient=(.025, .002, .002), specular=grey(.35),
                  shininess=90, reflectance=.05)
    text += "texture backdrop { filename ../textures/backdrop.png }\n"
    text += textured("wall", "backdrop", None, ambient=(.055, .060, .115))
    glow = {"amber": (3.2, 1.35, .30), "gold": (3.2, 2.0, .85), "rose": (2.4, .50, .42),
            "sky": (.55, 1.0, 2.2), "mint": (.50, 1.5, 1.1)}
    for name, colour in glow.items():
        text += phong(name, None, ambient=colour)
    text += """
mesh table {
    filename ../meshes/table_top.slo smooth_normals 1 material table
    addKframe { time 0 key { pivot { 20 8 -1.5 } } }
}
mesh wall {
    filename ../meshes/backdrop.slo smooth_normals 0 material wall
    addKframe { time 0 key { pivot { 77 300 -95 } right { .97 -.24 0 } } }
}

# The file of pawns
"""
    hand = random.Random(12)
    for i in range(9):
        x, y = -9.2 + 5.6 * i, -13.5 + 5.9 * i
        text += placed("pawn_%d" % i, "pawn", "red" if i == 1 else "boxwood",
                       x + hand.uniform(-.1, .1), y + hand.uniform(-.1, .1), 0.0,
                       hand.uniform(0, 6.28))
    text += "\n# Lamps far behind\n"
    names = list(glow)
    for i in range(34):
        x, z = hand.uniform(-65, 160), -6.0 + 56.0 * hand.random() ** 1.3
        text += "sphere lamp_%d { center %s radius %s material %s }\n" % (
            i, vector(x, hand.uniform(215, 270), z), number(hand.uniform(1.8, 2.7), 2),
            names[hand.choice((0, 0, 0, 1, 1, 1, 2, 3, 4))])
    write("depth_of_field", text)


def cradle_keys(pivot, amplitude, half, start, sign):
    """A swing from `amplitude` at `start` to rest `half` later, or out and back when sign is -1."""
    tilt = (math.cos(amplitude), 0.0, -math.sin(amplitude))
    handle = (1.0, 0.0, -amplitude * math.pi / 6.0)
    rest = (1.0, 0.0, 0.0)

    def key(time, right, pre=None, nex=None):
        parts = ["addKframe { time %s" % number(time, 3)]
        for name, value in (("pre", pre), ("key", right), ("nex", nex)):
            if value:
                extra = "pivot %s " % vector(*pivot) if name == "key" else ""
                parts.append("%s { %sright %s }" % (name, extra, vector(*value)))
        return "    " + " ".join(parts) + " }\n"

    if sign > 0:
        return key(start, tilt, nex=tilt) + key(start + half, rest, pre=handle)
    return (key(start, rest, nex=handle) + key(start + half, tilt, pre=tilt, nex=tilt)
            + key(start + 2 * half, rest, pre=handle))


def motion_blur():
    text = HEADER % ("Motion blur: a cradle of steel balls. In the first camera segment the swinging ball is\n"
                     "# blurred, in the second the camera follows it and blurs all else.")
    text += """settings quality {
    imageSamples 256 recursion 5 background { .01 .011 .014 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix motion_blur_ output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 2 sceneStart .088 sceneEnd 2.088
        addPosition { -13 -52 10.8 } addTarget { -.9 0 9.5 }
        skyStart { 0 0 1 } fovStart .25 blurDuration .04
    }
    CamSegment follow {
        # half speed; the camera passes along the cradle with the ball that flies out
        videoStart 2 videoEnd 3 sceneStart .1 sceneEnd .6
        addPosition { -14 -50 12 } addPosition { 2 -54 12 } addPosition { 16 -50 12 }
        addTarget { -10 0 8 } addTarget { 0 0 8 } addTarget { 16 0 9 }
        skyStart { 0 0 1 } fovStart .25 blurDuration .04
    }
}

light_rectangle key { color { .95 .86 .72 } vertex0 { -66 -30 26 } vertex1 { -46 -58 26 } vertex2 { -46 -58 66 } }
light_rectangle strip { color { .40 .50 .68 } vertex0 { 40 -60 4 } vertex1 { 52 -46 4 } vertex2 { 52 -46 60 } }
light_rectangle top { color { .42 .40 .38 } vertex0 { -40 -4 64 } vertex1 { 40 -4 64 } vertex2 { 40 44 64 } }
"""
    text += WOOD
    text += textured("table", "walnut", (.15, .062, .032), ambient=(.004, .002, .001),
                     reflectance=.10, diffuse_reflection=.06)
    text += textured("stand", "boxwood", (.50, .25, .10), 1, 1, ambient=(.01, .006, .003),
                     specular=grey(.15), shininess=50, reflectance=.04, diffuse_reflection=.06)
    text += phong("steel", (.035, .035, .038), specular=grey(.5), shininess=200, reflectance=.82)
    text += phong("gold", (.55, .30, .05), specular=(.7, .5, .2), shininess=120, reflectance=.40)
    text += phong("bar", (.06, .06, .065), specular=grey(.5), shininess=80, reflectance=.55,
                  diffuse_reflection=.05)
    text += phong("thread", (.45, .42, .38), ambient=grey(.02))
    text += "texture backdrop { filename ../textures/backdrop.png }\n"
    text += textured("wall", "backdrop", (.02, .03, .035), ambient=(.10, .165, .20))
    text += """
mesh table {
    filename ../meshes/table_top.slo smooth_normals 1 material table
    addKframe { time 0 key { pivot { 0 10 -1.5 } } }
}
mesh wall {
    filename ../meshes/backdrop.slo smooth_normals 0 material wall
    addKframe { time 0 key { pivot { -10 150 -86 } } }
}
mesh stand { filename ../meshes/stand.slo smooth_normals 1 material stand
    addKframe { time 0 key { pivot { 0 0 .9 } } } }
"""
    width, height, spread, radius, length = 16.8, 19.0, 5.0, 2.2, 13.4
    for name, y in (("front", -spread), ("back", spread)):
        for side, x in (("left", -width), ("right", width)):
            text += "cylinder post_%s_%s { base %s top %s radius .42 material bar }\n" % (
                name, side, vector(x, y, 1.8), vector(x, y, height))
            text += "sphere knob_%s_%s { center %s radius .62 material bar }\n" % (
                name, side, vector(x, y, height))
        text += "cylinder rod_%s { base %s top %s radius .42 material bar }\n" % (
            name, vector(-width, y, height), vector(width, y, height))
    text += "\n# The balls hang from z = %g; first and last swing in turn, as fast as gravity lets them\n" % height
    swing, half = math.radians(40.0), .184
    for i in range(5):
        pivot = ((i - 2) * 2.0 * radius, 0.0, height)
        keys = "    addKframe { time 0 key { pivot %s } }\n" % vector(*pivot)
        if i == 0:
            keys = cradle_keys(pivot, swing, half, 0.0, 1) + "".join(
                cradle_keys(pivot, swing, half, n * half, -1) for n in (3, 7, 11))
        if i == 4:
            keys = "".join(cradle_keys(pivot, -swing, half, n * half, -1) for n in (1, 5, 9))
        text += "sphere ball_%d { center %s radius %s material %s\n%s}\n" % (
            i, vector(0, 0, -length), number(radius, 2), "gold" if i in (0,) else "steel", keys)
        for name, y in (("front", -spread), ("back", spread)):
            text += "cylinder thread_%d_%s { base %s top %s radius .05 material thread\n%s}\n" % (
                i, name, vector(0, 0, -length + radius * .9), vector(0, y, 0), keys)
    write("motion_blur", text)


def build():
    supersampling()
    glossy_reflection()
    glossy_refraction()
    depth_of_field()
    motion_blur()
