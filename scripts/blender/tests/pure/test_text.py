# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers, names, elements, meshes and images as files."""

import itertools
import math
import os
import tempfile
import unittest
import zlib

import numpy as np

from slo_rt.fit import bezier, rigid
from slo_rt.fit.motion import KeyFrame
from slo_rt.format import exr, key_frames, png, slo_mesh
from slo_rt.format.decimal_text import decimal_lines, integer_lines, number, vectors
from slo_rt.format.fingerprint import BLOCK, fingerprint
from slo_rt.format.names import Names, plain
from slo_rt.format.scene_text import Element, block, exact, write
from slo_rt.report import Report

from .. import scene_reader


class NumberTest(unittest.TestCase):
    def test_single_numbers(self):
        for value, text in (
            (1, "1"),
            (True, "1"),
            (0.1, "0.1"),
            (float(np.float32(0.7)), "0.7"),
            (-0.0, "0"),
            (1.0 / 3.0, "0.333333333"),
            (1e-9, "1e-09"),
            (123456.789, "123456.789"),
            (2.0, "2"),
        ):
            self.assertEqual(number(value), text)

    def test_times_lose_nothing(self):
        for value, text in ((-0.0, "0"), (2.0, "2"), (1.0 / 24.0, "0.041666666666666664")):
            self.assertEqual(exact(value), text)
        for fps in (24.0 / 1.001, 30.0 / 1.001, 60.0 / 1.001, 25.0, 1000.0 / 7.0):
            self.assertEqual(float(exact(fps)), fps)
            for frame in (1, 28, 551, 10**7):
                self.assertEqual(float(exact(frame / fps)), frame / fps)
        for value in (math.inf, math.nan):
            with self.assertRaises(ValueError):
                exact(value)

    def test_vectors_are_as_single_numbers(self):
        random = np.random.default_rng(5)
        rows = random.standard_normal((400, 3)) * 10.0 ** random.integers(-9, 6, (400, 1))
        rows[:20] = np.round(rows[:20])
        rows[20:40] = rows[20:40].astype(np.float32)
        rows[40] = (-0.0, 1e-300, 123456.0)
        rows[41] = bezier.tidy(np.array([[0.123456789, 3.0, -7.0]]))[0]
        for row, text in zip(rows, vectors(rows)):
            words = text.split()
            self.assertEqual((words[0], words[-1]), ("{", "}"))
            for value, word in zip(row, words[1:-1]):
                self.assertEqual(float(word), float(number(value)))
                self.assertLessEqual(len(word), len(number(value)) + 4)
                self.assertFalse(word.startswith("-0") and float(word) == 0.0)
        for value in (math.inf, math.nan):
            with self.assertRaises(ValueError):
                vectors([[0.0, value, 0.0]])

    def test_many_numbers_come_back(self):
        random = np.random.default_rng(1)
        for scale in (1e-12, 1e-3, 0.5, 1.0, 9.999999999, 10.0, 1234.5, 1e6, 1e12, 1e20, 0.0):
            values = (random.standard_normal((700, 3)) * scale).astype(np.float32)
            values[5] = 0.0
            values[6] = -scale
            text = b"".join(decimal_lines(values, 9)).decode()
            self.assertEqual(len(text.splitlines()), 700)
            back = np.array(text.split(), float).reshape(-1, 3)
            largest = np.abs(values).max()
            self.assertLessEqual(np.abs(back - values).max(), 1e-8 * largest)
            self.assertNotIn("-0 ", text)

    def test_numbers_are_short(self):
        values = np.array([[1.0, -0.5, 0.0], [10.25, 100.0, -0.125]])
        self.assertEqual(b"".join(decimal_lines(values, 9)), b"1 -0.5 0\n10.25 100 -0.125\n")

    def test_integers(self):
        values = np.array([[0, 1, 10], [4294967295, 7, 90]], np.int64)
        self.assertEqual(b"".join(integer_lines(values)), b"0 1 10\n4294967295 7 90\n")
        random = np.random.default_rng(2).integers(0, 10**7, (40000, 3))
        back = np.array(b"".join(integer_lines(random)).split(), int).reshape(-1, 3)
        np.testing.assert_array_equal(back, random)
        self.assertEqual(b"".join(integer_lines(np.zeros((0, 3), int))), b"")


