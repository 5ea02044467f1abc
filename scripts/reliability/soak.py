#!/usr/bin/env python3
"""A sequence on four processes that share it, while everything goes wrong around them.

    scripts/reliability/soak.py [--frames N] [--size WxH] [--samples N] [--minutes M] [--seed N] [--clock LIBRARY]
        [--json FILE] [--folder DIR]

Four runs of `slo-rt --share` render the frames of one folder. At random they are killed (SIGKILL), stopped and continued,
asked to end (SIGTERM), and started again; the disk is filled and emptied (a tmpfs, if the script may mount one); the
clock of some runs is wrong by up to a day (with --clock, the path of libfaketime.so). Afterwards, one run without
disturbance completes what is left. Then all frames must be there, each with the bytes of a run by one process, no other
file may be left, and no process may have used more memory than one of the first minute, by a tenth.

If the frames are done before the minutes are over, the folder is emptied and they are rendered again. Needs Linux and
Python 3.11. $SLO_RT names the program [default: target/release/slo-rt].
"""

import argparse
import collections
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("SLO_RT", str(ROOT / "target/release/slo-rt"))
PROCESSES = 4
# Seconds after which a claim of a run that is gone is taken over.
SHARE = 6

SCENE = """
settings s { integrator PATH }
Camera c {
    fps 25
    Film f { width 96 height 72 prefix f_ output PNG_IMAGE }
    CamSegment only { videoStart 0 videoEnd 400 sceneStart 0 sceneEnd 400
        addPosition { 0 -5 1 } addPosition { 2 -4 2 } addTarget { 0 0 0 } fovStart .6 }
}
lamp_point lamp { power { 300 300 300 } position { 2 -3 4 } radius .2 }
material_principled matte { base_color { .6 .5 .4 } }
material_principled metal { base_color { .8 .8 .8 } metallic 1 roughness .2 }
sphere ball { center { 0 0 0 } radius .8 material metal }
plane floor { normal { 0 0 1 } position { 0 0 -.8 } material matte }
"""


class Disk:
    """Where the frames go: a small file system that can be full, or a folder."""

    def __init__(self, folder, megabytes):
        self.folder = folder
        folder.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", f"size={megabytes}m", "tmpfs", str(folder)]
        self.is_mounted = subprocess.run(mount, stderr=subprocess.DEVNULL).returncode == 0

    def fill(self):
        if not self.is_mounted:
            return False
        try:
            with open(self.folder / "ballast", "wb", buffering=0) as file:
                while file.write(b"x" * 65536):
                    pass
        except OSError:
            pass
        return True

    def empty(self):
        (self.folder / "ballast").unlink(missing_ok=True)

    def close(self):
        if self.is_mounted:
            subprocess.run(["umount", "-l", str(self.folder)], check=False)


class Runs:
    """The processes, and the most memory that each had."""

    def __init__(self, work, out, words, clock, chance):
        self.work, self.words, self.clock, self.chance = work, command(out, words), clock, chance
        self.log = open(work / "log", "ab")
        self.alive, self.stopped, self.memory = [], {}, []
        self.codes = collections.Counter()

    def start(self):
        words = [*self.words, "--threads", "1", f"--share={SHARE}s", "--checkpoint", "1s"]
        variables = {**os.environ, "NO_COLOR": "1"}
        if self.clock and self.chance.random() < 0.3:
            variables |= {"LD_PRELOAD": self.clock, "FAKETIME": f"{self.chance.randint(-86400, 86400):+d}s"}
            variables |= {"DONT_FAKE_MONOTONIC": "1"}
        run = subprocess.Popen(
            words, cwd=self.work, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=self.log
        )
        run.began, run.most = time.monotonic(), 0
        self.alive.append(run)

    def look(self):
        """Counts those that ended and notes memory. Returns whether one ended with all frames done."""
        is_done = False
        for run in list(self.alive):
            try:
                status = pathlib.Path(f"/proc/{run.pid}/status").read_text()
                line = next((line for line in status.splitlines() if line.startswith("VmHWM:")), None)
                if line:
                    run.most = max(run.most, int(line.split()[1]))
            except OSError:
                pass
            if run.poll() is not None:
                self.alive.remove(run)
                self.stopped.pop(run.pid, None)
                self.codes[run.returncode] += 1
                self.memory.append((run.began, run.most))
                is_done |= run.returncode == 0
        for pid, until in list(self.stopped.items()):
            if time.monotonic() > until:
                self.signal(pid, signal.SIGCONT)
                del self.stopped[pid]
        return is_done

    def signal(self, pid, number):
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass

    def disturb(self):
        """Does something to one of the processes. Returns its name."""
        if not self.alive:
            return "nothing"
        run = self.chance.choice(self.alive)
        what = self.chance.choices(["killed", "stopped", "asked to end"], [4, 3, 2])[0]
        if what == "killed":
            self.signal(run.pid, signal.SIGKILL)
        elif what == "asked to end":
            self.signal(run.pid, signal.SIGCONT)
            self.signal(run.pid, signal.SIGTERM)
        else:
            self.signal(run.pid, signal.SIGSTOP)
            self.stopped[run.pid] = time.monotonic() + self.chance.uniform(0.2, 3 * SHARE)
        return what

    def end(self):
        for run in self.alive:
            self.signal(run.pid, signal.SIGKILL)
            run.wait()
        self.look()
        self.stopped.clear()


