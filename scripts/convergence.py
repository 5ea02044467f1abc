#!/usr/bin/env python3
"""How fast the noise of each effect falls with the number of samples, by generator.

    python3 scripts/convergence.py [--program slo-rt] [--size 96x54] [--samples 4,16,64,256] [--reference 4096]

Renders shipped scenes of one effect each, compares them with a reference of another seed by the program's own
`compare`, and prints a Markdown table of relative mean square errors; the last columns are the exponent of the error
(root mean square) in the number of samples, -0.5 for independent ones, and how many samples PSEUDO takes for the error
that this generator has at the largest number. Needs Python 3.8 and nothing else.
"""

import argparse
import math
import re
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


def variant(scene, generator):
    """The text of a scene with this generator, a fixed number of samples, and EXR pictures."""
    text = (ROOT / "scenes" / f"{scene}.txt").read_text(encoding="utf-8")
    text = re.sub(r"\b(generatorType|imageMinSamples|imageContrastLimit|noise)\s+\S+", "", text)
    text = re.sub(r"(settings\s+\S+\s*\{)", rf"\1 generatorType {generator}", text, count=1)
    return re.sub(r"output\s+\S+", "output EXR_IMAGE", text, count=1)


def run(program, *arguments):
    command = [program, *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def render(options, scene, generator, samples, seed, outdir):
    """Path of the picture."""
    # Beside the scenes, so that their paths to meshes and textures hold.
    with tempfile.NamedTemporaryFile("w", dir=ROOT / "scenes", suffix=".txt", encoding="utf-8") as file:
        file.write(variant(scene, generator))
        file.flush()
        out = Path(outdir) / f"{scene}_{generator}_{samples}_{seed}"
        arguments = ["-q", "-s", file.name, "--allow-outside", "--size", options.size]
        arguments += ["--samples", samples, "--seed", seed, "--outdir", out]
        return run(options.program, *arguments).strip()


def error(options, picture, reference):
    """Relative mean square error."""
    for line in run(options.program, "compare", picture, reference).splitlines():
        name, value = line.split()
        if name == "relative-mse":
            return float(value)
    raise SystemExit("`compare` tells no relative-mse")


def slope(counts, errors):
    """Least squares exponent of the root of the errors."""
    xs = [math.log(n) for n in counts]
    ys = [0.5 * math.log(e) for e in errors]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sum((x - mx) ** 2 for x in xs)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", default=str(ROOT / "target/release/slo-rt"))
    parser.add_argument("--size", default="96x54")
    parser.add_argument("--samples", default="4,16,64,256")
    parser.add_argument("--reference", type=int, default=4096)
    parser.add_argument("--only", help="one effect, by a part of its name")
    options = parser.parse_args()
    counts = [int(n) for n in options.samples.split(",")]
    print("| effect | generator |", " | ".join(map(str, counts)), "| exponent | PSEUDO needs |")
    print("|---|---|" + "---|" * (len(counts) + 2))
    for effect, scene in EFFECTS.items():
        if options.only and options.only not in effect:
            continue
        with tempfile.TemporaryDirectory() as outdir:
            reference = render(options, scene, "QUASI", options.reference, 1, outdir)
            pseudo = None
            for generator in GENERATORS:
                pictures = [render(options, scene, generator, n, 0, outdir) for n in counts]
                errors = [error(options, picture, reference) for picture in pictures]
                pseudo = pseudo or errors
                times = pseudo[-1] / errors[-1]
                figures = " | ".join(f"{e:.2e}" for e in errors)
                print(f"| {effect} | {generator} | {figures} | {slope(counts, errors):.2f} | {times:.1f} x |", flush=True)


if __name__ == "__main__":
    main()
