# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares silhouettes with Cycles' at three moments of one shutter, and blurred pictures: a walker, a
flag, a forest.

A scene is written once, with an open shutter. Then its text is rendered at single moments by a shift
of scene time, while Blender moves to these moments.
"""

import os
import re
import subprocess
import unittest

import bpy
import numpy as np

from slo_rt import engine

from . import blend, moving_scenes
from .test_pictures import glowing, picture

SIZE = (160, 120)
# Silhouettes have so many pixels across one of the picture.
FINE = 4
# Largest distance between silhouettes, in pixels of the picture.
DISTANCE = 0.5
SAMPLES = 256
# Largest mean difference of blurred pixels, most of it noise.
DIFFERENCE = 0.02
SHUTTER = 0.5


def grown(mask, radius):
    """A mask with all pixels whose middle is at most `radius` from one of its own."""
    reach = int(radius)
    result = np.zeros_like(mask)
    wide = np.pad(mask, reach)
    height, width = mask.shape
    for y in range(-reach, reach + 1):
        for x in range(-reach, reach + 1):
            if x * x + y * y <= radius * radius:
                result |= wide[reach + y : reach + y + height, reach + x : reach + x + width]
    return result


def apart(one, other):
    """The smallest number of pixels by which each of two masks must grow to cover the other."""
    for radius in range(40):
        is_in = not (one & ~grown(other, radius)).any()
        if is_in and not (other & ~grown(one, radius)).any():
            return radius
    return 40


class MovingPictureTest(unittest.TestCase):
    def setUp(self):
        blend.program()
        self.scene = scene = blend.fresh_scene(SIZE, "PATH")
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
        scene.render.use_motion_blur = True
        scene.render.motion_blur_shutter = SHUTTER
        scene.cycles.max_bounces = 0
        scene.slo_rt.use_cycles_bounces = True

    def compare(self, frame):
        material = glowing()
        for thing in bpy.data.objects:
            if thing.type == "MESH":
                thing.data.materials.append(material)
        self.scene.frame_set(frame)
        ours, theirs = (picture(self.scene, name, SAMPLES) for name in ("SLO_RT", "CYCLES"))
        self.assertGreater(theirs.sum(), 500.0)
        self.assertLess(theirs.max(), 1.01)
        blurred = ((theirs > 0.02) & (theirs < 0.98)) | ((ours > 0.02) & (ours < 0.98))
        off = np.abs(ours - theirs)[blurred].mean()
        self.scene.render.use_motion_blur = False
        sharp = np.abs(picture(self.scene, "CYCLES", 16) - theirs)[blurred].mean()
        self.scene.render.use_motion_blur = True
        distances = [self.distance(frame, part) for part in (-0.5, 0.0, 0.5)]
        print(
            f"  {self.id().rsplit('.')[-1]}: silhouettes within "
            f"{', '.join(f'{d:.2f}' for d in distances)} px; blurred alpha off by {off:.4f} on "
            f"average of {blurred.sum()} pixels, {sharp:.4f} without blur, "
            f"light {ours.sum() / theirs.sum():.4f}"
        )
        self.assertLessEqual(max(distances), DISTANCE)
        self.assertLess(off, DIFFERENCE)
        self.assertGreater(sharp, 4.0 * DIFFERENCE)
        self.assertAlmostEqual(ours.sum() / theirs.sum(), 1.0, delta=0.01)

    def distance(self, frame, part):
        """The distance of the silhouettes, in pixels of the picture, at a fraction of the shutter."""
        time = frame + part * SHUTTER
        ours = self.at_moment(time)
        render = self.scene.render
        render.use_motion_blur = False
        render.resolution_percentage = 100 * FINE
        self.scene.frame_set(int(time // 1.0), subframe=time % 1.0)
        theirs = picture(self.scene, "CYCLES", 16)
        render.use_motion_blur = True
        render.resolution_percentage = 100
        self.scene.frame_set(frame)
        self.assertGreater((theirs > 0.5).sum(), 500 * FINE * FINE)
        return apart(ours > 0.5, theirs > 0.5) / FINE

    def at_moment(self, time):
        """Renders the text of the frame, which has an open shutter, at one moment."""
        folder = blend.work_folder()
        with open(os.path.join(folder, "frame.txt"), encoding="utf-8") as file:
            text = file.read()
        text = re.sub(r"\n *blurDuration .*", "", text)
        for side, later in (("Start", 0.0), ("End", 0.5)):
            value = (time + later) / self.scene.render.fps
            text, count = re.subn(rf"scene{side} \S+", f"scene{side} {value!r}", text)
            self.assertEqual(count, 1)
        with open(os.path.join(folder, "moment.txt"), "w", encoding="utf-8") as file:
            file.write(text)
        frame = self.scene.frame_current
        size = "x".join(str(FINE * side) for side in SIZE)
        command = [blend.PROGRAM, "-q", "-s", "moment.txt", "--size", size, "--samples", "16"]
        command += [f"--frame={frame}", "-od", "moments", "--overwrite"]
        subprocess.run(command, check=True, cwd=folder, stdout=subprocess.DEVNULL)
        path = os.path.join(folder, "moments", f"frame_{frame:05d}.exr")
        return engine.linear_pixels(path)[..., :3].mean(axis=2)

    def test_walker(self):
        moving_scenes.walker()
        self.scene.camera.location = (0.0, -5.0, 0.95)
        self.compare(13)

    def test_flag(self):
        moving_scenes.flag()
        self.scene.camera.location = (0.9, -7.0, 0.3)
        self.compare(7)

    def test_forest(self):
        trees = moving_scenes.trees()
        island = moving_scenes.grove(trees, 5.0, 2.0)
        island.scale = (1.2, 0.8, 1.0)
        for frame, turn in ((1, 0.0), (11, 2.0)):
            blend.key(island, "rotation_euler", frame, (0.15, 0.0, turn))
            blend.key(island, "location", frame, (turn, 2.0, -1.2))
        for i in range(3):
            tree = moving_scenes.collection_instance(trees, f"Tree{i}", (i - 1.0, -2.0, -1.0))
            blend.key(tree, "scale", 1, (1.0, 1.0, 0.4))
            blend.key(tree, "scale", 11, (1.0, 1.0, 1.0 + i))
        self.compare(6)
