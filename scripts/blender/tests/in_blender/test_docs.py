# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows docs/blender.md from start to end, as a newcomer would.

With `SLO_RT_PICTURES=FOLDER`, its pictures are rendered to that folder in the document's size;
otherwise they are small.
"""

import os
import re
import subprocess
import tempfile
import unittest

import bpy

from . import blend

DOCUMENT = os.path.join(blend.ROOT, "docs", "blender.md")


def lines_to_type(quick):
    """The Python blocks of the document, in order."""
    with open(DOCUMENT, encoding="utf-8") as file:
        blocks = re.findall(r"```python\n(.*?)```", file.read(), re.DOTALL)
    code = "\n".join(blocks)
    if quick:
        code = re.sub(r"samples = \d+", "samples = 2", code).replace("= 640, 360", "= 64, 36")
    return code


class DocumentTest(unittest.TestCase):
    def test_walk(self):
        pictures = os.environ.get("SLO_RT_PICTURES")
        folder = pictures or tempfile.mkdtemp(dir=blend.FOLDER)
        blend.program()
        blend.fresh_scene()
        bpy.ops.wm.read_factory_settings()
        before = os.getcwd()
        os.chdir(folder)
        try:
            exec(compile(lines_to_type(not pictures), DOCUMENT, "exec"), {})  # noqa: S102
            for name in ("cube", "scene", "blur"):
                self.assertGreater(os.path.getsize(f"blender_{name}.png"), 500)
            self.assertEqual(len(os.listdir("frames")), 3)
            self.assertTrue(os.path.exists("head.slo"))
            with open("head.txt", encoding="utf-8") as file:
                self.assertNotIn("wildly", file.read())
            done = subprocess.run(
                [blend.PROGRAM, "--scene", "head.txt", "--frame", "12"],
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertNotIn("warning", done.stderr)
        finally:
            os.chdir(before)
