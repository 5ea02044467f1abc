#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy", "openexr>=3.3", "pillow"]
# ///
"""Measures how much still things flicker in an animation with a moving lamp and glass, at equal time.

    python3 scripts/peers/flicker.py --keep FOLDER [--seconds 3] [--only slo-rt-path luxcore-photongi cycles-path ...]
        [--frames 48] [--size 256x144] [--program slo-rt] [--python luxcore=VENV/bin/python ...] [--sheet FILE.webp]

Renders the room of flicker_scene.py with slo-rt, LuxCore and Cycles: every frame in the same processor time (user, on
one thread), once with random numbers that are the same in all frames (FIXED) and once with others in each (FRAME). In
slo-rt, this is `photonSeed`: the numbers of camera paths always differ.

Prints, over the pixels that should stand still,

    deviation   the standard deviation of a pixel over time, of its mean: the root of the mean over pixels
    median      the median pixel's
    steps       the same of the differences between successive frames, over the root of two: what the eye sees

A pixel stands still if its true change is below 1 %: the standard deviation over time of a cubic that is fitted to
each sequence, taken as the median of all, and blurred over 5 x 5 pixels. Frames that are in the folder are not
rendered again. --sheet writes a contact sheet: a frame of each sequence, and its deviation.

Each program runs under the Python that --python names (by default the one that runs this script): they need `pip
install pyluxcore`, or `bpy`, together with numpy. Programs that are not installed are left out.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

try:
    import numpy as np
    from PIL import Image, ImageDraw
except ModuleNotFoundError as error:
    sys.exit(f"flicker.py: {error}; start it by `uv run`, or `pip install numpy openexr pillow`")

HERE = Path(__file__).resolve().parent
SEQUENCES = {
    "slo-rt-path": ("flicker_slo_rt", "path", "slo-rt, `PATH` with `photons .5`"),
    "slo-rt-photon-map": ("flicker_slo_rt", "photon_map", "slo-rt, `PHOTON_MAP`"),
    "slo-rt-preview": ("flicker_slo_rt", "preview", "slo-rt, `PHOTON_MAP` with `gather 0`"),
    "slo-rt-cache": ("flicker_slo_rt", "cache", "slo-rt, `PHOTON_MAP` with a cache"),
    "luxcore-photongi": ("flicker_luxcore", "photongi", "LuxCore, PhotonGI"),
    "luxcore-path": ("flicker_luxcore", "path", "LuxCore, path tracing"),
    "cycles-path": ("flicker_cycles", "path", "Cycles"),
}
STILL = 0.01


def render(name, fixed, options):
    """Returns the sequence [frame, row, column, channel] and the seconds of its frames, or nothing."""
    module, how, _ = SEQUENCES[name]
    folder = Path(options.keep).resolve() / f"{name}_{'fixed' if fixed else 'frame'}"
    folder.mkdir(parents=True, exist_ok=True)
    # Both sequences of a program take the same number of samples.
    samples = folder.parent / f"{name}_frame" / "samples"
    if fixed and samples.exists():
        (folder / "samples").write_bytes(samples.read_bytes())
    frames = list(range(0, 48, 48 // options.frames))
    order = {
        "how": how,
        "fixed": fixed,
        "folder": str(folder),
        "frames": frames,
        "seconds": options.seconds,
        "threads": 1,
        "size": options.size,
        "program": str(Path(options.program).resolve()),
    }
    python = dict(pair.split("=", 1) for pair in options.python).get(
        name.rsplit("-", 1)[0].split("-")[0], sys.executable
    )
    if any(not (folder / f"{number:03}.npz").exists() for number in frames):
        with open(folder / "words", "w", encoding="utf-8") as words:
            subprocess.run(
                [python, str(HERE / f"{module}.py"), json.dumps(order)], stdout=words, stderr=words, check=False
            )
    paths = [folder / f"{number:03}.npz" for number in frames]
    if not all(path.exists() for path in paths):
        lines = (folder / "words").read_text(encoding="utf-8", errors="replace").strip().splitlines()
        print(f"{name} is left out: {lines[-1] if lines else 'no frames'}", file=sys.stderr)
        return None
    stored = [np.load(path) for path in paths]
    version = (folder / "version").read_text(encoding="utf-8")
    return np.array([s["picture"] for s in stored], float), np.array([float(s["seconds"]) for s in stored]), version


def fitted(sequence):
    """A cubic over time for each pixel's brightness."""
    count, rows, columns, _ = sequence.shape
    powers = np.polynomial.legendre.legvander(np.linspace(-1, 1, count), 3)
    light = sequence.mean(axis=-1).reshape(count, -1)
    return (powers @ np.linalg.lstsq(powers, light, rcond=None)[0]).reshape(count, rows, columns)


