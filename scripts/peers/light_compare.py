#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy", "openexr>=3.3", "pillow"]
# ///
"""Compares path tracers on scenes of physical light: whether they agree, and the time for a given noise level.

    python3 scripts/peers/light_compare.py agree [--only slo-rt mitsuba cycles] [--scenes room window hall ...]
        [--reference 1024] [--keep FOLDER] [--pictures FOLDER] [--python mitsuba=VENV/bin/python ...] [--llvm libLLVM.so]
    python3 scripts/peers/light_compare.py time [the same options] [--limit 60]

`agree` compares the reference of every renderer with that of the first: the mean of the picture, with its standard
error, and blocks of 16 x 16 pixels, as the number of standard errors and in per cent. With --pictures it writes the
references, and the difference as red (brighter than the first) and blue (darker), white at 10 % of the brightness.

`time` doubles the number of samples until the relative mean square error is below the scene's limit, and prints the
processor time (user) for exactly this error. The error is the mean of (a - r)^2 / (r^2 + 0.01) without the worst 0.1 %
of the pixels, where r is a reference by the same renderer with other seeds; the error of all pixels goes to standard
error. Scenes of caustics have a limit for all pixels.

A reference is the mean of sixteen pictures; the noise that it still has is estimated from their differences. --keep
stores them in a folder, for later calls with the same scenes and the same renderer.
"""

import argparse
import math
import sys
from pathlib import Path

try:
    import numpy as np
    from PIL import Image
except ModuleNotFoundError as error:
    sys.exit(f"light_compare.py: {error}; start it by `uv run`, or `pip install numpy openexr pillow`")

import compare
import job
import light_scenes

RENDERERS = {"slo-rt": "light_slo_rt", "mitsuba": "light_mitsuba", "cycles": "light_cycles"}
CHUNKS = 16
BLOCK = 16
LEFT_OUT = 0.001


def errors(picture, reference):
    """Relative square error of each pixel, sorted."""
    return np.sort(np.mean((picture - reference) ** 2 / (reference**2 + 0.01), axis=-1), axis=None)


def trimmed(values):
    return float(np.mean(values[:len(values) - math.ceil(LEFT_OUT * len(values))]))


