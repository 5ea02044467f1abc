#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy", "matplotlib>=3.6"]
# ///
"""Compares counts of acceleration structures with published ones.

    cargo build --release -p slo-accel --example laboratory
    uv run scripts/reproduce/structures.py [--quick] [--program laboratory] [--keep FOLDER] [--plots FOLDER]
        [--only rays grids octrees best all sizes anchors ...] [--mesh bunny=FILE.ply ...]

Makes the scenes of the Standard Procedural Databases by scripts/models/spd.py, traces their rays through each
structure by the example `laboratory` of slo-accel, and prints published counts beside ours with the deviations:

    rays     numbers of rays by kind, which no structure may change
    grids    uniform grids (Havran and Sixta, 1999)
    octrees  octrees, cut in the middle or by cost
    best     the best of what Havran and Sixta tried, beside the other structures
    all      all structures on all scenes: counts, memory, time to build and to trace, and a ranking
    sizes    Zlatuska's thesis (2009): primary, shadow and reflected rays by structure in pictures of four sizes
    orbit    the same thesis: a camera that goes around the scene, and lights that do
    anchors  hierarchies of boxes on meshes, with --mesh bunny=..., dragon=... or conference=... (PLY files)

Counts are exact and the same on every machine. --quick traces every fourth ray of a row, and every fourth row: structures
stay exact, means per ray differ by about a per cent, and numbers of rays are scaled. Times are those of the processor. --keep stores what is counted, so that a run that was stopped goes on.
"""

import argparse
import math
import sys
from pathlib import Path

try:
    from matplotlib.figure import Figure
    from matplotlib.ticker import NullFormatter
except ModuleNotFoundError as error:
    sys.exit(f"structures.py: {error}; start it by `uv run`, or `pip install numpy matplotlib`")

import ply_scenes
from report import table, verdict
from structures_lab import KINDS, Lab, add_options, mean, rays_of
from structures_published import (
    ANCHORS, BEST_GRIDS, COST_OCTREES, GRIDS, OCTREES, RAYS, ZLATUSKA, ZLATUSKA_FRAMES, ZLATUSKA_REFLECTED,
)  # fmt: skip

DEPTHS = (4, 5, 6, 7)
# The scene whose published structures do not fit the files that Haines' programs write today.
OTHER = "gears"
STRUCTURES = {
    "GRID": "grid, 3 cells per object",
    "OCTREE:depth=6": "octree, depth 6",
    "MEDIAN": "halved on the longest axis",
    "RTREE": "R-tree (STR), 4 children",
    "BINARY": "hierarchy by SAH",
    "KD": "kd-tree by SAH",
}
TRIO = {"GRID:shortest=4": "grid", "KD:traversal=short-stack,stack=4": "kd-tree", "BINARY": "hierarchy"}


def off(ours, theirs):
    """Deviation in per cent."""
    if theirs == 0:
        return "0" if ours == 0 else "new"
    return f"{100 * (ours / theirs - 1):+.1f} %"


def exact(ours, theirs):
    return f"{theirs:,} / {ours:,}" + ("" if ours == theirs else f" ({off(ours, theirs)})")


def near(ours, theirs):
    return f"{theirs:.2f} / {ours:.2f} ({off(ours, theirs)})"


# The tables. Each returns deviations by what they are of, as factors.


def rays(lab):
    rows, found = [], []
    for name, published in RAYS.items():
        counted = lab.count(lab.scene(name), "KD")
        primary, shadow, secondary = (counted[kind] for kind in KINDS)
        scale = 513 * 513 / primary["rays"]
        ours = [primary["hits"], shadow["rays"], shadow["hits"], secondary["rays"], secondary["hits"]]
        ours = [round(scale * count) for count in ours]
        found += [a / b for a, b in zip(ours, published) if b]
        rows.append([name, *(exact(a, b) for a, b in zip(ours, published))])
    table(
        "Rays, published / ours" + (" (of every fourth ray, times 15.8)" if lab.every > 1 else ""),
        ["scene", "primary hits", "shadow rays", "blocked", "secondary rays", "their hits"],
        rows,
    )
    return found


