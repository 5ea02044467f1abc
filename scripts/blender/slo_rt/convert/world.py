# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts the world to one background colour."""

from .. import compat
from .checks import finite
from .emission import emitted
from .flags import note_flags
from .nodes import Feed, Reader, follow, output_node

BLACK = (0.0, 0.0, 0.0)


def background(world, report):
    """Returns the linear colour of the background, and notes a background that is not one colour.

    # Errors `ValueError` if it is not finite.
    """
    if world is None:
        return BLACK
    subject = f'world "{world.name}"'
    _note_rays(world, subject, report)
    note_flags(getattr(world, "cycles", None), "CyclesWorldSettings", subject, report)
    return finite(_color(world, subject, report), subject, "its colour")


def _color(world, subject, report):
    tree = compat.node_tree(world)
    if tree is None:
        return tuple(world.color)
    output = output_node(tree)
    if output is None:
        return BLACK
    reader = Reader(subject, report)
    reader.note_rest(Feed(output))
    return reader.light(emitted(follow(Feed(output).input("Surface")), reader))


def _note_rays(world, subject, report):
    """Notes kinds of rays for which Cycles hides the world; in slo-rt all rays see it."""
    rays = getattr(world, "cycles_visibility", None)
    names = ("camera", "diffuse", "glossy", "transmission")
    hidden = [name for name in names if not getattr(rays, name, True)]
    if hidden:
        report.note(subject, f"hidden from {', '.join(hidden)} rays in Blender, not in slo-rt")
