# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps with Blender's units: watts, and watts per square metre for the sun.

A lamp that shines all round with P watts has the intensity P / (4 pi). An area of A square metres has
the radiance P / (pi A). A spot is a lamp that shines all round with a screen around it, so less than
P leaves it.
"""

import math

import numpy as np

from .. import compat
from ..format.scene_text import Element
from .flags import note_flags
from .light import light_of_nodes
from .physical import PhysicalReader

# Scales along two axes count as equal if they differ by less than this fraction.
_EVEN = 1e-4
_SMALLEST_ANGLE = 1e-3  # of a spot, in degrees


def lamp_element(name, lamp, light, matrix, keys, report):
    """Returns the element of a lamp, or None and a note if slo-rt has no such lamp.

    `matrix` (4, 4) transforms to the lamp's space, in which `keys`, its key frames, move it; to world
    space without key frames. `lamp` (`things.Lamp`) says who sees it, `light` is its data.
    """
    subject = f'light "{light.name}"'
    if getattr(getattr(light, "cycles", None), "is_portal", False) and light.type == "AREA":
        report.note(subject, "portals are not carried: they give no light of their own")
        return None
    strength, color = compat.light_strength(light)
    strength *= light.slo_rt.brightness
    reader = PhysicalReader(subject, report)
    nodes = light_of_nodes(light, reader)
    color = reader.light(tuple(c * n * strength for c, n in zip(color, nodes)))
    _note_limits(light, subject, report)
    kind, body, has_size = _KINDS[light.type](light, color, matrix, _Notes(subject, report))
    if has_size:
        body += [] if lamp.camera_visible else [("camera_visible", 0)]
        body += [] if light.type == "SUN" else [("solid", 0)]
    if lamp.group:
        body.append(("light_group", lamp.group))
    return Element(kind, name, [*body, *keys])


class _Notes:
    def __init__(self, subject, report):
        self._subject = subject
        self._report = report

    def __call__(self, message):
        self._report.note(self._subject, message)


def _times(color, factor):
    return tuple(c * factor for c in color)


def _point(light, color, matrix, note):
    radius = light.shadow_soft_size
    body = [("power", _times(color, _power_factor(light))), ("position", tuple(matrix[:3, 3]))]
    body += _radius(light, note)
    return "lamp_point", body, radius > 0.0


def _spot(light, color, matrix, note):
    axes = matrix[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    if abs(lengths[0] - lengths[1]) > _EVEN * lengths[:2].max():
        note("its cone is round, whatever its scale")
    half = min(light.spot_size / 2.0, math.pi / 2.0)
    # The cone is that of a lamp without a scale.
    across = math.sqrt(lengths[0] * lengths[1]) / lengths[2]
    if abs(across - 1.0) > _EVEN:
        half = math.atan2(across * math.sin(half), math.cos(half))
    share = (1.0 - math.cos(half)) / 2.0
    position = matrix[:3, 3]
    body = [
        ("power", _times(color, _power_factor(light) * share)),
        ("position", tuple(position)),
        ("target", tuple(position - axes[:, 2] / lengths[2])),
        ("angle_deg", max(math.degrees(2.0 * half), _SMALLEST_ANGLE)),
        ("blend", light.spot_blend),
    ]
    body += _radius(light, note)
    return "lamp_spot", body, light.shadow_soft_size > 0.0


def _power_factor(light):
    """Returns the watts of all directions that one unit of a light's power is."""
    if getattr(light, "normalize", True):
        return 1.0
    # One unit is the intensity 1 / pi, or this radiance if the lamp has a size.
    radius = light.shadow_soft_size
    return 4.0 * math.pi * radius**2 if radius > 0.0 else 4.0


def _radius(light, note):
    if light.shadow_soft_size <= 0.0:
        return []
    if getattr(light, "use_soft_falloff", False):
        note("a glowing sphere in slo-rt: its soft falloff, darker near the lamp, is not carried")
    return [("radius", light.shadow_soft_size)]


def _sun(light, color, matrix, note):
    del note
    angle = min(light.angle, math.pi)
    area = math.pi * math.sin(angle / 2.0) ** 2
    if not getattr(light, "normalize", True) and angle > 0.0:
        color = _times(color, area)
    axis = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    body = [("irradiance", color), ("direction", tuple(-axis)), ("angle_deg", math.degrees(angle))]
    return "lamp_sun", body, angle > 0.0


def _area(light, color, matrix, note):
    if light.spread < math.pi - 1e-4:
        note("shines in all directions, whatever its spread")
    is_even = light.shape in {"SQUARE", "DISK"}
    axes = matrix[:3, :2] * (light.size, light.size if is_even else light.size_y)
    sides = np.linalg.norm(axes, axis=0)
    if abs(np.dot(axes[:, 0], axes[:, 1])) > _EVEN * sides.prod():
        note("skewed in Blender; slo-rt's corners have right angles")
    normal = np.cross(axes[:, 0], axes[:, 1])
    is_turned = np.dot(normal, matrix[:3, 2]) > 0.0  # it shines against its z axis
    center = matrix[:3, 3]
    is_round = light.shape in {"DISK", "ELLIPSE"}
    area = sides.prod() * (math.pi / 4.0 if is_round else 1.0)
    strength = ("power", color)
    if not getattr(light, "normalize", True):
        strength = ("power", _times(color, area))
    if is_round:
        if abs(sides[0] - sides[1]) > _EVEN * sides.max():
            note("an ellipse becomes a disc of the same area")
        normal = normal * (-1.0 if is_turned else 1.0) / np.linalg.norm(normal)
        body = [("center", tuple(center)), ("normal", tuple(normal))]
        body.append(("radius", math.sqrt(sides.prod()) / 2.0))
        return "lamp_disc", [strength, *body], True
    corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5)]
    if is_turned:
        corners = [(y, x) for x, y in corners]
    body = [
        (f"vertex{i}", tuple(center + axes @ np.array(corner))) for i, corner in enumerate(corners)
    ]
    return "lamp_rectangle", [strength, *body], True


_KINDS = {"POINT": _point, "SPOT": _spot, "SUN": _sun, "AREA": _area}


def size_of(light, matrix):
    """Returns the size of a lamp, in metres, which its motion's precision depends on."""
    if light.type == "AREA":
        sides = light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
        return float((np.linalg.norm(matrix[:3, :2], axis=0) * sides).max())
    return float(getattr(light, "shadow_soft_size", 0.0))


def _note_limits(light, subject, report):
    note_flags(light, "Light", subject, report)
    note_flags(getattr(light, "cycles", None), "CyclesLightSettings", subject, report)
    if not getattr(light, "use_shadow", True):
        report.note(subject, "throws shadows in slo-rt")
