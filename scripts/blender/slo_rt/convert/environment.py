# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts the world to an environment: light from all around, one colour or an image."""

import math

from .. import compat
from ..format.names import plain
from ..format.scene_text import Element
from .checks import finite
from .emission import emitted
from .flags import note_flags
from .image_use import Sampled, is_readable
from .nodes import Feed, follow, nearest, output_node
from .physical import PhysicalReader
from .texture import mapping_values, note_own_mapping

# Coordinates of the texture node of a world that are the direction of view.
_DIRECTIONS = {("TEX_COORD", "Generated"), ("TEX_COORD", "Object"), ("NEW_GEOMETRY", "Position")}


def environment_elements(world, texture_of, report):
    """Returns the elements of a world, none for a black one.

    `texture_of(sampled, elements)` adds the element of an image and returns its name.

    # Errors `ValueError` if a number is not finite.
    """
    if world is None:
        return []
    subject = f'world "{world.name}"'
    note_flags(getattr(world, "cycles", None), "CyclesWorldSettings", subject, report)
    elements = []
    reader = _WorldReader(subject, report)
    body = reader.sky(world, lambda sampled: texture_of(sampled, elements))
    if not body:
        return []
    rays = getattr(world, "cycles_visibility", None)
    if not getattr(rays, "camera", True):
        body.append(("camera_visible", 0))
    hidden = [n for n in ("diffuse", "glossy", "transmission") if not getattr(rays, n, True)]
    if hidden:
        report.note(subject, f"hidden from {', '.join(hidden)} rays in Blender, not in slo-rt")
    if world.lightgroup:
        body.append(("light_group", plain(world.lightgroup)))
    return [*elements, Element("environment", plain(world.name), body)]


class _WorldReader(PhysicalReader):
    """Reads the node tree of a world."""

    def sky(self, world, name_of):
        """Returns the attributes of what the world shows; none if it is black."""
        tree = compat.node_tree(world)
        if tree is None:
            return self._even(tuple(world.color))
        output = output_node(tree)
        if output is None:
            return []
        self.note_rest(Feed(output))
        surface = self._chosen(follow(Feed(output).input("Surface")))
        return self._image(surface, name_of) or self._even(emitted(surface, self))

    def _chosen(self, feed):
        """Returns the first shader of mixes whose factor is not constant, such as one by kind of ray."""
        while feed.node is not None and feed.node.type == "MIX_SHADER":
            if self.constant(follow(feed.input("Fac"))) is not None:
                break
            self.note(f"{feed.node.bl_label} is not carried, its first shader is")
            feed = next(follow(i) for i in feed.inputs() if i.socket.type == "SHADER")
        return feed

    def _even(self, color):
        color = finite(self.light(color), self.subject, "its colour")
        return [("radiance", color)] if any(color) else []

    def _image(self, feed, name_of):
        """Returns the attributes of a Background with an Environment Texture; None if it is another
        shader."""
        if feed.node is None or feed.node.type not in {"BACKGROUND", "EMISSION"}:
            return None
        chain = follow(feed.input("Color"))
        behind = nearest(chain, "TEX_ENVIRONMENT")
        if behind is None or not is_readable(behind.node.image, self):
            return None
        node = behind.node
        if node != chain.node:
            self.note_feed(chain, feed.input("Color"), "the image behind it is")
        self.note_rest(feed)
        self.note_rest(behind)
        note_own_mapping(node, self)
        strength = self.light((self.value(feed.input("Strength"), 1.0),))[0]
        turn = self._turn(behind.input("Vector"))
        filter_ = "NEAREST" if node.interpolation == "Closest" else "LINEAR"
        body = [("texture", name_of(Sampled(node.image, filter=filter_)))]
        if strength != 1.0:
            body.append(("strength", finite(strength, self.subject, "its strength")))
        if turn != 0.0:
            body.append(("turn_deg", turn))
        return body

    def _turn(self, input_):
        """Returns by how many degrees the sky turns from +x toward +y."""
        feed = follow(input_)
        turn = 0.0
        if feed.node is not None and feed.node.type == "MAPPING":
            turn = self._mapping(feed)
            feed = follow(feed.input("Vector"))
            if feed.node is None:
                self.note("a Mapping without coordinates is one point of the image; the sky is all")
        if feed.node is None:
            return turn
        if (feed.node.type, feed.socket.name) not in _DIRECTIONS:
            self.note(
                f"{feed.node.bl_label} ({feed.socket.name}) as coordinates of the sky is not carried, "
                "the direction is"
            )
        elif getattr(feed.node, "object", None):
            self.note("coordinates of an object are not carried for the sky, the direction is")
        return turn

    def _mapping(self, feed):
        location, rotation, scale = mapping_values(feed, self)
        kind = feed.node.vector_type
        is_plain = scale[0] == scale[1] == scale[2] and scale[0] > 0.0
        moves = any(location) and kind in {"POINT", "TEXTURE"}
        if rotation[0] or rotation[1] or moves or not is_plain:
            self.note("of the sky's mapping only the rotation about z is carried")
        # The vector that is looked up turns, so the sky turns the other way.
        return math.degrees(rotation[2] if kind == "TEXTURE" else -rotation[2])
