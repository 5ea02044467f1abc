# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances, as copies and placements."""

import math
import os
import subprocess
import unittest

import bpy
import numpy as np

from .. import scene_reader
from . import blend, moving_scenes
from .test_export import mesh_of


def instances(time, name):
    """Matrices to world space of the instances of an object at a time in frames."""
    scene = bpy.context.scene
    scene.frame_set(math.floor(time), subframe=time - math.floor(time))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return np.array(
        [
            np.array(instance.matrix_world)
            for instance in depsgraph.object_instances
            if instance.show_self and instance.is_instance and instance.object.name == name
        ]
    )


class CopyTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()
        self.trees = moving_scenes.trees()

    def export(self):
        path = blend.export()
        done = subprocess.run(
            [blend.program(), "--check", "--scene", path],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(path, encoding="utf-8") as file:
            self.text = file.read()
        self.folder = os.path.dirname(path)
        self.described = scene_reader.read(self.text)

    def places(self, original, seconds):
        """Matrices of all copies of an element, by the text."""
        found = []
        for element in self.described.all("copy"):
            if element.values["of"][0][0] == original:
                found.append(scene_reader.matrix(self.described, element, seconds))
        for element in self.described.all("copies"):
            if element.values["of"][0][0] == original:
                outer = scene_reader.matrix(self.described, element, seconds)
                found += list(outer @ self.placements(element))
        return np.array(found)

    def placements(self, element):
        path = os.path.join(self.folder, element.values["placements"][0][0])
        columns, _ = scene_reader.ply(path)
        count = len(columns["x"])
        w, x, y, z = (columns.get(f"q{n}", np.full(count, float(n == "w"))) for n in "wxyz")
        one = columns.get("scale", np.ones(count))
        scales = np.stack([columns.get(f"s{axis}", one) for axis in "xyz"], axis=1)
        matrices = np.zeros((count, 4, 4))
        matrices[:, :3, :3] = np.moveaxis(
            np.array(
                [
                    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
                ]
            ),
            2,
            0,
        )
        matrices[:, :3, :3] *= scales[:, None]
        matrices[:, :3, 3] = np.stack([columns[axis] for axis in "xyz"], axis=1)
        matrices[:, 3, 3] = 1.0
        return matrices

    def compare(self, times=(1.0,), mirror=False):
        for time in times:
            for name in ("Trunk", "Crown"):
                theirs, ours = instances(time, name), self.places(name, time / 24.0)
                self.assertEqual(len(ours), len(theirs))
                if mirror:  # mirrored in y, in the mesh
                    ours = ours @ np.diag((1.0, -1.0, 1.0, 1.0))
                size = np.abs(theirs[:, :3, 3]).max()
                gaps = np.abs(ours[:, None] - theirs).max(axis=(2, 3))
                self.assertLess(gaps.min(axis=1).max(), 5e-4 * size)
                self.assertLess(gaps.min(axis=0).max(), 5e-4 * size)

    def test_forest(self):
        moving_scenes.grove(self.trees, 4.0)
        self.export()
        self.assertEqual(len(self.described.all("copies")), 2)
        self.assertEqual(len(self.described.all("group")), 0)
        self.compare()

    def test_island(self):
        """A ground that moves, turns and is stretched takes its trees along."""
        ground = moving_scenes.grove(self.trees, 4.0)
        ground.scale = (1.5, 0.7, 1.0)
        for frame, turn in ((1, 0.0), (25, 1.0)):
            blend.key(ground, "rotation_euler", frame, (0.1, 0.2, turn))
            blend.key(ground, "location", frame, (turn, 0.0, 2.0 * turn))
        self.export()
        self.assertEqual(len(self.described.all("copies")), 2)
        group = self.described.one("group")
        for element in self.described.all("copies"):
            self.assertEqual(element.values["parent"], [[group.name]])
        self.compare((1.0, 7.3, 25.0))
        self.assertNotIn("wildly", self.text)

    def test_mirrored_island(self):
        ground = moving_scenes.grove(self.trees, 4.0)
        ground.scale = (-1.0, 1.0, 1.0)
        self.export()
        self.assertEqual(len(self.described.all("copies")), 2)
        self.compare(mirror=True)
        crown = self.described.one("mesh", "Crown")
        mesh = mesh_of(os.path.join(self.folder, crown.values["filename"][0][0]))
        a, b, c = (mesh["vertices"][mesh["faces"][:, i]] for i in range(3))
        middle = mesh["vertices"].mean(axis=0)
        outward = np.sum(np.cross(b - a, c - a) * (a - middle), axis=1)
        self.assertGreater(outward.min(), 0.0)

    def test_few_instances_are_copies(self):
        for i in range(3):
            empty = moving_scenes.collection_instance(self.trees, f"Tree{i}", (i, 0.0, 0.0))
        blend.key(empty, "location", 1, (2.0, 0.0, 0.0))
        blend.key(empty, "location", 25, (4.0, 1.0, 0.0))
        blend.key(empty, "scale", 1, (1.0, 1.0, 1.0))
        blend.key(empty, "scale", 25, (1.0, 1.0, 3.0))
        self.export()
        self.assertEqual(len(self.described.all("copy")), 6)
        self.compare((1.0, 11.7, 25.0))

    def test_many_collection_instances(self):
        """Those that never move are placements; the others have key frames."""
        for i in range(20):
            empty = moving_scenes.collection_instance(self.trees, f"Tree{i}", (i, 0.1 * i * i, 0.0))
            empty.rotation_euler.z, empty.scale.z = 0.5 * i, 1.0 + 0.1 * i
        blend.key(empty, "location", 1, (2.0, 0.0, 0.0))
        blend.key(empty, "location", 25, (4.0, 1.0, 0.0))
        self.export()
        self.assertEqual(len(self.described.all("copies")), 2)
        self.assertEqual(len(self.described.all("copy")), 2)
        self.compare((1.0, 11.7, 25.0))

    def test_sheared_instances_hang_in_their_instancer(self):
        empty = moving_scenes.collection_instance(self.trees, "A", (0.0, 0.0, 0.0))
        empty.scale = (1.0, 2.0, 1.0)
        for thing in self.trees.objects:
            thing.rotation_euler.z = 0.5
            thing.rotation_euler.x = 0.3
        moving_scenes.collection_instance(self.trees, "B", (1.0, 0.0, 0.0))
        self.export()
        self.assertEqual(len(self.described.one("group").all("addKframe")), 1)
        self.compare()

    def test_one_instance_is_a_mesh(self):
        moving_scenes.collection_instance(self.trees, "Tree", (1.0, 0.0, 0.0))
        self.export()
        self.assertEqual(len(self.described.all("mesh")), 2)
        self.assertNotIn("hidden", self.text)

    def test_wind_moves_each_tree(self):
        """Many instances that move by themselves have key frames of their own."""
        moving_scenes.grove(self.trees, 2.0)
        for thing in self.trees.objects:
            thing.driver_add("rotation_euler", 1).driver.expression = "0.2 * sin(frame)"
        self.scene.frame_end = 3
        self.export()
        self.compare((1.0, 1.6, 2.75))

    def test_a_wanderer_in_a_still_forest(self):
        """What moves is read alone if the instances are at rest; what vanishes is listed all the same."""
        moving_scenes.grove(self.trees, 4.0)
        wanderer, ghost = blend.cube("Wanderer"), blend.cube("Ghost")
        blend.key(wanderer, "location", 1, (0.0, 0.0, 0.0))
        blend.key(wanderer, "location", 25, (4.0, 1.0, 0.0))
        blend.key(ghost, "hide_render", 1, False)
        blend.key(ghost, "hide_render", 13, True)
        ghost.hide_render = False
        ghost.shape_key_add(name="Basis")
        grown = ghost.shape_key_add(name="Grown")
        grown.data[0].co.x += 2.0
        for frame, value in ((1, 0.0), (25, 1.0)):
            grown.value = value
            grown.keyframe_insert("value", frame=frame)
        self.export()
        self.compare((1.0, 20.0))
        for frame in (1, 7, 25):
            self.scene.frame_set(frame)
            ours = scene_reader.matrix(
                self.described, self.described.one("mesh", "Wanderer"), frame / 24.0
            )
            self.assertLess(np.abs(ours - np.array(wanderer.matrix_world)).max(), 1e-3)
        self.assertIn('object "Ghost": appears or vanishes', self.text)

    def test_materials_in_one_thing(self):
        """What has several materials is a group, and copies show all of it."""
        crown = self.trees.objects["Crown"]
        for name in ("Light", "Dark"):
            crown.data.materials.append(bpy.data.materials.new(name))
        crown.data.polygons[0].material_index = 1
        moving_scenes.grove(self.trees, 4.0)
        self.export()
        group = self.described.one("group", "Crown")
        self.assertIn("hidden", group.values)
        parts = [e for e in self.described.all("mesh") if e.values.get("parent") == [["Crown"]]]
        self.assertEqual([part.values["material"][0][0] for part in parts], ["Light", "Dark"])
        self.compare()
