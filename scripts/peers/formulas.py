#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy", "openexr>=3.3"]
# ///
"""Renders small scenes whose values are known by a formula, and prints measured against expected.

    python3 scripts/peers/formulas.py [--program target/release/slo-rt] [--only PART_OF_A_NAME ...] [--samples 1024]

A value is the mean of a picture of 16 x 16 pixels that all see the same. It is off if it differs from the expected one
by more than the tolerance (0.3 % unless stated) and by more than four standard errors. The exit code is 1 if any is.

The albedos of Blender's Principled BSDF were measured with bpy 5.0.1: a plane in a sky of radiance 1, seen at 0, 60
and 80 degrees from its normal.
"""

import argparse
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

try:
    import numpy as np
    import OpenEXR
except ImportError as error:
    sys.exit(f"formulas.py: {error}; start it by `uv run`, or `pip install numpy openexr` in a virtual environment")

ROOT = Path(__file__).resolve().parents[2]
PURE = "ior 1 specular_ior_level 0"
PI = np.pi


@dataclass
class Case:
    name: str
    text: str
    expected: object  # a number, or one for each channel
    eye: tuple = (0, 0, 5)
    target: tuple = (0, 0, 0)
    fov: float = 1e-3
    bounces: int = 0
    integrator: str = "PATH"
    tolerance: float = 0.003
    images: dict = field(default_factory=dict)


def numbers(*values):
    return "{ " + " ".join(f"{v:.9g}" for v in values) + " }"


def grey(value):
    return numbers(value, value, value)


def material(name, words):
    return f"material_principled {name} {{ {words} }}\n"


def matte(albedo, more=""):
    return material("matte", f"base_color {grey(albedo)} {PURE} {more}")


def sky(radiance):
    return f"environment sky {{ radiance {grey(radiance)} }}\n"


FLOOR = "plane floor { normal { 0 0 1 } position { 0 0 0 } material matte }\n"
ALBEDO = 0.6
# Looks at the origin from the side, past lamps overhead.
ASIDE = {"eye": (3, -4, 2)}


def rectangle(name, corners, look):
    v = " ".join(f"vertex{number} {numbers(*corner)}" for number, corner in enumerate(corners))
    return f"rectangle {name} {{ {v} material {look} }}\n"


def closed_box(look):
    faces = [((-1, -1, -1), (1, -1, -1), (1, 1, -1)), ((-1, -1, 1), (-1, 1, 1), (1, 1, 1)),
             ((-1, -1, -1), (-1, -1, 1), (1, -1, 1)), ((-1, 1, -1), (1, 1, -1), (1, 1, 1)),
             ((-1, -1, -1), (-1, 1, -1), (-1, 1, 1)), ((1, -1, -1), (1, -1, 1), (1, 1, 1))]
    return "".join(rectangle(f"wall_{number}", face, look) for number, face in enumerate(faces))


def lamp_in_a_sphere():
    """A point lamp in the middle of a sphere of radius 2: each bounce adds a factor of the albedo."""
    power, radius = 30.0, 2.0
    first = ALBEDO / PI * power / (4 * PI * radius**2)
    ball = matte(ALBEDO) + f"sphere ball {{ center {{ 0 0 0 }} radius {radius} material matte }}\n"
    inside = {"eye": (0.3, -1.2, 0.2), "target": (0.5, -3, 0.4), "fov": 0.3}
    for size in (0, 0.1):
        lamp = f"lamp_point lamp {{ power {grey(power)} position {{ 0 0 0 }} radius {size} }}\n"
        yield Case(f"lamp of radius {size} in a sphere, direct", ball + lamp, first, **inside)
        yield Case(f"lamp of radius {size} in a sphere, DISTRIBUTED", ball + lamp, first, integrator="DISTRIBUTED",
                   bounces=3, **inside)
        if not size:
            for bounces in (1, 3, 40):
                yield Case(f"lamp in a sphere, {bounces} bounces", ball + lamp,
                           first * (1 - ALBEDO ** (bounces + 1)) / (1 - ALBEDO), bounces=bounces, **inside)


