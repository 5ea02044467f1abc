# SPDX-License-Identifier: GPL-3.0-or-later
"""Finding and running the program, passes, and Phong values."""

import os
import stat
import sys
import tempfile
import time
import unittest
from unittest import mock

from slo_rt import passes, process, program
from slo_rt.format.phong import Surface, phong_of_surface


def script(text):
    """A shell script that can be run."""
    path = os.path.join(tempfile.mkdtemp(), "slo-rt")
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"#!/bin/sh\n{text}")
    os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)
    return path


class ProgramTest(unittest.TestCase):
    def test_options_are_found(self):
        new = script('[ "$1" = --version ] && echo slo-rt 9.9 || echo "  --progress FORM"')
        old = script('[ "$1" = --version ] && echo slo-rt 0.1 || echo "  --samples N"')
        with mock.patch.dict(os.environ, {"SLO_RT": ""}):
            command = program.find(new).command("/a/b.txt", -3, "/out", 8)
            self.assertEqual(command[1:5], ["--scene", "b.txt", "--indir", "/a"])
            self.assertIn("--frame=-3", command)
            self.assertEqual(command[-4:], ["--samples", "8", "--progress", "json"])
            self.assertNotIn("--progress", program.find(old).command("/a/b.txt", 1, "/out"))

    def test_what_is_wrong_is_said(self):
        with mock.patch.dict(os.environ, {"SLO_RT": "", "PATH": ""}):
            with self.assertRaisesRegex(program.ProgramMissing, "not on the PATH.*Preferences"):
                program.find("")
        with self.assertRaisesRegex(program.ProgramMissing, "There is no program /no/such"):
            program.find("/no/such")
        with self.assertRaisesRegex(program.ProgramMissing, "does not run"):
            program.find(script("exit 3"))
        with self.assertRaisesRegex(program.ProgramMissing, "is not slo-rt"):
            program.find(script("echo grep 3"))

    def test_paths_as_people_paste_them(self):
        path = script("[ $1 = --version ] && echo slo-rt 9.9 || echo")
        folder, name = os.path.split(path)
        spaced = os.path.join(tempfile.mkdtemp(), "two words", name)
        os.mkdir(os.path.dirname(spaced))
        os.rename(path, spaced)
        with mock.patch.dict(os.environ, {"HOME": os.path.dirname(spaced), "SLO_RT": ""}):
            for typed in (
                spaced, f'"{spaced}"', f" '{spaced}' ", f"~/{name}", "~", os.path.dirname(spaced)
            ):  # fmt: skip
                self.assertEqual(program.find(typed).path, spaced)

    def test_a_program_that_fails_is_asked_once(self):
        asked = os.path.join(tempfile.mkdtemp(), "asked")
        path = script(f"echo again >>{asked}; exit 3")
        for _ in range(3):
            with self.assertRaisesRegex(program.ProgramMissing, "does not run"):
                program.find(path)
        with open(asked, encoding="utf-8") as file:
            self.assertEqual(len(file.readlines()), 1)

    def test_picture_names(self):
        self.assertEqual(program.picture_name("a_", 7, "exr"), "a_00007.exr")
        self.assertEqual(program.picture_name("a_", -7, "exr"), "a_-00007.exr")
        self.assertEqual(program.picture_name("a_", 123456, "png"), "a_123456.png")


