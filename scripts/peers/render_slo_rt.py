"""slo-rt: the whole process, from the scene's text to the EXR file; with --order '{"rendering": true}' rendering only.

The time of rendering only is the wall clock time that the program reports (`-v`), so the core must be otherwise idle.
"""

import re
import subprocess
import tempfile
from pathlib import Path

import job
import stills

try:
    import OpenEXR
except ImportError as error:
    job.missing(f"{error}; `pip install OpenEXR` helps")


def numbers(values):
    return "{ " + " ".join(f"{v:g}" for v in values) + " }"


def material(name, color, more=""):
    return (f"phong_info {name} {{ diffuse {numbers(color)} {more} }}\n"
            f"material_phong {name} {{ phong_info {name} }}\n")


def object_text(still, name):
    place, color = stills.MESHES[name]
    words = {stills.WHITE: "white", stills.BLUE: "blue", stills.RED: "red"}
    look = "glass" if still.rough and name == stills.GLASS else words[color]
    keys = [f"key {{ pivot {numbers(place)} }}"]
    if still.moves and name == stills.MOVES:
        keys = [f"key {{ pivot {numbers(p)} up {numbers(u)} right {numbers(r)} }}" for p, u, r in stills.KEYS]
    frames = " ".join(f"addKframe {{ time {0.04 * i:g} {key} }}" for i, key in enumerate(keys))
    mesh = stills.ROOT / "meshes" / f"{name}.slo"
    return f"mesh {name} {{ filename {mesh} smooth_normals 1 material {look} {frames} }}\n"


def scene_text(still, settings=""):
    v0, v1, v2 = map(numbers, stills.LIGHT)
    center, radius, _ = stills.BALL
    text = f"""settings s {{ {settings} recursion {stills.BOUNCES if still.rough else 0} background {numbers(stills.SKY)} }}
Camera c {{ fps 25
 Film f {{ width {stills.WIDTH} height {stills.HEIGHT} prefix still_ output EXR_IMAGE }}
 CamSegment s {{ videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
  addPosition {numbers(stills.EYE)} addTarget {numbers(stills.TARGET)} skyStart {{ 0 0 1 }} fovStart {stills.FOV}
  dofStart {stills.FOCUS} lensRadiusStart {still.lens} blurDuration {0.04 * stills.SHUTTER if still.moves else 0} }} }}
light_rectangle lamp {{ color {numbers(stills.LIGHT_COLOR)} vertex0 {v0} vertex1 {v1} vertex2 {v2} }}
plane floor {{ normal {{ 0 0 1 }} position {{ 0 0 0 }} material floor }}
sphere ball {{ center {numbers(center)} radius {radius} material red }}
"""
    text += material("white", stills.WHITE) + material("blue", stills.BLUE) + material("red", stills.RED)
    if still.rough:
        text += material("floor", stills.FLOOR_UNDER_MIRROR,
                         f"reflectance {stills.MIRROR} diffuse_reflection {stills.MIRROR_SPREAD}")
        text += material("glass", (0, 0, 0), f"refraction .92 refraction_index {stills.GLASS_INDEX} reflectance .08"
                         f" diffuse_refraction {stills.GLASS_SPREAD} diffuse_reflection {stills.GLASS_SPREAD}")
    else:
        text += material("floor", stills.FLOOR)
    return text + "".join(object_text(still, name) for name in stills.MESHES)


def read_exr(path):
    """Returns the colours [row, column, channel]."""
    with OpenEXR.File(path) as file:
        return file.channels()["RGB"].pixels


class SloRt:
    def __init__(self, still, order):
        self.folder = tempfile.TemporaryDirectory()
        self.program = order["program"]
        self.rendering = order.get("rendering", False)
        self.scene = self.write("still.txt", scene_text(still))
        try:
            self.version = self.run("--version").split()[-1]
        except FileNotFoundError as error:
            job.missing(error)

    def write(self, name, text):
        path = Path(self.folder.name) / name
        path.write_text(text, encoding="utf-8")
        return path

    def run(self, *arguments):
        return self.ended(*arguments).stdout

    def ended(self, *arguments):
        command = [self.program, *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True)

    def render(self, samples, seed, threads):
        return self.rendered(self.scene, seed, threads, "--samples", samples)

    def rendered(self, scene, seed, threads, *how):
        began = job.user_time()
        ended = self.ended("-v", "--overwrite", "--allow-outside", "-s", scene, "--seed", seed, "--threads", threads,
                           "--outdir", self.folder.name, *how)
        seconds = job.user_time() - began
        if self.rendering:
            seconds = float(re.search(r"rendering ([0-9.]+) s", ended.stderr).group(1))
        return read_exr(ended.stdout.strip()), seconds


if __name__ == "__main__":
    job.serve(SloRt)
