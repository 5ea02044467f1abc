# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests which camera sees a frame, and how: markers, objects as cameras, mirrors, focus."""

import unittest

import bpy
import numpy as np

from .. import scene_reader
from . import blend
from .test_pictures import glowing, picture


def other_camera(name, x):
    """Another camera, at `x`, that looks along y."""
    scene = bpy.context.scene
    camera = scene.camera.copy()
    camera.name = name
    camera.location.x = x
    scene.collection.objects.link(camera)
    return camera


class MarkerTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()
        self.scene.frame_start, self.scene.frame_end = 1, 30
        blend.cube()
        self.cameras = [other_camera(f"Eye{i}", 10.0 * i) for i in range(3)]

    def mark(self, *cuts):
        for frame, i in cuts:
            self.scene.timeline_markers.new("cut", frame=frame).camera = self.cameras[i]

    def seen_by(self, *frames):
        """Number of the camera that sees each frame of an export."""
        scene = scene_reader.read(blend.export_text())
        return [round(scene_reader.camera(scene, f, 0.0)["position"][0] / 10.0) for f in frames]

    def check(self, *frames):
        """Returns `seen_by`, which must agree with Blender, whichever frame is shown."""
        texts = []
        for shown in (30, 1, 15):
            self.scene.frame_set(shown)
            texts.append(blend.export_text())
        self.assertEqual(len(set(texts)), 1)
        expected = []
        for frame in frames:
            self.scene.frame_set(frame)
            expected.append(self.cameras.index(self.scene.camera))
        self.assertEqual(self.seen_by(*frames), expected)
        return expected

    def test_before_the_first_marker(self):
        self.mark((12, 1), (20, 2))
        self.assertEqual(self.check(1, 11, 12, 19, 20, 30), [1, 1, 1, 1, 2, 2])

    def test_markers_before_the_first_frame(self):
        self.mark((-30, 2), (-4, 1), (40, 0))
        self.assertEqual(self.check(1, 30), [1, 1])

    def test_two_markers_on_one_frame(self):
        self.mark((5, 1), (5, 2), (9, 2), (9, 0))
        self.assertEqual(self.check(1, 5, 8, 9, 30), [1, 1, 1, 2, 2])

    def test_hidden_cameras_do_not_count(self):
        self.mark((1, 0), (7, 1), (9, 2))
        self.cameras[1].hide_render = True
        self.assertEqual(self.check(1, 7, 8, 9), [0, 0, 0, 2])

    def test_rendering_with_two_markers_on_one_frame(self):
        blend.program()
        self.mark((1, 0), (1, 1))
        bpy.context.object.data.materials.append(glowing())
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
        self.assertGreater(picture(self.scene, "SLO_RT", 4)[20:28, 28:36].min(), 0.9)


class ViewTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene((120, 90))
        blend.program()
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
        self.thing = blend.cube(size=1.5)
        self.thing.location = (0.4, 0.0, 0.3)
        self.thing.data.materials.append(glowing())

    def notes(self):
        return "\n".join(line for line in blend.export_text().splitlines() if line[:1] == "#")

    def test_any_object_is_a_camera(self):
        place = self.scene.camera.matrix_world.copy()
        spot = bpy.data.lights.new("Spot", "SPOT")
        spot.spot_size = 0.6
        for data in (spot, bpy.data.lights.new("Sun", "SUN"), None, bpy.data.meshes.new("Empty")):
            eye = bpy.data.objects.new("Eye", data)
            eye.matrix_world = place
            self.scene.collection.objects.link(eye)
            self.scene.camera = eye
            ours, theirs = (picture(self.scene, name, 16) for name in ("SLO_RT", "CYCLES"))
            self.assertGreater(theirs.sum(), 50.0)
            self.assertLess(np.abs(ours - theirs).sum(), 0.04 * theirs.sum(), data)
            self.assertIn('camera "Eye": no camera, but an object', self.notes())
            bpy.data.objects.remove(eye)

    def test_scales_of_cameras(self):
        parent = bpy.data.objects.new("Parent", None)
        self.scene.collection.objects.link(parent)
        camera = self.scene.camera
        camera.parent = parent
        for scale, words in (
            ((2.0, 2.0, 2.0), ""), ((-1.0, -1.0, 1.0), ""), ((-1.0, 1.0, 1.0), "mirrored"),
            ((1.0, 1.0, -1.0), "mirrored"), ((-1.0, -1.0, -1.0), "mirrored"),
        ):  # fmt: skip
            parent.scale = scale
            notes = self.notes()
            self.assertEqual(bool(words), "mirrored" in notes, scale)
            self.assertNotIn("sheared", notes)
        parent.scale, camera.rotation_euler.y = (1.0, 3.0, 1.0), 0.5
        camera.rotation_euler.z = 0.5
        self.assertIn("sheared", self.notes())

    def test_focus_on_a_bone(self):
        rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
        self.scene.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = rig.data.edit_bones.new("hand")
        bone.head, bone.tail = (1.0, -3.0, 0.0), (1.0, -3.0, 2.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        rig.scale = (1.0, 2.0, 1.0)
        rig.pose.bones["hand"].location = (0.0, 0.0, 0.5)
        dof = self.scene.camera.data.dof
        dof.use_dof, dof.focus_object, dof.aperture_fstop = True, rig, 0.5
        for name, distance in (("hand", None), ("", 10.0), ("gone", 10.0)):
            dof.focus_subtarget = name
            if distance is None:
                bpy.context.view_layer.update()
                head = rig.matrix_world @ rig.pose.bones["hand"].head
                distance = head.y + 10.0
                self.assertLess(distance, 9.0)
            scene = scene_reader.read(blend.export_text())
            self.assertAlmostEqual(scene_reader.camera(scene, 1, 0.0)["dof"], distance, delta=1e-5)
