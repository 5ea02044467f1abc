# SPDX-License-Identifier: GPL-3.0-or-later
"""Images that vary numbers, colours and normals of physical surfaces, and the image of a sky."""

import math
from dataclasses import dataclass

import bpy

from ..format.principled import ImageUse
from .nodes import constant, follow, luma
from .texture import coordinates, mapping_values, note_own_mapping

_WRAPS = {"REPEAT": "REPEAT", "MIRROR": "MIRROR", "EXTEND": "CLAMP", "CLIP": "CLAMP"}
_CHANNELS = {"Red": "R", "Green": "G", "Blue": "B"}
# Alpha modes of images whose colours Cycles never multiplies by alpha.
_LOOSE = {"NONE", "CHANNEL_PACKED"}


@dataclass(frozen=True)
class Sampled:
    """An image and how it is sampled.

    `uv_map` is the name of the uv map, "" for the render uv map. `has_alpha`: alpha stands beside
    colours; otherwise colours are multiplied by it, as in Cycles if nothing uses a node's alpha.
    """

    image: bpy.types.Image
    has_alpha: bool = False
    wrap: str = "REPEAT"
    filter: str = "LINEAR"
    uv_map: str = ""


@dataclass(frozen=True)
class _Mapping:
    scale: tuple = (1.0, 1.0)
    turn_deg: float = 0.0
    offset: tuple = (0.0, 0.0)


def image_behind(feed, reader):
    """Returns `(factor, ImageUse)` of a feed that is an image, one channel of it, or the product of
    one of these and a constant; None if it is something else. `factor` is a number or a colour."""
    node = feed.node
    if node is None:
        return None
    if node.type == "TEX_IMAGE":
        use = image_use(feed, reader)
        return use and (1.0, use)
    if node.type == "SEPARATE_COLOR" and node.mode == "RGB":
        behind = follow(feed.input("Color"))
        if behind.node is not None and behind.node.type == "TEX_IMAGE":
            if behind.socket.name == "Color" and feed.socket.name in _CHANNELS:
                use = image_use(behind, reader)
                return use and (1.0, _with_channel(use, _CHANNELS[feed.socket.name]))
        return None
    if _multiplies(feed):
        return _product(feed, reader)
    return None


def _multiplies(feed):
    node = feed.node
    if node.type == "MATH":
        return node.operation == "MULTIPLY" and not node.use_clamp
    if node.type == "MIX" and node.data_type == "RGBA" and node.blend_type == "MULTIPLY":
        return constant(follow(feed.input("Factor_Float"))) == 1.0 and not node.clamp_result
    return False


def _product(feed, reader):
    """Returns `(factor, ImageUse)` of the product of an image and a constant, or None."""
    names = ("Value", "Value_001") if feed.node.type == "MATH" else ("A_Color", "B_Color")
    first, second = (follow(feed.input(name)) for name in names)
    if constant(first) is not None:
        first, second = second, first
    factor = constant(second)
    found = image_behind(first, reader) if factor is not None else None
    if found is None:
        return None
    own, use = found
    if feed.node.type == "MATH":
        return _number(own) * _number(factor), use
    both = zip(_color(own), _color(factor))
    return tuple(a * b for a, b in both), use


def _number(value):
    return luma(value) if isinstance(value, tuple) else value


def _color(value):
    return value if isinstance(value, tuple) else (value,) * 3


def _with_channel(use, channel):
    return ImageUse(use.texture, channel, use.scale, use.turn_deg, use.offset)


def image_use(feed, reader):
    """Returns the `ImageUse` of an image texture node, or None if it has no image to read."""
    node = feed.node
    if not is_readable(node.image, reader):
        return None
    reader.note_rest(feed)
    note_own_mapping(node, reader)
    mapping, uv_map = coordinates(feed.input("Vector"), reader, _mapping, _Mapping())
    is_alpha = feed.socket.name == "Alpha"
    sampled = Sampled(
        image=node.image,
        has_alpha=_keeps_alpha(node),
        wrap=_WRAPS.get(node.extension, "REPEAT"),
        filter="NEAREST" if node.interpolation == "Closest" else "LINEAR",
        uv_map=uv_map,
    )
    return ImageUse(
        sampled, "A" if is_alpha else "", mapping.scale, mapping.turn_deg, mapping.offset
    )


def is_readable(image, reader):
    """Whether an image has pixels; otherwise notes that it has none."""
    if image is None:
        return False
    if image.size[0] > 0 and image.size[1] > 0:
        return True
    reader.report.note(f'image "{image.name}"', "can't be read; its surface has no texture")
    return False


def _keeps_alpha(node):
    """Whether alpha stands beside the colours of an image texture node."""
    image = node.image
    if image.channels != 4 or image.alpha_mode == "NONE":
        return False
    return any(not link.is_muted for link in node.outputs["Alpha"].links)


def multiplies_alpha(image):
    """Whether Cycles multiplies the colours of an image by its alpha if nothing uses its alpha."""
    has_alpha = image.channels == 4 and image.alpha_mode not in _LOOSE
    return has_alpha and not image.colorspace_settings.is_data


def _mapping(feed, reader):
    """Returns the `_Mapping` of a Mapping node in front of an image."""
    location, rotation, scale = mapping_values(feed, reader)
    kind = feed.node.vector_type
    if kind == "NORMAL":
        reader.note("a texture's mapping of type Normal is not carried")
        return _Mapping()
    if rotation[0] or rotation[1]:
        reader.note("of a texture's mapping only the rotation about z is carried")
    turn, scale = rotation[2], scale[:2]
    if kind == "VECTOR":
        return _Mapping(scale, math.degrees(turn))
    if kind == "POINT":
        return _Mapping(scale, math.degrees(turn), location[:2])
    if turn and scale[0] != scale[1]:
        reader.note("a texture's mapping of type Texture that turns and stretches is not carried")
        return _Mapping()
    # The inverse of scaling, turning and moving.
    inverse = tuple(1.0 / each if each else 0.0 for each in scale)
    x, y = location[:2]
    turned = (math.cos(turn) * x + math.sin(turn) * y, math.cos(turn) * y - math.sin(turn) * x)
    offset = tuple(-a * b for a, b in zip(turned, inverse))
    return _Mapping(inverse, math.degrees(-turn), offset)
