#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy", "matplotlib>=3.6"]
# ///
"""Repeats tables 1 to 6 of a Czech master's thesis on hierarchies for ray tracing (RayTracer 2, about 2012).

    cargo build --release -p slo-accel --example laboratory
    uv run scripts/reproduce/hierarchies.py [--quick] [--program laboratory] [--keep FOLDER] [--plots FOLDER]

The thesis counts tests of objects and of bounding boxes. Its scenes are lost but for their numbers of objects, so
these are look-alikes: compare orders and ratios, not counts. Its "kd-tree" and "octree" are hierarchies of boxes:
each object is in one leaf, and boxes are fitted after the objects were divided. Its kd-tree is our MEDIAN; nothing
here is its octree, so that column is an octree of space, whose steps are no tests of boxes.

Pictures have the thesis's numbers of pixels, four rays each. Tests without a structure are counted for every eighth
ray and row, and scaled. --quick does so with all. docs/reproduction.md discusses the tables.
"""

import argparse
import sys

try:
    from matplotlib.figure import Figure
except ModuleNotFoundError as error:
    sys.exit(f"hierarchies.py: {error}; start it by `uv run`, or `pip install numpy matplotlib`")

from pathlib import Path

import hierarchies_scenes
from report import table, verdict
from structures_lab import KINDS, Lab, add_options, rays_of

# Rays of a side, depth, and the thesis's tests of objects and of boxes, in millions, and its number of rays.
SCENES = {
    "sphericCube": (554, 1, {"NAIVE": (3169.098, None), "MEDIAN": (0.699, 61.904)}, 0.938992),
    "box_a": (512, 1, {"NAIVE": (1.617739, None), "BOXES": (1.581501, 1.617739)}, 1.617739),
    "box_b": (512, 1, {"NAIVE": (2.174019, None), "BOXES": (2.174019, 2.174019)}, 2.174019),
    "cylAxes": (
        960, 2, {"NAIVE": (24225, None), "RTREE": (95, 1033), "OCTREE": (94, 466), "MEDIAN": (92, 608)}, 18.45
    ),
    "cylWalls": (
        554, 2, {"NAIVE": (67086, None), "RTREE": (21, 308), "OCTREE": (21, 144), "MEDIAN": (21, 145)}, 8.94
    ),
}  # fmt: skip
TITLES = {
    "sphericCube": "Table 1: 3375 spheres that form a cube",
    "box_a": "Table 2: one object in its box",
    "box_b": "Table 3: one object whose box fills the picture",
    "cylAxes": "Table 4: 1313 cylinders",
    "cylWalls": "Table 5: 7500 cylinders in walls",
}
WORDS = {
    "NAIVE": "naive",
    "BOXES": "lone boxes",
    "RTREE": "R-tree",
    "OCTREE": "octree",
    "MEDIAN": "kd-tree (halved)",
    "BINARY": "hierarchy by SAH (not in the thesis)",
}


# The thesis's hierarchies end in single objects, each with its box; its R-trees have four children.
PARAMETERS = {"MEDIAN": ":leaf=1", "BINARY": ":leaf=1", "OCTREE": ":leaf=1", "RTREE": ":capacity=4"}


def sums(counted):
    """Rays, tests of objects, tests of boxes and steps, of all kinds of rays."""
    return [rays_of(counted)] + [sum(counted[kind][key] for kind in KINDS) for key in ("tests", "boxes", "steps")]


def count(lab, name, structure, **options):
    """The sums for all rays of the picture."""
    size, depth, _, _ = SCENES[name]
    path = lab.folder / f"{name}.nff"
    if not path.exists():
        path.write_text(hierarchies_scenes.SCENES[name]().text(), encoding="ascii")
    every = 8 if lab.options.quick or structure == "NAIVE" and name not in ("box_a", "box_b") else 1
    counted = lab.count(path, structure + PARAMETERS.get(structure, ""), size=size, depth=depth, every=every, **options)
    traced = len(range(0, size, every)) ** 2
    return [value * size * size / traced for value in sums(counted)]


def millions(value):
    return f"{value / 1e6:,.3f}"


def counts(lab):
    found = {}
    for name, (_, _, thesis, rays_of_thesis) in SCENES.items():
        names = list(thesis) + ([] if name.startswith("box") else ["RTREE", "OCTREE", "BINARY"])
        rows = []
        for structure in dict.fromkeys(names):
            # Without a structure, the thesis's shadow rays have no early exit in these tables.
            options = {"nearest_shadows": True} if structure == "NAIVE" else {}
            found[name, structure] = rays, tests, boxes, steps = count(lab, name, structure, **options)
            their_tests, their_boxes = thesis.get(structure, (None, None))
            rows.append(
                [WORDS[structure]]
                + [
                    "" if value is None else f"{value:,.3f} ({value / rays_of_thesis:.2f})"
                    for value in (their_tests, their_boxes)
                ]
                + [f"{millions(value)} ({value / rays:.2f})" for value in (tests, boxes, steps)]
            )
        table(
            f"{TITLES[name]}: millions (and per ray); {rays_of_thesis:.2f} million rays in the thesis, "
            f"{found[name, 'NAIVE'][0] / 1e6:.2f} here",
            ["technique", "thesis: object tests", "box tests", "here: object tests", "box tests", "steps"],
            rows,
        )
    return found


