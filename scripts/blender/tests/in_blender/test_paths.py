# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths of files, whatever artists type and however they name things."""

import os
import subprocess
import tempfile
import unittest

import bpy

from slo_rt import operators

from .. import scene_reader
from . import blend

ODD_NAMES = (
    "two words",
    'with "quotes"',
    "it's",
    "a/b",
    "a\\b",
    "a:b",
    "..",
    ".",
    "...dots...",
    "~",
    "$HOME",
    "%s",
    "-dash",
    "a#b",
    "#hash",
    "/* comment */",
    "{brace}",
    "mesh",
    "Camera",
    "con",
    "NUL.001",
    "1",
    "kůň",
    "馬",
    "🐴",
    "tab\tand\nline",
    "no\u00a0break",
    "mark\ufeff",
    "e\u0301",
    "é",
    "CUBE",
    "cube",
)


class TargetTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()
        blend.cube()
        self.folder = tempfile.mkdtemp(dir=blend.FOLDER)

    def export(self, path):
        return bpy.ops.slo_rt.export_scene(filepath=path, animation=False)

    def save(self):
        path = os.path.join(self.folder, "head.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        with open(path, "rb") as file:
            return path, file.read()

    def test_relative_paths_are_those_of_the_blend_file(self):
        with self.assertRaisesRegex(RuntimeError, "save that first"):
            self.export("//head.txt")
        self.save()
        self.export("//head.txt")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "head.txt")))
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.slo_rt.export_mesh(filepath="//mesh")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "mesh.slo")))

    def test_the_blend_file_is_never_written_over(self):
        path, before = self.save()
        self.export(path)
        bpy.ops.object.select_all(action="SELECT")
        bpy.ops.slo_rt.export_mesh(filepath=path)
        with open(path, "rb") as file:
            self.assertEqual(file.read(), before)
        for name in ("head.txt", "head.slo"):
            self.assertTrue(os.path.exists(os.path.join(self.folder, name)))

    def test_what_names_no_file(self):
        os.mkdir(os.path.join(self.folder, "folder.txt"))
        for name in ("", "folder.txt", ".txt"):
            with self.assertRaisesRegex(RuntimeError, "names no file"):
                self.export(os.path.join(self.folder, name))

    def test_home(self):
        path = operators.target_path("~/a", ".txt")
        self.assertEqual(path, os.path.join(os.path.expanduser("~"), "a.txt"))

    def test_folders_that_cannot_be_written_to(self):
        taken = os.path.join(self.folder, "file")
        with open(taken, "w", encoding="utf-8"):
            pass
        for path in (os.path.join(taken, "a.txt"), f"{taken}.txt"):
            with self.assertRaisesRegex(RuntimeError, "file"):
                self.export(path)

    def test_odd_names_of_files(self):
        for name in ("two words.txt", "it's {odd}.txt", "kůň.v2.txt"):
            path = os.path.join(self.folder, name)
            self.export(path)
            check = [blend.program(), "--check", "--scene", path]
            self.assertEqual(subprocess.run(check, check=False).returncode, 0, name)


class NameTest(unittest.TestCase):
    def test_odd_names_of_things(self):
        blend.fresh_scene()
        for number, name in enumerate(ODD_NAMES):
            thing = blend.cube(name, size=0.1 + 0.01 * number)  # equal meshes share a file
            blend.paint(thing, name)
        blend.lamp(ODD_NAMES[0])
        path = blend.export()
        done = subprocess.run(
            [blend.program(), "--check", "--scene", path],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(path, encoding="utf-8") as file:
            meshes = scene_reader.read(file.read()).all("mesh")
        self.assertEqual(len({mesh.name.casefold() for mesh in meshes}), len(ODD_NAMES))
        files = {mesh.values["filename"][0][0] for mesh in meshes}
        self.assertEqual(len({name.casefold() for name in files}), len(ODD_NAMES))
        for name in files:
            stem = os.path.splitext(os.path.basename(name))[0]
            self.assertTrue(os.path.exists(os.path.join(os.path.dirname(path), name)), name)
            self.assertNotIn(stem.split(".")[0].lower(), {"con", "nul", ""})