def command(out, words):
    return [PROGRAM, "-q", "-s", "scene.txt", "-od", str(out), *words]


def once(work, out, words):
    return subprocess.run(command(out, words), cwd=work, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def content(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=2000)
    parser.add_argument("--size", default="96x72")
    parser.add_argument("--samples", type=int, default=24)
    parser.add_argument("--minutes", type=float, default=120)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--clock", help="path of libfaketime.so")
    parser.add_argument("--folder", help="where to work")
    parser.add_argument("--json", type=pathlib.Path, help="write the figures")
    args = parser.parse_args()

    work = pathlib.Path(tempfile.mkdtemp(prefix="slo-rt-soak-", dir=args.folder))
    (work / "scene.txt").write_text(SCENE.replace("400", str(args.frames / 25)))
    words = ["-f", f"0-{args.frames - 1}", "--size", args.size, "--samples", str(args.samples)]
    chance = random.Random(args.seed)
    expected_at = work / "expected"
    done = once(work, expected_at, words)
    if done.returncode != 0:
        sys.exit(done.stderr)
    expected = content(expected_at)
    size = sum(map(len, expected.values()))
    disk = Disk(work / "disk", max(16, int(size * 1.2 / 1e6) + 8))
    out = disk.folder / "out"
    runs = Runs(work, out, words, args.clock, chance)
    events, rounds, problems = collections.Counter(), 0, []
    began, full_until, next_event = time.monotonic(), None, 0
    try:
        while time.monotonic() - began < args.minutes * 60 and not problems:
            is_done = runs.look()
            now = time.monotonic()
            if full_until and now > full_until:
                disk.empty()
                full_until = None
            if is_done:
                # Others still look for frames; what they find is complete.
                runs.end()
                disk.empty()
                full_until = None
                rounds += 1
                problems += check(work, out, expected, words)
                shutil.rmtree(out)
                continue
            while len(runs.alive) < PROCESSES:
                runs.start()
            if now > next_event:
                if chance.random() < 0.1 and not full_until and disk.fill():
                    events["disk filled"] += 1
                    full_until = now + chance.uniform(0.5, 5)
                else:
                    events[runs.disturb()] += 1
                next_event = now + chance.expovariate(1 / 1.5)
            time.sleep(0.05)
        runs.end()
        disk.empty()
        if out.exists():
            problems += check(work, out, expected, words)
    finally:
        runs.end()
        disk.close()
    log = (work / "log").read_text(errors="replace")
    if "panicked" in log or "internal error" in log:
        problems.append("a run panicked")
    # 130: asked to end twice.
    bad = {code: count for code, count in runs.codes.items() if code not in (0, 1, 73, 74, 75, 130, -9, -15)}
    if bad:
        problems.append(f"exit codes that were not expected: {bad}")
    long = [(start, most) for start, most in runs.memory if most]
    first = max((most for start, most in long if start - began < 60), default=0)
    later = max((most for start, most in long if start - began >= 60), default=0)
    if later > 1.1 * first > 0:
        problems.append(f"memory grew from {first} to {later} KiB")
    figures = {
        "minutes": round((time.monotonic() - began) / 60, 1),
        "frames": args.frames,
        "rounds": rounds,
        "processes": sum(runs.codes.values()),
        "exit codes": {str(code): count for code, count in sorted(runs.codes.items())},
        "events": dict(events),
        "memory of the first minute, KiB": first,
        "memory later, KiB": later,
        "problems": problems,
    }
    print(json.dumps(figures, indent=2))
    if args.json:
        args.json.write_text(json.dumps(figures, indent=2) + "\n")
    if not problems:
        shutil.rmtree(work)
    else:
        print(f"see {work}", file=sys.stderr)
    return 1 if problems else 0


def check(work, out, expected, words):
    """Completes the frames without disturbance, and compares them. Returns what is wrong."""
    problems = []
    for name, bytes in content(out).items():
        if name in expected and bytes != expected[name]:
            problems.append(f"before the last run, `{name}` is wrong")
    # What killed runs left is removed when it is a minute old, when its frame is written.
    for path in out.glob(".slo-rt-*"):
        os.utime(path, (path.stat().st_atime, path.stat().st_mtime - 120))
    done = once(work, out, words)
    if done.returncode != 0:
        problems.append(f"the last run ends with {done.returncode}: {done.stderr[-300:]}")
    left = content(out)
    wrong = [name for name in expected if left.get(name) != expected[name]]
    more = sorted(set(left) - set(expected))
    if wrong:
        problems.append(f"wrong or missing: {wrong[:5]}, {len(wrong)} in all")
    if more:
        problems.append(f"left over: {more[:5]}, {len(more)} in all")
    return problems


if __name__ == "__main__":
    sys.exit(main())
