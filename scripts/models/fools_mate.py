"""The fool's mate, a film of 800 frames: scenes/fools_mate.txt.

1. f3 e5 2. g4 Qh4 mate. The moves, the fall of the king and the way of the camera are functions of time here;
the scene gets their values as key frames and as segments of Bézier curves.
"""

import math
import random

from chess_scenes import BOARD, NAMES, centre, vector, write
from mesh import add, dot, mul, number, smoothstep, sub, unit

FPS = 25
FRAMES = 800


# ---- The moves ----

class Move:
    """A piece that an unseen hand lifts, carries and sets down."""

    def __init__(self, piece, start, end, begin, seconds, height, lean, foot):
        self.piece, self.begin, self.seconds = piece, begin, seconds
        self.a, self.b = square(start) + (0.0,), square(end) + (0.0,)
        # Of the way; degrees that it leans at most; radius of its foot
        self.height, self.lean, self.foot = height, math.radians(lean), foot
        self.way = unit(sub(self.b, self.a))

    def progress(self, t):
        """Share of the way, 0 to 1: it starts and stops without a jerk."""
        x = min(max((t - self.begin) / self.seconds, 0.0), 1.0)
        x = min(max((x - .14) / .66, 0.0), 1.0)
        return x * x * x * (x * (6.0 * x - 15.0) + 10.0)

    def angle(self, t):
        """The hand holds the head: the foot lags behind at first, swings ahead at the end, and comes to rest."""
        x = (t - self.begin) / self.seconds
        forward = smoothstep(.04, .30, x) - smoothstep(.30, .56, x)
        back = smoothstep(.50, .76, x) - smoothstep(.80, 1.0, x)
        rest = math.sin((x - 1.0) * 15.0) * math.exp(-(x - 1.0) * 9.0) * .10 if x > 1.0 else 0.0
        return self.lean * (forward - .8 * back + rest)

    def place(self, t):
        x = (t - self.begin) / self.seconds
        lift = self.height * smoothstep(0.0, .36, x) * (1.0 - smoothstep(.58, 1.0, x))
        p = add(self.a, mul(sub(self.b, self.a), self.progress(t)))
        # The lower rim of a leaning foot stays above the board
        return (p[0], p[1], lift + self.foot * math.sin(abs(self.angle(t))))

    def keys(self):
        end = self.begin + 1.45 * self.seconds
        return key_frames(self.begin, end, .08, self.place, self.angle, lean_axis(self.way))


def square(name):
    return centre("abcdefgh".index(name[0]), int(name[1]) - 1)


def lean_axis(way):
    """A turn about it leans what stands upright towards `way`."""
    return (-way[1], way[0], 0.0)


# Seconds at which a piece leaves its square and that it takes, centimetres that it is lifted
F3 = Move("white_pawn_f2", "f2", "f3", 5.9, 1.3, 1.5, 9.0, 1.45)
E5 = Move("black_pawn_e7", "e7", "e5", 10.3, 1.5, 2.2, 11.0, 1.45)
G4 = Move("white_pawn_g2", "g2", "g4", 14.7, 1.45, 2.2, 11.0, 1.45)
QUEEN = Move("black_queen_d8", "d8", "h4", 19.0, 1.9, 3.4, 9.0, 1.9)
MOVES = (F3, E5, G4, QUEEN)


def key_frames(begin, end, step, place, angle, axis):
    """Key frames of a motion every `step` seconds, with the handles of its speed there."""
    n = max(1, round((end - begin) / step))
    out = []
    for i in range(n + 1):
        t, h, e = begin + (end - begin) * i / n, (end - begin) / n / 3.0, 1e-3

        def state(sign):
            p = add(place(t), mul(sub(place(t + sign * e), place(t)), h / e)) if sign else place(t)
            a = angle(t) + (angle(t + sign * e) - angle(t)) * h / e if sign else angle(t)
            return "{ pivot %s turn { axis %s angle_deg %s } }" % (
                vector(*p), vector(*axis), number(math.degrees(a), 2))

        handles = ("" if i == 0 else "pre %s " % state(-1.0)), ("" if i == n else " nex %s" % state(1.0))
        out.append("    addKframe { time %s %skey %s%s }\n" % (number(t, 3), handles[0], state(0), handles[1]))
    return "".join(out)


