#!/usr/bin/env python3
"""Measures how fast the noise of each effect falls with the number of samples, or how much adaptive sampling saves.

    python3 scripts/convergence.py [--program slo-rt] [--size 96x54] [--samples 4,16,64,256] [--reference 4096]
                                   [--columns 4,16,64,256] [--data FILE.csv]
    python3 scripts/convergence.py --noise 0.04,0.02,0.01 --size 320x180 --samples 4,8,16,32,64,128,256

Renders shipped scenes of one effect each, compares them with references of another seed by `slo-rt compare`, and
prints a Markdown table of relative mean square errors. The last three columns are

- the exponent of the error (root mean square) in the number of samples: -0.5 for independent samples,
- how many times as many samples PSEUDO needs for the same error, at the largest number of samples,
- FLIP, the perceived difference, at the second number of samples.

--columns selects the numbers of samples that get a column; the exponent is fitted to all. --data writes all
measurements to a file, which convergence_plot.py draws.

With --noise the table shows pictures rendered with `--noise E` on one thread: their samples per pixel; the uniform
samples per pixel that give the same error; the ratio of the two in samples and in processor time; and the mean of the
picture relative to the reference.

Needs only Python 3.10 on Linux or macOS.
"""

import argparse
import csv
import json
import math
import re
import resource
import statistics
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EFFECTS = {
    "soft shadows": "soft_shadows",
    "depth of field": "depth_of_field",
    "motion blur": "motion_blur",
    "glossy reflection": "glossy_reflection",
    "all at once": "default",
}
GENERATORS = ["PSEUDO", "ZERO_TWO", "QUASI"]
# Upper limit of the samples per pixel with --noise.
MOST = 4096


def variant(scene, generator):
    """Returns the text of a scene with this generator, a fixed number of samples, and EXR pictures."""
    text = (ROOT / "scenes" / f"{scene}.txt").read_text(encoding="utf-8")
    text = re.sub(r"\b(generatorType|imageMinSamples|imageContrastLimit|noise)\s+\S+", "", text)
    text = re.sub(r"(settings\s+\S+\s*\{)", rf"\1 generatorType {generator}", text, count=1)
    return re.sub(r"output\s+\S+", "output EXR_IMAGE", text, count=1)


