# SPDX-License-Identifier: GPL-3.0-or-later
"""The world becomes one background colour."""

from .. import compat


def background(world, report):
    """Linear colour of the background; what is not one colour is noted."""
    if world is None:
        return (0.0, 0.0, 0.0)
    subject = f'world "{world.name}"'
    tree = compat.node_tree(world)
    if tree is None:
        return tuple(world.color)
    output = tree.get_output_node("ALL")
    if output is None or not output.inputs["Surface"].is_linked:
        return (0.0, 0.0, 0.0)
    if output.inputs["Volume"].is_linked:
        report.note(subject, "volumes are not carried")
    shader = output.inputs["Surface"].links[0].from_node
    if shader.type != "BACKGROUND":
        report.note(subject, f"{shader.bl_label}: not carried, the background is black")
        return (0.0, 0.0, 0.0)
    for socket in (shader.inputs["Color"], shader.inputs["Strength"]):
        if socket.is_linked:
            report.note(
                subject, f"what is linked to {socket.name} is not carried, its own value is"
            )
    strength = shader.inputs["Strength"].default_value
    return tuple(c * strength for c in shader.inputs["Color"].default_value[:3])
