"""Writes scenes/bouncing_ball.txt: a row of balls that hop along one path, one after another. Metres."""

import math

import png
from chess_scenes import write
from mesh import number, smoothstep

RADIUS, HOP, HEIGHT, GRAVITY = .13, .84, .80, 9.81
FLIGHT = 2 * math.sqrt(2 * HEIGHT / GRAVITY)
TOUCH = .06                         # half of the time that a ball is on the ground
STEP = 2 * TOUCH + FLIGHT           # from the middle of one touch to the next
FLAT = (1.20, 1.20, .69)            # scale in the middle of a touch,
LONG = (.93, .93, 1.16)             # and when it leaves the ground and comes back to it
COUNT, HOPS = 13, 2.5               # balls, and hops that the row of them is long


def v(*values):
    return "{ %s }" % " ".join(number(x, 3) for x in values)


def color(hue):
    """A saturated colour of linear light."""
    return tuple(.012 + .82 * (.5 + .5 * math.cos(math.tau * (hue - shift))) ** 2.6 * weight
                 for shift, weight in ((0, 1), (.36, .62), (.66, .8)))


def hop(name, x, delay):
    """Key frames of one hop, from the ground to the ground, that repeat.

    A throw is a parabola, so one Bezier curve is exact: its handles are a third of the speed times the flight.
    """
    low, drift = RADIUS * LONG[2], HOP * TOUCH / STEP
    rise = GRAVITY * FLIGHT / 2 * FLIGHT / 3
    left, right = x + drift, x + HOP - drift
    third = (right - left) / 3
    round_up = ["scale " + v(1.024, 1.024, .947)]       # so that the ball is round at the top
    rows = ["group %s {" % name,
            "    addKframe { time %s  key { pivot %s  scale %s } }"
            % (number(delay, 4), v(x, 0, RADIUS * FLAT[2]), v(*FLAT)),
            "    addKframe { time %s  key { pivot %s  scale %s }"
            % (number(delay + TOUCH, 4), v(left, 0, low), v(*LONG)),
            "                nex { pivot %s  %s } }" % (v(left + third, 0, low + rise), *round_up),
            "    addKframe { time %s  pre { pivot %s  %s }"
            % (number(delay + TOUCH + FLIGHT, 4), v(right - third, 0, low + rise), *round_up),
            "                key { pivot %s  scale %s } }" % (v(right, 0, low), v(*LONG)),
            "    addKframe { time %s  key { pivot %s  scale %s } }"
            % (number(delay + STEP, 4), v(x + HOP, 0, RADIUS * FLAT[2]), v(*FLAT)),
            "    repeat OFFSET", "}"]
    return "\n".join(rows)


HEAD = """# Balls that squash and stretch, blurred by motion. All hop along one path, one after another, so one picture
# shows the whole path. Metres, z up. Written by scripts/models/ball.py.

settings light { integrator PATH  imageSamples 512  noise .02  recursion 8 }

Camera main {
    fps 24
    Film film { width 1280  height 720  prefix bouncing_ball_  toneMap AGX  exposure .2 }
    CamSegment row {
        videoStart 0  videoEnd 2
        addPosition { .25 -4.6 1.85 }  addTarget { .06 0 .42 }
        fovStart .172
        blurDuration .024
    }
}

lamp_disc sun { power { 560 490 380 }  center { -2.6 -1.9 3.6 }  normal { 2.6 1.9 -3.4 }  radius .22 }
environment room { radiance { .20 .27 .38 } }

material_principled floor { base_color { .70 .62 .50 }  roughness .6  specular_ior_level .3 }
plane floor { normal { 0 0 1 }  position { 0 0 0 }  material floor }

# Where this image is white, a ball has its colour
texture stripes { filename ../textures/stripes.png }
material_principled white { base_color { .84 .82 .78 }  roughness .4 }
"""


def scene():
    parts = [HEAD]
    for k in range(COUNT):
        name = "ball%d" % (k + 1)
        # The delay puts ball k on the path at frame 0: they are spread evenly over the hops
        age = (k + .1) / COUNT * HOPS * STEP
        parts.append("material_principled paint%d { base_color %s  roughness .4 }\n"
                     "material_mix stripes%d { first white  second paint%d  factor_texture stripes }\n"
                     % (k + 1, v(*color(k / COUNT)), k + 1, k + 1))
        parts.append(hop("hop%d" % (k + 1), -HOPS / 2 * HOP, -age))
        parts.append("sphere %s { center { 0 0 0 }  radius %s  material stripes%d  parent hop%d\n"
                     "    addKframe { time 0  key { turn_deg %s } }\n    addKframe { time 1  key { turn_deg %s } }\n"
                     "    repeat OFFSET\n}\n"
                     % (name, number(RADIUS, 3), k + 1, k + 1, v(20, 60 + 31 * k, 0), v(20, 60 + 31 * k + 200, 0)))
    write("bouncing_ball", "\n".join(parts))


def stripes():
    """Where a ball is painted: white in five segments, black in those between them."""
    def pixel(x, _):
        return (smoothstep(.02, -.02, abs((x + .5) / 256 * 5 % 1 - .5) - .25),) * 3
    png.write("stripes", 256, 4, pixel)


def build():
    stripes()
    scene()


if __name__ == "__main__":
    build()