def run(program, *arguments):
    command = [program, *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def render(options, scene, generator, samples, seed, outdir, *more):
    """Renders a scene and returns the path of the picture."""
    # In the folder of the scenes, so that their paths to meshes and textures stay valid.
    with tempfile.NamedTemporaryFile("w", dir=ROOT / "scenes", suffix=".txt", encoding="utf-8") as file:
        file.write(variant(scene, generator))
        file.flush()
        out = Path(outdir) / "_".join(map(str, [scene, generator, samples, seed, *more]))
        arguments = ["-q", "-s", file.name, "--allow-outside", "--size", options.size]
        arguments += ["--samples", samples, "--seed", seed, "--outdir", out, *more]
        return run(options.program, *arguments).strip()


def compare(options, picture, reference):
    """Returns the numbers that `compare` prints, by name."""
    lines = run(options.program, "compare", picture, reference).splitlines()
    return {name: float(value) for name, value in map(str.split, lines)}


def numbers(text):
    return [int(n) for n in text.split(",")]


def slope(counts, errors):
    """Returns the exponent of the root of the errors in the number of samples, by least squares."""
    return statistics.linear_regression([math.log(n) for n in counts], [0.5 * math.log(e) for e in errors]).slope


def at(error, errors, values):
    """Interpolates the value at an error between measured errors (falling), in logarithms; None outside their range."""
    for e0, e1, v0, v1 in zip(errors, errors[1:], values, values[1:]):
        if e1 <= error <= e0:
            return v0 * (v1 / v0) ** (math.log(e0 / error) / math.log(e0 / e1))
    return None


def timed(options, *arguments):
    """Renders a picture on one thread; returns it and the processor time in seconds."""
    spent = lambda: resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    before = spent()
    picture = render(options, *arguments, "--threads", 1)
    return picture, spent() - before


def generators(options, effect, scene, counts, reference, outdir):
    """Prints the rows of an effect; returns all measurements as rows for --data."""
    measured, pseudo = [], None
    for generator in GENERATORS:
        found = [compare(options, render(options, scene, generator, n, 0, outdir), reference) for n in counts]
        errors = [figures["relative-mse"] for figures in found]
        exponent = slope(counts, errors)
        shown = [counts.index(n) for n in options.columns]
        last = errors[shown[-1]]
        pseudo = pseudo or last
        figures = [*(f"{errors[i]:.2e}" for i in shown), f"{exponent:.2f}", f"{pseudo / last:.1f} x"]
        print(f"| {effect} | {generator} |", " | ".join(figures), f"| {found[shown[1]]['flip']:.4f} |", flush=True)
        measured += [[effect, generator, n, row["relative-mse"], row["flip"]] for n, row in zip(counts, found)]
    return measured


def adaptive(options, effect, scene, counts, reference, outdir):
    uniform = [timed(options, scene, "QUASI", n, 0, outdir) for n in counts]
    errors = [compare(options, picture, reference)["relative-mse"] for picture, _ in uniform]
    for noise in options.noise.split(","):
        picture, spent = timed(options, scene, "QUASI", MOST, 0, outdir, "--noise", noise)
        found = compare(options, picture, reference)
        taken = json.loads(run(options.program, "--recipe", picture))["result"]["samplesPerPixel"]
        error = found["relative-mse"]
        samples, time = (at(error, errors, values) for values in (counts, [spent for _, spent in uniform]))
        ratios = [f"{samples:.0f}", f"{taken / samples:.2f}", f"{spent / time:.2f}"] if samples else ["-"] * 3
        print(f"| {effect} | {noise} | {taken:.0f} | {error:.1e} |", " | ".join(ratios), f"| {found['mean-ratio']:.5f} |", flush=True)
    return []


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=str(ROOT / "target/release/slo-rt"))
    parser.add_argument("--size", default="96x54")
    parser.add_argument("--samples", type=numbers, default="4,16,64,256")
    parser.add_argument("--columns", type=numbers, metavar="N,...", help="numbers of samples that get a column (all)")
    parser.add_argument("--reference", type=int, default=4096)
    parser.add_argument("--data", metavar="FILE.csv", help="also write all measurements of the generators")
    parser.add_argument("--noise", metavar="E,...", help="errors to stop at, instead of the generators")
    parser.add_argument("--only", default="", help="measure one effect, given by a part of its name")
    options = parser.parse_args()
    counts = options.samples
    options.columns = options.columns or counts
    if not set(options.columns) <= set(counts):
        parser.error("--columns has a number that is missing in --samples")
    if options.data and options.noise:
        parser.error("--data writes the errors of the generators, which --noise does not measure")
    try:
        # Before anything is rendered, so that a wrong path does not cost the measurements.
        file = open(options.data, "w", newline="", encoding="utf-8") if options.data else None
    except OSError as error:
        parser.error(f"--data: {error}")
    if options.noise:
        head = ["effect", "`--noise`", "samples a pixel", "relative-mse", "uniform takes", "samples over uniform's"]
        head += ["time over uniform's", "mean over the reference's"]
    else:
        head = ["effect", "generator", *map(str, options.columns), "exponent", "PSEUDO needs"]
        head.append(f"FLIP at {options.columns[1]}")
    print("|", " | ".join(head), "|\n|" + "---|" * len(head))
    measured = [["effect", "generator", "samples", "relative-mse", "flip"]]
    for effect, scene in EFFECTS.items():
        if options.only in effect:
            with tempfile.TemporaryDirectory() as outdir:
                reference = render(options, scene, "QUASI", options.reference, 1, outdir)
                table = adaptive if options.noise else generators
                measured += table(options, effect, scene, counts, reference, outdir)
    if file:
        with file:
            csv.writer(file, lineterminator="\n").writerows(measured)


if __name__ == "__main__":
    main()