def shadows(lab):
    thesis = {
        ("NAIVE", True): (3169.1, None), ("NAIVE", False): (2293.9, None),
        ("MEDIAN", True): (0.7, 61.904812), ("MEDIAN", False): (0.6, 61.904812),
    }  # fmt: skip
    found, rows = {}, []
    for (structure, nearest), (tests, boxes) in thesis.items():
        options = {"nearest_shadows": True} if nearest else {}
        found[structure, nearest] = count(lab, "sphericCube", structure, **options)
        ours = found[structure, nearest]
        rows.append(
            [f"{WORDS[structure]}, " + ("shadow rays find the nearest hit" if nearest else "any hit ends a shadow ray")]
            + [f"{tests:,.1f}", "" if boxes is None else f"{boxes:,.1f}", millions(ours[1]), millions(ours[2])]
        )
    table(
        "Table 6: the early exit of shadow rays among the spheres, millions",
        ["technique", "thesis: object tests", "box tests", "here: object tests", "box tests"],
        rows,
    )
    return found


def findings(found, shadow):
    print("\n**What is confirmed**\n")
    for name in ("sphericCube", "cylAxes", "cylWalls"):
        naive, tree = found[name, "NAIVE"], found[name, "MEDIAN"]
        verdict(
            naive[1] > 100 * tree[1],
            f"{name}: a hierarchy saves orders of magnitude: object tests fall {naive[1] / tree[1]:,.0f} times, all tests "
            f"{naive[1] / (tree[1] + tree[2]):,.0f} times",
        )
    verdict(
        found["box_b", "BOXES"][1] == found["box_b", "NAIVE"][1],
        "a lone box that fills the picture saves no test of its object",
    )
    for name in ("cylAxes", "cylWalls"):
        boxes = {structure: found[name, structure][2] for structure in ("RTREE", "MEDIAN")}
        verdict(
            boxes["RTREE"] > boxes["MEDIAN"],
            f"{name}: the R-tree tests more boxes than the kd-tree: {boxes['RTREE'] / boxes['MEDIAN']:.2f} times "
            f"(thesis: {1033 / 608 if name == 'cylAxes' else 308 / 145:.2f})",
        )
        tree, best = (sum(found[name, structure][1:3]) for structure in ("MEDIAN", "BINARY"))
        verdict(tree <= best, f"{name}: the kd-tree is best; SAH takes {best / tree:.2f} of its tests")
    for structure, share in (("NAIVE", 28), ("MEDIAN", 14)):
        before, after = shadow[structure, True], shadow[structure, False]
        saved = [100 * (1 - b / a) if a else 0.0 for a, b in zip(before[1:3], after[1:3])]
        verdict(
            saved[0] > 0,
            f"{WORDS[structure]}: the early exit of shadow rays saves {saved[0]:.0f} % of object tests (thesis: {share} %)"
            + (f" and {saved[1]:.0f} % of box tests (thesis: none)" if structure == "MEDIAN" else ""),
        )


def draw(found, folder):
    folder.mkdir(parents=True, exist_ok=True)
    names = ("sphericCube", "cylAxes", "cylWalls")
    figure = Figure(figsize=(9.0, 2.9), layout="constrained")
    for axis, name in zip(figure.subplots(1, 3), names):
        structures = [structure for structure in WORDS if (name, structure) in found and structure != "NAIVE"]
        for number, structure in enumerate(structures):
            rays, tests, boxes, _ = found[name, structure]
            axis.bar(number - 0.2, tests / rays, 0.4, color="#0072b2", label="object tests" if not number else None)
            axis.bar(number + 0.2, boxes / rays, 0.4, color="#d55e00", label="box tests" if not number else None)
        axis.set_xticks(range(len(structures)), labels=[s.lower() for s in structures], fontsize=8)
        axis.set(title=name, ylabel="per ray", ylim=(0, 1.3 * axis.get_ylim()[1]))
        axis.legend(frameon=False, fontsize=8)
    figure.savefig(folder / "hierarchies.png", dpi=110)


def main():
    parser = argparse.ArgumentParser(
        description="Repeats tables 1 to 6 of a thesis on hierarchies for ray tracing.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="a sixty-fourth of the rays")
    add_options(parser)
    options = parser.parse_args()
    lab = Lab(options)
    found = counts(lab)
    findings(found, shadows(lab))
    if options.plots:
        draw(found, Path(options.plots))


if __name__ == "__main__":
    main()
