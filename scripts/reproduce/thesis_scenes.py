"""The scenes of photon_mapping.py, as scene text: the thesis's ten, with a dragon, a letter and a box of our own.

The thesis gives neither the sizes of its box nor its models. Its radii and photons fit a cube of about 10 units, which
is what this file makes. Its sky, a textured hemisphere of 1500 W, is made here too.
"""

import math
import sys
from pathlib import Path

import matplotlib.image
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/models"))
import dragon

SIZE = 5.0  # half the side of the box
ALBEDO = 0.56  # the thesis's factor 0.8 times a grey of its texture
LAMP_POWER = 700.0


def vector(values):
    return "{ " + " ".join(f"{v:.9g}" for v in values) + " }"


def rectangle(name, corners, material):
    points = " ".join(f"vertex{number} {vector(corner)}" for number, corner in enumerate(corners))
    return f"rectangle {name} {{ {points} material {material} }}\n"


def write_mesh(path, vertices, faces, normals=None, uvs=None):
    def rows(name, values):
        return f"{name} {{\n" + "\n".join(" ".join(f"{v:.7g}" for v in row) for row in values) + "\n}\n"

    text = "slo_mesh 1\n" + rows("vertices", vertices)
    if normals is not None:
        text += rows("normals", normals)
    if uvs is not None:
        text += rows("uvs", uvs)
    path.write_text(text + rows("faces", faces), encoding="ascii")


# Meshes.


def letter():
    """An X of 1 by 1, 0.3 thick, standing on z = 0 in the plane of x and z."""
    arm, half = 0.16, 0.5
    outline = [
        (0, arm),
        (half - arm, half),
        (half, half),
        (half, half - arm),
        (arm, 0),
        (half, arm - half),
        (half, -half),
        (half - arm, -half),
        (0, -arm),
        (arm - half, -half),
        (-half, -half),
        (-half, arm - half),
        (-arm, 0),
        (-half, half - arm),
        (-half, half),
        (arm - half, half),
    ]
    count = len(outline)
    vertices = [(x, y, z + half) for y in (-0.15, 0.15) for x, z in outline]
    arms = [
        (0, 4, 3),
        (0, 3, 1),
        (1, 3, 2),
        (4, 8, 7),
        (4, 7, 5),
        (5, 7, 6),
        (8, 12, 11),
        (8, 11, 9),
        (9, 11, 10),
        (12, 0, 15),
        (12, 15, 13),
        (13, 15, 14),
        (0, 12, 8),
        (0, 8, 4),
    ]
    faces = list(arms) + [(a + count, c + count, b + count) for a, b, c in arms]
    for i in range(count):
        j = (i + 1) % count
        faces += [(i, j, j + count), (i, j + count, i + count)]
    return np.array(vertices), np.array(faces)


def ball(radius, around, down):
    """A sphere about the origin: 2 * around * (down - 1) triangles."""
    vertices = [(0, 0, radius)]
    for row in range(1, down):
        v = math.pi * row / down
        vertices += [
            (
                radius * math.sin(v) * math.cos(2 * math.pi * k / around),
                radius * math.sin(v) * math.sin(2 * math.pi * k / around),
                radius * math.cos(v),
            )
            for k in range(around)
        ]
    vertices.append((0, 0, -radius))
    faces = [(0, 1 + k, 1 + (k + 1) % around) for k in range(around)]
    for row in range(down - 2):
        for k in range(around):
            a, b = 1 + row * around + k, 1 + row * around + (k + 1) % around
            faces += [(a, a + around, b + around), (a, b + around, b)]
    last = len(vertices) - 1
    faces += [(last, last - around + (k + 1) % around, last - around + k) for k in range(around)]
    return np.array(vertices), np.array(faces)


def dome(radius, around=20, up=12):
    """A hemisphere over z = 0 whose texture coordinates are longitude and height."""
    rows, columns = np.meshgrid(np.arange(up + 1), np.arange(around + 1), indexing="ij")
    v, u = math.pi / 2 * rows / up, 2 * math.pi * columns / around
    vertices = radius * np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=-1).reshape(-1, 3)
    uvs = np.stack([columns / around, rows / up], axis=-1).reshape(-1, 2)
    faces = []
    for row in range(up):
        for k in range(around):
            a, b = row * (around + 1) + k, row * (around + 1) + k + 1
            c, d = b + around + 1, a + around + 1
            faces.append((a, c, b))
            if row < up - 1:
                faces.append((a, d, c))
    return vertices, np.array(faces), uvs