def grids(lab):
    rows, found = [], {"empty": [], "references": [], "tests": [], "steps": []}
    for (name, density), (cells, empty, references, tests, steps, empty_steps) in GRIDS.items():
        counted = lab.count(lab.scene(name), f"GRID:cells={cells}")
        means = [mean(counted, counter) for counter in ("tests", "steps", "empty_leaves")]
        if name != OTHER:
            found["empty"].append(counted["empty_leaves"] / empty if empty else 1.0)
            found["references"].append(counted["references"] / references)
            found["tests"].append(means[0] / tests)
            found["steps"].append(means[1] / steps)
        rows.append(
            [name, density, cells, exact(counted["empty_leaves"], empty), exact(counted["references"], references)]
            + [near(ours, theirs) for ours, theirs in zip(means, (tests, steps, empty_steps))]
        )
    table(
        "Uniform grids, published / ours",
        ["scene", "density", "cells", "empty", "references", "tests per ray", "steps", "empty steps"],
        rows,
    )
    return found


def octrees(lab):
    rows, found = [], {"interior": [], "empty": [], "references": [], "tests": [], "leaves": []}
    for name, by_depth in OCTREES.items():
        for depth, (interior, empty, references, tests, leaves) in zip(DEPTHS, by_depth):
            counted = lab.count(lab.scene(name), f"OCTREE:depth={depth}")
            # These published tests are divided by the rays that hit something, those of the grids by all rays.
            hits = sum(counted[kind]["hits"] for kind in KINDS)
            means = [mean(counted, "tests") * rays_of(counted) / hits, mean(counted, "leaves")]
            if name != OTHER:
                found["interior"].append(counted["interior"] / interior)
                found["empty"].append(counted["empty_leaves"] / empty if empty else 1.0)
                found["references"].append(counted["references"] / references)
                found["tests"].append(means[0] / tests)
                found["leaves"].append(means[1] / leaves)
            rows.append(
                [name, depth, exact(counted["interior"], interior), exact(counted["empty_leaves"], empty)]
                + [exact(counted["references"], references), near(means[0], tests), near(means[1], leaves)]
            )
    table(
        "Octrees, published / ours",
        ["scene", "depth", "interior", "empty leaves", "references", "tests per ray that hits", "leaves per ray"],
        rows,
    )
    # The published steps begin at the root for each leaf: in lattice, whose leaves all lie at depth 4, 5 for each.
    rows, found["by cost: interior"], found["by cost: tests"] = [], [], []
    for name, by_depth in COST_OCTREES.items():
        for depth, (interior, tests, steps) in zip(DEPTHS, by_depth):
            counted = lab.count(lab.scene(name), f"OCTREE:depth={depth},planes=cost")
            hits = sum(counted[kind]["hits"] for kind in KINDS)
            ours, leaves = mean(counted, "tests") * rays_of(counted) / hits, mean(counted, "leaves")
            if name != OTHER:
                found["by cost: interior"].append(counted["interior"] / interior)
                found["by cost: tests"].append(ours / tests)
            rows.append([name, depth, exact(counted["interior"], interior), near(ours, tests)])
            rows[-1] += [steps, f"{mean(counted, 'steps'):.2f}", f"{leaves:.2f}", f"{steps / leaves:.2f}"]
    table(
        "Octrees with planes by cost, published / ours",
        ["scene", "depth", "interior", "tests per ray that hits", "published: steps", "ours: steps", "leaves"]
        + ["published steps for each of our leaves"],
        rows,
    )
    return found


def best(lab):
    rows = []
    for name, published in BEST_GRIDS.items():
        ours = [lab.count(lab.scene(name), structure) for structure in ("KD", "BINARY", "MEDIAN", "RTREE")]
        rows.append(
            [name]
            + [f"{tests:.2f} / {steps:.2f}" for tests, steps in published]
            + [f"{mean(counted, 'tests'):.2f} / {mean(counted, 'steps'):.2f}" for counted in ours]
        )
    table(
        "Tests / steps per ray: the best grids of Havran and Sixta, and other structures here",
        ["scene", "uniform, tuned", "recursive", "HUG", "adaptive", "here: kd-tree", "SAH", "halved", "R-tree"],
        rows,
    )
    return rows


