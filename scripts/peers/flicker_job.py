"""What the renderers of flicker.py have in common: a process renders all frames and writes each with its time."""

import json
import os
import sys
from pathlib import Path

import numpy as np

import flicker_scene
import light_scenes


class Calibrated:
    """A renderer that takes a number of samples; it is chosen once, from two times of the first frame."""

    samples = None

    def timed(self, frame, seed, samples, threads, number):
        raise NotImplementedError

    def render(self, frame, seed, seconds, threads, number):
        if self.samples is None:
            few, many = 4, 16
            a = self.timed(frame, seed, few, threads, number)[1]
            b = self.timed(frame, seed, many, threads, number)[1]
            each = max((b - a) / (many - few), 1e-6)
            self.samples = max(1, round((seconds - (a - few * each)) / each))
        return self.timed(frame, seed, self.samples, threads, number)


def serve(renderer_class):
    """Renders the frames that the order lists; those that are written already are left alone."""
    order = json.loads(sys.argv[1])
    light_scenes.WIDTH, light_scenes.HEIGHT = order["size"]
    folder = Path(order["folder"])
    renderer = renderer_class(order)
    (folder / "version").write_text(renderer.version, encoding="utf-8")
    known = folder / "samples"
    if known.exists():
        renderer.samples = int(known.read_text(encoding="utf-8"))
    for number in order["frames"]:
        path = folder / f"{number:03}.npz"
        if path.exists():
            continue
        seed = 1 + (0 if order["fixed"] else number)
        picture, seconds = renderer.render(flicker_scene.room(number), seed, order["seconds"], order["threads"], number)
        np.savez(path, picture=np.ascontiguousarray(picture[..., :3], np.float32), seconds=seconds)
        if getattr(renderer, "samples", None):
            known.write_text(str(renderer.samples), encoding="utf-8")
        print(f"{folder.name}, frame {number}: {seconds:.2f} s", flush=True)
    # Some renderers crash at shutdown.
    sys.stdout.flush()
    os._exit(0)
