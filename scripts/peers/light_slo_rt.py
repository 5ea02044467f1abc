"""slo-rt's path tracer on the scenes of physical light."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np

import job
import light_scenes

try:
    import OpenEXR
except ImportError as error:
    job.missing(f"{error}; `pip install OpenEXR` helps")

FRAME = 0.04


def numbers(values):
    return "{ " + " ".join(f"{v:.9g}" for v in values) + " }"


def corners(shape):
    return " ".join(f"vertex{number} {numbers(v)}" for number, v in enumerate((shape.v0, shape.v1, shape.v2)))


def look(material):
    pure = "ior 1 specular_ior_level 0"
    match material:
        case light_scenes.Matte():
            return f"base_color {numbers(material.color)} {pure}"
        case light_scenes.Metal():
            return f"base_color {numbers(material.color)} metallic 1 roughness {material.roughness:g}"
        case light_scenes.Glass():
            return f"base_color {{ 1 1 1 }} transmission 1 roughness {material.roughness:g} ior {material.ior:g}"
        case light_scenes.Plastic():
            return f"base_color {numbers(material.color)} roughness {material.roughness:g}"
        case light_scenes.Coat():
            return (f"base_color {numbers(material.color)} metallic 1 roughness {material.roughness:g}"
                    f" coat 1 coat_roughness {material.coat_roughness:g}")
        case light_scenes.Glow():
            return (f"base_color {{ 0 0 0 }} {pure} emission_color {numbers(material.radiance)} emission_strength 1")
    raise TypeError(material)


def pose(key):
    pivot, up, right = key
    return f"key {{ pivot {numbers(pivot)} up {numbers(up)} right {numbers(right)} }}"


def object_text(thing, folder):
    frames = " ".join(f"addKframe {{ time {FRAME * number:g} {pose(key)} }}" for number, key in enumerate(thing.keys))
    end = f"material {thing.name} {frames} }}\n"
    text = f"material_principled {thing.name} {{ {look(thing.material)} }}\n"
    match thing.shape:
        case light_scenes.Mesh():
            write_mesh(folder / f"{thing.name}.slo", thing.shape)
            smooth = 0 if thing.shape.normals is None else 1
            return f"{text}mesh {thing.name} {{ filename {thing.name}.slo smooth_normals {smooth} {end}"
        case light_scenes.Sphere():
            shape = f"center {numbers(thing.shape.center)} radius {thing.shape.radius:g}"
            return f"{text}sphere {thing.name} {{ {shape} {end}"
        case light_scenes.Rectangle():
            return f"{text}rectangle {thing.name} {{ {corners(thing.shape)} {end}"
    raise TypeError(thing.shape)


def write_mesh(path, shape):
    def rows(name, values):
        return f"{name} {{\n" + "\n".join(" ".join(f"{v:.9g}" for v in row) for row in values) + "\n}\n"

    text = "slo_mesh 1\n" + rows("vertices", shape.vertices) + rows("faces", shape.faces)
    if shape.normals is not None:
        text += rows("normals", shape.normals)
    path.write_text(text, encoding="utf-8")


def lamp_text(number, lamp):
    match lamp:
        case light_scenes.RectangleLamp():
            what, how = "lamp_rectangle", f"radiance {numbers(lamp.radiance)} {corners(lamp.shape)}"
        case light_scenes.SphereLamp():
            what = "lamp_point"
            how = f"power {numbers(lamp.power())} position {numbers(lamp.center)} radius {lamp.radius:.9g}"
        case light_scenes.Sun():
            what = "lamp_sun"
            how = (f"irradiance {numbers(lamp.irradiance)} direction {numbers(lamp.direction)}"
                   f" angle_deg {lamp.angle_deg:g}")
    return f"{what} lamp_{number} {{ {how} }}\n"


def scene_text(scene, folder, settings="", bounces=None):
    blur = FRAME if scene.moves() else 0
    if scene.photons:
        settings += f" photons {scene.photons:g}"
    text = f"""settings s {{ integrator PATH {settings} recursion {scene.bounces if bounces is None else bounces} }}
Camera c {{ fps 25
 Film f {{ width {light_scenes.WIDTH} height {light_scenes.HEIGHT} prefix still_ output EXR_IMAGE }}
 CamSegment s {{ videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
  addPosition {numbers(scene.eye)} addTarget {numbers(scene.target)} skyStart {{ 0 0 1 }} fovStart {scene.fov}
  dofStart {scene.focus} lensRadiusStart {scene.lens} blurDuration {blur} }} }}
"""
    if scene.sky:
        write_exr(folder / "sky.exr", scene.sky.centered())
        text += "texture sky { filename sky.exr }\nenvironment sky { texture sky }\n"
    text += "".join(lamp_text(number, lamp) for number, lamp in enumerate(scene.lamps))
    return text + "".join(object_text(thing, folder) for thing in scene.things)


def write_exr(path, pixels):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": np.ascontiguousarray(pixels, dtype=np.float32)}) as file:
        file.write(str(path))


def read_exr(path):
    """Returns the colours [row, column, channel]."""
    with OpenEXR.File(path) as file:
        return file.channels()["RGB"].pixels


class SloRt:
    def __init__(self, scene, order):
        self.folder = tempfile.TemporaryDirectory()
        self.program = order["program"]
        self.how = order.get("how", [])
        self.scene = self.write(scene, order.get("settings", ""), order.get("bounces"))
        try:
            self.version = self.run("--version").split()[-1]
        except FileNotFoundError as error:
            job.missing(error)

    def write(self, scene, settings, bounces):
        folder = Path(self.folder.name)
        path = folder / "scene.txt"
        path.write_text(scene_text(scene, folder, settings, bounces), encoding="utf-8")
        return path

    def run(self, *arguments):
        command = [self.program, *map(str, arguments)]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout

    def render(self, samples, seed, threads):
        return self.rendered(seed, threads, "--samples", samples)

    def rendered(self, seed, threads, *how):
        began = job.user_time()
        words = self.run("--overwrite", "-s", self.scene, "--seed", seed, "--threads", threads, "--outdir",
                         self.folder.name, *self.how, *how)
        seconds = job.user_time() - began
        return read_exr(words.strip().splitlines()[-1]), seconds


if __name__ == "__main__":
    job.serve(SloRt, light_scenes.scene)