def all_structures(lab):
    rows, times, invariant = [], {}, True
    for name in RAYS:
        first = None
        for structure, words in STRUCTURES.items():
            counted = lab.count(lab.scene(name), structure)
            hits = [counted[kind][key] for kind in KINDS for key in ("rays", "hits")]
            first = first or hits
            invariant &= hits == first
            times[name, structure] = (counted["build_s"], counted["trace_s"])
            rows.append(
                [name, words, f"{counted['leaves']:,}", f"{counted['references'] / counted['objects']:.2f}"]
                + [f"{counted['bytes'] / 1024:,.0f}", f"{1e3 * counted['build_s']:.1f}"]
                + [f"{mean(counted, counter):.2f}" for counter in ("steps", "boxes", "tests")]
                + [f"{1e9 * counted['trace_s'] / rays_of(counted):.0f}"]
            )
    table(
        "All structures",
        ["scene", "structure", "leaves", "references per object", "KiB", "build, ms", "steps per ray", "boxes", "tests"]
        + ["ns per ray"],
        rows,
    )
    ranking = []
    for structure, words in STRUCTURES.items():
        ratios = [
            times[name, structure][1] / min(times[name, other][1] for other in STRUCTURES) for name in RAYS
        ]
        ranking.append([words, math.prod(ratios) ** (1 / len(ratios)), max(ratios)])
    ranking.sort(key=lambda row: row[1])
    table(
        "Time to trace, relative to the best structure of each scene",
        ["structure", "geometric mean", "worst"],
        [[words, f"{average:.2f}", f"{worst:.2f}"] for words, average, worst in ranking],
    )
    return {"invariant": invariant, "ranking": ranking, "times": times}


def sizes(lab):
    """Steps and tests of P, PS and PSR (up to two reflections), each of what the kind adds, as in the thesis."""
    scenes = {"teapot": lab.scene("teapot"), "mount": lab.scene("mount", 7)}
    scenes |= {name: ply_scenes.scene(path, lab.folder) for name, path in lab.options.meshes.items()}
    resolutions = (64, 128, 256, 512) if lab.options.quick else (256, 512, 768, 1024)
    rows, found = [], {}
    for name, path in scenes.items():
        for structure, words in TRIO.items():
            for size in resolutions:
                counted = lab.count(path, structure, size=size, depth=3, every=1)
                found[name, structure, size] = counted
            published = ZLATUSKA.get(name)
            place = list(TRIO).index(structure)
            rows.append(
                [name, words, f"{counted['objects']:,}", f"{1e3 * counted['build_s']:.0f}"]
                + [f"{counted['bytes'] / 2**20:.2f}"]
                + [
                    f"{mean(counted, 'steps', [kind]):.1f} / {mean(counted, 'tests', [kind]):.1f}"
                    if counted[kind]["rays"]
                    else ""
                    for kind in KINDS
                ]
                + [
                    f"{1e9 * found[name, structure, size]['trace_s'] / rays_of(found[name, structure, size]):.0f}"
                    for size in resolutions
                ]
                + (
                    [f"{published[1][place]}", f"{published[2][place]}"]
                    + [f"{a:.1f} / {b:.1f}" for a, b in (published[3][place], published[4][place])]
                    if published
                    else [""] * 4
                )
            )
    table(
        "Primary (P), shadow (PS) and reflected rays (PSR): steps / tests per ray, and ns per ray by size of the picture",
        ["scene", "structure", "objects", "build, ms", "MiB", "P", "PS", "PSR"]
        + [f"{size}x{size}" for size in resolutions]
        + ["thesis: build, ms", "MB with triangles", "P", "PS"],
        rows,
    )
    return {"resolutions": resolutions, "counted": found, "scenes": list(scenes)}


def orbit(lab):
    """As the thesis measures: primary rays while the camera goes around the scene, shadow rays while the light does,
    reflected rays (up to two) while the camera does; means over the whole way."""
    frames, size = (24, 129) if lab.options.quick else (400, 257)
    scenes = {"teapot": lab.scene("teapot"), "mount": lab.scene("mount", 7)}
    scenes |= {name: ply_scenes.scene(path, lab.folder) for name, path in lab.options.meshes.items()}
    rows, found = [], {}
    for name, path in scenes.items():
        for place, (structure, words) in enumerate(TRIO.items()):
            way = {"size": size, "every": 1, "orbit": frames}
            moving = lab.count(path, structure, depth=3, **way)
            lit = lab.count(path, structure, depth=1, orbit_lights=True, **way)
            published = ZLATUSKA.get(name, [None] * 5)
            theirs = [published[3], published[4], ZLATUSKA_REFLECTED.get(name)]
            row = [name, words]
            for counted, kind, thesis in zip((moving, lit, moving), KINDS, theirs):
                if not counted[kind]["rays"]:
                    row.append("")
                    continue
                ours = (mean(counted, "steps", [kind]), mean(counted, "tests", [kind]))
                found[name, structure, kind] = ours
                row.append(f"{ours[0]:.1f} / {ours[1]:.1f}")
                if thesis:
                    row[-1] += f" ({thesis[place][0]:.1f} / {thesis[place][1]:.1f})"
            costs = [1.2 * steps + tests for _, steps, tests in (frame["primary"] for frame in moving["path"])]
            found[name, structure] = max(costs) / min(costs)
            row.append(f"{found[name, structure]:.2f}")
            if name in ZLATUSKA_FRAMES:
                least, most, _ = ZLATUSKA_FRAMES[name][place]
                row[-1] += f" ({most / least:.2f})"
            rows.append(row)
    table(
        f"{frames} frames around each scene: steps / tests per ray that each kind adds, and the dearest frame of primary "
        "rays over the cheapest (1.2 steps + tests; in the thesis: time). In brackets: the thesis",
        ["scene", "structure", "P", "PS", "PSR", "dearest over cheapest"],
        rows,
    )
    return {"found": found, "scenes": list(scenes)}


