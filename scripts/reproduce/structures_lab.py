"""Runs the example `laboratory` of slo-accel, which counts what structures cost, and remembers."""

import hashlib
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/models"))
import spd  # noqa: E402

KINDS = ("primary", "shadow", "secondary")


def add_options(parser):
    parser.add_argument(
        "--program", default=str(ROOT / "target/release/examples/laboratory"), help="the example `laboratory`"
    )
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--keep", metavar="FOLDER", help="folder in which what is counted is stored")
    parser.add_argument("--plots", metavar="FOLDER", help="folder to which plots are written")


class Lab:
    """Counts, and remembers."""

    def __init__(self, options):
        self.options = options
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = Path(options.keep or self.temporary.name)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.began = time.monotonic()
        self.every = 4 if options.quick else 1

    def scene(self, name, size=None):
        path = self.folder / f"{name}{'' if size is None else f'_{size}'}.nff"
        if not path.exists():
            path.write_text(spd.text(name, size), encoding="ascii")
        return path

    def count(self, path, structure, **options):
        """Returns what the example prints for one structure."""
        arguments = [path, structure, "--threads", str(self.options.threads)]
        for key, value in {"every": self.every, **options}.items():
            arguments += [f"--{key.replace('_', '-')}"] + ([] if value is True else [str(value)])
        key = hashlib.sha256("\0".join(map(str, [path.name, *arguments[1:]])).encode()).hexdigest()[:16]
        stored = self.folder / f"{key}.json"
        if not stored.exists():
            program = Path(self.options.program).resolve()
            done = subprocess.run([program, *arguments], capture_output=True, text=True)
            if done.returncode:
                sys.exit(f"{' '.join(map(str, arguments))}: {done.stderr}")
            stored.write_text(done.stdout, encoding="utf-8")
            print(f"{time.monotonic() - self.began:6.0f} s: {path.stem} {structure}", file=sys.stderr, flush=True)
        found = json.loads(stored.read_text(encoding="utf-8"))
        return {"objects": found["objects"], **found["structures"][0]}


def rays_of(counted):
    return sum(counted[kind]["rays"] for kind in KINDS)


def mean(counted, counter, kinds=KINDS):
    """Mean of a counter per ray."""
    rays = sum(counted[kind]["rays"] for kind in kinds)
    return sum(counted[kind][counter] for kind in kinds) / rays if rays else 0.0
