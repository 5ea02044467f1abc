#!/usr/bin/env python3
"""Shows where a render spends its time, and how much of that is vector code.

    python3 scripts/vector_code.py target/release/slo-rt [--top 20] -- -s scenes/table.txt --threads 1 --samples 8

Runs the program under `perf record` and prints the hottest functions: their share of the time, which instructions the
samples fell on (512-bit, 256-bit, scalar or 128-bit, integer), and the lines of source that they came from. Loops over
columns should be 512-bit on a processor with AVX-512. A loop that is not has usually a branch, a call, a conversion
of a float to an integer, or writes to several objects that the compiler cannot tell apart.

Needs Linux, perf, and binutils; the program needs its debug information.
"""

import argparse
import bisect
import collections
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SCALAR = re.compile(r"v?\w+s[sd]\b|.*xmm")


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


class Program:
    """The functions of a program, and where it is loaded."""

    def __init__(self, path, recorded):
        self.path = path
        mapped = output("perf", "script", "-i", recorded, "--show-mmap-events")
        name = re.escape(Path(path).name)
        found = re.search(rf"\[0x([0-9a-f]+)\(0x[0-9a-f]+\) @ (?:0x)?([0-9a-f]+) [^\n]*r-xp [^\n]*{name}", mapped)
        if not found:
            sys.exit("vector_code.py: perf recorded nothing of the program")
        base, offset = (int(number, 16) for number in found.groups())
        code = next(line.split() for line in output("readelf", "-lW", path).splitlines() if "LOAD" in line and " E " in line)
        self.shift = offset - int(code[1], 16) + int(code[2], 16) - base
        self.functions = []
        for line in output("nm", "-SC", "--defined-only", path).splitlines():
            parts = line.split(" ", 3)
            if len(parts) == 4 and parts[2] in "tTwW":
                self.functions.append((int(parts[0], 16), int(parts[1], 16), parts[3]))
        self.functions.sort()
        self.starts = [start for start, _, _ in self.functions]

    def function_at(self, address):
        index = bisect.bisect(self.starts, address) - 1
        start, size, _ = self.functions[index]
        return index if index >= 0 and address < start + size else None

    def instructions(self, index):
        start, size, _ = self.functions[index]
        bounds = f"--start-address={start}", f"--stop-address={start + size}"
        lines = output("objdump", "-d", "-M", "intel", "--no-show-raw-insn", *bounds, self.path).splitlines()
        matches = (re.match(r"\s*([0-9a-f]+):\s+(.*)", line) for line in lines)
        return {int(match[1], 16): match[2] for match in matches if match}

    def sources(self, addresses):
        lines = output("addr2line", "-e", self.path, "-i", *map(hex, addresses)).splitlines()
        places = (re.sub(r".*/crates/|\s*\(.*", "", line) for line in lines if "/crates/" in line and "/isa/mod.rs" not in line)
        return list(dict.fromkeys(places))[:5]


def kind(instruction):
    if "zmm" in instruction:
        return "512 bits"
    if "ymm" in instruction:
        return "256 bits"
    return "scalar" if SCALAR.match(instruction) else "integer"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--top", type=int, default=20, help="functions to show")
    parser.add_argument("arguments", nargs="+", help="arguments of the program, behind --")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        recorded = f"{folder}/perf.data"
        record = ["perf", "record", "-q", "-F", "1999", "-e", "cpu-clock", "-o", recorded]
        try:
            code = subprocess.run([*record, options.program, *options.arguments]).returncode
        except FileNotFoundError:
            sys.exit("vector_code.py: perf is not installed")
        if code:
            sys.exit(code)
        program = Program(options.program, recorded)
        sampled = [int(word, 16) + program.shift for word in output("perf", "script", "-i", recorded, "-F", "ip").split()]
    by_function = collections.defaultdict(collections.Counter)
    for address in sampled:
        by_function[program.function_at(address)][address] += 1
    ranked = sorted(by_function.items(), key=lambda item: -sum(item[1].values()))
    for index, addresses in ranked[:options.top]:
        share = 100 * sum(addresses.values()) / len(sampled)
        if index is None:
            print(f"{share:5.1f} %  other libraries and the kernel")
            continue
        code = program.instructions(index)
        known, kinds = sorted(code), collections.Counter()
        for address, count in addresses.items():
            kinds[kind(code[known[bisect.bisect(known, address) - 1]])] += count
        hottest = [address for address, _ in addresses.most_common(4)]
        print(f"{share:5.1f} %  {program.functions[index][2][-70:]}")
        print(f"         {', '.join(f'{what} {count}' for what, count in kinds.most_common())}")
        print(f"         {' '.join(program.sources(hottest))}")


if __name__ == "__main__":
    main()