# ---- The fall of the king: along the diagonal on which the queen gives mate ----

KING = square("e1") + (0.0,)
DOWN = unit((1.0, 1.0, 0.0))
RIM = 2.0
LYING = math.radians(97.2)
"""The king rests on the rims of its foot and its head."""
APEX = RIM + 15.9
"""A lying king rolls as a cone does, about the point where the line of the two rims meets the board."""
SHUDDER, FALL = 23.9, 25.2


def fall():
    """(time, angle) every 4 ms: a rod that tips over its rim, strikes the board and bounces."""
    rows, t, angle, speed = [], FALL, math.radians(.8), math.radians(3.0)
    # Of a rod of 9.5 cm; somewhat slower, for the eye
    pull = 1.5 * 981.0 / 9.5 * .62
    while t < FALL + 2.5:
        rows.append((t, angle))
        speed += .004 * pull * math.sin(max(angle, math.radians(1.2)))
        angle += .004 * speed
        if angle > LYING:
            angle, speed = LYING, -.24 * speed
            if abs(speed) < .25:
                speed = 0.0
        t += .004
    return rows


FALLING = fall()


def king_angle(t):
    if t < FALL:
        # It shudders before it gives up
        x = (t - SHUDDER) / (FALL - SHUDDER)
        if x <= 0.0:
            return 0.0
        return math.radians(2.6) * math.sin(x * 9.0) * smoothstep(0.0, .2, x) * (1.0 - .55 * x) * (
            1.0 - smoothstep(.8, 1.0, x)) + math.radians(.8) * smoothstep(.8, 1.0, x)
    i = (t - FALL) / .004
    k = min(int(i), len(FALLING) - 2)
    a, b = FALLING[k][1], FALLING[k + 1][1]
    return a + (b - a) * min(i - k, 1.0)


def king_place(t):
    """Of its foot, seen from the apex of the cone; it turns over the rim that touches the board."""
    a = king_angle(t)
    along = RIM * (1.0 - math.cos(a)) * (1.0 if a > 0.0 else -1.0) - APEX
    return add(mul(DOWN, along), (0.0, 0.0, RIM * math.sin(abs(a)) + .03 * smoothstep(1.0, 1.6, a)))


def landing():
    return next(t for t, angle in FALLING if angle >= LYING)


def king_roll(t):
    """Degrees about its own axis, after it has struck the board."""
    x = t - landing()
    return 0.0 if x <= 0.0 else 30.0 * math.exp(-1.5 * x) * math.sin(4.2 * x) * smoothstep(0.0, .25, x)


def king_turn(axis, degrees, name, rest, more=""):
    """A group or mesh that turns as the king rolls."""
    out = ""
    begin = landing()
    for i in range(21):
        t = begin + i * .16
        d = [king_roll(t + s * .001) for s in (-1.0, 0.0, 1.0)]
        at = [d[1] + (d[0] - d[1]) * .16 / .003, d[1], d[1] + (d[2] - d[1]) * .16 / .003]
        turn = ["{ %sturn { axis %s angle_deg %s } }" % (rest if k == 1 else "", vector(*axis),
                                                          number(x * degrees, 2)) for k, x in enumerate(at)]
        out += "    addKframe { time %s %skey %s%s }\n" % (
            number(t, 3), "pre %s " % turn[0] if i else "", turn[1], " nex %s" % turn[2] if i < 20 else "")
    return "%s {%s\n%s}\n" % (name, more, out)


