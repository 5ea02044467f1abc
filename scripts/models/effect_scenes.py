"""One scene for each effect, those of them that are long lists: strings, crayons, pawns, a cradle."""

import math
import random

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
    recursion 3 background { .04 .02 .02 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix supersampling output PNG_IMAGE encoding SRGB }
    CamSegment around {
        videoStart 0 videoEnd 8 sceneStart 0 sceneEnd 8
        addPosition { -13 -44 13 } addPosition { 13 -44 13 }
        addTarget { 0 0 9.2 }
        skyStart { 0 0 1 } fovStart .30
    }
}

light_rectangle sun { color { .78 .72 .62 } vertex0 { -60 -60 80 } vertex1 { -40 -60 95 } vertex2 { -40 -40 95 } }
light_rectangle sky { color { .16 .20 .26 } vertex0 { 60 -50 60 } vertex1 { 100 -10 60 } vertex2 { 100 -10 110 } }

texture checker { filename ../textures/checker.png }
phong_info floor { ambient { .03 .03 .035 } diffuse { .62 .62 .62 } reflectance .12 }
material_texture floor { phong_info floor texture checker scale_U 3 scale_V 3 }
"""
    text += "texture backdrop { filename ../textures/backdrop.png }\n"
    text += textured("dusk", "backdrop", None, ambient=(.95, .42, .20))
    text += phong("gold", (.42, .26, .07), ambient=(.03, .02, .01), specular=grey(.5), shininess=60,
                  reflectance=.25)
    text += phong("copper", (.45, .16, .07), ambient=(.03, .012, .006), specular=grey(.5),
                  shininess=60, reflectance=.15)
    text += phong("pearl", (.05, .05, .05), specular=grey(.6), shininess=150, reflectance=.85)
    text += """
mesh floor { filename ../meshes/floor.slo smooth_normals 0 material floor }
mesh dusk {
    filename ../meshes/backdrop.slo smooth_normals 0 material dusk
    addKframe { time 0 key { pivot { 20 138 -30 } } }
}

# The strings: two families of straight lines on a hyperboloid
mesh strings_right { filename ../meshes/strings_right.slo smooth_normals 1 material gold }
mesh strings_left { filename ../meshes/strings_left.slo smooth_normals 1 material copper }
"""
    low, high = .6, 18.4
    text += "\n# A pearl in the waist, rings that hold the strings\n"
    text += "sphere pearl { center { 0 0 9.5 } radius 2.3 material pearl }\n"
    for name, z in (("low", low), ("high", high)):
        text += ("mesh ring_%s { filename ../meshes/hoop.slo smooth_normals 1 material gold\n"
                 "    addKframe { time 0 key { pivot { 0 0 %s } } } }\n" % (name, number(z, 2)))
    write("supersampling", text)


def crayon(name, x, y, z, height, colour, radius=.55):
    """A crayon on end: a cylinder under a cone."""
    return ("cylinder %s { base %s top %s radius %s material %s }\n"
            "cone %s_tip { base %s apex %s radius %s material %s }\n" % (
                name, vector(x, y, z), vector(x, y, z + height), number(radius, 2), colour,
                name, vector(x, y, z + height), vector(x, y, z + height + 1.5),
                number(radius, 2), colour))


CRAYONS = [("red", (.70, .03, .03)), ("orange", (.80, .22, .01)), ("yellow", (.82, .60, .02)),
           ("green", (.06, .42, .08)), ("teal", (.01, .34, .36)), ("blue", (.02, .10, .55)),
           ("violet", (.22, .04, .42)), ("pink", (.78, .16, .30))]


def crayon_materials():
    return "".join(phong(n, c, ambient=tuple(.04 * v for v in c), specular=grey(.25), shininess=50,
                         reflectance=.04) for n, c in CRAYONS)


def glossy_reflection():
    text = HEADER % ("Glossy reflection: crayons on five metal plates, from a mirror on the left\n"
                     "# to brushed metal on the right; what is farther from a plate blurs more.")
    text += """settings quality {
    imageSamples 256 diffuseReflectionSamples 2 recursion 3 background { .006 .007 .010 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix glossy_reflection output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { 0 -84 21 } addTarget { 0 0 1.6 }
        skyStart { 0 0 1 } fovStart .225
    }
}

light_rectangle key { color { .92 .87 .78 } vertex0 { -70 -50 75 } vertex1 { -30 -50 95 } vertex2 { -30 -10 95 } }
light_rectangle fill { color { .34 .40 .52 } vertex0 { 80 -70 30 } vertex1 { 80 -20 30 } vertex2 { 80 -20 80 } }

"""
    text += crayon_materials()
    for i, sigma in enumerate((0, .04, .09, .18, .40)):
        text += phong("metal_%d" % i, (.045, .045, .05), reflectance=.62, diffuse_reflection=sigma)
    text += phong("cove", (.10, .11, .13), ambient=(.012, .013, .016))
    text += """
