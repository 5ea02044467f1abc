#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy", "matplotlib>=3.6"]
# ///
"""Repeats the experiments of slo-rt's thesis (Radek Slovak, *Distributed ray tracing in reasonable time*, Brno
University of Technology, 2011).

    uv run scripts/reproduce/distributed.py [--quick] [--program slo-rt] [--keep FOLDER] [--plots FOLDER]
        [--only operations instructions structures convergence adaptive table table-few rose rose-many ...]

Prints the thesis's tables 6.1 to 6.4 beside the same of slo-rt, the noise of its figures 6.1 to 6.6, and what its
large pictures take (figures 6.8 to 6.11), then which of its findings are confirmed. docs/reproduction.md discusses
them. Times are processor seconds (user) of whole runs, all threads together.

    operations    table 6.1: scalars against SSE; needs rustc, on x86-64
    instructions  table 6.2: instruction sets
    structures    table 6.3: with and without a structure, still and moving
    convergence   figures 6.1 to 6.6: noise by samples, PSEUDO against QUASI
    adaptive      table 6.4: contrast limits
    table, rose   figures 6.8 and 6.10: the chess table at 1680x1050 and the rose at 1024x576, at the noise of the thesis's
                  settings
    table-few, rose-many
                  figures 6.9 and 6.11: the same with fewer and with more samples. The thesis gives their times only;
                  they are taken to be in proportion to the samples

The last four render six small parts of the picture with the thesis's settings and with many samples. The difference is
the noise that has to be met; then they find what meets it, a number of samples or `--noise`, and render the whole picture.
--quick does so at half the width. --keep stores what is measured, so that a run that was stopped goes on. Needs numpy
and matplotlib, on Linux or macOS.
"""

import argparse
import functools
import math
import re
import shutil
import subprocess
import sys
from pathlib import Path

try:
    from matplotlib.figure import Figure
    from matplotlib.ticker import StrMethodFormatter
except ModuleNotFoundError as error:
    sys.exit(f"distributed.py: {error}; start it by `uv run`, or `pip install numpy matplotlib`")

from distributed_lab import ROOT, Lab, mse, mse_srgb
from report import short, table, verdict

# The thesis's numbers; its machine is a Core 2 Duo T8100 with 2.1 GHz and two cores.
OPERATIONS = {
    "normalise_fpu": ("normalise, FPU", 4.696),
    "normalise_sse": ("normalise, SSE", 3.096),
    "normalise_rcp": ("normalise, SSE with an estimated root", 2.750),
    "normalise_newton": ("the same, and a step of Newton's", 3.333),
    "add_fpu": ("add, FPU", 4.297),
    "add_sse": ("add, SSE", 1.474),
}
INSTRUCTIONS = {"without": (45, 32), "with": (82, 64)}
STRUCTURES = {"before": 64, "none": 34, "kdtree": 7, "two levels": 11}
ADAPTIVE = {
    0.5: (5.73e-4, 65), 0.2: (5.73e-4, 92), 0.1: (3.39e-4, 124), 0.05: (2.95e-4, 140), 0.01: (2.54e-4, 182), 0: (0, 188)
}  # fmt: skip
EFFECTS = {
    "motion blur": "motion_blur",
    "depth of field": "depth_of_field",
    "soft shadows": "soft_shadows",
    "glossy reflection": "glossy_reflection",
}
FEW = "dofSamples 2 softShadowSamples 1 diffuseReflectionSamples"
PICTURES = {
    "table": (
        "figure 6.8, the chess table", (1680, 1050), 15, 6 * 3600 + 16 * 60,
        f"imageSamples 256 imageMinSamples 32 {FEW} 2 diffuseRefractionSamples 2",
    ),
    "table-few": (
        "figure 6.9, the chess table with fewer samples", (1680, 1050), 15, 28 * 60 + 29,
        f"imageSamples 16 imageMinSamples 2 {FEW} 2 diffuseRefractionSamples 2",
    ),
    "rose": (
        "figure 6.10, the rose", (1024, 576), 0, 5 * 60 + 25,
        f"imageSamples 64 imageMinSamples 8 {FEW} 1 diffuseRefractionSamples 1",
    ),
    "rose-many": (
        "figure 6.11, the rose with more samples", (1024, 576), 0, 20 * 60 + 10,
        f"imageSamples 256 imageMinSamples 32 {FEW} 1 diffuseRefractionSamples 1",
    ),
}  # fmt: skip
# What is tried to meet the noise of the thesis's settings.
SAMPLES = (4, 8, 16, 32, 64, 128, 256, 512)
NOISE = (0.1, 0.05, 0.035, 0.025, 0.0175, 0.012, 0.0085, 0.006, 0.004)
MOST_SAMPLES = 1024


