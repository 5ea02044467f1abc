# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the light of the shaders of worlds and lights: one colour."""

from .nodes import follow, luma

BLACK = (0.0, 0.0, 0.0)
_SHINING = {"BACKGROUND", "EMISSION"}


def emitted(feed, reader):
    """Returns the light of a `Feed` of a shader socket; `reader` (`nodes.Reader`) notes what cannot
    be read."""
    node = feed.node
    if node is None:
        return BLACK
    if node.type in _SHINING:
        reader.note_rest(feed)
        color, strength = reader.color(feed.input("Color")), reader.value(feed.input("Strength"))
        return tuple(c * strength for c in color)
    shaders = [i for i in feed.inputs() if i.socket.type == "SHADER"]
    if node.type == "ADD_SHADER":
        return _sum((1.0, emitted(follow(i), reader)) for i in shaders)
    if node.type == "MIX_SHADER":
        factor = reader.constant(follow(feed.input("Fac")))
        if factor is not None:
            factor = min(max(luma(factor) if isinstance(factor, tuple) else factor, 0.0), 1.0)
            parts = [(w, i) for w, i in zip((1.0 - factor, factor), shaders) if w > 0.0]
            return _sum((weight, emitted(follow(i), reader)) for weight, i in parts)
        reader.note(f"{node.bl_label} is not carried, the first shader that shines is")
        for input_ in shaders:
            behind = follow(input_)
            if behind.node is not None and behind.node.type in _SHINING:
                return emitted(behind, reader)
        return BLACK
    reader.note(f"{node.bl_label} is not carried: it is black")
    return BLACK


def _sum(parts):
    total = BLACK
    for weight, color in parts:
        total = tuple(a + weight * b for a, b in zip(total, color))
    return total
