"""scenes/rose.txt: a red rose after rain, its garden out of focus."""

import math
import random

import rose
from chess_scenes import number, vector, write
from effect_scenes import grey, phong, textured
from mesh import add, cross, mul, sub, unit, dot

HEAD = """# A red rose after rain, in focus, its garden out of focus. Centimetres, z up.
# Written by scripts/models/rose_scene.py.

settings quality {
    imageSamples 256 dofSamples 1 recursion 4 shadow TRANSPARENT background { .01 .014 .008 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix rose_ output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { 0 -44 34 } addTarget { 1.3 0 24.6 }
        skyStart { 0 0 1 } fovStart .142
        dofStart 43 lensRadiusStart .62
    }
}

# The sun through a veil from the left, the sky from behind, its reflection from the right
light_rectangle sun { color { .98 .89 .74 } vertex0 { -64 -30 50 } vertex1 { -44 -42 70 } vertex2 { -29 -17 70 } }
light_rectangle sky { color { .34 .39 .44 } vertex0 { -20 60 70 } vertex1 { 50 60 70 } vertex2 { 50 20 95 } }
light_rectangle fill { color { .16 .175 .19 } vertex0 { 60 -50 20 } vertex1 { 60 -10 20 } vertex2 { 60 -10 60 } }

texture petal { filename ../textures/petal.png }
texture leaf { filename ../textures/leaf.png }
texture garden { filename ../textures/garden.png }
"""


def frame(up, right):
    """Columns right, forward, up by Gram-Schmidt, as in the renderer."""
    x = unit(right)
    z = unit(sub(up, mul(x, dot(up, x))))
    return x, cross(z, x), z


def placed_at(point, pivot, up, right):
    """Transforms a point from an object's space to the scene's."""
    x, y, z = frame(up, right)
    return add(pivot, add(add(mul(x, point[0]), mul(y, point[1])), mul(z, point[2])))


def on_stem(t, pivot, up, right):
    """Point where a leaf springs from the stem of the flower at `pivot`; t runs down the stem."""
    return placed_at(rose.bezier(rose.STEM, t), pivot, up, right)


def group(name, meshes, pivot, up, right):
    out = ""
    for part, material in meshes:
        out += ("mesh %s_%s {\n    filename ../meshes/%s.slo smooth_normals 1 material %s\n"
                "    addKframe { time 0 key { pivot %s up %s right %s } }\n}\n"
                % (name, part, part, material, vector(*pivot), vector(*up), vector(*right)))
    return out


def build():
    text = HEAD
    text += textured("red", "petal", (.60, .030, .052), ambient=(.035, .002, .004),
                     specular=(.07, .05, .05), shininess=9)
    text += textured("pink", "petal", (.80, .30, .30), ambient=(.05, .02, .02),
                     specular=grey(.05), shininess=9)
    text += textured("cream", "petal", (.85, .66, .42), ambient=(.05, .04, .025),
                     specular=grey(.05), shininess=9)
    text += textured("leaf", "leaf", (.085, .21, .060), ambient=(.006, .012, .004),
                     specular=grey(.12), shininess=24)
    text += phong("stalk", (.09, .20, .05), ambient=(.006, .012, .004), specular=grey(.10),
                  shininess=20)
    text += phong("water", (.004, .004, .004), specular=grey(.9), shininess=220, reflectance=.06,
                  refraction=.92, refraction_index=1.33)
    text += textured("garden", "garden", None, ambient=(.72, .76, .60))
    text += """
mesh garden {
    filename ../meshes/sheet.slo smooth_normals 0 material garden
    addKframe { time 0 key { pivot { 20 420 0 } up { 0 -1 0 } right { 1 0 0 } } }
}

# The rose that the picture is about
"""
    pivot, up, right = (-1.6, 0.0, 24.6), (-.12, -.50, .86), (1.0, -.1, 0.0)
    flower = [("rose_heart", "red"), ("rose_outer", "red"), ("rose_calyx", "stalk"),
              ("rose_stem", "stalk")]
    text += group("front", flower, pivot, up, right)
    leaf = [("rose_leaf", "leaf")]
    for name, t, lean, ahead in (("right", .36, (-.25, -.62, .75), (1.0, .05, .35)),
                                 ("left", .46, (.35, -.55, .75), (-1.0, .0, .22)),
                                 ("low", .60, (.1, -.65, .75), (.9, -.5, -.1))):
        text += group(name, leaf, on_stem(t, pivot, up, right), lean, ahead)
    text += group("bud", [("rose_bud", "red"), ("rose_calyx", "stalk"), ("rose_stem", "stalk")],
                  (8.6, 6.5, 26.0), (.28, -.20, .93), (1.0, .1, -.2))
    text += "\n# Its neighbours\n"
    neighbours = [("pink", (31.0, 62.0, 27.0), (-.2, -.5, .85), 1.0), ("pink", (13.0, 85.0, 10.0), (.2, -.6, .8), 2.0),
                  ("cream", (-38.0, 95.0, 30.0), (.2, -.5, .85), 3.0), ("red", (-24.0, 70.0, 8.0), (.0, -.5, .85), 4.0),
                  ("cream", (58.0, 130.0, 8.0), (-.1, -.6, .8), 5.0)]
    for i, (colour, where, axis, turn) in enumerate(neighbours):
        text += group("far%d" % i, [("rose_heart", colour), ("rose_outer", colour),
                                    ("rose_calyx", "stalk"), ("rose_stem", "stalk")],
                      where, axis, (math.cos(turn), math.sin(turn), 0.0))
    hand = random.Random(31)
    for i in range(46):
        where = (hand.uniform(-75, 95), hand.uniform(60, 170), hand.uniform(-22, 22))
        turn = hand.uniform(0, 6.28)
        text += group("leaves%d" % i, leaf, where, (hand.uniform(-.5, .3), -.5, .8),
                      (math.cos(turn), math.sin(turn), hand.uniform(-.3, .5)))
    text += "\n# Dew on the outer petals\n"
    for i, (*point, r) in enumerate(rose.dew(4, 34)):
        text += "sphere dew%d { center %s radius %s material water }\n" % (
            i, vector(*placed_at(point, pivot, up, right)), number(r, 3))
    write("rose", text)
