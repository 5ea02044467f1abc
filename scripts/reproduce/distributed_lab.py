"""The laboratory of distributed.py: renders variants of shipped scenes, and remembers pictures and times."""

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np
from exr import read_exr, shown

ROOT = Path(__file__).resolve().parents[2]
SAMPLING = (
    "generatorType|lightSamplingType|imageSamples|imageMinSamples|imageContrastLimit|contrastType|noise|dofSamples"
    "|softShadowSamples|diffuseReflectionSamples|diffuseRefractionSamples"
)


class Lab:
    """Renders variants of the scenes in `scenes/`. Times are processor seconds (user) of whole runs."""

    def __init__(self, options):
        self.options, self.quick = options, options.quick
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(options.keep or self.temporary.name).resolve()
        (self.folder / "scenes").mkdir(parents=True, exist_ok=True)
        for name in ("meshes", "textures"):  # so that variants of scenes find them
            if not (self.folder / name).exists():
                (self.folder / name).symlink_to(ROOT / name)
        self.began = time.monotonic()

    def scene(self, name, settings="", edit=lambda text: text):
        """A shipped scene with other settings; without any, its own."""
        text = (ROOT / "scenes" / f"{name}.txt").read_text(encoding="utf-8")
        if settings:
            text = re.sub(rf"\b(?:{SAMPLING})\s+\S+", "", text)
            text = re.sub(r"(settings\s+\S+\s*\{)", rf"\1 {settings}", text, count=1)
        return edit(text)

    def test_scene(self, edit=lambda text: text):
        """The thesis's test scene, with a quarter of its samples in a quick run."""
        text = self.scene("thesis2011", edit=edit)
        return text.replace("imageSamples 16", "imageSamples 4") if self.quick else text

    def render(self, text, *arguments, isa=None, kind="exr"):
        """Returns the picture [row, column, channel] and what is known of the run, as measured or as stored."""
        known = "\0".join([text, *map(str, arguments), isa or "", str(self.options.threads), kind])
        name = f"{zlib.crc32(known.encode()):08x}"
        stored = self.folder / f"{name}.npz"
        if stored.exists():
            kept = np.load(stored)
            return kept["picture"].astype(float), json.loads(str(kept["run"]))
        scene = self.folder / "scenes" / f"{name}.txt"
        scene.write_text(text, encoding="utf-8")
        command = [self.options.program, "-q", "--overwrite", "--checkpoint", "0", "-s", str(scene), "--allow-outside", "--format", kind]
        command += ["--threads", str(self.options.threads), "-od", str(self.folder), "--prefix", f"{name}_"]
        command += map(str, arguments)
        environment = {**os.environ, **({"SLO_RT_ISA": isa} if isa else {})}
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        if done.returncode:
            sys.exit(f"{' '.join(command)}: {done.stderr}")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        path = Path(done.stdout.split()[-1])
        recipe = subprocess.run([self.options.program, "--recipe", path], capture_output=True, text=True, check=True)
        run = {
            "seconds": after.ru_utime - before.ru_utime,
            "wall": time.monotonic() - began,
            "samples": json.loads(recipe.stdout)["result"]["samplesPerPixel"],
        }
        picture = read_exr(path)
        path.unlink()
        np.savez_compressed(stored, picture=picture.astype(np.float32), run=json.dumps(run))
        print(f"{time.monotonic() - self.began:6.0f} s: {path.name}: {run['seconds']:.2f} s", file=sys.stderr, flush=True)
        return picture, run

    def spread(self, text, size, frame, *arguments):
        """Renders six small regions of a picture. Returns them in one, and the time that the whole would take. They consist
        of whole blocks of 8 x 8 pixels, which `--noise` judges together."""
        width, height = size
        part = (40, 32) if self.quick else (72, 56)
        pictures, seconds, samples = [], 0.0, []
        for x in (0.2, 0.5, 0.8):
            for y in (0.3, 0.7):
                left, top = (int(side * place - size / 2) // 8 * 8 for side, place, size in zip((width, height), (x, y), part))
                region = f"{part[0]}x{part[1]}+{left}+{top}"
                whole = ["--size", f"{width}x{height}", "-f", frame, "--region", region]
                picture, run = self.render(text, *whole, *arguments)
                pictures.append(picture)
                seconds += run["seconds"]
                samples.append(run["samples"])
        share = len(pictures) * part[0] * part[1] / (width * height)
        return np.concatenate(pictures), seconds / share, float(np.mean(samples))


def mse(picture, reference, encode=lambda a: np.clip(a, 0, 1)):
    """Mean square error of what is shown; 1 is the range from black to white. The thesis shows light as it is."""
    return float(np.mean((encode(picture) - encode(reference)) ** 2))


def mse_srgb(picture, reference):
    return mse(picture, reference, shown)
