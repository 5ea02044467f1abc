#!/usr/bin/env python3
"""Compares the ray tracing speed of slo-rt and Embree, running both programs in turn.

    cargo build --release --example trace_rays
    c++ -O3 -march=native scripts/embree/trace_rays.cpp -o trace_rays_embree -lembree3
    python3 scripts/embree/compare.py ./trace_rays_embree MESH.tri RAYS.rays [--rounds N]
        [--accelerator BVH ...] [--isa auto ...] [--copies FILE]

Prints for each set of rays the speed of each program by the processor's clock, the best of all rounds, and its ratio to the
speed of Embree's single rays and of Embree's best kernel.
"""

import argparse
import json
import pathlib
import subprocess

OURS = pathlib.Path(__file__).parents[2] / "target/release/examples/trace_rays"
NAMES = ["primary", "lens", "shadow", "bounce 1", "bounce 2"]


def run(command):
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    build, *rest = map(json.loads, lines)
    return build, [line for line in rest if "set" in line]


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("embree", help="scripts/embree/trace_rays.cpp, compiled")
    parser.add_argument("mesh")
    parser.add_argument("rays")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--accelerator", nargs="+", default=["BVH"])
    parser.add_argument("--isa", nargs="+", default=["auto"])
    parser.add_argument("--copies", help="where copies of the mesh are")
    options = parser.parse_args()
    files = [options.mesh, options.rays]
    copies = [options.copies] if options.copies else []
    commands = {f"embree {n}": [options.embree, *files, n, "2", *copies] for n in ["1", "8", "16"]}
    for accelerator in options.accelerator:
        for isa in options.isa:
            commands[f"{accelerator} {isa}"] = [str(OURS), *files, "--accelerator", accelerator,
                                                "--isa", isa, "--repeat", "2",
                                                *(["--copies", *copies] if copies else [])]
    speeds = {name: [] for name in commands}
    builds = {name: [] for name in commands}
    for _ in range(options.rounds):
        for name, command in commands.items():
            build, sets = run(command)
            builds[name].append(build["build_s"])
            speeds[name].append([s["cpu_mrays_per_s"] for s in sets])
            for number, s in enumerate(sets):
                if s.get("disagreement", 0) > 0:
                    print(f"{name}, {NAMES[number]}: {s['disagreement']:.1e} of the hits differ")
    best = {name: [max(column) for column in zip(*rows)] for name, rows in speeds.items()}
    single = best["embree 1"]
    strongest = [max(column) for column in zip(*(best[f"embree {n}"] for n in (1, 8, 16)))]
    print(f"{'':16}" + "".join(f"{name:>22}" for name in NAMES[:len(single)]) + f"{'build':>9}")
    for name, row in best.items():
        cells = "".join(f"{v:7.2f} x{v / s:5.2f} x{v / b:5.2f} "
                        for v, s, b in zip(row, single, strongest))
        print(f"{name:16}{cells}{min(builds[name]):9.3f}")


if __name__ == "__main__":
    main()