def glowing_rooms():
    inside = {"eye": (0.2, -0.5, 0.1), "target": (0.4, 1, 0.3), "fov": 0.6}
    glow = "emission_color { 1 1 1 } emission_strength .5"
    things = "sphere ball { center { .4 .4 -.6 } radius .35 material matte }\n"
    for sampled in (1, 0):
        text = matte(0.5, glow) + closed_box("matte") + things
        text = text if sampled else text.replace("material matte }", "material matte sampled 0 }")
        for bounces in (0, 1, 2, 40):
            yield Case(f"closed room that glows, sampled {sampled}, {bounces} bounces", text, 0.5 * (1 - 0.5 ** (bounces + 2)) / 0.5,
                       bounces=bounces, **inside)
    guests = (material("mirror", "base_color { 1 1 1 } metallic 1 roughness 0") +
              material("brushed", "base_color { 1 1 1 } metallic 1 roughness .6") +
              material("glass", "base_color { 1 1 1 } transmission 1 roughness 0") +
              "sphere m { center { .4 .4 -.6 } radius .35 material mirror }\n"
              "sphere g { center { -.3 .3 .3 } radius .3 material glass }\n"
              "sphere b { center { .5 .5 .5 } radius .3 material brushed }\n")
    yield Case("closed room with mirror, brushed metal and glass", matte(0.5, glow) + closed_box("matte") + guests, 1.0,
               bounces=100, tolerance=0.005, **inside)
    yield Case("closed room of albedo 0.9", matte(0.9, "emission_color { 1 1 1 } emission_strength .1") + closed_box("matte"),
               1.0, bounces=300, **inside)


def furnaces():
    """Everything that absorbs nothing vanishes in a sky of radiance 1."""
    ball = "sphere ball { center { 0 0 0 } radius 1 material white }\n" + sky(1)
    looks = {"metal": "metallic 1", "glass": "transmission 1", "plastic": "", "coat on metal": "metallic 1 coat 1",
             "coat": "coat 1", "sheen": "sheen 1", "half metal": "metallic .5", "half glass": "transmission .5"}
    for name, words in looks.items():
        for roughness in (0, 0.1, 0.3, 0.6, 1):
            look = material("white", f"base_color {{ 1 1 1 }} {words} roughness {roughness}")
            yield Case(f"furnace, {name}, roughness {roughness}", look + ball, 1.0, eye=(0, -5, 0), fov=0.22, bounces=100,
                       tolerance=0.005)
    yield Case("furnace, matte", matte(1) + ball.replace("white", "matte"), 1.0, eye=(0, -5, 0), fov=0.22, bounces=100)
    yield Case("furnace, clear coat of roughness .5", material("white", "base_color { 1 1 1 } coat 1 coat_roughness .5")
               + ball, 1.0, eye=(0, -5, 0), fov=0.22, bounces=100, tolerance=0.005)


def lambert(corners, radiance):
    """Irradiance of the origin, facing +z, from a polygon above it."""
    v = np.float64(corners)
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(v, np.roll(v, -1, axis=0)):
        side = np.cross(a, b)
        total += np.arccos(a @ b) * side[2] / np.linalg.norm(side)
    return abs(total) * radiance / 2


