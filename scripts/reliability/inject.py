#!/usr/bin/env python3
"""Lets every system call of small runs fail, or kills the program there, and looks at what is left.

    scripts/reliability/inject.py [--run NAME ...] [--fault NAME ...] [--sample K] [--json FILE] [--folder DIR]

Each run is made once for each call of each kind: the n-th call of every thread answers with an error, or the program is
killed there by SIGKILL. Then:

- a file under a final name has the bytes that it should have, or is not there;
- the exit code is 0 only if all is there;
- nothing panics, aborts, or takes longer than a minute. Memory that the system refuses is an exception: the loader of
  programs and Rust's library end the program then (counted as `aborted`);
- the same run without faults completes the rest, with the same bytes, and leaves no other file.

Needs Linux, strace, and Python 3.11. $SLO_RT names the program [default: target/release/slo-rt]. `--sample K` tries
every K-th call only.
"""

import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("SLO_RT", str(ROOT / "target/release/slo-rt"))

SCENE = """
settings s {{ imageSamples 4 {settings} }}
Camera c {{
    fps 25
    Film f {{ width 48 height 40 prefix f_ output {format} }}
    CamSegment only {{ videoStart 0 videoEnd 4 sceneStart 0 sceneEnd 4
        addPosition {{ 0 -5 1 }} addTarget {{ 0 0 0 }} fovStart .6 }}
}}
light_point lamp {{ color {{ 1 1 1 }} position {{ 2 -3 4 }} }}
phong_info grey {{ diffuse {{ .7 .6 .5 }} }}
material_phong matte {{ phong_info grey }}
mesh thing {{ filename thing.obj material matte }}
plane floor {{ normal {{ 0 0 1 }} position {{ 0 0 -1 }} material matte }}
"""

MESH = "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"

# What is run: the scene, commands before that are not disturbed, the command that is, and the files that it makes.
RUNS = {
    "sequence": (
        {"settings": "", "format": "PNG_IMAGE"}, [], "-s scene.txt -f 0-2 -od out --threads 2",
    ),
    "exr": (
        {"settings": "integrator PATH", "format": "EXR_IMAGE"}, [],
        "-s scene.txt -f 0-1 -od out --threads 2 --layers albedo,depth --cache kept --checkpoint 1s",
    ),
    "share": (
        {"settings": "", "format": "PNG_IMAGE"}, [], "-s scene.txt -f 0-2 -od out --threads 2 --share=3s",
    ),
    "part": (
        {"settings": "", "format": "PNG_IMAGE"}, [], "-s scene.txt -f 0 -od out --threads 2 --part 1/2",
    ),
    "merge": (
        {"settings": "", "format": "PNG_IMAGE"},
        ["-q -s scene.txt -f 0 --part 1/2", "-q -s scene.txt -f 0 --part 2/2"],
        "merge f_00000.pixels-1-of-2.part f_00000.pixels-2-of-2.part -od out",
    ),
}

# Errors that a call may answer with.
ERRORS = {
    "openat": ["EACCES", "EIO", "EMFILE", "ENOSPC", "EINTR"],
    "read": ["EIO", "EINTR"],
    "pread64": ["EIO", "EINTR"],
    "write": ["EIO", "ENOSPC", "EINTR"],
    "pwrite64": ["EIO", "ENOSPC", "EINTR"],
    "fsync": ["EIO", "ENOSPC"],
    "fdatasync": ["EIO"],
    "ftruncate": ["EIO"],
    "lseek": ["EIO"],
    "renameat": ["EIO", "ENOSPC"],
    "renameat2": ["EIO"],
    "rename": ["EIO"],
    "linkat": ["EIO", "EEXIST"],
    "unlink": ["EIO"],
    "mkdir": ["EIO", "ENOSPC"],
    "statx": ["EIO", "EACCES"],
    "fcntl": ["EIO", "ENOLCK"],
    "flock": ["EIO", "ENOLCK"],
    "getdents64": ["EIO"],
    "utimensat": ["EIO"],
    "statfs": ["EIO"],
    "clone3": ["EAGAIN"],
    "mmap": ["ENOMEM"],
    "getrandom": ["EINTR"],
}

# Calls by which memory is had.
MEMORY = {"mmap", "brk", "mprotect", "clone3"}


def environment():
    return {**os.environ, "NO_COLOR": "1", "RUST_BACKTRACE": "0"}


