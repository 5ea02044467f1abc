#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy", "openexr>=3.3", "pillow"]
# ///
"""Measures the processor time that slo-rt and other renderers need for a given noise level, on one thread.

    python3 scripts/peers/compare.py [--only slo-rt cycles ...] [--stills S1 S2 S3 S4]
        [--python cycles=VENV/bin/python ...] [--llvm libLLVM.so] [--reference 1024] [--pictures FOLDER]

Renders four still lifes, doubling the number of samples, until the relative mean square error is below 1e-3 (S4:
1e-2). This error is the mean of (a - r)^2 / (r^2 + 0.01), where r is a reference by the same renderer with other
seeds. Prints the time for exactly this error as a row of a Markdown table, interpolated linearly between the last two
pictures in the logarithms of time and error. `~` marks a time that is extrapolated with error = 1 / samples, because
the next picture would have taken longer than --limit.

A reference is the mean of eight pictures. The noise that it still has is estimated from their differences, and
subtracted.

Each renderer runs in a process of its own, under the Python that --python names (by default the one that runs this
script), so the renderers may be installed independently of each other. Renderers that are not installed are skipped.

Needs `pip install numpy openexr pillow`, which `uv run scripts/peers/compare.py` fetches by itself. The other
renderers need `pip install mitsuba`, `bpy` or `pyluxcore`, or Debian's povray, each together with numpy.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import numpy as np
    from PIL import Image
except ModuleNotFoundError as error:
    sys.exit(f"compare.py: {error}; start it by `uv run`, or `pip install numpy openexr pillow` in a virtual environment")

import job
import stills

HERE = Path(__file__).resolve().parent
RENDERERS = {
    "slo-rt": "render_slo_rt",
    "slo-rt-noise": "render_slo_rt_noise",
    "mitsuba": "render_mitsuba",
    "cycles": "render_cycles",
    "luxcore": "render_luxcore",
    "povray": "render_povray",
}
TARGETS = {"S1": 1e-3, "S2": 1e-3, "S3": 1e-3, "S4": 1e-2}
CHUNKS = 8


class Unable(Exception):
    """A renderer's process ended; holds its exit code and last messages."""


class Renderer:
    """A renderer that has loaded a still life."""

    def __init__(self, module, still, options):
        self.folder = tempfile.TemporaryDirectory()
        self.words = open(Path(self.folder.name) / "words", "w+", encoding="utf-8", errors="replace")
        answers, theirs = os.pipe()
        self.answers = os.fdopen(answers)
        order = {"still": still, "answers": theirs, "program": options.program, "llvm": options.llvm}
        order.update(json.loads(options.order))
        name = module.split("_", 1)[1].replace("_", "-")
        python = dict(pair.split("=", 1) for pair in options.python).get(name, sys.executable)
        command = [python, str(HERE / f"{module}.py"), json.dumps(order)]
        self.process = subprocess.Popen(command, text=True, pass_fds=[theirs], stdin=subprocess.PIPE,
                                        stdout=self.words, stderr=self.words)
        os.close(theirs)
        self.version = self.answer()["version"]

    def answer(self):
        line = self.answers.readline()
        if not line:
            code = self.process.wait()
            self.words.seek(0)
            lines = [line for line in self.words.read().splitlines() if line.strip()]
            raise Unable(code, lines[-1] if lines else "")
        return json.loads(line)

    def render(self, samples, seed, threads=1):
        """Returns the picture, and the processor time that it took."""
        return self.wish(samples=samples, seed=seed, threads=threads, reference=False)

    def reference(self, samples, seed, threads):
        """Renders a picture with the same number of samples in every pixel."""
        return self.wish(samples=samples, seed=seed, threads=threads, reference=True)[0]

    def wish(self, **wish):
        path = Path(self.folder.name) / "picture.npy"
        wish["picture"] = str(path)
        print(json.dumps(wish), file=self.process.stdin, flush=True)
        seconds = self.answer()["seconds"]
        return np.load(path).astype(np.float64), seconds

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait()
        self.words.close()
        self.answers.close()


