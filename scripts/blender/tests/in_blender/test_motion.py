# SPDX-License-Identifier: GPL-3.0-or-later
"""Key frames reproduce Blender's motion: compares scene texts with `matrix_world` between frames."""

import math
import os
import random
import unittest

import bpy
import numpy as np

from .. import scene_reader
from . import blend

POSITION = 1e-4  # of the size
DIRECTION = math.radians(0.05)
CUBE = 2.0 * math.sqrt(3.0)  # diagonal of the cube of side 2


def moments(scene, count=150):
    """Random times in frames, whole frames and their middles among them."""
    random.seed(5)
    first, last = scene.frame_start, scene.frame_end
    whole = [float(frame) for frame in range(first, last + 1)]
    return (
        whole + [f + 0.5 for f in whole[:-1]] + [random.uniform(first, last) for _ in range(count)]
    )


def matrix_at(scene, thing, time):
    """The evaluated matrix of an object at a time in frames."""
    whole = math.floor(time)
    scene.frame_set(whole, subframe=time - whole)
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array(evaluated.matrix_world, np.float64)


def worst(scene, thing, text, size, times):
    """Returns the largest errors of an object's key frames: (fraction of the size, radians)."""
    element = scene_reader.read(text).one("mesh", thing.name)
    position = direction = 0.0
    for time in times:
        matrix = matrix_at(scene, thing, time)
        pivot, (right, _, up) = scene_reader.placement(element, time / scene.render.fps)
        position = max(position, float(np.linalg.norm(np.array(pivot) - matrix[:3, 3])) / size)
        for ours, column in ((right, 0), (up, 2)):
            axis = matrix[:3, column] / np.linalg.norm(matrix[:3, column])
            direction = max(direction, 2.0 * math.asin(np.linalg.norm(axis - ours) / 2.0))
    return position, direction


class MotionTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()

    def check(self, thing, size=CUBE, most_keys=None):
        text = blend.export_text()
        position, direction = worst(self.scene, thing, text, size, moments(self.scene))
        keys = text.count("addKframe")
        print(
            f"  {self.id().rsplit('.')[-1]}: position {position:.1e} of the size, "
            f"direction {math.degrees(direction):.4f} degrees, {keys} key frames"
        )
        self.assertLessEqual(position, POSITION)
        self.assertLessEqual(direction, DIRECTION)
        self.assertNotIn("wildly", text[:1000])
        if most_keys:
            self.assertLessEqual(keys, most_keys)
        return text

    def test_swing(self):
        thing = blend.cube()
        for frame, angle in ((1, -0.9), (9, 0.9), (17, -0.9), (25, 0.9)):
            blend.key(thing, "rotation_euler", frame, (0.0, angle, 0.3))
        self.check(thing, most_keys=40)

    def test_spiral(self):
        thing = blend.cube(size=0.5)
        for frame in range(1, 26, 4):
            angle = 0.6 * frame
            place = (3.0 * math.cos(angle), 3.0 * math.sin(angle), 0.1 * frame)
            blend.key(thing, "location", frame, place)
            blend.key(thing, "rotation_euler", frame, (0.0, 0.0, angle))
        for curve in blend.curves(thing):
            for point in curve.keyframe_points:
                point.handle_left_type = point.handle_right_type = "FREE"
                point.handle_right.x += 0.7
        self.check(thing, size=0.5 * math.sqrt(3.0))

    def test_parented_spin(self):
        parent = bpy.data.objects.new("Parent", None)
        self.scene.collection.objects.link(parent)
        parent.scale = (2.0, 2.0, 2.0)
        blend.key(parent, "rotation_euler", 1, (0.0, 0.0, 0.0))
        blend.key(parent, "rotation_euler", 25, (0.0, 0.0, 6.0 * math.pi))
        blend.key(parent, "location", 1, (0.0, 0.0, 0.0))
        blend.key(parent, "location", 25, (4.0, 0.0, 1.0))
        blend.interpolation(parent, "LINEAR")
        thing = blend.cube(size=1.0)
        thing.parent = parent
        thing.location = (2.0, 0.0, 0.0)
        thing.rotation_mode = "QUATERNION"
        blend.key(thing, "rotation_quaternion", 1, (1.0, 0.0, 0.0, 0.0))
        blend.key(thing, "rotation_quaternion", 25, (0.0, 1.0, 0.0, 0.0))
        self.check(thing, size=2.0 * math.sqrt(3.0))

    def test_noisy_driver(self):
        thing = blend.cube()
        for index, expression in enumerate(
            (
                "sin(frame * 1.7) * 0.5",
                "sin(frame ** 1.3) * cos(frame * 4.1)",
                "cos(frame * 2.3) ** 3 * 0.7",
            )
        ):
            thing.driver_add("location", index).driver.expression = expression
        thing.driver_add("rotation_euler", 2).driver.expression = "sin(frame * 3.1) + sin(frame)"
        self.check(thing)

    def test_corners_are_told(self):
        thing = blend.cube()
        thing.driver_add("location", 0).driver.expression = "abs(cos(frame * 2.3))"
        text = blend.export_text()
        position, direction = worst(self.scene, thing, text, CUBE, moments(self.scene))
        self.assertLessEqual(position, 5.0 * POSITION)
        self.assertLessEqual(direction, DIRECTION)
        self.assertIn("moves too wildly", text)

    def test_noise_modifier(self):
        thing = blend.cube()
        blend.key(thing, "location", 1, (0.0, 0.0, 0.0))
        blend.key(thing, "location", 25, (1.0, 0.0, 0.0))
        for curve in blend.curves(thing):
            noise = curve.modifiers.new("NOISE")
            noise.scale, noise.strength = 3.0, 0.4
        self.check(thing)

    def test_automatic_handles_are_copied(self):
        thing = blend.cube()
        for frame, x in ((1, 0.0), (8, 2.0), (15, 1.0), (25, 3.0)):
            blend.key(thing, "location", frame, (x, -x, 0.5 * x * x))
        for curve in blend.curves(thing):
            for point in curve.keyframe_points:
                point.handle_left_type = point.handle_right_type = "AUTO"
            curve.update()
        text = self.check(thing)
        element = scene_reader.read(text).one("mesh", "Cube")
        times = [24.0 * block.number("time") for block in element.all("addKframe")]
        self.assertEqual([round(time, 4) for time in times[:4]], [1.0, 8.0, 15.0, 25.0])
        for block, frame in zip(element.all("addKframe"), (1, 8, 15)):
            nex = block.one("nex").vector("pivot")
            for axis, curve in enumerate(
                c for c in blend.curves(thing) if c.data_path == "location"
            ):
                point = next(p for p in curve.keyframe_points if p.co[0] == frame)
                self.assertAlmostEqual(nex[axis], point.handle_right[1], delta=2e-6)

    def test_stretched_time(self):
        """Time remapping moves the animation, not the frames."""
        thing = blend.cube()
        for frame, x in ((1, 0.0), (6, 3.0), (11, 1.0)):
            blend.key(thing, "location", frame, (x, 0.0, 0.0))
        render = self.scene.render
        render.frame_map_old, render.frame_map_new = 100, 250
        text = self.check(thing, most_keys=8)
        element = scene_reader.read(text).one("mesh", "Cube")
        times = [24.0 * block.number("time") for block in element.all("addKframe")]
        self.assertIn(15.0, [round(time, 4) for time in times])

    def test_leap(self):
        thing = blend.cube()
        for frame, x in ((1, 0.0), (10, 5.0), (20, -5.0)):
            blend.key(thing, "location", frame, (x, 0.0, 0.0))
        blend.interpolation(thing, "CONSTANT")
        text = blend.export_text()
        element = scene_reader.read(text).one("mesh", "Cube")
        for frame, x in ((9.99, 0.0), (10.0, 5.0), (19.99, 5.0), (20.0, -5.0)):
            self.assertAlmostEqual(
                scene_reader.placement(element, frame / 24.0)[0][0], x, delta=1e-5
            )
        self.assertNotIn("wildly", text[:1000])

    def check_matrices(self, thing, reach=1.0, error=2e-4):
        """The whole matrix, with scale, of the only mesh."""
        text = blend.export_text()
        described = scene_reader.read(text)
        element = described.one("mesh", thing.name)
        for time in moments(self.scene, 50):
            ours = scene_reader.matrix(described, element, time / self.scene.render.fps)
            theirs = matrix_at(self.scene, thing, time)
            off = np.abs(np.abs(ours) - np.abs(theirs)).max()
            self.assertLess(off, error * reach, time)
        self.assertNotIn("wildly", text)
        return text

    def test_scale(self):
        thing = blend.cube()
        for frame, scale, turn in ((1, (1.0, 2.0, -3.0), 0.0), (25, (2.0, 2.0, -1.0), 2.0)):
            blend.key(thing, "scale", frame, scale)
            blend.key(thing, "rotation_euler", frame, (0.0, 0.0, turn))
        text = self.check_matrices(thing, reach=6.0)
        self.assertNotIn("Not carried, or carried differently:\n# object", text)

    def test_growth_from_nothing(self):
        """What is scaled to nothing is turned as when it grows."""
        thing = blend.cube()
        thing.rotation_euler = (0.3, 0.9, 1.7)
        for frame, size in ((1, 0.0), (8, 0.0), (20, 1.5), (25, 1.5)):
            blend.key(thing, "scale", frame, (size, size, size))
        text = self.check_matrices(thing, reach=3.0)
        self.assertNotIn("left out", text)

    def test_what_stays_nothing_is_left_out(self):
        thing = blend.cube()
        thing.scale = (0.0, 0.0, 0.0)
        blend.key(thing, "location", 1, (0.0, 0.0, 0.0))
        blend.key(thing, "location", 25, (1.0, 0.0, 0.0))
        text = blend.export_text()
        self.assertIn("left out", text)
        self.assertNotIn("mesh Cube", text)

    def test_constant_scale_is_no_motion_of_its_own(self):
        thing = blend.cube()
        thing.scale = (0.3, 1.7, 0.55)
        blend.key(thing, "rotation_euler", 1, (0.0, 0.0, 0.0))
        blend.key(thing, "rotation_euler", 25, (2.0, 1.0, 3.0))
        self.assertEqual(blend.export_text().count("scale {"), 1)

    def test_shear_that_changes_is_a_change_of_shape(self):
        """A child turns in a squashed parent: no key frame can say this."""
        parent = bpy.data.objects.new("Parent", None)
        self.scene.collection.objects.link(parent)
        parent.scale = (1.0, 1.0, 0.4)
        thing = blend.cube()
        thing.parent = parent
        self.scene.frame_end = 5
        blend.key(thing, "rotation_euler", 1, (0.1, 0.0, 0.0))
        blend.key(thing, "rotation_euler", 5, (0.6, 0.0, 0.0))
        self.scene.render.use_motion_blur = True
        path = blend.export()
        with open(path, encoding="utf-8") as file:
            described = scene_reader.read(file.read())
        element = described.one("mesh")
        shapes = scene_reader.shapes(element)
        self.assertGreater(len(shapes), 4)
        corners = np.array([vertex.co[:] for vertex in thing.data.vertices])
        for time, filename in shapes:
            columns, _ = scene_reader.ply(os.path.join(os.path.dirname(path), filename))
            vertices = np.stack([columns[axis] for axis in "xyz"], axis=1)
            ours = scene_reader.matrix(described, element, time)
            theirs = matrix_at(self.scene, thing, time * self.scene.render.fps)
            ours = vertices @ ours[:3, :3].T + ours[:3, 3]
            theirs = corners @ theirs[:3, :3].T + theirs[:3, 3]
            gaps = np.linalg.norm(ours[:, None] - theirs, axis=2).min(axis=1)
            self.assertLess(gaps.max(), 1e-3)

    def test_rest_needs_no_more_than_one_key_frame(self):
        thing = blend.cube()
        thing.location = (1.0, 2.0, 3.0)
        self.scene.frame_end = 250
        text = blend.export_text()
        self.assertEqual(text.count("addKframe"), 1)


class CameraTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()
        blend.cube()

    def check(self, most_segments=None):
        """Compares the camera of the text with Blender's while each frame's shutter is open."""
        scene, camera = self.scene, self.scene.camera
        text = blend.export_text()
        described = scene_reader.read(text)
        render = scene.render
        shutter = render.motion_blur_shutter if render.use_motion_blur else 0.0
        before = {"START": 0.0, "CENTER": 0.5, "END": 1.0}[render.motion_blur_position]
        misses = {"position": 0.0, "direction": 0.0, "fov": 0.0}
        for frame in range(scene.frame_start, scene.frame_end + 1):
            for part in (0.0, 0.31, 0.77, 1.0) if shutter else (0.0,):
                ours = scene_reader.camera(described, frame, part)
                time = frame + shutter * (part - before)
                self.assertAlmostEqual(ours["time"] * render.fps, time, delta=1e-6)
                matrix = matrix_at(scene, camera, time)
                # The cube is at the origin.
                away = np.linalg.norm(matrix[:3, 3] - ours["position"]) / np.linalg.norm(
                    matrix[:3, 3]
                )
                misses["position"] = max(misses["position"], float(away))
                for axis, name in ((-matrix[:3, 2], "forward"), (matrix[:3, 1], "up")):
                    chord = np.linalg.norm(axis / np.linalg.norm(axis) - ours[name])
                    misses["direction"] = max(misses["direction"], 2.0 * math.asin(chord / 2.0))
                fov = 1.0 / self.projection(camera)[1][1]
                misses["fov"] = max(misses["fov"], abs(ours["fov"] / fov - 1.0))
        segments = text.count("CamSegment")
        print(
            f"  {self.id().rsplit('.')[-1]}: position {misses['position']:.1e} of the distance, direction "
            f"{math.degrees(misses['direction']):.4f} degrees, {segments} segments"
        )
        self.assertLessEqual(misses["position"], POSITION)
        self.assertLessEqual(misses["direction"], DIRECTION)
        self.assertLessEqual(misses["fov"], 4e-4)
        self.assertNotIn("wildly", text[:1000])
        if most_segments:
            self.assertLessEqual(segments, most_segments)
        return described

    def projection(self, camera):
        size = {"x": self.scene.render.resolution_x, "y": self.scene.render.resolution_y}
        return camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), **size)

    def path(self):
        """The camera follows a curve and looks at the cube, through constraints."""
        bpy.ops.curve.primitive_bezier_circle_add(radius=8.0)
        circle = bpy.context.object
        circle.data.resolution_u = 64
        circle.data.path_duration = 48
        circle.data.use_path = True
        circle.data.eval_time = 0.0
        circle.data.keyframe_insert("eval_time", frame=1)
        circle.data.eval_time = 16.0
        circle.data.keyframe_insert("eval_time", frame=25)
        camera = self.scene.camera
        camera.location = (0.0, 0.0, 2.0)
        camera.rotation_euler = (0.0, 0.0, 0.0)
        camera.constraints.new("FOLLOW_PATH").target = circle
        track = camera.constraints.new("TRACK_TO")
        track.target = bpy.data.objects["Cube"]
        track.track_axis, track.up_axis = "TRACK_NEGATIVE_Z", "UP_Y"

    def test_camera_on_a_path(self):
        self.path()
        self.check()

    def test_camera_on_a_path_with_blur(self):
        self.path()
        for position in ("START", "CENTER", "END"):
            self.scene.render.use_motion_blur = True
            self.scene.render.motion_blur_position = position
            described = self.check()
            segment = described.all("Camera")[0].all("CamSegment")[0]
            self.assertAlmostEqual(segment.number("blurDuration"), 0.5 / 24.0)

    def test_pan_roll_and_zoom(self):
        camera = self.scene.camera
        blend.key(camera, "rotation_euler", 1, (1.2, 0.0, -0.5))
        blend.key(camera, "rotation_euler", 25, (1.8, 0.7, 1.5))
        camera.data.lens = 35.0
        camera.data.keyframe_insert("lens", frame=1)
        camera.data.lens = 80.0
        camera.data.keyframe_insert("lens", frame=25)
        self.check()

    def test_still_camera_is_one_segment(self):
        self.check(most_segments=1)

    def test_markers_cut(self):
        other = bpy.data.objects.new("Other", bpy.data.cameras.new("Other"))
        self.scene.collection.objects.link(other)
        other.location = (5.0, 0.0, 20.0)
        for name, frame, camera in (("a", 1, self.scene.camera), ("b", 11, other)):
            self.scene.timeline_markers.new(name, frame=frame).camera = camera
        text = blend.export_text()
        described = scene_reader.read(text)
        self.assertAlmostEqual(
            scene_reader.camera(described, 10, 0.0)["position"][1], -10.0, delta=1e-5
        )
        self.assertAlmostEqual(
            scene_reader.camera(described, 11, 0.0)["position"][2], 20.0, delta=1e-5
        )
        self.assertEqual(text.count("CamSegment"), 2)

    def test_focus_and_lens(self):
        camera = self.scene.camera
        camera.data.dof.use_dof = True
        camera.data.dof.focus_object = bpy.data.objects["Cube"]
        camera.data.dof.aperture_fstop = 0.5
        described = scene_reader.read(blend.export_text())
        ours = scene_reader.camera(described, 1, 0.0)
        self.assertAlmostEqual(ours["dof"], 10.0, delta=1e-5)
        self.assertAlmostEqual(ours["lens_radius"], 0.05, delta=1e-7)  # 50 mm / 0.5 / 2