def king():
    apex = add(KING, mul(DOWN, APEX))
    text = "\n# The white king: it tips over (king_falls), and what lies there rolls (king_rolls, white_king_e1)\n"
    text += king_turn((0, 0, 1), RIM / (APEX - RIM), "group king_rolls", "pivot %s " % vector(*apex))
    text += "group king_falls {\n    parent king_rolls\n"
    text += key_frames(SHUDDER, landing(), .05, king_place, king_angle, lean_axis(DOWN))
    # It bounces
    text += key_frames(landing() + .04, landing() + .6, .04, king_place, king_angle, lean_axis(DOWN)) + "}\n"
    return text + king_turn((0, 0, 1), 1.0, "copy white_king_e1", "",
                            "\n    of king parent king_falls material boxwood")


# ---- The camera ----

# Time, where the camera stands, what it looks at, half the height of the view at distance 1, radius of the lens
PATH = (
    (0.0, (66, -50, 34), (-2, 1, -1), .285, .30),
    (2.6, (60, -44, 29), (0, -1, -.5), .285, .32),
    (5.2, (40, -22, 16), (7, -10, 1.5), .28, .40),
    (7.2, (31, -8, 10.5), (9, -11, 2.2), .27, .45),
    (9.4, (29.5, -7.5, 9.5), (5.5, 2, 2.8), .27, .45),
    (11.8, (28, -8.5, 8.5), (3.4, 6, 2.2), .27, .45),
    (14.2, (30, -3, 7.5), (11, -8, 2.2), .27, .45),
    (16.3, (30.5, 4, 7.0), (13.2, -5, 2.2), .27, .45),
    (18.4, (35.5, -14, 9.5), (3.5, 10.5, 3.2), .27, .48),
    (20.4, (35.5, -17, 8.5), (12, 2, 3.6), .27, .48),
    (21.6, (35, -10, 8.0), (14, -5, 3.9), .27, .48),
    (23.4, (32.8, 1.4, 7.0), (8, -14, 4.2), .26, .48),
    (25.4, (32.2, 1.0, 6.8), (7.5, -14.5, 3.8), .25, .48),
    (27.6, (33, 1.2, 8.5), (8, -14, 2.8), .25, .46),
    (32.0, (41, 3.5, 19), (8, -11, 1.0), .27, .40),
)


def hermite(column, t):
    """Value of a column of PATH: cubic pieces whose speed is that of their neighbours; it rests at both ends."""
    times = [row[0] for row in PATH]
    k = max(i for i in range(len(PATH) - 1) if times[i] <= t)

    def value(i):
        v = PATH[i][column]
        return v if isinstance(v, tuple) else (v,)

    def speed(i):
        if i in (0, len(PATH) - 1):
            return tuple(0.0 for _ in value(i))
        before, after = times[i] - times[i - 1], times[i + 1] - times[i]
        u = [(b - a) / before for a, b in zip(value(i - 1), value(i))]
        v = [(b - a) / after for a, b in zip(value(i), value(i + 1))]
        return tuple((p * after + q * before) / (before + after) for p, q in zip(u, v))

    span = times[k + 1] - times[k]
    x = (t - times[k]) / span
    h = (2 * x ** 3 - 3 * x ** 2 + 1, (x ** 3 - 2 * x ** 2 + x) * span, 3 * x ** 2 - 2 * x ** 3,
         (x ** 3 - x ** 2) * span)
    return tuple(h[0] * a + h[1] * u + h[2] * b + h[3] * v
                 for a, u, b, v in zip(value(k), speed(k), value(k + 1), speed(k + 1)))


def above(move, z):
    return lambda t: add(move.place(t), (0.0, 0.0, z))


# From each time on the focus goes over to another thing, in so many seconds
FOCUS = (
    (0.0, 0.0, lambda t: (4.0, -4.0, 2.0)),
    (3.6, 1.8, above(F3, 2.8)),
    (8.0, 1.5, above(E5, 2.8)),
    (12.6, 1.5, above(G4, 2.8)),
    (16.9, 1.5, above(QUEEN, 5.0)),
    (21.9, 1.4, lambda t: add(KING, (0.0, 0.0, 6.0))),
    (FALL, .5, lambda t: add(KING, (2.5, 2.5, 1.5))),
)


