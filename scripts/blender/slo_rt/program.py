# SPDX-License-Identifier: GPL-3.0-or-later
"""The program slo-rt: its path, its features, and its command line. Independent of Blender."""

import functools
import os
import re
import shutil
import subprocess
from dataclasses import dataclass

NAME = "slo-rt"
ANSWER_SECONDS = 5.0
WHAT_TO_DO = (
    "Install it (cargo install --path . in its sources), or name its path in "
    "Edit > Preferences > Add-ons > slo-rt."
)


class ProgramMissing(Exception):
    """slo-rt cannot be found or does not run; the message explains what to do."""


@dataclass(frozen=True)
class Program:
    """A working program: its path, its version, and the long options in its help."""

    path: str
    version: str
    options: frozenset

    def can(self, option):
        """Whether its help lists a long option, such as `--region`."""
        return option in self.options

    def command(self, scene_path, frame, outdir, samples=None, region=None, keep_state=False):
        """Returns the command line that renders one frame of a scene.

        Paths in the scene stay in its folder, so `--allow-outside` is not needed. `region` is
        `WxH+X+Y`.
        """
        folder, name = os.path.split(scene_path)
        command = [self.path, "--scene", name, "--indir", folder, "--outdir", outdir]
        command += [f"--frame={frame}"]
        if samples is not None:
            command += ["--samples", str(samples)]
        if region:
            command += ["--region", region]
        if keep_state:
            command += ["--keep-state"]
        if self.can("--progress"):
            command += ["--progress", "json"]
        return command


def find(preferred):
    """Returns the program to use: `preferred` (a path) if it is not empty, `$SLO_RT`, or `slo-rt` on the
    PATH.

    # Errors
    `ProgramMissing`.
    """
    wanted = _as_meant(preferred) or _as_meant(os.environ.get("SLO_RT", ""))
    path = shutil.which(wanted or NAME)
    if path is None and wanted:
        raise ProgramMissing(f"There is no program {wanted}. {WHAT_TO_DO}")
    if path is None:
        raise ProgramMissing(f"{NAME} is not on the PATH. {WHAT_TO_DO}")
    path = os.path.abspath(path)
    found = _examined(path, os.stat(path).st_mtime_ns)
    if isinstance(found, ProgramMissing):
        raise found
    return found


def _as_meant(path):
    """Cleans a path as people paste it: with quotes around it, `~` for their home, or the folder that
    contains the program."""
    path = os.path.expanduser(path.strip().strip("\"'").strip())
    return os.path.join(path, NAME) if os.path.isdir(path) else path


@functools.lru_cache(maxsize=8)
def _examined(path, _modified):
    """Returns a `Program`, or the `ProgramMissing` that explains why there is none. Cached, because
    panels ask often."""
    try:
        return _examine(path)
    except ProgramMissing as error:
        return error


def _examine(path):
    version = _output(path, "--version").strip()
    if not version.startswith(NAME):
        raise ProgramMissing(
            f"{path} is not {NAME}: it calls itself {version[:60]!r}. {WHAT_TO_DO}"
        )
    options = frozenset(re.findall(r"--[a-z][a-z-]+", _output(path, "--help")))
    return Program(path, version, options)


def _output(path, option):
    try:
        done = subprocess.run(
            [path, option], capture_output=True, text=True, timeout=ANSWER_SECONDS, check=True
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise ProgramMissing(f"{path} does not run: {error}. {WHAT_TO_DO}") from error
    return done.stdout


def picture_name(prefix, frame, ending, region=None):
    """Returns the name of the picture of a frame: `prefix`, a minus sign if negative, and five digits."""
    sign = "-" if frame < 0 else ""
    part = f"_region={region}" if region else ""
    return f"{prefix}{sign}{abs(frame):05d}{part}.{ending}"