def saved(before, after):
    return f"{100 * (1 - after / before):.0f} %"


# The experiments. Each prints its table and returns what it found.


def operations(lab):
    if not shutil.which("rustc"):
        print("\nTable 6.1 is left out: there is no rustc.")
        return None
    program = lab.folder / "operations"
    source = ROOT / "scripts/reproduce/operations.rs"
    plain = ["-O", "-C", "no-vectorize-loops", "-C", "no-vectorize-slp", "--edition", "2024"]
    if subprocess.run(["rustc", *plain, source, "-o", program]).returncode:
        print("\nTable 6.1 is left out: its program needs x86-64.")
        return None
    lines = subprocess.run([program], capture_output=True, text=True, check=True).stdout.splitlines()
    found = {name: float(seconds) for name, seconds in map(str.split, lines)}
    rows = []
    for name, (words, thesis) in OPERATIONS.items():
        first = "normalise_fpu" if "normalise" in name else "add_fpu"
        rows.append(
            [words, thesis, f"{found[name]:.3f}", saved(OPERATIONS[first][1], thesis), saved(found[first], found[name])]
        )
    table(
        "Table 6.1: 100 million operations on vectors, wall clock",
        ["operation", "thesis, s", "here, s", "thesis: saved", "here: saved"],
        rows,
    )
    return found


def instructions(lab):
    """SLO_RT_ISA names the instruction set. `portable` is SSE2, which every x86-64 processor has."""

    def point_light(text):
        start = text.index("light_rectangle lamp")
        return text[:start] + "light_point lamp { color { .95 .95 .90 } position { 0 0 7 } }" + text[text.index("\n", start) :]

    found, rows = {}, []
    for lamp, edit in (("without", point_light), ("with", lambda text: text)):
        times = {
            isa: min(
                lab.render(lab.test_scene(edit), "--seed", seed, isa=isa)[1]["seconds"] for seed in (0, 1, 2)
            )
            for isa in ("portable", "avx2", "avx512")
        }
        found[lamp] = times
        fpu, sse = INSTRUCTIONS[lamp]
        rows.append(
            [f"{lamp} an area light", fpu, sse, saved(fpu, sse)]
            + [f"{seconds:.2f}" for seconds in times.values()]
            + [saved(times["portable"], times["avx512"])]
        )
    table(
        "Table 6.2: the test scene at 320x240, by instruction set, shortest of three (slower sets stand in for faster "
        "ones that a processor lacks)",
        ["test scene", "thesis: FPU, s", "SSE, s", "saved", "slo-rt: portable, s", "avx2, s", "avx512, s", "saved"],
        rows,
    )
    return found


def structures(lab):
    """The torus of the test scene turns, or stands still."""

    def moving(text):
        frames = [
            f"addKframe {{ time {time} key {{ pivot {{ 1.7 {1.2 + time} 1.36 }} up {{ -.35 -1 .25 }} right {{ 1 -.35 0 }} }} }}"
            for time in (0, 1)
        ]
        start = text.index("addKframe")
        text = text[:start] + "\n    ".join(frames) + text[text.index("\n", start) :]
        return text.replace("lensRadiusStart .06", "lensRadiusStart .06 blurDuration .04")

    found = {}
    for accelerator in ("none", "kdtree", "bvh"):
        for motion, edit in (("still", lambda text: text), ("moving", moving)):
            text = lab.test_scene(edit)
            times = [
                lab.render(text, "--accelerator", accelerator, "--seed", seed)[1]["seconds"] for seed in (0, 1)
            ]
            found[accelerator, motion] = min(times)
    rows = [["before the thesis: one list of objects", STRUCTURES["before"], "", ""]]
    for accelerator, words, thesis in (
        ("none", "no structure", STRUCTURES["none"]),
        ("kdtree", "kd-tree", f"{STRUCTURES['kdtree']}; {STRUCTURES['two levels']} on two levels"),
        ("bvh", "hierarchy of boxes (the default)", ""),
    ):
        rows.append([words, thesis, f"{found[accelerator, 'still']:.2f}", f"{found[accelerator, 'moving']:.2f}"])
    table(
        "Table 6.3: the test scene, one of its objects animated",
        ["structure", "thesis, s", "slo-rt: still, s", "moving, s"],
        rows,
    )
    return found