def anchors(lab):
    rows, found = [], []
    for name, path in lab.options.meshes.items():
        if name not in ANCHORS:
            continue
        sah, primary, shadow = ANCHORS[name]
        counted = lab.count(ply_scenes.scene(path, lab.folder), "BINARY", size=257, depth=1, every=1, orbit=8)
        found.append(counted["sah"] / sah)
        ours = [(mean(counted, "steps", [kind]), mean(counted, "tests", [kind])) for kind in KINDS[:2]]
        rows.append(
            [name, f"{counted['objects']:,}", near(counted["sah"], sah)]
            + [f"{a:.2f} / {b:.2f}" for pair in zip((primary, shadow), ours) for a, b in pair]
        )
    if not rows:
        print("\nHierarchies on meshes are left out: --mesh names none of " + ", ".join(ANCHORS) + ".")
        return None
    table(
        "Hierarchies of boxes: SAH, published / ours; steps / tests per ray of other cameras and lights",
        ["mesh", "triangles", "SAH", "published: primary", "ours", "published: shadow", "ours"],
        rows,
    )
    return found


TABLES = {
    "rays": rays, "grids": grids, "octrees": octrees, "best": best, "all": all_structures, "sizes": sizes,
    "orbit": orbit, "anchors": anchors,
}  # fmt: skip


# What is confirmed.


def within(factors, share):
    return sum(abs(factor - 1) <= share for factor in factors)


def findings(results):
    print("\n**What is confirmed** (without gears, whose published structures are of other gears)\n")
    if f := results.get("rays"):
        verdict(
            within(f, 0.1) == len(f),
            f"numbers of rays and hits: {within(f, 0.01)} of {len(f)} within 1 %, {within(f, 0.05)} within 5 %, "
            f"{within(f, 0.1)} within 10 %",
        )
    for name in ("grids", "octrees"):
        if f := results.get(name):
            structure = [key for key in f if key.split(": ")[-1] not in ("tests", "steps", "leaves")]
            for key in structure:
                verdict(
                    within(f[key], 0.05) == len(f[key]) or key.startswith("by cost") and within(f[key], 0.1) > 0.9 * len(f[key]),
                    f"{name}, {key}: {within(f[key], 0)} of {len(f[key])} exact, {within(f[key], 0.01)} within 1 %, "
                    f"{within(f[key], 0.05)} within 5 %",
                )
            for key in f:
                if key not in structure:
                    verdict(
                        within(f[key], 0.1) >= (0.75 if key.startswith("by cost") else 0.9) * len(f[key]),
                        f"{name}, {key} per {'hit' if name == 'octrees' and key.endswith('tests') else 'ray'}: {within(f[key], 0.03)} of {len(f[key])} within 3 %, "
                        f"{within(f[key], 0.1)} within 10 %",
                    )
    if f := results.get("all"):
        verdict(f["invariant"], "all structures find the same rays and hits")
        grid = {name: f["times"][name, "GRID"][1] for name in RAYS}
        others = {name: min(f["times"][name, s][1] for s in STRUCTURES if s != "GRID") for name in RAYS}
        uneven = [grid[name] / others[name] for name in ("balls", "tree")]
        even = [grid[name] / others[name] for name in RAYS if name not in ("balls", "tree")]
        verdict(
            min(uneven) > max(even),
            f"grids lose most in uneven scenes: {uneven[0]:.1f} (balls) and {uneven[1]:.1f} (tree) times the time of the "
            f"best other structure, in the others {min(even):.1f} to {max(even):.1f} times",
        )
    if f := results.get("sizes"):
        least, most = f["resolutions"][0], f["resolutions"][-1]
        for name in f["scenes"]:
            for structure, words in TRIO.items():
                a, b = (f["counted"][name, structure, size] for size in (least, most))
                if abs(mean(a, "steps") / mean(b, "steps") - 1) > 0.05:
                    print(f"- {name}, {words}: steps per ray depend on the size of the picture")
        names = f["scenes"]
        builds = {s: [f["counted"][name, s, most]["build_s"] for name in names] for s in TRIO}
        grid, kd, hierarchy = builds.values()
        verdict(
            all(a < b for a, b in zip(grid, hierarchy)) and all(a < b for a, b in zip(hierarchy, kd)),
            "the grid is built fastest, the kd-tree slowest: "
            + ", ".join(f"{k / h:.1f} times the hierarchy ({name})" for name, h, k in zip(names, hierarchy, kd))
            + " (thesis: 5 to 11 times)",
        )
        memory = {s: [f["counted"][name, s, most]["bytes"] for name in names] for s in TRIO}
        verdict(
            all(h < min(g, k) for g, k, h in zip(*memory.values())), "the hierarchy takes the least memory"
        )
    if f := results.get("orbit"):
        bounces = [
            f["found"][name, "BINARY", "secondary"][0] / f["found"][name, "BINARY", "primary"][0]
            for name in f["scenes"]
            if (name, "BINARY", "secondary") in f["found"]
        ]
        verdict(
            min(bounces) > 1,
            "reflected rays take more steps than primary ones in a hierarchy everywhere: "
            + ", ".join(f"{share:.1f}" for share in bounces)
            + " times (thesis: 1.2 to 3.4, in five of six scenes 2 or more)",
        )
    if f := results.get("anchors"):
        verdict(within(f, 0.25) == len(f), f"SAH of hierarchies: {within(f, 0.25)} of {len(f)} within a quarter")