mesh cove { filename ../meshes/cove.slo smooth_normals 1 material cove
    addKframe { time 0 key { pivot { 0 0 -1.1 } } } }
"""
    hand = random.Random(3)
    k = 0
    for i in range(5):
        x = (i - 2) * 12.6
        text += ("mesh plate_%d { filename ../meshes/plate.slo smooth_normals 1 material metal_%d\n"
                 "    addKframe { time 0 key { pivot { %s -6 -.5 } } } }\n" % (i, i, number(x, 2)))
        for j in range(4):
            name = "crayon_%d%d" % (i, j)
            text += crayon(name, x - 4.35 + 2.9 * j, 4.0 + hand.uniform(-1.5, 1.5), 0.0,
                           hand.uniform(5.5, 8.5), CRAYONS[k % 8][0], .72)
            k += 1
        k += 1
    write("glossy_reflection", text)


def glossy_refraction():
    text = HEADER % ("Glossy refraction: five panes from clear to frosted glass before a row of balls;\n"
                     "# what is farther behind a pane blurs more.")
    text += """settings quality {
    imageSamples 256 diffuseRefractionSamples 2 recursion 4 shadow TRANSPARENT
    background { .02 .02 .025 }
}

Camera main {
    fps 25
    Film film { width 1280 height 720 prefix glossy_refraction output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { -12 -78 16 } addTarget { 0 0 6.4 }
        skyStart { 0 0 1 } fovStart .225
    }
}

light_rectangle key { color { .84 .80 .73 } vertex0 { -60 -30 70 } vertex1 { -30 -30 90 } vertex2 { -30 10 90 } }
light_rectangle fill { color { .20 .23 .28 } vertex0 { 80 -60 30 } vertex1 { 80 -10 30 } vertex2 { 80 -10 75 } }

"""
    text += crayon_materials()
    for i, sigma in enumerate((0, .03, .07, .14, .28)):
        text += phong("glass_%d" % i, (.016, .022, .021), ambient=(.003, .005, .005),
                      specular=grey(.25), shininess=80, reflectance=.06, refraction=.90,
                      diffuse_refraction=sigma, refraction_index=1.5)
    text += phong("cove", (.62, .61, .59), ambient=(.04, .04, .042))
    text += phong("steel", (.06, .06, .065), specular=grey(.4), shininess=60, reflectance=.4,
                  diffuse_reflection=.1)
    text += """
