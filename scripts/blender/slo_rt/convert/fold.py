# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers and colours that nodes compute from constants."""

from .nodes import constant, follow, luma

# What a longer chain is worth is not asked.
_DEEPEST = 16

_MATH = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b if b else 0.0,
    "MINIMUM": min,
    "MAXIMUM": max,
}
_BLENDS = {
    "MIX": lambda _, b: b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "MULTIPLY": lambda a, b: a * b,
}
_CHANNELS = ("Red", "Green", "Blue")


def folded(feed, depth=_DEEPEST):
    """Returns the number or colour (three numbers) of a feed, or None if it is not constant."""
    found = constant(feed)
    node = feed.node
    if found is not None or node is None or depth == 0 or node.type not in _FOLDED:
        return found

    def of(name):
        return folded(follow(feed.input(name)), depth - 1)

    return _FOLDED[node.type](feed, of)


def _math(feed, of):
    node = feed.node
    function = _MATH.get(node.operation)
    if function is None:
        return None
    values = of("Value"), of("Value_001")
    if None in values:
        return None
    found = function(*map(_number, values))
    return min(max(found, 0.0), 1.0) if node.use_clamp else found


def _invert(_, of):
    share, color = of("Fac"), of("Color")
    if share is None or color is None:
        return None
    share = _number(share)
    return tuple(c + share * (1.0 - 2.0 * c) for c in _color(color))


def _mix(feed, of):
    node = feed.node
    kinds = {"FLOAT": "Float", "RGBA": "Color"}
    blend = _BLENDS.get(node.blend_type if node.data_type == "RGBA" else "MIX")
    if blend is None or node.data_type not in kinds:
        return None
    kind = kinds[node.data_type]
    share, first, second = of("Factor_Float"), of(f"A_{kind}"), of(f"B_{kind}")
    if None in (share, first, second):
        return None
    share = _number(share)
    if node.clamp_factor:
        share = min(max(share, 0.0), 1.0)
    both = zip(_color(first), _color(second))
    mixed = tuple(a + share * (blend(a, b) - a) for a, b in both)
    if node.data_type == "FLOAT":
        return _number(first) + share * (_number(second) - _number(first))
    return tuple(min(max(c, 0.0), 1.0) for c in mixed) if node.clamp_result else mixed


def _separate(feed, of):
    if feed.node.mode != "RGB" or feed.socket.name not in _CHANNELS:
        return None
    color = of("Color")
    return None if color is None else _color(color)[_CHANNELS.index(feed.socket.name)]


def _combine(feed, of):
    values = [of(name) for name in _CHANNELS] if feed.node.mode == "RGB" else [None]
    return None if None in values else tuple(map(_number, values))


_FOLDED = {
    "MATH": _math,
    "INVERT": _invert,
    "MIX": _mix,
    "SEPARATE_COLOR": _separate,
    "COMBINE_COLOR": _combine,
}


def _number(value):
    return luma(value) if isinstance(value, tuple) else value


def _color(value):
    return value if isinstance(value, tuple) else (value,) * 3