class Reference:
    """Sixteen pictures of one renderer, and their mean."""

    def __init__(self, name, scene, renderer, options):
        count = max(1, options.reference // CHUNKS)
        folder = Path(options.keep) / name / scene if options.keep else None
        pictures = []
        for chunk in range(CHUNKS):
            path = folder and folder / f"{count}_{chunk}.npy"
            if path and path.exists():
                pictures.append(np.load(path).astype(np.float64))
                continue
            pictures.append(renderer.reference(count, 1000 + chunk, options.threads))
            if path:
                folder.mkdir(parents=True, exist_ok=True)
                np.save(path, pictures[-1].astype(np.float32))
        self.pictures = np.array(pictures)
        self.mean = self.pictures.mean(axis=0)
        apart = [errors(picture, self.mean) for picture in pictures]
        self.noise = np.mean([np.mean(e) for e in apart]) / (CHUNKS - 1)
        self.trimmed_noise = np.mean([trimmed(e) for e in apart]) / (CHUNKS - 1)

    def blocks(self):
        """Means of blocks of pixels, and their standard errors."""
        count, rows, columns, _ = self.pictures.shape
        cut = self.pictures[:, :rows // BLOCK * BLOCK, :columns // BLOCK * BLOCK].mean(axis=-1)
        means = cut.reshape(count, rows // BLOCK, BLOCK, columns // BLOCK, BLOCK).mean(axis=(2, 4))
        return means.mean(axis=0), means.std(axis=0, ddof=1) / math.sqrt(count)


def agree(first, other):
    """Returns a line of numbers that compares two references."""
    means = [reference.pictures.mean(axis=(1, 2)) for reference in (first, other)]
    (a, b), count = (m.mean(axis=0) for m in means), len(means[0])
    whole = [m.mean(axis=1) for m in means]
    ratio = whole[1].mean() / whole[0].mean()
    spread = math.hypot(*(w.std(ddof=1) / w.mean() / math.sqrt(count) for w in whole))
    (mean0, error0), (mean1, error1) = first.blocks(), other.blocks()
    off = (mean1 - mean0) / np.hypot(error0, error1).clip(1e-12)
    part = (mean1 - mean0) / mean0.clip(1e-3)
    # Beyond the noise: by how much a block differs at least, at three standard errors.
    beyond = np.sign(part) * np.maximum(np.abs(part) - 3 * np.hypot(error0, error1) / mean0.clip(1e-3), 0)
    worst = np.unravel_index(np.argmax(np.abs(beyond)), beyond.shape)
    channels = " ".join(f"{100 * (y / x - 1):+.2f}" for x, y in zip(a, b))
    return (f"{100 * (ratio - 1):+.3f} % ± {100 * spread:.3f} (r g b {channels}), "
            f"blocks: {np.sqrt(np.mean(off**2)):.2f} standard errors, worst {100 * beyond[worst]:+.2f} % "
            f"beyond noise at row {worst[0] * BLOCK}, column {worst[1] * BLOCK}")


def write_difference(path, first, other):
    """Red: brighter than the first; blue: darker. Full at 10 % of the first's brightness."""
    a, b = first.mean.mean(axis=-1), other.mean.mean(axis=-1)
    part = np.clip((b - a) / (a + 0.01) / 0.1, -1, 1)
    colors = np.stack([1 + np.minimum(part, 0), 1 - np.abs(part), 1 - np.maximum(part, 0)], axis=-1)
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray((colors * 255 + 0.5).astype(np.uint8)).resize((3 * a.shape[1], 3 * a.shape[0]), 0).save(path)


def time_for(scene, renderer, reference, options):
    limit, series, samples = light_scenes.scene(scene).limit, [], options.first
    of_all = light_scenes.scene(scene).all_pixels
    while True:
        cut, whole, seconds = [], [], []
        for turn in range(options.turns):
            picture, spent = renderer.render(samples, 1 + turn)
            apart = errors(picture, reference.mean)
            cut.append(trimmed(apart) - reference.trimmed_noise)
            whole.append(np.mean(apart) - reference.noise)
            seconds.append(spent)
        error = whole if of_all else cut
        series.append((samples, min(seconds), sum(error) / len(error)))
        print(f"{scene}: {samples} samples, {min(seconds):.2f} to {max(seconds):.2f} s, {np.mean(cut):.2e}, "
              f"of all pixels {np.mean(whole):.2e} (reference {reference.trimmed_noise:.1e})", file=sys.stderr, flush=True)
        if series[-1][2] <= limit or 2 * min(seconds) > options.limit:
            return compare.time_for(limit, series), samples_for(limit, series)
        samples *= 2


def samples_for(limit, series):
    """Samples a pixel for this error, to within the slope of the last two pictures."""
    (n, _, error), before = series[-1], series[-2] if len(series) > 1 else None
    slope = math.log(before[2] / error) / math.log(n / before[0]) if before else 1
    return n * (error / limit) ** (1 / max(slope, 0.5))


def rows(options):
    for scene in options.scenes:
        first = None
        for name in options.only:
            if name == "mitsuba" and options.what == "agree" and not light_scenes.scene(scene).same_light:
                continue
            try:
                with compare.Renderer(RENDERERS[name], scene, options) as renderer:
                    reference = Reference(name, scene, renderer, options)
                    if options.pictures:
                        compare.write_png(Path(options.pictures) / f"{scene}_{name}.png", reference.mean)
                    if options.what == "time":
                        seconds, samples = time_for(scene, renderer, reference, options)
                        yield f"{scene}, {name} {renderer.version}: {seconds} s, {samples:.0f} samples"
                    elif first is None:
                        first = name, reference
                        mean = " ".join(f"{c:.5f}" for c in reference.mean.mean(axis=(0, 1)))
                        yield f"{scene}, {name} {renderer.version}: mean {mean}"
                    else:
                        yield f"{scene}, {name} against {first[0]}: {agree(first[1], reference)}"
                        if options.pictures:
                            write_difference(Path(options.pictures) / f"{scene}_{name}_{first[0]}.png", first[1], reference)
            except compare.Unable as unable:
                code, words = unable.args
                yield f"{scene}, {name}: " + (f"skipped: {words}" if code == job.NOT_INSTALLED else words)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("agree", "time"))
    parser.add_argument("--only", nargs="+", default=list(RENDERERS), choices=list(RENDERERS))
    parser.add_argument("--scenes", nargs="+", default=list(light_scenes.SCENES), choices=list(light_scenes.SCENES))
    parser.add_argument("--program", default=str(compare.HERE.parents[1] / "target/release/slo-rt"), help="slo-rt")
    parser.add_argument("--python", nargs="+", default=[], metavar="NAME=PYTHON")
    parser.add_argument("--llvm", help="libLLVM.so for Mitsuba")
    parser.add_argument("--order", default="{}", help="JSON: settings of a renderer's module")
    parser.add_argument("--reference", type=int, default=1024, help="samples of the reference")
    parser.add_argument("--threads", type=int, default=1, help="threads for the reference")
    parser.add_argument("--first", type=int, default=16, help="samples of the first picture")
    parser.add_argument("--turns", type=int, default=3, help="pictures for each number of samples: least time, mean error")
    parser.add_argument("--limit", type=float, default=60, help="most seconds of a picture")
    parser.add_argument("--keep", metavar="FOLDER", help="folder in which the pictures of references are stored")
    parser.add_argument("--pictures", metavar="FOLDER", help="folder to which PNG files are written")
    options = parser.parse_args()
    for line in rows(options):
        print(line, flush=True)


if __name__ == "__main__":
    main()
