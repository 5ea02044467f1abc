# SPDX-License-Identifier: GPL-3.0-or-later
"""Every failure while a frame is rendered stops the rendering, and the artist reads the reason."""

import os
import unittest
from unittest import mock

import bpy

from slo_rt import engine

from . import blend
from .test_engine import false_program


class FailureTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene((16, 12))
        self.scene.slo_rt.samples = 1
        blend.cube()
        blend.lamp()
        blend.program()

    def animate(self):
        """Renders frames 1 to 3; names of the pictures that were written."""
        folder = os.path.join(blend.FOLDER, self.id())
        self.scene.frame_start, self.scene.frame_end = 1, 3
        self.scene.render.filepath = os.path.join(folder, "frame_")
        try:
            bpy.ops.render.render(animation=True)
        finally:
            self.written = os.listdir(folder) if os.path.isdir(folder) else []

    def test_any_exception_stops_an_animation(self):
        for place in ("_tell", "_show", "_run_passes", "_set_frame"):
            for error in (TypeError("sorted"), AttributeError("lens"), KeyError("x"), IndexError(3),
                          RuntimeError("gone"), MemoryError(), RecursionError("deep"),
                          KeyboardInterrupt("Ctrl-C")):  # fmt: skip
                with mock.patch.object(
                    engine.SloRtRenderEngine, place, side_effect=error
                ), mock.patch("traceback.print_exception"):  # fmt: skip
                    with self.assertRaises(RuntimeError) as caught:
                        self.animate()
                    self.assertIn(str(error), str(caught.exception))
                    self.assertEqual(self.written, [])

    def test_an_exception_in_the_middle_of_an_animation(self):
        whole = engine.SloRtRenderEngine._tell

        def tell(self, report, is_first):
            if not is_first:
                raise ZeroDivisionError("at the second frame")
            whole(self, report, is_first)

        with (
            mock.patch.object(engine.SloRtRenderEngine, "_tell", tell),
            mock.patch("traceback.print_exception"),
        ):
            with self.assertRaisesRegex(RuntimeError, "ZeroDivisionError: at the second frame"):
                self.animate()
        self.assertEqual(self.written, ["frame_0001.png"])

    def test_any_exception_of_an_export_is_told(self):
        for error in (TypeError("sorted"), KeyError("x"), ZeroDivisionError("no")):
            with (
                mock.patch.object(engine, "write_scene", side_effect=error),
                mock.patch("traceback.print_exception"),
            ):
                with self.assertRaisesRegex(RuntimeError, type(error).__name__):
                    blend.export()

    def test_the_list_is_not_that_of_another_picture(self):
        self.scene.camera.data.shift_x = 0.1
        bpy.ops.render.render()
        self.assertIn("shift", "".join(engine.last_notes))
        with mock.patch.object(engine, "write_scene", side_effect=ValueError("no")):
            with self.assertRaisesRegex(RuntimeError, "no"):
                bpy.ops.render.render()
        self.assertEqual(engine.last_notes, [])

    def test_programs_without_a_picture(self):
        find_out = 'while [ $# -gt 0 ]; do [ "$1" = --outdir ] && out=$2; shift; done\n'
        for body, words in (
            ("exit 0", "without a picture"),
            (find_out + 'echo hi >"$out/frame_00001.exr"', "can't be read"),
            (find_out + ': >"$out/frame_00001.exr"', "can't be read"),
            (find_out + 'echo hi >"$out/other_00001.exr"', "without a picture"),
        ):
            os.environ["SLO_RT"] = false_program(body)
            with self.assertRaisesRegex(RuntimeError, words):
                self.animate()
            self.assertEqual(self.written, [])

    def test_a_picture_of_an_earlier_rendering_is_not_shown(self):
        bpy.ops.render.render()
        left = os.path.join(blend.work_folder(), "frame_00001.exr")
        self.scene.render.image_settings.file_format = "OPEN_EXR"
        self.scene.render.filepath = left
        bpy.ops.render.render(write_still=True)
        self.assertTrue(os.path.exists(left))
        os.environ["SLO_RT"] = false_program("exit 0")
        with self.assertRaisesRegex(RuntimeError, "without a picture"):
            bpy.ops.render.render()

    def test_pictures_of_another_size(self):
        small = os.path.join(blend.FOLDER, "small.exr")
        self.scene.render.image_settings.file_format = "OPEN_EXR"
        self.scene.render.filepath = small
        bpy.ops.render.render(write_still=True)
        self.scene.render.resolution_x = 20
        os.environ["SLO_RT"] = false_program(
            'while [ $# -gt 0 ]; do [ "$1" = --outdir ] && out=$2; shift; done\n'
            f'cp "{small}" "$out/frame_00001.exr"'
        )
        with self.assertRaisesRegex(RuntimeError, "a picture of 16 x 12 pixels"):
            bpy.ops.render.render()


class StoppedTest(unittest.TestCase):
    """Tests what a stopped rendering keeps, and for how long."""

    def setUp(self):
        self.scene = blend.fresh_scene((160, 120))
        self.thing = blend.cube()
        blend.lamp()
        blend.program()

    def stop(self):
        self.scene.slo_rt.samples = 60000
        answers = iter([False] * 4)
        with mock.patch.object(
            engine.SloRtRenderEngine, "_should_stop", lambda engine: next(answers, True)
        ):
            bpy.ops.render.render()

    def states(self):
        return [name for name in os.listdir(blend.work_folder()) if name.endswith(".state")]

    def early(self):
        """Renders; whether early pictures were shown."""
        shown = []
        whole = engine.SloRtRenderEngine._show

        def show(self, run, depsgraph):
            shown.append(run)
            whole(self, run, depsgraph)

        with mock.patch.object(
            engine.SloRtRenderEngine, "_shows_early", lambda self, values: True
        ), mock.patch.object(engine.SloRtRenderEngine, "_show", show):  # fmt: skip
            bpy.ops.render.render()
        return len(shown) > 1

    def test_nothing_stays_after_a_change(self):
        for change in (
            lambda: setattr(self.thing.location, "x", 1.0),
            lambda: self.scene.frame_set(7),
            lambda: setattr(self.scene.render, "use_border", True),
        ):
            self.stop()
            self.assertTrue(self.states())
            change()
            self.scene.slo_rt.samples = 4
            self.assertTrue(self.early())
            self.assertEqual(self.states(), [])

    def test_what_was_stopped_goes_on_at_once(self):
        self.stop()
        kept = self.states()
        self.assertTrue(kept)
        self.stop()
        self.assertTrue(self.states())
        with mock.patch.object(engine.Run, "_remove_states") as removed:
            with mock.patch.object(engine.SloRtRenderEngine, "_run", lambda *_: False):
                self.assertFalse(self.early())
        removed.assert_not_called()
