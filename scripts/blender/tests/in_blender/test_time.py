# SPDX-License-Identifier: GPL-3.0-or-later
"""Frame rates and times: every frame of Blender is a frame of the exported scene."""

import os
import subprocess
import unittest

import bpy

from .. import scene_reader
from . import blend

# As Blender's presets have them: frames per second and their base.
FRACTIONAL_RATES = ((24, 1.001), (30, 1.001), (60, 1.001), (120, 1.001), (25, 0.97), (1, 7.3))
FRAMES = (0, 1, 21, 28, 551, 4000)


class FrameRateTest(unittest.TestCase):
    def scene(self, fps, base, **blur):
        """A thing that moves, seen by a still camera; few pixels."""
        scene = blend.fresh_scene((8, 6))
        scene.render.fps, scene.render.fps_base = fps, base
        scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
        scene.slo_rt.samples = 1
        for name, value in blur.items():
            setattr(scene.render, name, value)
        thing = blend.cube()
        for frame, x in ((FRAMES[0], -1.0), (FRAMES[-1], 1.0)):
            blend.key(thing, "location", frame, (x, 0.0, 0.0))
        blend.interpolation(thing, "LINEAR")
        blend.program()
        return scene

    def check_export(self):
        path = blend.export()
        frames = ",".join(str(frame) for frame in FRAMES)
        done = subprocess.run(
            [blend.PROGRAM, "-q", "-s", path, f"--frame={frames}", "-od", os.path.dirname(path)],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(path, encoding="utf-8") as file:
            return scene_reader.read(file.read())

    def test_all_frames_of_fractional_rates_are_there(self):
        for fps, base in FRACTIONAL_RATES:
            with self.subTest(fps=fps, base=base):
                self.scene(fps, base)
                camera = self.check_export().one("Camera")
                self.assertEqual(camera.number("fps"), fps / base)
                segment = camera.one("CamSegment")
                # Exactly, as the program divides.
                self.assertEqual(segment.number("videoStart"), FRAMES[0] / (fps / base))

    def test_rates_with_an_open_shutter(self):
        for position in ("START", "CENTER", "END"):
            self.scene(
                30, 1.001, use_motion_blur=True, motion_blur_shutter=0.3,
                motion_blur_position=position,
            )  # fmt: skip
            segment = self.check_export().one("Camera").one("CamSegment")
            self.assertEqual(segment.number("videoStart"), FRAMES[0] / (30 / 1.001))

    def test_frames_render_one_by_one(self):
        for fps, base in FRACTIONAL_RATES[:3]:
            scene = self.scene(fps, base)
            for frame in (-700, 28, 551, 4000):
                scene.frame_set(frame)
                bpy.ops.render.render()  # a failure is a RuntimeError