def convergence(lab):
    counts = [4, 16, 64, 256] if lab.quick else [4, 8, 16, 32, 64, 128, 256]
    size = ["--size", "96x54" if lab.quick else "192x108"]
    found, rows = {}, []
    for effect, name in EFFECTS.items():
        text = lambda generator: lab.scene(name, f"generatorType {generator} softShadowSamples 1")  # noqa: B023, E731
        reference = lab.render(text("QUASI"), *size, "--samples", 1024 if lab.quick else 2048, "--seed", 9)[0]
        for generator in ("PSEUDO", "ZERO_TWO", "QUASI"):
            found[effect, generator] = {
                n: mse(lab.render(text(generator), *size, "--samples", n)[0], reference) for n in counts
            }
            measured = found[effect, generator]
            pseudo = found[effect, "PSEUDO"]
            gains = [pseudo[n] / measured[n] for n in counts]
            rows.append(
                [effect, generator]
                + [f"{measured[n]:.1e}" for n in counts]
                + [f"{min(gains):.1f} to {max(gains):.1f}" if generator != "PSEUDO" else "1"]
            )
    table(
        "Figures 6.1 to 6.6: mean square error by samples per pixel (light as it is, 1 is white), and how many times as "
        "many samples PSEUDO needs",
        ["effect", "generator", *map(str, counts), "PSEUDO needs"],
        rows,
    )
    return found


def adaptive(lab):
    settings = (
        "generatorType ZERO_TWO lightSamplingType SAMPLE_ALL_AT_TIME imageSamples 16 imageMinSamples 4 dofSamples 6 "
        "softShadowSamples 3 diffuseReflectionSamples 3 diffuseRefractionSamples 3 imageContrastLimit"
    )
    size = ["--size", "160x120"] if lab.quick else []
    found = {limit: lab.render(lab.scene("thesis2011", f"{settings} {limit}"), *size) for limit in ADAPTIVE}
    whole, longest = found[0]
    rows = []
    for limit, (error, seconds) in ADAPTIVE.items():
        picture, run = found[limit]
        found[limit] = (mse(picture, whole), run["seconds"])
        rows.append(
            [
                f"{limit:g}",
                f"{error:.2e}" if error else "0",
                seconds,
                f"{seconds / ADAPTIVE[0][1]:.2f}",
                f"{found[limit][0]:.2e}" if found[limit][0] else "0",
                f"{run['seconds']:.2f}",
                f"{run['seconds'] / longest['seconds']:.2f}",
                f"{run['samples']:.1f}",
            ]
        )
    table(
        "Table 6.4: 4 to 16 samples by contrast; the error is that against 16 samples everywhere",
        ["limit", "thesis: MSE", "s", "of all", "slo-rt: MSE", "s", "of all", "samples"],
        rows,
    )
    return found


def at(target, curve):
    """What meets an error: a parameter and its time, between two of those measured, in logarithms. `curve` has
    (parameter, error, seconds)."""
    for (a, high, before), (b, low, after) in zip(curve, curve[1:]):
        if low <= target <= high:
            share = math.log(high / target) / math.log(high / low) if high > low else 0
            return a * (b / a) ** share, before * (after / before) ** share
    return curve[0][::2] if target > curve[0][1] else None


def options_of(option, value):
    return [option, value] + (["--samples", MOST_SAMPLES] if option == "--noise" else [])


def two_to_lamps(text):
    """The scene with two rays from each hit to each area light, and one refracted ray."""
    settings = re.sub(r"\b(?:softShadowSamples|diffuseRefractionSamples)\s+\S+", "", text)
    more = "softShadowSamples 2 diffuseRefractionSamples 1"
    return re.sub(r"(settings\s+\S+\s*\{)", rf"\1 {more}", settings, count=1)