def run(folder, words, timeout=60):
    """Runs a command in a folder. Returns its exit code, minus the signal that ended it, and what it said."""
    done = subprocess.run(
        words, cwd=folder, env=environment(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        timeout=timeout, text=True, errors="replace",
    )
    return done.returncode, done.stdout


def prepare(folder, name):
    scene, before, command = RUNS[name]
    folder.mkdir(parents=True)
    (folder / "scene.txt").write_text(SCENE.format(**scene))
    (folder / "thing.obj").write_text(MESH)
    for words in before:
        code, said = run(folder, [PROGRAM, *words.split()])
        if code != 0:
            sys.exit(f"{name}: {words}: {said}")
    return [PROGRAM, *command.split()]


def content(folder):
    """The files of a folder below `out`, and their bytes."""
    out = folder / "out"
    return {path.name: path.read_bytes() for path in out.rglob("*") if path.is_file()} if out.exists() else {}


def calls_of(folder, words):
    """How many calls of each kind the busiest thread makes."""
    log = folder / "calls"
    run(folder, ["strace", "-ff", "-qq", "-o", str(log), *words])
    most = collections.Counter()
    for path in folder.glob("calls.*"):
        of_thread = collections.Counter()
        for line in path.read_text(errors="replace").splitlines():
            found = re.match(r"(\w+)\(", line)
            if found:
                of_thread[found[1]] += 1
        for name, count in of_thread.items():
            most[name] = max(most[name], count)
    return most


def try_one(base, name, expected, call, fault, number):
    """Disturbs one run. Returns what is wrong afterwards, if anything, and how it ended."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=base))
    shutil.rmtree(folder)
    try:
        words = prepare(folder, name)
        what = "signal=KILL" if fault == "SIGKILL" else f"error={fault}"
        trace = ["strace", "-f", "-qq", "-o", "/dev/null", "-e", f"trace={call}"]
        trace += ["-e", f"inject={call}:{what}:when={number}"]
        try:
            code, said = run(folder, [*trace, *words])
        except subprocess.TimeoutExpired:
            return "no end within a minute", "failed"
        problems = []
        left = content(folder)
        for file, bytes in expected.items():
            if file in left and left[file] != bytes:
                problems.append(f"`{file}` is wrong")
            if code == 0 and file not in left:
                problems.append(f"exit code 0, but `{file}` is missing")
        crashed = code in (134, 139, -signal.SIGABRT, -signal.SIGSEGV)
        if not (crashed and call in MEMORY) and (crashed or "panicked" in said or "internal error" in said):
            problems.append(f"panicked or ended by a fault: {code}")
        # What a killed run left is removed when it is a minute old.
        for path in folder.rglob(".slo-rt-*.part"):
            os.utime(path, (path.stat().st_atime, path.stat().st_mtime - 120))
        try:
            again, said_again = run(folder, words)
        except subprocess.TimeoutExpired:
            return "; ".join([*problems, "the second run has no end"]), "failed"
        if again != 0:
            problems.append(f"the second run ends with {again}: {said_again.strip()[-300:]}")
        after = content(folder)
        if after != expected:
            more = sorted(set(after) - set(expected))
            lost = [file for file in expected if after.get(file) != expected[file]]
            problems.append(f"after the second run: beside what was expected {more}, wrong or missing {lost}")
        if problems:
            problems.append(f"exit {code}: {said.strip()[-300:]}")
        kind = "killed" if fault == "SIGKILL" else "aborted" if crashed else "failed" if code else "went on"
        return "; ".join(problems), kind
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", nargs="+", choices=RUNS, default=list(RUNS))
    parser.add_argument("--fault", nargs="+", help="errors, such as ENOSPC, and SIGKILL [default: all]")
    parser.add_argument("--sample", type=int, default=1, help="try every K-th call only")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs at a time [default: all processors]")
    parser.add_argument("--folder", default=None, help="where to work: on the file system to be tested")
    parser.add_argument("--json", type=pathlib.Path, help="write the counts")
    args = parser.parse_args()
    if not shutil.which("strace"):
        print("SKIPPED: there is no strace", file=sys.stderr)
        return 3

    base = pathlib.Path(tempfile.mkdtemp(prefix="slo-rt-inject-", dir=args.folder))
    counts, wrong = collections.Counter(), []
    try:
        for name in args.run:
            words = prepare(base / f"{name}-expected", name)
            code, said = run(base / f"{name}-expected", words)
            if code != 0:
                sys.exit(f"{name}: {said}")
            expected = content(base / f"{name}-expected")
            prepare(base / f"{name}-calls", name)
            calls = calls_of(base / f"{name}-calls", words)
            tries = []
            for call, most in sorted(calls.items()):
                faults = [*ERRORS.get(call, []), "SIGKILL"]
                faults = [fault for fault in faults if not args.fault or fault in args.fault]
                tries += [(call, fault, n) for fault in faults for n in range(1, most + 1)]
            tries = tries[:: args.sample]
            with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
                one = lambda of: (of, try_one(base, name, expected, *of))
                for (call, fault, number), (problem, kind) in pool.map(one, tries):
                    counts[name, kind] += 1
                    if problem:
                        counts[name, "wrong"] += 1
                        wrong.append(f"{name}: {fault} at {call} number {number}: {problem}")
                        print(wrong[-1], flush=True)
            kinds = ["killed", "aborted", "failed", "went on", "wrong"]
            told = ", ".join(f"{counts[name, kind]} {kind}" for kind in kinds)
            print(f"{name}: {len(tries)} faults in {len(calls)} kinds of calls: {told}", flush=True)
    finally:
        shutil.rmtree(base, ignore_errors=True)
    if args.json:
        args.json.write_text(json.dumps({f"{run} {kind}": n for (run, kind), n in sorted(counts.items())}, indent=2) + "\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