def focus(t):
    point = FOCUS[0][2](t)
    for begin, seconds, thing in FOCUS[1:]:
        x = smoothstep(begin, begin + seconds, t)
        point = tuple(a + (b - a) * x for a, b in zip(point, thing(t)))
    where, target = hermite(1, t), hermite(2, t)
    return dot(sub(point, where), unit(sub(target, where)))


def camera():
    """The way of the camera, in segments of a fifth of a second and of a piece of PATH at most."""
    steps = sorted({i / 5 for i in range(160)} | {row[0] for row in PATH[:-1]} | {(FRAMES - 1) / FPS})
    text = "".join(segment(n, a, b) for n, (a, b) in enumerate(zip(steps, steps[1:])))
    return """
Camera main {
    fps 25
    Film film { width 854 height 480 prefix fools_mate_ encoding SRGB toneMap AGX exposure 1 }
%s}
""" % text


def segment(n, a, b):
    h, e = (b - a) / 3.0, 1e-4
    out = ""
    for word, column in (("addPosition", 1), ("addTarget", 2)):
        p, q = hermite(column, a), hermite(column, b)
        u = mul(sub(hermite(column, a + e), p), h / e)
        v = mul(sub(hermite(column, b - e), q), h / e)
        out += "".join(" %s %s" % (word, vector(*x)) for x in (p, add(p, u), add(q, v), q))
    ends = [(hermite(3, t)[0], focus(t), hermite(4, t)[0]) for t in (a, b)]
    for word, i in (("fov", 0), ("dof", 1), ("lensRadius", 2)):
        out += " %sStart %s %sEnd %s" % (word, number(ends[0][i], 3), word, number(ends[1][i], 3))
    return "    CamSegment s%03d { videoStart %s videoEnd %s%s blurDuration .02 }\n" % (
        n, number(a, 3), number(b, 3), out)


# ---- The scene ----

HEAD = """# The fool's mate, a film of 800 frames: 1. f3 e5 2. g4 Qh4 mate. slo-rt -s scenes/fools_mate.txt -f all
# Centimetres, z up, the playing surface is z = 0; white sits at -y. Written by scripts/models/fools_mate.py.

# ZERO_TWO: the noise of few samples is as the denoiser expects it, without a pattern from pixel to pixel
settings film { integrator DISTRIBUTED  generatorType ZERO_TWO  imageSamples 64  recursion 2  lightSamplingType SAMPLE_ONE_AT_TIME }
"""

LIGHT = """
# A warm softbox above the left, a cool window on the right, a warm one behind black
lamp_rectangle key    { radiance { 30 22 14 }     vertex0 { -20 -22 105 }  vertex1 { -45 -22 90 }  vertex2 { -45 10 90 } }
lamp_rectangle window { radiance { 2.0 2.1 2.4 }  vertex0 { 90 -10 35 }    vertex1 { 70 -70 35 }   vertex2 { 70 -70 95 } }
lamp_rectangle rim    { radiance { 26 16 8 }      vertex0 { -70 50 100 }   vertex1 { -25 80 100 }  vertex2 { -20 72.5 128 } }
"""

WOODS = """
# These images hold linear light
texture boxwood { filename ../textures/boxwood.png encoding RAW }
texture walnut { filename ../textures/walnut.png encoding RAW }

material_principled boxwood { base_color { .70 .44 .20 } base_color_texture boxwood roughness .4 coat .6 coat_roughness .12 }
material_principled ebony { base_color { .060 .030 .022 } base_color_texture walnut roughness .35 coat .8 coat_roughness .1 }
material_principled light_square { base_color { .64 .44 .25 } base_color_texture boxwood roughness .4 coat 1 coat_roughness .06 }
material_principled dark_square { base_color { .125 .056 .028 } base_color_texture walnut roughness .4 coat 1 coat_roughness .06 }
material_principled frame { base_color { .15 .052 .026 } base_color_texture walnut roughness .4 coat 1 coat_roughness .06 }
material_principled table { base_color { .05 .022 .014 } base_color_texture walnut roughness .4 coat 1 coat_roughness .15 }
material_principled china { base_color { .75 .73 .68 } roughness .3 coat 1 }
"""

