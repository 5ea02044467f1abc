#!/usr/bin/env python3
"""Tests the Blender extension in Blender itself, as a Python module.

    scripts/blender/test.py                     Blender 5.0
    scripts/blender/test.py --all               Blender 4.5 and 5.0
    scripts/blender/test.py --all test_motion.py

Needs Python 3.11, the version of Blender's wheels, and the program: `$SLO_RT`, or
target/release/slo-rt. The wheels (370 MB each) are fetched from PyPI once and kept in
`$XDG_CACHE_HOME/slo-rt-ci`.

Exit code: 0 all tests pass, 1 some fail, 3 Blender is not available.
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

VERSIONS = {"5.0": "bpy==5.0.1", "4.5": "bpy==4.5.*"}
HERE = Path(__file__).resolve().parent
CANNOT_BE_HAD = 3


def main():
    """Runs the tests with each version; returns the exit code."""
    arguments = parse()
    versions = list(VERSIONS) if arguments.all else ["5.0"]
    failed = False
    for version in versions:
        python = environment(version, arguments.fetch_seconds)
        if python is None:
            print(f"test.py: Blender {version} can't be had here", file=sys.stderr)
            return CANNOT_BE_HAD
        print(f"Blender {version}", flush=True)
        runner = [str(python), str(HERE / "tests" / "run.py"), *arguments.files]
        failed |= subprocess.run(runner, check=False).returncode != 0
    return int(failed)


def parse():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--all", action="store_true", help="all versions, not only the newest")
    parser.add_argument(
        "--fetch-seconds", type=float, default=1800.0, help="how long fetching a wheel may take"
    )
    parser.add_argument("files", nargs="*", help="test files, such as test_motion.py")
    return parser.parse_args()


def environment(version, seconds):
    """Returns the Python of a virtual environment with Blender, created if necessary; None if that
    fails."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "slo-rt-ci"
    folder = cache / f"bpy-{version}"
    python = folder / "bin" / "python"
    complete = folder / "complete"
    if complete.exists():
        return python
    interpreter = shutil.which("python3.11")
    if interpreter is None:
        print("test.py: there is no python3.11", file=sys.stderr)
        return None
    shutil.rmtree(folder, ignore_errors=True)
    try:
        subprocess.run([interpreter, "-m", "venv", str(folder)], check=True, timeout=120)
        install = [
            str(python),
            "-m",
            "pip",
            "install",
            "--quiet",
            "--no-cache-dir",
            VERSIONS[version],
        ]
        subprocess.run(install, check=True, timeout=seconds)
        subprocess.run([str(python), "-c", "import bpy, os; os._exit(0)"], check=True, timeout=120)
    except (OSError, subprocess.SubprocessError) as error:
        print(f"test.py: {error}", file=sys.stderr)
        shutil.rmtree(folder, ignore_errors=True)
        return None
    complete.touch()
    return python


if __name__ == "__main__":
    sys.exit(main())