# Plots.


def draw(results, folder):
    folder.mkdir(parents=True, exist_ok=True)
    panels = [
        ("grids", "tests", "grid: tests per ray"), ("grids", "steps", "grid: steps per ray"),
        ("octrees", "tests", "octree: tests per hit"), ("octrees", "leaves", "octree: leaves entered"),
    ]  # fmt: skip
    panels = [panel for panel in panels if panel[0] in results]
    if panels:
        figure = Figure(figsize=(3.0 * len(panels), 3.0), layout="constrained")
        for axis, (name, key, title) in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels):
            published = (
                [row[3 if key == "tests" else 4] for (scene, _), row in GRIDS.items() if scene != OTHER]
                if name == "grids"
                else [row[3 if key == "tests" else 4] for scene, rows in OCTREES.items() if scene != OTHER for row in rows]
            )
            factors = results[name][key]
            ends = [0.8 * min(published), 1.25 * max(published)]
            axis.plot(ends, ends, color="#8a8a8a", linewidth=1)
            axis.scatter(published, [p * f for p, f in zip(published, factors)], s=14, color="#0072b2")
            axis.set(xscale="log", yscale="log", xlabel="published", title=title)
            if ends[1] < 20 * ends[0]:
                for side in (axis.xaxis, axis.yaxis):
                    side.set_ticks([5, 10, 20, 40], labels=["5", "10", "20", "40"])
                    side.set_minor_formatter(NullFormatter())
            axis.set(xlim=ends, ylim=ends)
        figure.savefig(folder / "structures_published.png", dpi=110)
    if f := results.get("sizes"):
        figure = Figure(figsize=(3.2 * len(f["scenes"]), 3.0), layout="constrained")
        for axis, name in zip(figure.subplots(1, len(f["scenes"]), squeeze=False)[0], f["scenes"]):
            for (structure, words), color in zip(TRIO.items(), ("#8a8a8a", "#0072b2", "#d55e00")):
                counted = [f["counted"][name, structure, size] for size in f["resolutions"]]
                axis.plot(
                    f["resolutions"],
                    [1e9 * c["trace_s"] / rays_of(c) for c in counted],
                    marker="o", color=color, label=words,
                )  # fmt: skip
            axis.set(xlabel="pixels of a side", ylabel="ns per ray", title=name)
            axis.set_ylim(bottom=0)
            axis.legend(frameon=False, fontsize=9)
        figure.savefig(folder / "structures_sizes.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(
        description="Compares counts of acceleration structures with published ones.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="a sixteenth of the rays")
    parser.add_argument("--only", nargs="+", default=list(TABLES), choices=list(TABLES))
    parser.add_argument("--mesh", nargs="+", default=[], metavar="NAME=FILE.ply", help="meshes for sizes, orbit and anchors")
    add_options(parser)
    options = parser.parse_args()
    options.meshes = dict(mesh.split("=", 1) for mesh in options.mesh)
    lab = Lab(options)
    results = {name: TABLES[name](lab) for name in TABLES if name in options.only}
    findings(results)
    if options.plots:
        draw(results, Path(options.plots))


if __name__ == "__main__":
    main()
