# SPDX-License-Identifier: GPL-3.0-or-later
"""Brightness of lights at the walls of a room, wherever in the room they hang."""

import math
import unittest

import bpy

from .. import scene_reader
from . import blend

POWER = 100.0


class BrightnessTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()

    def distance(self, thing):
        """Returns the distance in metres at which the exported light is as bright as Blender's."""
        scene = scene_reader.read(blend.export_text(animation=False))
        kind = "light_point" if thing.data.type == "POINT" else "light_rectangle"
        color = scene.one(kind).vector("color")[0]
        factor = 4.0 if thing.data.type == "POINT" else 1.0
        return math.sqrt(thing.data.energy / (factor * math.pi**2 * color))

    def wall(self, size, location, rotation=(0.0, 0.0, 0.0)):
        bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=rotation)

    def room(self, size, is_one_mesh):
        """A room around the point (0, 0, 1)."""
        if is_one_mesh:
            blend.cube("Room", size).location.z = 1.0
            return
        half, right = size / 2.0, math.pi / 2.0
        for place, turn in (
            ((0, 0, 1 - half), (0, 0, 0)), ((0, 0, 1 + half), (0, 0, 0)),
            ((half, 0, 1), (0, right, 0)), ((-half, 0, 1), (0, right, 0)),
            ((0, half, 1), (right, 0, 0)), ((0, -half, 1), (right, 0, 0)),
        ):  # fmt: skip
            self.wall(size, place, turn)

    def test_bulbs_in_rooms(self):
        for is_one_mesh in (True, False):
            for kind in ("POINT", "AREA"):
                for place in (
                    (0.0, 0.0, 1.0),
                    (0.01, 0.0, 1.02),
                    (0.0, 0.0, 3.6),
                    (1.5, -1.0, 2.0),
                ):
                    self.setUp()
                    self.room(6.0, is_one_mesh)
                    light = blend.lamp("Bulb", kind, place, POWER)
                    found = self.distance(light)
                    self.assertGreater(found, 3.0 / math.sqrt(8.0), (is_one_mesh, kind, place))
                    self.assertLess(found, 3.0 * math.sqrt(8.0), (is_one_mesh, kind, place))

    def test_a_fixture_does_not_count(self):
        self.room(6.0, True)
        for i in range(5):
            blend.cube(f"Part {i}", 0.1).location = (0.02 * i, 0.0, 1.03)
        self.assertGreater(self.distance(blend.lamp("Bulb", "POINT", (0.0, 0.0, 1.0), POWER)), 1.5)

    def test_a_light_outside_counts_to_the_middle(self):
        blend.cube("A").location = (1.0, 0.0, 0.0)
        blend.cube("B").location = (-1.0, 0.0, 0.0)
        light = blend.lamp("Lamp", "POINT", (0.0, -6.0, 8.0), POWER)
        self.assertAlmostEqual(self.distance(light), 10.0, places=4)

    def test_a_wide_floor_is_no_room(self):
        self.wall(1000.0, (0.0, 0.0, -1.0))
        blend.cube()
        light = blend.lamp("Lamp", "POINT", (3.0, -4.0, 2.0), POWER)
        self.assertLess(self.distance(light), 6.0)

    def test_the_artist_s_distance_counts_first(self):
        self.room(6.0, True)
        light = blend.lamp("Bulb", "POINT", (0.0, 0.0, 1.0), POWER)
        light.data.slo_rt.distance = 0.5
        self.assertAlmostEqual(self.distance(light), 0.5, places=5)

    def test_a_light_alone(self):
        for place in ((0.0, 0.0, 0.0), (0.0, 0.0, 5.0)):
            self.setUp()
            self.assertGreater(self.distance(blend.lamp("Lamp", "POINT", place, POWER)), 0.0)