def relative(difference, reference):
    return float(np.mean(difference**2 / (reference**2 + 0.01)))


def reference_of(renderer, options):
    """A reference picture, and its own relative mean square error."""
    count = max(1, options.reference // CHUNKS)
    pictures = [renderer.reference(count, 1000 + chunk, options.reference_threads) for chunk in range(CHUNKS)]
    mean = np.mean(pictures, axis=0)
    noise = np.mean([relative(picture - mean, mean) for picture in pictures]) / (CHUNKS - 1)
    return mean, noise


def time_for(target, series):
    """Returns the time to reach the error, as text, from a list of (samples, seconds, error) with falling errors."""
    n, seconds, error = series[-1]
    if error > target:
        return f"~{seconds * error / target:.0f}"
    if len(series) == 1:
        return f"< {seconds:.2g}"
    _, seconds0, error0 = series[-2]
    share = math.log(error0 / target) / math.log(error0 / error)
    needed = seconds0 * (seconds / seconds0) ** share
    return f"{needed:.2f}" if needed < 10 else f"{needed:.0f}"


def measure(renderer, still, options):
    reference, noise = reference_of(renderer, options)
    if options.pictures:
        write_png(Path(options.pictures) / f"{still}.png", reference)
    series, samples = [], options.first
    while True:
        error, seconds = [], []
        for turn in range(options.turns):
            picture, spent = renderer.render(samples, 1 + turn)
            error.append(relative(picture - reference, reference) - noise)
            seconds.append(spent)
        series.append((samples, min(seconds), sum(error) / len(error)))
        print(f"{still}: {samples} samples, {min(seconds):.2f} s, {series[-1][2]:.2e} "
              f"(reference {noise:.1e})", file=sys.stderr, flush=True)
        if series[-1][2] <= TARGETS[still] or 2 * min(seconds) > options.limit:
            return time_for(TARGETS[still], series)
        samples *= 2


def write_png(path, picture):
    linear = np.clip(picture, 0, 1)
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray((shown * 255 + 0.5).astype(np.uint8)).save(path)


def row(name, options):
    cells, version = [], ""
    for still in options.stills:
        try:
            with Renderer(RENDERERS[name], still, options) as renderer:
                version = renderer.version
                where = argparse.Namespace(**vars(options))
                where.pictures = options.pictures and str(Path(options.pictures) / name)
                cells.append(measure(renderer, still, where))
        except Unable as unable:
            code, words = unable.args
            if code == job.NOT_INSTALLED:
                print(f"{name} is skipped: {words}", file=sys.stderr)
                return None
            print(f"{name}, {still}: {words}", file=sys.stderr)
            cells.append("cannot" if code == job.CANNOT else "fails")
    return f"| {name} {version} | " + " | ".join(cells) + " |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=list(RENDERERS), choices=list(RENDERERS))
    parser.add_argument("--stills", nargs="+", default=list(stills.STILLS), choices=stills.STILLS)
    parser.add_argument("--program", default=str(stills.ROOT / "target/release/slo-rt"), help="slo-rt")
    parser.add_argument("--python", nargs="+", default=[], metavar="NAME=PYTHON")
    parser.add_argument("--llvm", help="libLLVM.so for Mitsuba")
    parser.add_argument("--order", default="{}", help="JSON: settings of a renderer's module")
    parser.add_argument("--reference", type=int, default=1024, help="samples of the reference")
    parser.add_argument("--reference-threads", type=int, default=1)
    parser.add_argument("--first", type=int, default=1, help="samples of the first picture")
    parser.add_argument("--turns", type=int, default=3, help="pictures for each number of samples: least time, mean error")
    parser.add_argument("--limit", type=float, default=300, help="most seconds of a picture")
    parser.add_argument("--pictures", metavar="FOLDER", help="folder to which references are written as PNG files")
    options = parser.parse_args()
    print("| seconds | " + " | ".join(options.stills) + " |\n|" + "---|" * (len(options.stills) + 1), flush=True)
    for name in options.only:
        line = row(name, options)
        if line:
            print(line, flush=True)


if __name__ == "__main__":
    main()