def lamps():
    radiance, white = 3.0, matte(ALBEDO) + FLOOR
    for name, corners in {"over its middle": ((-1, -.5, 1.5), (-1, .5, 1.5), (1, .5, 1.5)),
                          "aside": ((1, .5, 1), (1, 2, 1), (3, 2, 1)),
                          "upright, near": ((-1, .3, 0), (1, .3, 0), (1, .3, 2))}.items():
        v = np.float64(corners)
        expected = ALBEDO / PI * lambert([*v, v[0] + v[2] - v[1]], radiance)
        words = " ".join(f"vertex{number} {numbers(*corner)}" for number, corner in enumerate(corners))
        area = np.linalg.norm(np.cross(v[1] - v[0], v[2] - v[1]))
        kinds = {"": f"lamp_rectangle lamp {{ radiance {grey(radiance)} {words} }}",
                 ", by power": f"lamp_rectangle lamp {{ power {grey(radiance * PI * area)} {words} }}",
                 ", two-sided, by power": f"lamp_rectangle lamp {{ power {grey(2 * radiance * PI * area)} two_sided 1 {words} }}",
                 ", of glowing material": material("glow", f"base_color {{ 0 0 0 }} {PURE} emission_strength {radiance}")
                 + f"rectangle lamp {{ {words} material glow }}"}
        for kind, lamp in kinds.items():
            yield Case(f"rectangle {name}{kind}", white + lamp + "\n", expected, **ASIDE)
    disc = f"lamp_disc lamp {{ radiance {grey(radiance)} center {{ 0 0 1.5 }} normal {{ 0 0 -1 }} radius .8 }}\n"
    yield Case("disc over its middle", white + disc, ALBEDO * radiance * 0.8**2 / (1.5**2 + 0.8**2), **ASIDE)
    for angle in (0, 0.53, 20):
        for name, way, cosine in (("facing", (0, 0, -1), 1.0), ("slanting", (0.6, 0, -0.8), 0.8)):
            sun = f"lamp_sun sun {{ irradiance {grey(2)} direction {numbers(*way)} angle_deg {angle} }}\n"
            yield Case(f"sun of {angle} degrees, {name}", white + sun, ALBEDO / PI * 2 * cosine, **ASIDE)
    for distance, size in ((10, 0.1), (2, 1.5), (1.5, 0)):
        lamp = f"lamp_point lamp {{ power {grey(50)} position {numbers(0, 0, distance)} radius {size} }}\n"
        yield Case(f"sphere lamp of radius {size} at {distance}", white + lamp, ALBEDO / PI * 50 / (4 * PI * distance**2),
                   **ASIDE)
    for angle, blend in ((60, 0), (10, 0), (60, 0.5)):
        spot = (f"lamp_spot lamp {{ power {grey(50)} position {{ 0 0 2 }} target {{ 0 0 0 }} angle_deg {angle}"
                f" blend {blend} }}\n")
        intensity = 50 / (2 * PI * (1 - np.cos(np.radians(angle / 2))))
        yield Case(f"spot of {angle} degrees, blend {blend}, on its axis", white + spot, ALBEDO / PI * intensity / 4, **ASIDE)


def glass():
    box = "box slab { vertex0 { -9 -9 0 } vertex1 { 9 -9 0 } vertex2 { 9 9 0 } height 1 material glass }\n"
    below = f"lamp_rectangle lamp {{ radiance {grey(1)} vertex0 {{ -5 -5 -2 }} vertex1 {{ 5 -5 -2 }} vertex2 {{ 5 5 -2 }} }}\n"
    above = f"lamp_rectangle lamp {{ radiance {grey(1)} vertex0 {{ -5 -5 9 }} vertex1 {{ -5 5 9 }} vertex2 {{ 5 5 9 }} }}\n"
    clear, r = material("glass", "base_color { 1 1 1 } transmission 1 roughness 0"), 0.04
    yield Case("slab of glass, through", clear + box + below, (1 - r) / (1 + r), bounces=40, eye=(0, 0, 6))
    yield Case("slab of glass, mirrored", clear + box + above, 2 * r / (1 + r), bounces=40, eye=(0, 0, 6))
    keep = np.array([0.5, 0.8, 1.0]) ** (1 / 2)
    tinted = material("glass", "base_color { 1 1 1 } transmission 1 roughness 0 absorption_color { .5 .8 1 }"
                               " absorption_distance 2")
    yield Case("slab that absorbs, through", tinted + box + below, (1 - r) ** 2 * keep / (1 - (r * keep) ** 2), bounces=40,
               eye=(0, 0, 6))
    base = np.array([0.25, 0.64, 1.0])
    stained = material("glass", f"base_color {numbers(*base)} transmission 1 roughness 0")
    inner = base**0.5 * (1 - r)
    yield Case("slab of stained glass, through, first order", stained + box + below, inner**2, bounces=2, eye=(0, 0, 6),
               tolerance=0.004)
    holes = material("glass", f"base_color {{ 0 0 0 }} {PURE} alpha .25")
    yield Case("alpha of 0.25, through", holes + box.replace("box", "box") + below, 0.75**2, bounces=0, eye=(0, 0, 6))
    mix = (material("a", f"base_color {{ 0 0 0 }} {PURE} emission_strength 1") +
           material("b", f"base_color {{ 0 0 0 }} {PURE} emission_strength 5") +
           "material_mix glass { first REFA second REFB factor .25 }\n".replace("REFA", "a").replace("REFB", "b"))
    yield Case("mix of 3/4 and 1/4", mix + box, 2.0, eye=(0, 0, 6))


