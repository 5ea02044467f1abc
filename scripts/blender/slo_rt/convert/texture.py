# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures: the image, its channels, and its position on a surface."""

from dataclasses import dataclass

import bpy

from .. import compat
from .node_table import PLAIN_TEXTURE_MAPPING
from .nodes import follow


@dataclass(frozen=True)
class Texture:
    """An image on the base colour, repeated `scale` times over one unit of uv coordinates.

    `uv_map` is the name of the uv map, "" for the render uv map. `is_alpha`: the image's alpha as
    grey is used instead of its colours.
    """

    image: bpy.types.Image
    scale: tuple = (1.0, 1.0)
    uv_map: str = ""
    is_alpha: bool = False


def read_texture(feed, reader):
    """Returns the `Texture` of an image texture node; `reader` (`nodes.Reader`) notes what is lost."""
    node = feed.node
    reader.note_rest(feed)
    note_own_mapping(node, reader)
    scale, uv_map = coordinates(feed.input("Vector"), reader, _mapping_scale, (1.0, 1.0))
    return Texture(node.image, scale, uv_map, feed.socket.name == "Alpha")


def note_own_mapping(node, reader):
    """Notes the mapping that an image texture node itself has."""
    mapping = node.texture_mapping
    if any(_plain(getattr(mapping, name)) != v for name, v in PLAIN_TEXTURE_MAPPING.items()):
        reader.note("the texture mapping of an Image Texture is not carried; use a Mapping node")


def coordinates(input_, reader, read_mapping, mapping):
    """Returns `(mapping, uv map)` of texture coordinates: what `read_mapping(feed, reader)` finds in a
    Mapping node, or `mapping` without one."""
    feed = follow(input_)
    if feed.node is not None and feed.node.type == "MAPPING":
        mapping = read_mapping(feed, reader)
        behind = follow(feed.input("Vector"))
        if behind.node is None:
            reader.note(
                "a Mapping without coordinates is one point of the image; here the uv map is"
            )
            return mapping, ""
        feed = behind
    node = feed.node
    if node is None:
        # Only the image's own socket means the uv map if nothing is linked.
        if feed.own not in {None, input_.socket} and not compat.ENDLESS_CHAINS_ARE_ZERO:
            reader.note("a vector as coordinates is one point of the image; here the uv map is")
        return mapping, ""
    if node.type in reader.table.entries:
        reader.note_rest(feed)
    is_uv = node.type == "UVMAP" or (node.type == "TEX_COORD" and feed.socket.name == "UV")
    if not is_uv:
        reader.note(
            f"{node.bl_label} ({feed.socket.name}) as texture coordinates is not carried, the uv map is"
        )
        return mapping, ""
    if node.from_instancer:
        reader.note("texture coordinates of the instancer are not carried, the uv map is")
    return mapping, node.uv_map if node.type == "UVMAP" else ""


def _mapping_scale(feed, reader):
    location, rotation, scale = mapping_values(feed, reader)
    kind = feed.node.vector_type
    if any(location) or any(rotation) or kind == "NORMAL":
        reader.note("of a texture's mapping only the scale is carried")
    if kind == "TEXTURE":
        scale = tuple(1.0 / s if s else 0.0 for s in scale)
    return tuple(scale[:2])


def mapping_values(feed, reader):
    """Returns location, rotation and scale of a Mapping node."""
    reader.note_rest(feed)
    return tuple(
        reader.color(i) if (i := feed.input(name)) else otherwise
        for name, otherwise in (
            ("Location", (0.0,) * 3),
            ("Rotation", (0.0,) * 3),
            ("Scale", (1.0,) * 3),
        )
    )


def _plain(value):
    """Returns a property's value as a number, word or tuple."""
    return value if isinstance(value, str) or not hasattr(value, "__len__") else tuple(value)