def blurred(pictures, half=2):
    padded = np.pad(pictures, ((0, 0), (half, half), (half, half)), mode="edge")
    rows, columns = pictures.shape[1:]
    return (
        sum(padded[:, i : i + rows, j : j + columns] for i in range(2 * half + 1) for j in range(2 * half + 1))
        / (2 * half + 1) ** 2
    )


def still_pixels(sequences):
    mean = blurred(np.median([fitted(s / np.median(s)) for s in sequences], axis=0))
    light = mean.mean(axis=0)
    # Lamps, and the brightest pixels next to them, are not light on surfaces.
    return (mean.std(axis=0) < STILL * light) & (light < 5)


def flicker(sequence):
    """Relative deviations of each pixel over time, and of the steps between frames."""
    light = sequence.mean(axis=-1)
    mean = light.mean(axis=0) + 0.01 * light.mean()
    return light.std(axis=0, ddof=1) / mean, np.sqrt(np.mean(np.diff(light, axis=0) ** 2, axis=0) / 2) / mean


def sheet(path, sequences, still):
    cells = []
    for (name, fixed), sequence in sequences.items():
        deviation = np.clip(flicker(sequence)[0] / 0.3, 0, 1)
        linear = np.clip(1.2 * sequence[len(sequence) // 2] / sequence.mean() * 0.25, 0, 1)
        picture = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        heat = np.stack([deviation, deviation**2, deviation**4], axis=-1)
        heat[~still] = heat[~still] * 0.5 + np.array([0.0, 0.0, 0.25])
        both = np.concatenate([picture, heat], axis=1)
        image = Image.fromarray((255 * both + 0.5).astype(np.uint8))
        ImageDraw.Draw(image).text((4, 2), f"{name} {'FIXED' if fixed else 'FRAME'}", fill=(255, 255, 255))
        cells.append(image)
    width, height = cells[0].size
    columns = 2
    whole = Image.new("RGB", (columns * width, -(-len(cells) // columns) * height))
    for number, cell in enumerate(cells):
        whole.paste(cell, (number % columns * width, number // columns * height))
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    whole.save(path, quality=80)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--keep", required=True, metavar="FOLDER", help="folder for the frames")
    parser.add_argument("--only", nargs="+", default=list(SEQUENCES), choices=list(SEQUENCES))
    parser.add_argument("--seconds", type=float, default=3, help="processor time of a frame")
    parser.add_argument("--frames", type=int, default=48, choices=(6, 12, 24, 48))
    parser.add_argument("--size", type=lambda text: list(map(int, text.split("x"))), default=[256, 144])
    parser.add_argument("--program", default=str(HERE.parents[1] / "target/release/slo-rt"), help="slo-rt")
    parser.add_argument("--python", nargs="+", default=[], metavar="NAME=PYTHON")
    parser.add_argument("--sheet", metavar="FILE")
    options = parser.parse_args()
    found, seconds, versions = {}, {}, {}
    for name in options.only:
        for fixed in (False, True):
            if made := render(name, fixed, options):
                found[name, fixed], seconds[name, fixed], versions[name] = made
    if not found:
        sys.exit("no program rendered the frames")
    still = still_pixels(list(found.values()))
    print(f"{100 * still.mean():.0f} % of the pixels stand still.\n")
    print("| program | random numbers | s a frame | deviation | median | steps |\n|---|---|---|---|---|---|")
    for (name, fixed), sequence in found.items():
        deviation, steps = (part[still] for part in flicker(sequence))
        root = [f"{100 * np.sqrt(np.mean(part**2)):.1f} %" for part in (deviation, steps)]
        what = f"{SEQUENCES[name][2]} ({versions[name]}) | {'FIXED' if fixed else 'FRAME'}"
        spent = f"{seconds[name, fixed].mean():.2f}"
        print(f"| {what} | {spent} | {root[0]} | {100 * np.median(deviation):.1f} % | {root[1]} |")
    if options.sheet:
        sheet(options.sheet, found, still)


if __name__ == "__main__":
    main()
