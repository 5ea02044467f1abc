# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that change their shape, as shapes of one mesh."""

import math
import os
import subprocess
import unittest

import bpy
import numpy as np

from .. import scene_reader
from . import blend, moving_scenes


def world_vertices(thing, time):
    """Vertices in world space of an object at a time in frames, as Blender evaluates them."""
    scene = bpy.context.scene
    scene.frame_set(math.floor(time), subframe=time - math.floor(time))
    evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    points = np.array([vertex.co[:] for vertex in mesh.vertices])
    matrix = np.array(evaluated.matrix_world)
    evaluated.to_mesh_clear()
    return points @ matrix[:3, :3].T + matrix[:3, 3]


class BendingTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()
        self.scene.frame_end = 9
        self.scene.render.use_motion_blur = True

    def export(self, name="Flag"):
        """Exports the scene, which the program must accept; keeps it read back. Returns the mesh."""
        self.path = blend.export()
        done = subprocess.run(
            [blend.program(), "--check", "--scene", self.path],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.path, encoding="utf-8") as file:
            self.text = file.read()
        self.described = scene_reader.read(self.text)
        return self.described.one("mesh", name)

    def points(self, element, time):
        """World positions of the vertices of a mesh at a time in frames, by the text."""
        seconds = time / self.scene.render.fps
        shapes = scene_reader.shapes(element)
        times = [at for at, _ in shapes]
        after = min(max(int(np.searchsorted(times, seconds)), 1), len(times) - 1)
        (t0, first), (t1, second) = shapes[after - 1 : after + 1]
        a, b = (self.file(name) for name in (first, second))
        u = min(max((seconds - t0) / (t1 - t0), 0.0), 1.0)
        matrix = scene_reader.matrix(self.described, element, seconds)
        return (a + u * (b - a)) @ matrix[:3, :3].T + matrix[:3, 3]

    def file(self, name):
        columns, _ = scene_reader.ply(os.path.join(os.path.dirname(self.path), name))
        return np.stack([columns[axis] for axis in "xyz"], axis=1)

    def compare(self, thing, element, tolerance=1.5e-3):
        """The text says at all times where Blender's vertices are."""
        for time in (1.0, 1.25, 2.0, 2.6, 4.4, 6.0, 7.75, 8.9):
            theirs = world_vertices(thing, time)
            size = np.linalg.norm(np.ptp(theirs, axis=0))
            gaps = [
                np.abs(theirs - point).max(axis=1).min() for point in self.points(element, time)
            ]
            self.assertLess(max(gaps), tolerance * size, time)

    def test_walker(self):
        _, body = moving_scenes.walker()
        body.modifiers["Smooth"].levels = body.modifiers["Smooth"].render_levels
        element = self.export("Body")
        self.compare(body, element)
        self.assertNotIn("Not carried, or carried differently:\n# object", self.text)
        # The armature moves; so does its child, by key frames.
        self.assertGreater(len(element.all("addKframe")), 1)

    def test_flag(self):
        cloth = moving_scenes.flag()
        self.compare(cloth, self.export())
        self.assertIn("filename", self.described.one("mesh", "Pole").values)

    def test_even_motion_needs_two_shapes_for_each_stretch(self):
        thing = blend.cube("Flag")
        thing.shape_key_add(name="Basis")
        far = thing.shape_key_add(name="Far")
        for point in far.data:
            point.co.z *= 2.0
        for frame, value in ((1, 0.0), (9, 1.0)):
            far.value = value
            far.keyframe_insert("value", frame=frame)
        for curve in blend.slo_rt.compat.fcurves(thing.data.shape_keys.animation_data):
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
        self.scene.render.use_motion_blur = False
        element = self.export()
        self.assertEqual(len(element.all("shapes")), 1)
        self.assertEqual(len(scene_reader.shapes(element)), 9)
        self.compare(thing, element)

    def test_rest_and_return_share_files(self):
        thing = blend.cube("Flag")
        thing.shape_key_add(name="Basis")
        far = thing.shape_key_add(name="Far")
        far.data[0].co.x -= 3.0
        for frame, value in ((1, 0.0), (3, 0.0), (4, 1.0), (6, 1.0), (7, 0.0), (9, 0.0)):
            far.value = value
            far.keyframe_insert("value", frame=frame)
        for curve in blend.slo_rt.compat.fcurves(thing.data.shape_keys.animation_data):
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
        element = self.export()
        files = [filename for _, filename in scene_reader.shapes(element)]
        self.assertEqual(len(set(files)), 2)
        self.assertEqual(len(files), 6)
        self.compare(thing, element)

    def test_still_meshes_with_modifiers_are_one_file(self):
        thing = blend.cube("Flag")
        thing.modifiers.new("Bevel", "BEVEL")
        blend.key(thing, "location", 1, (0.0, 0.0, 0.0))
        blend.key(thing, "location", 9, (3.0, 0.0, 0.0))
        moving_scenes.walker()[0].animation_data_clear()
        element = self.export()
        self.assertTrue(element.values["filename"][0][0].endswith(".slo"))
        folder = os.path.join(os.path.dirname(self.path), "scene")
        self.assertFalse([name for name in os.listdir(folder) if name.endswith(".ply")])

    def test_faces_that_change_are_listed(self):
        thing = blend.cube("Flag")
        build = thing.modifiers.new("Build", "BUILD")
        build.frame_start, build.frame_duration = -4, 20
        element = self.export()
        self.assertIn('object "Flag": its faces change; it has those of frame 1', self.text)
        self.assertIn("filename", element.values)

    def test_materials_and_sharp_edges(self):
        """Parts keep their triangles, and corners that are flat only at first get normals of their own."""
        thing = blend.cube("Flag")
        for name in ("Red", "Blue"):
            thing.data.materials.append(bpy.data.materials.new(name))
        thing.data.polygons[0].material_index = 1
        for polygon in thing.data.polygons[1:]:
            polygon.use_smooth = True
        thing.shape_key_add(name="Basis")
        far = thing.shape_key_add(name="Far")
        far.data[0].co.x -= 3.0
        far.value = 0.0
        far.keyframe_insert("value", frame=1)
        far.value = 1.0
        far.keyframe_insert("value", frame=9)
        element = self.export("Flag_Red")
        folder = os.path.dirname(self.path)
        for name, count in (("Flag_Red", 10), ("Flag_Blue", 2)):
            element = self.described.one("mesh", name)
            for _, filename in scene_reader.shapes(element)[:3]:
                columns, faces = scene_reader.ply(os.path.join(folder, filename))
                self.assertEqual(len(faces), count)
                lengths = np.linalg.norm([columns[f"n{axis}"] for axis in "xyz"], axis=0)
                self.assertLess(np.abs(lengths - 1.0).max(), 1e-3)

    def test_f12_shares_files_between_frames(self):
        """With a shutter of a whole frame, the shape at the end of one is that at the start of the next."""
        moving_scenes.flag()
        blend.program()
        render = self.scene.render
        render.motion_blur_shutter, render.motion_blur_position = 1.0, "START"
        files = []
        for frame in (3, 4):
            self.scene.frame_set(frame)
            bpy.ops.render.render()
            with open(os.path.join(blend.work_folder(), "frame.txt"), encoding="utf-8") as file:
                element = scene_reader.read(file.read()).one("mesh", "Flag")
            shapes = scene_reader.shapes(element)
            self.assertAlmostEqual(shapes[0][0], frame / 24.0)
            self.assertAlmostEqual(shapes[-1][0], (frame + 1) / 24.0)
            files.append([filename for _, filename in shapes])
        self.assertEqual(files[0][-1], files[1][0])
        self.assertEqual(len(set(files[0] + files[1])), len(files[0]) + len(files[1]) - 1)