mesh cove { filename ../meshes/cove.slo smooth_normals 1 material cove }
box rail { vertex0 { -29 -.9 0 } vertex1 { 29 -.9 0 } vertex2 { 29 .9 0 } height .9 material steel }
"""
    for i in range(5):
        text += ("mesh pane_%d { filename ../meshes/pane.slo smooth_normals 1 material glass_%d\n"
                 "    addKframe { time 0 key { pivot { %s 0 8 } } } }\n"
                 % (i, i, number((i - 2) * 11.0, 2)))
    text += "\n# Balls near the panes, crayons farther behind\n"
    for i in range(11):
        x = -27.5 + 5.5 * i
        near = i % 2 == 0
        if near:
            text += "sphere ball_%d { center %s radius 2.6 material %s }\n" % (
                i, vector(x + 2.75, 4.4, 2.6), CRAYONS[(i * 3 // 2) % 8][0])
        text += crayon("crayon_%d" % i, x, 11.0 + 2.0 * (i % 3), 0.0, 8.0 + 2.2 * ((i * 7) % 3),
                       CRAYONS[(i * 5 + 2) % 8][0], .9)
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
    Film film { width 1280 height 720 prefix depth_of_field output PNG_IMAGE encoding SRGB }
    CamSegment pull {
        # the focus wanders from the red pawn to the end of the row
        videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition { -4 -33 8.6 } addTarget { 2.6 -4 4.0 }
        skyStart { 0 0 1 } fovStart .25
        dofStart 26.6 dofEnd 60 lensRadiusStart .55
    }
}

light_rectangle key { color { .72 .66 .56 } vertex0 { -55 -25 45 } vertex1 { -35 -25 65 } vertex2 { -35 10 65 } }
light_rectangle rim { color { .34 .36 .42 } vertex0 { 20 70 40 } vertex1 { 70 50 40 } vertex2 { 70 50 65 } }
"""
    text += WOOD
    text += textured("boxwood", "boxwood", (.64, .42, .20), ambient=(.02, .014, .008),
                     specular=grey(.2), shininess=60, reflectance=.04, diffuse_reflection=.08)
    text += textured("table", "walnut", (.24, .095, .045), ambient=(.004, .002, .001),
                     reflectance=.14, diffuse_reflection=.06)
    text += phong("red", (.62, .018, .018), ambient=(.025, .002, .002), specular=grey(.35),
                  shininess=90, reflectance=.05)
    glow = {"amber": (1.0, .50, .14), "gold": (1.0, .74, .38), "rose": (.85, .22, .20),
            "sky": (.25, .45, .85), "mint": (.25, .65, .50)}
    for name, colour in glow.items():
        text += phong(name, None, ambient=colour)
    text += """
mesh table {
    filename ../meshes/table_top.slo smooth_normals 1 material table
    addKframe { time 0 key { pivot { 20 8 -1.5 } } }
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
    for i in range(30):
        x, z = hand.uniform(-120, 190), -22.0 + 92.0 * hand.random()
        text += "sphere lamp_%d { center %s radius %s material %s }\n" % (
            i, vector(x, hand.uniform(250, 330), z), number(hand.uniform(2.4, 4.4), 2),
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
    Film film { width 1280 height 720 prefix motion_blur output PNG_IMAGE encoding SRGB }
    CamSegment still {
        videoStart 0 videoEnd 2 sceneStart .13 sceneEnd 2.13
        addPosition { -9 -54 12.5 } addTarget { -2.4 0 9.3 }
        skyStart { 0 0 1 } fovStart .25 blurDuration .05
    }
    CamSegment follow {
        # half speed; the camera passes along the cradle with the ball that flies out
        videoStart 2 videoEnd 4 sceneStart .3 sceneEnd 1.3
        addPosition { -14 -50 12 } addPosition { 2 -54 12 } addPosition { 16 -50 12 }
        addTarget { -10 0 8 } addTarget { 0 0 8 } addTarget { 16 0 9 }
        skyStart { 0 0 1 } fovStart .25 blurDuration .04
    }
}

light_rectangle key { color { .66 .62 .55 } vertex0 { -60 -40 40 } vertex1 { -30 -60 40 } vertex2 { -30 -60 80 } }
light_rectangle strip { color { .50 .56 .66 } vertex0 { 30 -70 6 } vertex1 { 44 -60 6 } vertex2 { 44 -60 60 } }
light_rectangle top { color { .34 .32 .30 } vertex0 { -30 -16 70 } vertex1 { 30 -16 70 } vertex2 { 30 30 70 } }
"""
    text += WOOD
    text += textured("table", "walnut", (.24, .10, .05), ambient=(.006, .003, .002),
                     reflectance=.08, diffuse_reflection=.08)
    text += textured("stand", "boxwood", (.50, .25, .10), 1, 1, ambient=(.01, .006, .003),
                     specular=grey(.15), shininess=50, reflectance=.04, diffuse_reflection=.06)
    text += phong("steel", (.035, .035, .038), specular=grey(.5), shininess=200, reflectance=.82)
    text += phong("gold", (.30, .17, .03), specular=(.6, .45, .2), shininess=120, reflectance=.45)
    text += phong("bar", (.06, .06, .065), specular=grey(.5), shininess=80, reflectance=.55,
                  diffuse_reflection=.05)
    text += phong("thread", (.45, .42, .38), ambient=grey(.02))
    text += "texture backdrop { filename ../textures/backdrop.png }\n"
    text += textured("wall", "backdrop", (.16, .10, .06), ambient=(.30, .15, .07))
    text += """
mesh table {
    filename ../meshes/table_top.slo smooth_normals 1 material table
    addKframe { time 0 key { pivot { 0 10 -1.5 } } }
}
mesh wall {
    filename ../meshes/backdrop.slo smooth_normals 0 material wall
    addKframe { time 0 key { pivot { -10 170 -90 } } }
}
mesh stand { filename ../meshes/stand.slo smooth_normals 1 material stand
    addKframe { time 0 key { pivot { 0 0 .9 } } } }
"""
    height, spread, radius, length = 19.0, 5.0, 2.2, 13.4
    for name, y in (("front", -spread), ("back", spread)):
        for side, x in (("left", -13.5), ("right", 13.5)):
            text += "cylinder post_%s_%s { base %s top %s radius .42 material bar }\n" % (
                name, side, vector(x, y, 1.8), vector(x, y, height))
            text += "sphere knob_%s_%s { center %s radius .62 material bar }\n" % (
                name, side, vector(x, y, height))
        text += "cylinder rod_%s { base %s top %s radius .42 material bar }\n" % (
            name, vector(-13.5, y, height), vector(13.5, y, height))
    text += "\n# The balls hang from z = %g; first and last swing in turn, half a second each way\n" % height
    for i in range(5):
        pivot = ((i - 2) * 2.0 * radius, 0.0, height)
        keys = "    addKframe { time 0 key { pivot %s } }\n" % vector(*pivot)
        if i == 0:
            a = math.radians(40.0)
            keys = (cradle_keys(pivot, a, .3, 0.0, 1)
                    + cradle_keys(pivot, a, .3, .9, -1) + cradle_keys(pivot, a, .3, 2.1, -1))
        if i == 4:
            a = math.radians(-40.0)
            keys = cradle_keys(pivot, a, .3, .3, -1) + cradle_keys(pivot, a, .3, 1.5, -1)
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
