"""The laboratory of photon_mapping.py: renders settings of the thesis's scenes, remembers, and compares with references."""

import resource
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import matplotlib.image
import numpy as np
import thesis_scenes
from exr import read_exr, shown


class Lab:
    """Renders and remembers: time, and pictures of two seeds."""

    def __init__(self, options):
        self.options, self.quick = options, options.quick
        self.size = (200, 150) if options.quick else (400, 300)
        self.share = 0.1 if options.quick else 1.0
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(options.keep or self.temporary.name)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.dragon = thesis_scenes.write_files(self.folder)
        self.began = time.monotonic()

    def settings(self, scene, **changes):
        """The thesis's table 2, and what an experiment changes."""
        sharp = scene in (5, 6, 10)
        nearest = 1000 if scene == 10 else 5000
        values = {
            "integrator": "PHOTON_MAP",
            "recursion": 20,
            "gather": int(scene != 1),
            "photonMapSize": 5e6 * self.share,
            "photonNearest": nearest * self.share,
            "photonDistance": 0.3,
            "causticMapSize": 1e7 * self.share if sharp else 1,
            "causticNearest": nearest * self.share,
            "causticDistance": 0.08,
            "cacheError": 0.1,
            "gatherLimit": 0.0005,
            "gatherRays": 256 if self.quick else 1024,
            "imageSamples": 4,
        }
        values.update(changes)
        if values["integrator"] == "PATH":
            values = {key: values[key] for key in ("integrator", "recursion", "imageSamples")}
        elif not values["gather"]:
            for key in ("cacheError", "gatherLimit", "gatherRays"):
                del values[key]
        return " ".join(
            f"{key} {value if isinstance(value, str) else format(value, '.9g')}" for key, value in values.items()
        )

    def render(self, scene, seed, sampled=None, **changes):
        """Returns the picture and its processor time."""
        settings = self.settings(scene, **changes)
        text = thesis_scenes.text(scene, settings, self.size, sampled)
        name = f"{zlib.crc32(text.encode()):08x}_{seed}"
        kept = self.folder / f"{name}.npz"
        if kept.exists():
            stored = np.load(kept)
            return stored["picture"].astype(float), float(stored["seconds"])
        path = self.folder / f"{name}.txt"
        path.write_text(text, encoding="utf-8")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        command = [
            self.options.program,
            "-q",
            "--overwrite",
            "-s",
            path.name,
            "--seed",
            str(seed),
            "--threads",
            str(self.options.threads),
            "--prefix",
            f"{name}_",
        ]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{' '.join(command)}: {done.stderr}")
        seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        picture = read_exr(self.folder / done.stdout.split()[-1])
        (self.folder / done.stdout.split()[-1]).unlink()
        np.savez_compressed(kept, picture=picture.astype(np.float32), seconds=seconds)
        print(
            f"{time.monotonic() - self.began:6.0f} s: scene {scene}, {settings}: {seconds:.2f} s",
            file=sys.stderr,
            flush=True,
        )
        return picture, seconds

    def reference(self, scene):
        samples = (128 if scene == 1 else 32) if self.quick else 256
        return sum(self.render(scene, seed, integrator="PATH", imageSamples=samples)[0] for seed in (101, 102)) / 2

    def measure(self, scene, reference=None, **changes):
        """Returns time, noise, bias, bias at edges, and brightness relative to the reference."""
        (a, spent_a), (b, spent_b) = (self.render(scene, seed, **changes) for seed in (1, 2))
        r = self.reference(scene) if reference is None else reference
        scale = r**2 + 0.01
        both = np.mean((a - r) * (b - r) / scale, axis=-1)
        edges = changes_of(r)
        return {
            "time": (spent_a + spent_b) / 2,
            "noise": float(np.mean((a - b) ** 2 / (2 * scale))),
            "bias": float(both.mean()),
            "edges": float(both[edges >= np.quantile(edges, 0.9)].mean()),
            "mean": float((a + b).mean() / (2 * r.mean())),
        }

    def pictures(self, scene, **changes):
        if self.options.pictures:
            folder = Path(self.options.pictures)
            folder.mkdir(parents=True, exist_ok=True)
            matplotlib.image.imsave(folder / f"scene_{scene}.png", shown(self.render(scene, 1, **changes)[0]))


def changes_of(r):
    """How much the brightness of each pixel differs from its neighbours', relative to it."""
    light = r.mean(axis=-1)
    padded = np.pad(light, 1, mode="edge")
    rows, columns = light.shape
    around = [padded[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]
    return (np.max(around, axis=0) - np.min(around, axis=0)) / (light + 0.05)