def sky(sunset):
    """256 x 64 texels of 8 bits: longitude, and height from the horizon below to the zenith above."""
    u, v = np.meshgrid((np.arange(256) + 0.5) / 256, 1 - (np.arange(64) + 0.5) / 64)
    clouds = sum(np.sin(2 * np.pi * (f * u + f * v * 0.7) + f * f) / f for f in (1, 2, 3, 5, 8))
    clouds = np.clip(0.5 + 0.6 * clouds, 0, 1)[..., None] * (1 - v[..., None])
    zenith, horizon = ((0.1, 0.12, 0.35), (0.95, 0.5, 0.25)) if sunset else ((0.2, 0.4, 0.85), (0.75, 0.85, 0.95))
    color = np.array(horizon) + (np.array(zenith) - horizon) * v[..., None] ** 0.6
    color = color + (np.array((0.9, 0.55, 0.4) if sunset else (1, 1, 1)) - color) * 0.5 * clouds
    glow = np.exp(-(((u - 0.62) / 0.06) ** 2 + ((v - (0.1 if sunset else 0.55)) / 0.12) ** 2))[..., None]
    return (255 * np.clip(color * 0.75 + glow * np.array((1, 0.8, 0.5)), 0, 1) ** (1 / 2.2) + 0.5).astype(int)


def write_files(folder):
    """Writes all meshes and textures that the scenes name, and returns the number of triangles of the dragon."""
    if not (folder / "dragon.slo").exists():
        vertices, normals, faces = dragon.dragon()
        dragon.write(folder / "part.slo", vertices, normals, faces)
        (folder / "part.slo").rename(folder / "dragon.slo")
    triangles = (folder / "dragon.slo").read_text(encoding="ascii").split("faces {\n")[1].count("\n") - 1
    write_mesh(folder / "letter.slo", *letter())
    write_mesh(folder / "lamp.slo", *ball(0.4, 22, 19))
    vertices, dome_faces, uvs = dome(30.0)
    write_mesh(folder / "dome.slo", vertices, dome_faces, uvs=uvs)
    vertices, ball_faces = ball(1.3, 48, 24)
    write_mesh(folder / "glass_ball.slo", vertices, ball_faces, normals=vertices / 1.3)
    vertices, ring_faces, ring_normals = ring()
    write_mesh(folder / "ring.slo", vertices, ring_faces, normals=ring_normals)
    for name, sunset in (("sky_1", False), ("sky_2", True)):
        matplotlib.image.imsave(folder / f"{name}.png", sky(sunset).astype(np.uint8))
    return triangles