def directions(width=256):
    """An image whose colour tells the direction."""
    height = width // 2
    v, u = np.meshgrid(PI * (np.arange(height) + 0.5) / height, 2 * PI * (0.5 - (np.arange(width) + 0.5) / width), indexing="ij")
    return 0.5 + 0.4 * np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)


def skies():
    images = {"sky.exr": directions()}
    text = "texture sky { filename sky.exr }\nenvironment sky { texture sky strength 2 turn_deg TURN }\n"
    for way in ((1, 0, 0), (0, 1, 0), (-1, 0.1, 0), (0, -1, 0), (0.3, 0.2, 0.9), (0.5, -0.4, -0.7)):
        unit = np.float64(way) / np.linalg.norm(way)
        yield Case(f"sky toward {way}", text.replace("TURN", "0"), 1 + 0.8 * unit, eye=(0, 0, 0), target=way, images=images)
    turned = np.array([0.0, 1, 0])
    yield Case("sky turned by 90 degrees, toward +y", text.replace("TURN", "90"), 1 + 0.8 * np.array([1.0, 0, 0]),
               eye=(0, 0, 0), target=tuple(turned), images=images)
    # Irradiance of a + b w: pi (a + 2/3 b n).
    for normal in ((0, 0, 1), (0.6, 0, 0.8)):
        floor = matte(ALBEDO) + f"plane floor {{ normal {numbers(*normal)} position {{ 0 0 0 }} material matte }}\n"
        yield Case(f"light of a sky on a floor that faces {normal}", floor + text.replace("TURN", "0"),
                   ALBEDO * 2 * (0.5 + 0.4 * 2 / 3 * np.float64(normal)), eye=(0.5, -1, 5), images=images)
    yield Case("light of a constant sky", matte(ALBEDO) + FLOOR + sky(1.5), ALBEDO * 1.5)


ALBEDOS = {
    "defaults": ("", (0.8074, 0.8124, 0.8221)),
    "white base": ("base_color { 1 1 1 }", (0.9999, 0.9986, 0.9914)),
    "black base": ("base_color { 0 0 0 }", (0.0373, 0.0678, 0.1448)),
    "black base, roughness 0": ("base_color { 0 0 0 } roughness 0", (0.0400, 0.0892, 0.3877)),
    "black base, roughness 1": ("base_color { 0 0 0 } roughness 1", (0.0138, 0.0245, 0.0477)),
    "black base, specular_ior_level 1": ("base_color { 0 0 0 } specular_ior_level 1", (0.0746, 0.1055, 0.1809)),
    "metal 0.8, roughness 0.5": ("metallic 1", (0.7861, 0.7810, 0.7999)),
    "metal 0.8, roughness 1": ("metallic 1 roughness 1", (0.5976, 0.6405, 0.7069)),
    "metal 1, roughness 1": ("base_color { 1 1 1 } metallic 1 roughness 1", (1.0, 0.9998, 0.9992)),
    "diffuse_roughness 1": (f"diffuse_roughness 1 {PURE}", (0.7312, 0.7586, 0.7860)),
    "coat on black": (f"base_color {{ 0 0 0 }} {PURE} coat 1 coat_roughness 0", (0.0400, 0.0892, 0.3877)),
    "sheen on black": (f"base_color {{ 0 0 0 }} {PURE} sheen 1", (0.0186, 0.1539, 0.4579)),
    "sheen on white": (f"base_color {{ 1 1 1 }} {PURE} sheen 1", (1.0, 1.0, 1.0)),
}


