# SPDX-License-Identifier: GPL-3.0-or-later
"""The world becomes one background colour."""

from .. import compat
from .checks import finite


BLACK = (0.0, 0.0, 0.0)


def background(world, report):
    """Linear colour of the background; what is not one colour is noted.

    # Errors `ValueError` where it is not finite.
    """
    if world is None:
        return BLACK
    subject = f'world "{world.name}"'
    _note_rays(world, subject, report)
    return finite(_color(world, subject, report), subject, "its colour")


def _color(world, subject, report):
    tree = compat.node_tree(world)
    if tree is None:
        return tuple(world.color)
    output = tree.get_output_node("ALL")
    if output is None or not output.inputs["Surface"].is_linked:
        return BLACK
    if output.inputs["Volume"].is_linked:
        report.note(subject, "volumes are not carried")
    shader = output.inputs["Surface"].links[0].from_node
    if shader.type != "BACKGROUND":
        report.note(subject, f"{shader.bl_label}: not carried, the background is black")
        return BLACK
    for socket in (shader.inputs["Color"], shader.inputs["Strength"]):
        if socket.is_linked:
            report.note(
                subject, f"what is linked to {socket.name} is not carried, its own value is"
            )
    strength = shader.inputs["Strength"].default_value
    return tuple(c * strength for c in shader.inputs["Color"].default_value[:3])


def _note_rays(world, subject, report):
    """Notes rays for which Cycles has no world; slo-rt has it for all."""
    rays = getattr(world, "cycles_visibility", None)
    names = ("camera", "diffuse", "glossy", "transmission")
    hidden = [name for name in names if not getattr(rays, name, True)]
    if hidden:
        report.note(subject, f"hidden from {', '.join(hidden)} rays in Blender, not in slo-rt")