def large_picture(lab, name):
    """The thesis does not give the contrast limit of its pictures, so several are tried."""
    title, size, frame, thesis, settings = PICTURES[name]
    scene = name.split("-")[0]
    if lab.quick:
        size = (size[0] // 2, size[1] // 2)
    own = lab.scene(scene)
    reference = lab.spread(own, size, frame, "--samples", 1024 if lab.quick else 2048, "--seed", 9)[0]
    # What six runs take beside their samples: loading, building.
    _, rest, _ = lab.spread(own, size, frame, "--samples", 1)
    rows, errors = [], {}

    def measure(words, *arguments):
        picture, seconds, samples = lab.spread(*arguments)
        error, seconds = mse_srgb(picture, reference), max(seconds - rest, 1e-3)
        rows.append([words, f"{samples:.0f}", f"{error:.1e}", f"{seconds:.0f}"])
        return error, seconds

    for limit in (0.5, 0.1, 0.03):
        text = lab.scene(scene, f"generatorType ZERO_TWO imageContrastLimit {limit} {settings}")
        errors[limit], _ = measure(f"the thesis's, contrast limit {limit}", text, size, frame)
    texts = {"as shipped": own, "two to lamps": lab.scene(scene, edit=two_to_lamps)}
    ways = [(words, option, values) for option, values in (("--samples", SAMPLES), ("--noise", NOISE)) for words in texts]
    curves = {}
    for words, option, values in ways:
        curve = curves[words, option] = []
        for value in values:
            arguments = options_of(option, value)
            error, seconds = measure(f"{words}, `{option} {value}`", texts[words], size, frame, *arguments)
            curve.append((value, error, seconds))
            if error < min(errors.values()):
                break
    scale = 4 if lab.quick else 1
    table(
        f"Of {title}, at {size[0]}x{size[1]}: six parts, and the processor time of the whole, estimated from them",
        ["settings", "samples per pixel", "MSE (sRGB, 1 is white)", "whole picture, s"],
        rows,
    )
    rows, best = [], None
    for limit, error in errors.items():
        met = {way: at(error, curve) for way, curve in curves.items()}
        row = [limit, f"{error:.1e}"]
        for (_, option), found in met.items():
            if found is None:
                row.append("not met")
                continue
            parameter = f"{math.ceil(found[0])}" if option == "--samples" else f"{found[0]:.3f}"
            row.append(f"{parameter}: {scale * found[1]:.0f}")
        rows.append(row)
        if best is None:
            best = min(((found[1], way, found[0]) for way, found in met.items() if found), default=None)
    table(
        f"What meets the noise of {title}, and the estimated processor time of the whole picture in seconds",
        ["contrast limit", "MSE"] + [f"{words}, `{option}`" for words, option in curves],
        rows,
    )
    if best is None:
        return None
    _, (words, option), parameter = best
    arguments = options_of(option, math.ceil(parameter) if option == "--samples" else f"{parameter:.4f}")
    _, run = lab.render(texts[words], "--size", f"{size[0]}x{size[1]}", "-f", frame, *arguments)
    table(
        f"{title[0].upper()}{title[1:]}, rendered whole with the noise of limit 0.5"
        + (", at half the width, times four" if lab.quick else ""),
        ["settings", "samples per pixel", "processor time, s", "on two free cores, minutes", "thesis, minutes", "factor"],
        [
            [f"{words}, `{' '.join(map(str, arguments))}`", f"{run['samples']:.0f}", f"{run['seconds'] * scale:.0f}"]
            + [f"{run['seconds'] * scale / 120:.1f}", f"{thesis / 60:.1f}", f"{2 * thesis / run['seconds'] / scale:.0f}"]
        ],
    )
    return {"seconds": run["seconds"] * scale, "thesis": thesis, "title": title}


EXPERIMENTS = {
    "operations": operations,
    "instructions": instructions,
    "structures": structures,
    "convergence": convergence,
    "adaptive": adaptive,
    **{name: functools.partial(large_picture, name=name) for name in PICTURES},
}


# What the thesis finds, and what is found.


def findings(results):
    print("\n**Findings of the thesis**\n")
    if f := results.get("operations"):
        verdict(
            f["add_sse"] < f["add_fpu"] and f["normalise_sse"] < f["normalise_fpu"],
            f"SSE is faster than scalars: {f['normalise_fpu'] / f['normalise_sse']:.1f} and "
            f"{f['add_fpu'] / f['add_sse']:.1f} times (thesis: 1.5 and 2.9)",
        )
        verdict(
            f["normalise_rcp"] < f["normalise_sse"] <= 1.1 * f["normalise_newton"],
            "an estimated root is faster than an exact one, but not with a step of Newton's",
        )
    if f := results.get("instructions"):
        best = {lamp: 1 - times["avx512"] / times["portable"] for lamp, times in f.items()}
        verdict(
            min(best.values()) > 0.1,
            "wider vectors save a share of the whole: "
            + ", ".join(f"{100 * share:.0f} % {lamp} an area light" for lamp, share in best.items())
            + " (thesis: 28 % without, 22 % with)",
        )
    if f := results.get("structures"):
        verdict(
            f["kdtree", "still"] < f["none", "still"],
            f"a kd-tree pays for a hundred triangles: {saved(f['none', 'still'], f['kdtree', 'still'])} of the time saved "
            f"(thesis: {saved(34, 7)})",
        )
        verdict(
            f["kdtree", "moving"] > f["kdtree", "still"],
            f"two levels take longer than one: {f['kdtree', 'moving'] / f['kdtree', 'still']:.2f} times (thesis: 1.57)",
        )
    if f := results.get("convergence"):
        gains = [f[e, "PSEUDO"][n] / f[e, "ZERO_TWO"][n] for e in EFFECTS for n in f[e, "PSEUDO"]]
        verdict(
            sorted(gains)[len(gains) // 2] > 1.5,
            f"quasi-random points converge about twice as fast: median {sorted(gains)[len(gains) // 2]:.1f} times fewer "
            f"samples (ZERO_TWO, the thesis's points), {min(gains):.1f} to {max(gains):.1f}",
        )
        fours = {e: f[e, "PSEUDO"][16] / f[e, "ZERO_TWO"][4] for e in EFFECTS}
        verdict(
            min(fours.values()) > 0.7,
            "4 quasi-random samples are almost as good as 16 pseudo-random ones: they have "
            + ", ".join(f"{1 / share:.1f} ({e})" for e, share in fours.items())
            + " times the error",
        )
    if f := results.get("adaptive"):
        errors = [f[limit][0] for limit in ADAPTIVE]
        verdict(
            all(a >= b for a, b in zip(errors, errors[1:])) and f[0.5][1] < 0.7 * f[0][1],
            f"a limit trades error for time: {f[0.5][1] / f[0][1]:.2f} of the time with 0.5 (thesis: 0.35)",
        )
    for name in PICTURES:
        if f := results.get(name):
            verdict(
                f["seconds"] < 240 if name == "table" else f["seconds"] < 2 * f["thesis"],
                f"{f['title']} takes {f['seconds']:.0f} s of processor time, {f['seconds'] / 120:.1f} minutes on two free "
                f"cores, instead of {f['thesis'] / 60:.1f} minutes: a factor of {2 * f['thesis'] / f['seconds']:.0f}"
                + (" (our own aim: two minutes)" if name == "table" else ""),
            )


# Plots.


def draw(results, folder):
    folder.mkdir(parents=True, exist_ok=True)
    if f := results.get("convergence"):
        figure = Figure(figsize=(3.1 * len(EFFECTS), 2.9), layout="constrained")
        axes = figure.subplots(1, len(EFFECTS), squeeze=False, sharey=True)[0]
        for axis, effect in zip(axes, EFFECTS):
            for generator, color in (("PSEUDO", "#8a8a8a"), ("ZERO_TWO", "#0072b2"), ("QUASI", "#d55e00")):
                measured = f[effect, generator]
                axis.plot(list(measured), list(measured.values()), color=color, marker="o", label=generator)
            axis.set(xscale="log", yscale="log", xlabel="samples per pixel")
            axis.set_title(effect, fontsize=10)
            axis.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_xticks([4, 16, 64, 256], labels=["4", "16", "64", "256"])
            axis.minorticks_off()
            axis.grid(alpha=0.3)
        axes[0].set_ylabel("mean square error")
        axes[0].legend(frameon=False, fontsize=9)
        figure.savefig(folder / "distributed_convergence.png", dpi=110)
    if f := results.get("adaptive"):
        figure = Figure(figsize=(4.2, 2.9), layout="constrained")
        axis = figure.subplots()
        ours = [(f[limit][1] / f[0][1], f[limit][0]) for limit in ADAPTIVE if limit]
        thesis = [(ADAPTIVE[limit][1] / ADAPTIVE[0][1], ADAPTIVE[limit][0]) for limit in ADAPTIVE if limit]
        axis.plot(*zip(*thesis), color="#8a8a8a", marker="s", linestyle="--", label="thesis")
        axis.plot(*zip(*ours), color="#0072b2", marker="o", label="slo-rt")
        axis.set(xlabel="time, of that with all samples", ylabel="mean square error", yscale="log")
        axis.legend(frameon=False, fontsize=9)
        figure.savefig(folder / "distributed_adaptive.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(
        description="Repeats the experiments of slo-rt's thesis.", formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="small pictures, few samples: minutes")
    parser.add_argument("--only", nargs="+", default=list(EXPERIMENTS), choices=list(EXPERIMENTS))
    parser.add_argument("--program", default=str(ROOT / "target/release/slo-rt"), help="slo-rt")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--keep", metavar="FOLDER", help="folder in which what is measured is stored")
    parser.add_argument("--plots", metavar="FOLDER", help="folder to which plots are written")
    options = parser.parse_args()
    options.program = str(Path(options.program).resolve())
    lab = Lab(options)
    results = {name: EXPERIMENTS[name](lab) for name in EXPERIMENTS if name in options.only}
    findings(results)
    if options.plots:
        draw(results, Path(options.plots))


if __name__ == "__main__":
    main()