ROOM = """
# The dusk around: the camera and the polish see it, it lights nothing
texture blue_hour { filename ../textures/blue_hour.hdr }
material_principled dusk { base_color { 0 0 0 } emission_color { .55 .42 .34 } emission_color_texture blue_hour emission_strength 1 specular_ior_level 0 }
sphere dusk { center { 0 0 0 } radius 600 material dusk sampled 0 addKframe { time 0 key { pivot { 0 0 -130 } turn_deg { 0 0 100 } } } }

# The table and a cup of coffee, which gets cold
mesh table { filename ../meshes/table_top.slo smooth_normals 1 material table addKframe { time 0 key { pivot { -8 0 -3.7 } right { 0 1 0 } } } }
mesh cup { filename ../meshes/cup.slo smooth_normals 1 material china addKframe { time 0 key { pivot { -33 15 -1.3 } right { .8 .6 0 } } } }
mesh saucer { filename ../meshes/saucer.slo smooth_normals 1 material china addKframe { time 0 key { pivot { -33 15 -2.05 } } } }
"""


def lamps():
    """Lamps far behind, out of focus; nothing near is lit by them."""
    hand = random.Random(11)
    text = "\n# Lamps of the room, far behind and out of focus: the camera and the polish see them, nothing is lit by them\n"
    glow = {"warm": (1.0, .52, .20), "pale": (.95, .74, .48), "blue": (.25, .42, .80), "red": (.9, .2, .1)}
    for name, colour in glow.items():
        text += "material_principled glow_%s { base_color { 0 0 0 } emission_color %s emission_strength 1.6 }\n" % (
            name, vector(*colour))
    for n in range(110):
        a, r = math.radians(hand.uniform(95, 290)), hand.uniform(240, 420)
        text += "sphere lamp_%d { center %s radius %s material glow_%s sampled 0 }\n" % (
            n, vector(r * math.cos(a), r * math.sin(a), hand.uniform(-40, 60)), number(hand.uniform(1.4, 3.6), 2),
            hand.choice(("warm", "warm", "warm", "pale", "pale", "blue", "red")))
    return text


def pieces():
    text = "\n# The pieces, each shown only as copies\n"
    for name in NAMES.values():
        text += "mesh %s { filename ../meshes/%s.slo smooth_normals 1 material boxwood hidden 1 }\n" % (name, name)
    text += "\n# Those that stay where they are\n"
    hand = random.Random(3)
    moved = {}
    for row, letters in ((1, "RNBQKBNR"), (2, "P" * 8), (7, "p" * 8), (8, "rnbqkbnr")):
        for file, c in enumerate(letters):
            side, material = ("white", "boxwood") if c.isupper() else ("black", "ebony")
            name = "%s_%s_%s%d" % (side, NAMES[c.lower()], "abcdefgh"[file], row)
            turn = (0.0 if side == "white" else math.pi) + hand.uniform(-.3, .3)
            x, y = centre(file, row - 1)
            right = vector(math.cos(turn), math.sin(turn), 0.0)
            if name == "white_king_e1":
                continue
            if name in (m.piece for m in MOVES):
                moved[name] = (NAMES[c.lower()], material)
                continue
            text += "copy %s { of %s material %s addKframe { time 0 key { pivot %s right %s } } }\n" % (
                name, NAMES[c.lower()], material,
                vector(x + hand.uniform(-.12, .12), y + hand.uniform(-.12, .12), 0.0), right)
    for m in MOVES:
        text += "\n# The move of %s\ncopy %s {\n    of %s material %s\n%s}\n" % ((m.piece, m.piece) + moved[m.piece] + (m.keys(),))
    return text + king()


def build():
    write("fools_mate", HEAD + camera() + LIGHT + WOODS + "\n# The board\n" + BOARD.lstrip() + ROOM + lamps() + pieces())


if __name__ == "__main__":
    build()