def albedos():
    for name, (words, values) in ALBEDOS.items():
        for degrees, expected in zip((0, 60, 80), values):
            angle = np.radians(degrees)
            yield Case(f"albedo, {name}, {degrees} degrees", material("matte", words) + FLOOR + sky(1), expected,
                       eye=(5 * np.sin(angle), 1e-3, 5 * np.cos(angle)), bounces=4, tolerance=0.005)


CASES = (lamp_in_a_sphere, glowing_rooms, furnaces, lamps, glass, skies, albedos)


def render(case, folder, options):
    for name, pixels in case.images.items():
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        with OpenEXR.File(header, {"RGB": np.ascontiguousarray(pixels, dtype=np.float32)}) as file:
            file.write(str(folder / name))
    up = numbers(0, 1, 0) if np.linalg.norm(np.subtract(case.target, case.eye)[:2]) < 1e-6 else numbers(0, 0, 1)
    text = f"""settings s {{ integrator {case.integrator} recursion {case.bounces} imageSamples {options.samples} }}
Camera c {{ fps 25
 Film f {{ width 16 height 16 prefix value_ output EXR_IMAGE }}
 CamSegment s {{ videoStart 0 videoEnd 1 addPosition {numbers(*case.eye)} addTarget {numbers(*case.target)}
  skyStart {up} fovStart {case.fov:g} }} }}
{case.text}"""
    (folder / "scene.txt").write_text(text, encoding="utf-8")
    command = [options.program, "--overwrite", "-s", str(folder / "scene.txt"), "--outdir", str(folder), "--threads", "1"]
    ended = subprocess.run(command, capture_output=True, text=True)
    if ended.returncode:
        return None, ended.stderr
    with OpenEXR.File(ended.stdout.strip().splitlines()[-1]) as file:
        return file.channels()["RGB"].pixels.astype(np.float64), ""


def report(case, folder, options):
    """Prints a line; returns whether the value is right."""
    pixels, words = render(case, folder, options)
    if pixels is None:
        print(f"FAILS {case.name}: {' / '.join(words.strip().splitlines()[:4])}", flush=True)
        return False
    expected = np.broadcast_to(np.float64(case.expected), 3)
    mean, error = pixels.mean(axis=(0, 1)), pixels.std(axis=(0, 1), ddof=1) / 16
    apart = np.abs(mean - expected)
    right = bool(np.all((apart <= case.tolerance * np.abs(expected)) | (apart <= 4 * error)))
    worst = int(np.argmax(apart / np.maximum(np.abs(expected), 1e-9)))
    print(f"{'ok   ' if right else 'OFF  '} {case.name}: {mean[worst]:.5f}, expected {expected[worst]:.5f}, "
          f"{100 * (mean[worst] / max(expected[worst], 1e-9) - 1):+.3f} % ± {100 * error[worst] / max(expected[worst], 1e-9):.3f}",
          flush=True)
    return right


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "target/release/slo-rt"))
    parser.add_argument("--only", nargs="+", default=[""], metavar="PART", help="cases whose name has one of these parts")
    parser.add_argument("--samples", type=int, default=1024)
    options = parser.parse_args()
    cases = [case for make in CASES for case in make() if any(part in case.name for part in options.only)]
    with tempfile.TemporaryDirectory() as folder:
        right = [report(case, Path(folder), options) for case in cases]
    print(f"{sum(right)} of {len(right)} are right")
    sys.exit(0 if all(right) else 1)


if __name__ == "__main__":
    main()