def ring(radius=1.5, height=0.9, thickness=0.08, around=120):
    """A band that stands on its rim: 11 points around its cross-section."""
    angles = 2 * math.pi * np.arange(11) / 11
    outline = np.stack(
        [
            radius + thickness * np.cos(angles),
            height / 2 + (height / 2 - thickness) * np.sign(np.round(np.sin(angles), 9)) + thickness * np.sin(angles),
        ],
        axis=-1,
    )
    s = 2 * math.pi * np.arange(around) / around
    vertices = np.stack(
        [
            np.outer(outline[:, 0], np.cos(s)),
            np.outer(outline[:, 0], np.sin(s)),
            np.outer(outline[:, 1], np.ones(around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    normals = np.stack(
        [
            np.outer(np.cos(angles), np.cos(s)),
            np.outer(np.cos(angles), np.sin(s)),
            np.outer(np.sin(angles), np.ones(around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    faces = []
    for i in range(11):
        for k in range(around):
            a, b = i * around + k, i * around + (k + 1) % around
            c, d = (i + 1) % 11 * around + (k + 1) % around, (i + 1) % 11 * around + k
            faces += [(a, b, c), (a, c, d)]
    return vertices, np.array(faces), normals


# Scenes.

MATT = "ior 1 specular_ior_level 0"
GREY = f"material_principled grey {{ base_color {vector([ALBEDO] * 3)} {MATT} }}\n"
GREEN = f"material_principled green {{ base_color {{ .08 .64 .12 }} {MATT} }}\n"
DRAGONS = {
    "matt": f"material_principled dragon {{ base_color {vector([ALBEDO] * 3)} {MATT} }}\n",
    "mirror": "material_principled dragon { base_color { .9 .9 .9 } metallic 1 roughness 0 specular_tint { 1 1 1 } }\n",
    "glass": "material_principled dragon { base_color { 1 1 1 } transmission 1 roughness 0 ior 1.6 }\n",
}


def box():
    s, h = SIZE, 2 * SIZE
    low, high = [(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [(-s, -s, h), (s, -s, h), (s, s, h), (-s, s, h)]
    sides = {
        "floor": low[:3],
        "ceiling": [high[0], high[3], high[2]],
        "front": [low[0], high[0], high[1]],
        "back": [low[3], low[2], high[2]],
        "left": [low[0], low[3], high[3]],
        "right": [low[1], high[1], high[2]],
    }
    return "".join(rectangle(name, corners, "grey") for name, corners in sides.items())


def things(look):
    return (
        GREY
        + GREEN
        + DRAGONS[look]
        + """mesh dragon { filename dragon.slo fit { 6 } smooth_normals 1 material dragon
 addKframe { time 0 key { pivot { -.4 .9 0 } turn_deg { 0 0 20 } } } }
mesh letter { filename letter.slo fit { 2.4 } material green
 addKframe { time 0 key { pivot { 3.1 -.4 0 } turn_deg { 0 0 -35 } } } }
"""
    )


POINT = f"lamp_point lamp {{ power {vector([LAMP_POWER] * 3)} position {{ 1 -2 9 }} }}\n"
SPOT = f"lamp_spot lamp {{ power {vector([LAMP_POWER / 6] * 3)} position {{ 1 -2 9.5 }} target {{ -.3 .8 1 }} angle_deg 50 }}\n"
CAMERA_IN = "addPosition { -1.2 -4.8 3.9 } addTarget { .4 .5 1.5 } fovStart .58"
CAMERA_OUT = "addPosition { -2.6 -6.3 3.2 } addTarget { .4 .5 1.3 } fovStart .5"
CAMERA_CAUSTIC = "addPosition { 0 -4.7 4.2 } addTarget { -.1 .3 .5 } fovStart .45"


def area_lamp(sampled=True):
    """A glowing sphere of 792 triangles."""
    radiance = LAMP_POWER / (math.pi * 4 * math.pi * 0.4**2)
    return (
        f"material_principled glow {{ base_color {{ 0 0 0 }} {MATT} emission_color {{ 1 1 1 }} emission_strength {radiance:.6g} }}\n"
        f"mesh lamp {{ filename lamp.slo material glow sampled {int(sampled)}\n"
        " addKframe { time 0 key { pivot { 1 -2 9 } } } }\n"
    )


def outdoors(texture, sampled=True):
    ground = rectangle("ground", [(-30, -30, 0), (30, -30, 0), (30, 30, 0)], "grey")
    return (
        f"texture sky {{ filename {texture}.png encoding SRGB }}\n"
        f"material_principled glow {{ base_color {{ 0 0 0 }} {MATT} emission_color_texture sky emission_strength 1.2 }}\n"
        f"mesh dome {{ filename dome.slo material glow sampled {int(sampled)} }}\n{ground}"
    )


def caustic_things():
    return (
        GREY
        + """material_principled glass { base_color { 1 1 1 } transmission 1 roughness 0 ior 1.5 }
material_principled gold { base_color { 1 .78 .34 } metallic 1 roughness 0 }
mesh ball { filename glass_ball.slo smooth_normals 1 material glass addKframe { time 0 key { pivot { -1.9 .6 1.6 } } } }
mesh ring { filename ring.slo smooth_normals 1 material gold addKframe { time 0 key { pivot { 1.7 .5 .001 } } } }
lamp_point lamp { power { 700 700 700 } position { 3 3.5 8 } }
"""
    )


def text(number, settings, size, sampled=None):
    """Returns the text of scene `number` of the thesis; `sampled` overrides whether its lamp is asked for."""
    camera, body = CAMERA_IN, ""
    if number in (7, 8, 9):
        camera = CAMERA_OUT
        asked = number != 8 if sampled is None else sampled
        body = outdoors("sky_2" if number == 9 else "sky_1", asked) + things("matt")
    elif number == 10:
        camera, body = CAMERA_CAUSTIC, box() + caustic_things()
    else:
        look = {5: "mirror", 6: "glass"}.get(number, "matt")
        lamp = {3: SPOT, 4: area_lamp(sampled is not False)}.get(number, POINT)
        body = box() + things(look) + lamp
    return f"""settings thesis {{ {settings} }}
Camera c {{ fps 25 Film f {{ width {size[0]} height {size[1]} prefix s_ output EXR_IMAGE }}
 CamSegment all {{ videoStart 0 videoEnd 1 {camera} }} }}
{body}"""