class FingerprintTest(unittest.TestCase):
    def test_every_byte_counts(self):
        for size in (0, 1, 7, 8 * BLOCK - 1, 8 * BLOCK, 8 * BLOCK + 5, 24 * BLOCK + 1):
            data = np.random.default_rng(size).integers(0, 256, size, dtype=np.uint8)
            seen = {fingerprint(data)}
            self.assertEqual(fingerprint(data.copy()), next(iter(seen)))
            places = {0, 1, size // 2, size - 2, size - 1} & set(range(size))
            for at in places:
                for bit in (1, 128):
                    other = data.copy()
                    other[at] ^= bit
                    seen.add(fingerprint(other))
            self.assertEqual(len(seen), 1 + 2 * len(places))
        zeros = {fingerprint(np.zeros(size, np.float32)) for size in (0, 1, 2 * BLOCK, 4 * BLOCK)}
        self.assertEqual(len(zeros), 4)

    def test_order_counts(self):
        rows = np.random.default_rng(6).random((BLOCK, 4), np.float32)
        swapped = rows.copy()
        swapped[[0, 1]] = swapped[[1, 0]]
        self.assertNotEqual(fingerprint(rows), fingerprint(swapped))
        self.assertNotEqual(fingerprint(rows), fingerprint(rows[::-1]))


class NameTest(unittest.TestCase):
    def test_plain(self):
        for name, word in (
            ("Cube.001", "Cube.001"),
            ("a b\tc", "a_b_c"),
            ("x{y}", "x_y_"),
            ("a/b:c", "a_b_c"),
            ("##", "unnamed"),
            ("", "unnamed"),
            ("Con", "Con_"),
            ("nul.001", "nul_.001"),
            ("..", "unnamed"),
            ("a\ud800b", "a_b"),
            ("e\u0301", "é"),
            ("馬" * 99, "馬" * 40),
            ("světlo", "světlo"),
        ):
            self.assertEqual(plain(name), word)

    def test_names_differ_without_capitals(self):
        names = Names()
        self.assertEqual([names.new(n) for n in ("a", "A", "a", "b")], ["a", "A_2", "a_3", "b"])


class SceneTextTest(unittest.TestCase):
    def test_three_forms_come_back(self):
        pose = [("pivot", (1.0, 2.0, 3.0))]
        thing = Element(
            "mesh",
            "m",
            [
                ("filename", "m.slo"),
                ("smooth_normals", 1),
                block("addKframe", [("time", "0"), block("key", pose)]),
                block("addKframe", [("time", "1"), block("pre", pose), block("key", pose)]),
            ],
        )
        text = write([thing], ["first line", "", "# { } in a comment"])
        self.assertTrue(text.startswith("# first line\n#\n# # { }"))
        self.assertLessEqual(max(len(line) for line in text.splitlines()), 110)
        mesh = scene_reader.read(text).one("mesh", "m")
        self.assertEqual(mesh.values["filename"], [["m.slo"]])
        self.assertEqual(scene_reader.placement(mesh, 0.5)[0], [1.0, 2.0, 3.0])


class KeyFrameTest(unittest.TestCase):
    def test_what_is_left_out_comes_back(self):
        random = np.random.default_rng(6)
        for moves in itertools.product((False, True), repeat=3):
            bends = np.repeat(moves, 3)
            keys = []
            for time in (1.0, 4.0, 5.0):
                rest = np.array([1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0])
                values = rest + np.where(bends, random.uniform(-0.3, 0.3, (3, 9)), 0.0)
                keys.append(KeyFrame(time, values[0], values[1], values[2]))
            text = write([Element("mesh", "m", key_frames.moving(keys, 24.0))])
            self.assertEqual("pre" in text, any(moves))
            mesh = scene_reader.read(text).one("mesh")
            for a, b in itertools.pairwise(keys):
                for u in (0.0, 0.2, 0.7, 1.0):
                    time = (a.time + (b.time - a.time) * u) / 24.0
                    control = np.array([a.key, a.nex, b.pre, b.key])
                    expected = bezier.evaluate(control, np.array([u]))[0]
                    pivot, (right, _, up) = scene_reader.placement(mesh, time)
                    axes = rigid.axes_of(expected[3:6], expected[6:9])
                    np.testing.assert_allclose(pivot, expected[:3], atol=1e-6)
                    np.testing.assert_allclose(right, axes[:, 0], atol=1e-6)
                    np.testing.assert_allclose(up, axes[:, 2], atol=1e-6)


class FileTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()

    def test_mesh(self):
        triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1.5, 0]], np.float32)
        mesh = slo_mesh.MeshArrays(triangle, np.array([[0, 1, 2]]))
        path = os.path.join(self.folder, "m.slo")
        slo_mesh.write(path, mesh)
        with open(path, encoding="utf-8") as file:
            self.assertEqual(
                file.read(), "slo_mesh 1\nvertices {\n0 0 0\n1 0 0\n0 1.5 0\n}\nfaces {\n0 1 2\n}\n"
            )
        self.assertEqual(os.listdir(self.folder), ["m.slo"])

    def test_mesh_that_is_not_finite(self):
        triangle = np.array([[0, 0, 0], [1, np.nan, 0], [0, 1.5, 0]], np.float32)
        with self.assertRaisesRegex(ValueError, "vertices is not finite"):
            slo_mesh.write(
                os.path.join(self.folder, "m.slo"),
                slo_mesh.MeshArrays(triangle, np.array([[0, 1, 2]])),
            )
        self.assertEqual(os.listdir(self.folder), [])

    def test_digest_tells_meshes_apart(self):
        vertices = np.zeros((3, 3), np.float32)
        faces = np.array([[0, 1, 2]])
        plain_mesh = slo_mesh.MeshArrays(vertices, faces)
        smooth = slo_mesh.MeshArrays(vertices, faces, normals=vertices)
        moved = slo_mesh.MeshArrays(vertices + 1.0, faces)
        self.assertEqual(len({m.digest() for m in (plain_mesh, smooth, moved)}), 3)
        self.assertEqual(plain_mesh.digest(), slo_mesh.MeshArrays(vertices, faces).digest())

    def test_png(self):
        path = os.path.join(self.folder, "p.png")
        png.write(path, png.levels(np.array([[[0.0, 0.5, 1.0], [2.0, -1.0, 0.25]]])))
        with open(path, "rb") as file:
            data = file.read()
        self.assertEqual(data[16:26], b"\0\0\0\2\0\0\0\1\x10\2")
        start = data.index(b"IDAT") + 4
        row = zlib.decompress(data[start:])
        self.assertEqual(row, b"\0" + b"\0\0\x80\0\xff\xff" + b"\xff\xff\0\0\x40\0")

    def test_png_of_bytes_with_alpha(self):
        path = os.path.join(self.folder, "p.png")
        png.write(path, np.array([[[1, 2, 3, 4]], [[5, 6, 7, 255]]], np.uint8))
        with open(path, "rb") as file:
            data = file.read()
        self.assertEqual(data[16:26], b"\0\0\0\1\0\0\0\2\x08\6")
        row = zlib.decompress(data[data.index(b"IDAT") + 4 :])
        self.assertEqual(row, b"\0\1\2\3\4" + b"\0\5\6\7\xff")

    def test_exr_is_half_only_if_that_loses_nothing(self):
        path = os.path.join(self.folder, "p.exr")
        for value, kind in ((0.5, 1), (0.1, 2), (1e5, 2), (65504.0, 1)):
            exr.write(path, np.full((3, 2, 3), value, np.float32))
            with open(path, "rb") as file:
                data = file.read()
            channels = data.index(b"chlist\0") + 7 + 4
            self.assertEqual(data[channels : channels + 6], b"B\0" + bytes([kind, 0, 0, 0]))


class ReportTest(unittest.TestCase):
    def test_one_line_for_each_message(self):
        report = Report()
        for name in "abcdefgh":
            report.note(name, "is lost")
            report.note(name, "is lost")
        report.note("a", "is grey")
        self.assertEqual(report.lines(), ["a, b, c, d, e, f and 2 more: is lost", "a: is grey"])


if __name__ == "__main__":
    unittest.main()
