# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights.

In Blender light falls off with distance, in slo-rt it does not. An exported light is as bright as
Blender's light at one distance: the distance that the artist set, or, if it is 0, the distance to
the middle of the scene, but at least the median distance to the surfaces of things, since a bulb in
the middle of a room lights its walls.

A white surface that faces a lamp of P watts at distance d has, in Blender, the radiance P / (4 pi^2
d^2) for a point, P / (pi^2 d^2) for a small area that faces it, and E / pi for a sun of E watts per
square metre; slo-rt gives it the light's colour.
"""

import math

import numpy as np

from .. import compat
from ..format.scene_text import Element
from .emission import emitted
from .flags import note_flags
from .nodes import Feed, Reader, follow, output_node

SUN_DISTANCE = 200.0  # in diagonals of the scene


def elements_of_light(name, light, matrix, surroundings, report):
    """Returns the elements of one light; none, and a note, if slo-rt has no such light.

    `matrix` (4, 4) transforms to world space; `surroundings` (`Surroundings`) describes the scene.
    """
    center, diagonal = surroundings.center, surroundings.diagonal
    subject = f'light "{light.name}"'
    position, axes = matrix[:3, 3], matrix[:3, :3]
    toward = -axes[:, 2] / max(np.linalg.norm(axes[:, 2]), 1e-30)
    distance = light.slo_rt.distance or surroundings.distance(position)
    power, color = compat.light_strength(light)
    power *= light.slo_rt.brightness
    reader = Reader(subject, report)
    color = reader.light(tuple(c * n * power for c, n in zip(color, light_of_nodes(light, reader))))
    if getattr(getattr(light, "cycles", None), "is_portal", False) and light.type == "AREA":
        report.note(subject, "portals are not carried: they give no light of their own")
        return []
    _note_limits(light, subject, report)

    if light.type == "POINT":
        if light.shadow_soft_size > 0.0:
            report.note(subject, "a point in slo-rt: its radius is not carried, shadows are sharp")
        return [_point(name, color, 1.0 / (4.0 * math.pi**2 * distance**2), position)]
    if light.type == "SUN":
        if light.angle > 0.0:
            report.note(subject, "a sun without size in slo-rt: shadows are sharp")
        far = center - toward * SUN_DISTANCE * max(diagonal, 1.0)
        return [_point(name, color, 1.0 / math.pi, far)]
    if light.type == "AREA":
        brightness = 1.0 / (math.pi**2 * distance**2)
        return [_rectangle(name, light, color, brightness, matrix, subject, report)]
    report.note(subject, f"{light.type.lower()} lights are not carried")
    return []


def _point(name, color, brightness, position):
    rgb = tuple(c * brightness for c in color)
    return Element("light_point", name, [("color", rgb), ("position", tuple(position))])


def _rectangle(name, light, color, brightness, matrix, subject, report):
    width = light.size
    height = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    if light.shape in {"DISK", "ELLIPSE"}:
        report.note(subject, "a round area light becomes a rectangle of the same area")
        width, height = (side * math.sqrt(math.pi) / 2.0 for side in (width, height))
    report.note(subject, "area lights shine from both sides in slo-rt, and are visible")
    corners = [(-1, -1), (1, -1), (1, 1)]
    body = [("color", tuple(c * brightness for c in color))]
    for i, (x, y) in enumerate(corners):
        corner = matrix @ np.array([x * width / 2.0, y * height / 2.0, 0.0, 1.0])
        body.append((f"vertex{i}", tuple(corner[:3])))
    if abs(np.dot(matrix[:3, 0], matrix[:3, 1])) > 1e-4 * np.linalg.norm(
        matrix[:3, 0]
    ) * np.linalg.norm(matrix[:3, 1]):
        report.note(subject, "skewed in Blender; slo-rt's corners have right angles")
    return Element("light_rectangle", name, body)


def light_of_nodes(light, reader):
    """Returns the factor by which the nodes of a light multiply its own light: three numbers."""
    tree = compat.node_tree(light)
    if tree is None:
        return (1.0, 1.0, 1.0)
    output = output_node(tree)
    if output is None:
        return (0.0, 0.0, 0.0)
    reader.note_rest(Feed(output))
    return emitted(follow(Feed(output).input("Surface")), reader)


def _note_limits(light, subject, report):
    note_flags(light, "Light", subject, report)
    note_flags(getattr(light, "cycles", None), "CyclesLightSettings", subject, report)
    if not getattr(light, "use_shadow", True):
        report.note(subject, "throws shadows in slo-rt")
    if not getattr(light, "normalize", True):
        report.note(subject, "its power is taken as watts, whatever its size")
    if light.type == "AREA" and light.spread < math.pi - 1e-4:
        report.note(subject, "shines in all directions, whatever its spread")
