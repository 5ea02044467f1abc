# SPDX-License-Identifier: GPL-3.0-or-later
"""Differences between Blender 4.2 and 5.x."""

import bpy


def fcurves(animation_data):
    """Returns all F-curves that act on the owner of `animation_data`, without drivers.

    Blender 4.4 divided actions into layers, strips and channel bags, one bag for each slot; Blender
    5.0 took `Action.fcurves` away.
    """
    action = animation_data.action if animation_data else None
    if action is None:
        return []
    slot = getattr(animation_data, "action_slot", None)
    if slot is None:
        return list(getattr(action, "fcurves", ()))
    bags = [
        strip.channelbag(slot)
        for layer in action.layers
        for strip in layer.strips
        if strip.type == "KEYFRAME"
    ]
    return [curve for bag in bags if bag for curve in bag.fcurves]


def is_animated(owner):
    """Whether F-curves, strips of the nonlinear animation or drivers act on `owner`."""
    animation = owner.animation_data
    strips = animation and any(track.strips for track in animation.nla_tracks)
    return bool(animation and (strips or fcurves(animation) or animation.drivers))


def node_tree(owner):
    """Returns the node tree of a material, world or light if it is used, or None.

    `use_nodes` of materials and worlds is always on, and deprecated, in Blender 5.0.
    """
    has_switch = bpy.app.version < (5, 0, 0) or isinstance(owner, bpy.types.Light)
    if has_switch and not owner.use_nodes:
        return None
    return owner.node_tree


def light_strength(light):
    """Returns the power of a light in watts (sun: watts per square metre), and its linear colour.

    Exposure and temperature came with Blender 4.5.
    """
    power = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    color = tuple(light.color)
    if getattr(light, "use_temperature", False):
        color = tuple(a * b for a, b in zip(color, light.temperature_color))
    return power, color


def compositing_nodes(scene):
    """Returns the nodes of the compositor; none if it is off."""
    if bpy.app.version < (5, 0, 0):
        tree = scene.node_tree if scene.use_nodes else None
    else:
        tree = scene.compositing_node_group
    return list(tree.nodes) if tree else []


def strips(scene):
    """Returns the strips of the video sequencer, called sequences before Blender 4.4."""
    editor = scene.sequence_editor
    return (
        list(getattr(editor, "strips", None) or getattr(editor, "sequences", ())) if editor else []
    )


# Blender 5.0 resolves reroutes, muted nodes and groups itself before Cycles sees them. If a chain of
# links has no source, the socket keeps its own value (0 in earlier versions), and muting an output
# node has no effect.
ENDLESS_CHAINS_ARE_ZERO = bpy.app.version < (5, 0, 0)
MUTED_OUTPUTS_ARE_NONE = bpy.app.version < (5, 0, 0)
