"""Look-alikes of the scenes of the thesis on hierarchies, as NFF. It gives numbers of objects and pictures, no places."""

import math
import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts/models"))
import spd  # noqa: E402


def spheric_cube():
    """3375 spheres that form a cube, 15 to each side, with gaps as wide as a sphere's radius."""
    scene = spd.Scene((2.4, 3.1, 2.2), (0.5, 0.5, 0.5), angle=18, lights=[(4, 3, 5), (-1, 5, 3)])
    scene.fill((0.9, 0.5, 0.3), 0.8)
    for cell in ((x, y, z) for x in range(15) for y in range(15) for z in range(15)):
        scene.sphere([(c + 0.5) / 15 for c in cell], 0.33 / 15)
    return scene


def one_object(whole):
    """A sphere. With `whole`, its box fills the picture."""
    scene = spd.Scene((0, 0, 4), (0, 0, 0), (0, 1, 0), angle=20 if whole else 27.9, lights=[(3, 4, 5), (-4, 2, 5)])
    scene.fill((0.9, 0.5, 0.3), 0.8)
    scene.sphere((0, 0, 0), 0.97)
    return scene


def cylinder_axes():
    """1313 cylinders: three bundles of long ones along the axes, and short ones around them, mirrors all."""
    scene = spd.Scene((3.2, 2.6, 4.1), (0, 0, 0), (0, 1, 0), angle=40, lights=[(6, 8, 3), (-5, 7, 6)])
    scene.fill((0.8, 0.8, 0.9), 0.6, 0.3, 40)
    numbers = random.Random(1313)
    for axis in range(3):
        along, u, v = ([float(axis == k) for k in range(3)] for axis in (axis, (axis + 1) % 3, (axis + 2) % 3))
        for row in range(21):
            for column in range(20 if axis else 21):
                a, b = (row - 10) / 6, (column - 10) / 6
                length = 0.08 + 0.3 * numbers.random()
                center = [a * u[k] + b * v[k] + 0.3 * (numbers.random() - 0.5) * along[k] for k in range(3)]
                scene.cone(spd.plus(center, along, -length), 0.03, spd.plus(center, along, length), 0.03)
    for _ in range(1313 - 21 * (21 + 20 + 20)):
        angle = 2 * math.pi * numbers.random()
        place = (2 * math.cos(angle), 2 * numbers.random() - 1, 2 * math.sin(angle))
        scene.cone(place, 0.05, spd.plus(place, (0, 0.5, 0)), 0.05)
    return scene


def cylinder_walls():
    """7500 cylinders: three walls of 50 by 50 that stand behind each other."""
    scene = spd.Scene((0.4, 1.2, 5.5), (0, 0, 0), (0, 1, 0), angle=38, lights=[(5, 6, 7), (-6, 4, 6)])
    scene.fill((0.7, 0.8, 0.6), 0.6, 0.3, 40)
    for wall in range(3):
        for row in range(50):
            for column in range(50):
                x, y = (column - 24.5) / 12 + 0.02 * wall, (row - 24.5) / 12
                scene.cone((x, y, -wall - 0.2), 0.03, (x, y, -wall + 0.2), 0.03)
    return scene


SCENES = {
    "sphericCube": spheric_cube,
    "box_a": lambda: one_object(False),
    "box_b": lambda: one_object(True),
    "cylAxes": cylinder_axes,
    "cylWalls": cylinder_walls,
}