class ProcessTest(unittest.TestCase):
    def run_script(self, text, stop=lambda: False):
        fractions = []
        return process.run([script(text)], fractions.append, stop), fractions

    def test_progress_and_messages(self):
        outcome, fractions = self.run_script(
            'echo \'{"event":"progress","fraction":0.25,"left":null}\' >&2\n'
            "echo out/a_00001.exr\n"
            "echo 'slo-rt:  50 %, 3 s passed, about 3 s left' >&2\n"
            "echo 'warning: odd' >&2\n"
        )
        self.assertEqual(fractions, [0.25, 0.5])
        self.assertEqual(outcome.messages, ["warning: odd"])
        self.assertTrue(outcome.succeeded)

    def test_failures(self):
        outcome, _ = self.run_script(
            "echo 'error: scene.txt:3:1' >&2\n"
            'echo \'{"event":"failed","message":"frame 1: no light"}\' >&2\nexit 65'
        )
        self.assertFalse(outcome.succeeded)
        self.assertEqual(outcome.complaint(), "error: scene.txt:3:1\nframe 1: no light")
        self.assertIn("exit code 3", self.run_script("exit 3")[0].complaint())
        crash = self.run_script("echo 'error: frame.txt:3:1' >&2; kill -SEGV $$")[0]
        self.assertEqual(crash.complaint(), "error: frame.txt:3:1\nslo-rt was ended by SIGSEGV")

    def test_much_talk_does_not_block(self):
        line = "x" * 99
        outcome, _ = self.run_script(
            f"i=0; while [ $i -lt 3000 ]; do echo {line} >&2; i=$((i+1)); done"
        )
        self.assertEqual(len(outcome.messages), 3000)

    def test_stop_is_asked_for_first(self):
        outcome, _ = self.run_script(
            "trap 'exit 75' INT\nwhile :; do sleep 0.05; done", stop=lambda: True
        )
        self.assertTrue(outcome.stopped)
        # A shell that is still starting when asked has no trap yet.
        self.assertIn(outcome.code, (75, -2))

    def test_who_does_not_listen_is_ended(self):
        with mock.patch.object(process, "GRACE_SECONDS", 0.3):
            begin = time.monotonic()
            ready = os.path.join(tempfile.mkdtemp(), "ready")
            code = (
                "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); "
                f"open({ready!r}, 'w').close(); time.sleep(60)"
            )
            outcome = process.run(
                [sys.executable, "-c", code], lambda fraction: None, lambda: os.path.exists(ready)
            )
        self.assertTrue(outcome.stopped)
        self.assertLess(time.monotonic() - begin, 30.0)

    def test_lines_that_are_not_progress(self):
        for line in (
            "",
            "{",
            "{]",
            "[1]",
            '{"fraction": "x"}',
            '{"fraction": true}',
            '{"event": "ended"}',
        ):
            self.assertIn(process.fraction_of(line), (None, 1.0))
        self.assertEqual(process.fraction_of('{"fraction": 7}'), 1.0)


class PassesTest(unittest.TestCase):
    def test_plan(self):
        self.assertEqual(passes.planned(64, True, False), [1, 8, 64])
        self.assertEqual(passes.planned(16, True, False), [1, 16])
        self.assertEqual(passes.planned(1, True, False), [1])
        self.assertEqual(passes.planned(256, False, False), [256])
        self.assertEqual(passes.planned(256, False, True), [256])
        self.assertEqual(passes.planned(513, True, True), [1, 8, 64, 512, 513])
        self.assertEqual(passes.planned(8, True, True), [1, 8])
        self.assertEqual(passes.planned(1, True, True), [1])

    def limited(self, limit, samples, goes_on, duration):
        """Returns the passes under a time limit, if a pass takes `duration(samples of before, samples)`."""
        measured, before = [], 0
        while (count := passes.following(limit, samples, measured, goes_on)) is not None:
            measured.append((count, duration(before if goes_on else 0, count)))
            before = count
        return [count for count, _ in measured], sum(seconds for _, seconds in measured)

    def test_time_limit_holds(self):
        for goes_on in (False, True):
            for fixed, each, limit in ((0.5, 0.1, 10.0), (0.0, 0.001, 60.0), (3.0, 2.0, 5.0)):

                def duration(before, count, fixed=fixed, each=each):
                    return fixed + each * (count - before)

                counts, spent = self.limited(limit, 4096, goes_on, duration)
                self.assertLessEqual(spent, max(limit, fixed + each) + fixed * goes_on + 1e-9)
                self.assertEqual(counts, sorted(set(counts)))
                if fixed + each > limit / 2.0:
                    self.assertEqual(counts, [1])

    def test_quick_pictures_get_all_samples(self):
        for goes_on in (False, True):
            counts, _ = self.limited(100.0, 100, goes_on, lambda before, count: 0.001)
            self.assertEqual(counts, [1, 8, 64, 100])


class PhongTest(unittest.TestCase):
    def test_no_surface_gives_more_than_it_gets(self):
        for metallic in (0.0, 0.5, 1.0):
            for transmission in (0.0, 0.7, 1.0):
                for alpha in (0.0, 0.5, 1.0):
                    phong = phong_of_surface(
                        Surface((1.0, 1.0, 1.0), metallic, 0.3, 1.5, 0.5, transmission, alpha)
                    )
                    total = phong.diffuse[0] + phong.reflectance + phong.refraction
                    self.assertLessEqual(total, 1.05)
                    self.assertGreaterEqual(total, 0.95)

    def test_text_leaves_out_what_has_no_effect(self):
        def keys(**sockets):
            return {key for key, _ in phong_of_surface(Surface(**sockets)).element("p").body}

        self.assertEqual(keys(specular_level=0.0), {"diffuse"})
        shiny = {"diffuse", "specular", "shininess", "reflectance", "diffuse_reflection"}
        self.assertEqual(keys(), shiny)
        self.assertIn("refraction_index", keys(transmission=0.5))
