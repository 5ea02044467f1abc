# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts the surface shader of a material's node tree to a physical surface."""

import math

from .. import compat
from ..format.principled import (
    BLACK,
    DEFAULTS,
    DULL,
    INVISIBLE,
    WHITE,
    Mix,
    Principled,
    Value,
    glowing,
    matt,
    metal_of_conductor,
    seen_through,
    tint_of_even_metal,
)
from .flags import note_flags
from .fold import folded
from .image_use import image_behind
from .nodes import Feed, Reader, follow, luma, nearest, output_node
from .node_table import PHYSICAL

_TRANSPARENT = "BSDF_TRANSPARENT"
# Factors of a mix closer to 0 or 1 show one shader only.
_HARDLY = 1e-6
_LARGEST = 1e6  # of numbers without a limit
_GREY = (0.8, 0.8, 0.8)  # of objects without a material

# Sockets of the Principled BSDF by slo-rt's names, with the limits of their numbers.
_NUMBERS = {
    "metallic": ("Metallic", 0.0, 1.0),
    "roughness": ("Roughness", 0.0, 1.0),
    "diffuse_roughness": ("Diffuse Roughness", 0.0, 1.0),
    "ior": ("IOR", 1.0, _LARGEST),
    "alpha": ("Alpha", 0.0, 1.0),
    "specular_ior_level": ("Specular IOR Level", 0.0, 1.0),
    "anisotropic": ("Anisotropic", 0.0, 1.0),
    "anisotropic_rotation": ("Anisotropic Rotation", -_LARGEST, _LARGEST),
    "transmission": ("Transmission Weight", 0.0, 1.0),
    "coat": ("Coat Weight", 0.0, 1.0),
    "coat_roughness": ("Coat Roughness", 0.0, 1.0),
    "coat_ior": ("Coat IOR", 1.0, _LARGEST),
    "sheen": ("Sheen Weight", 0.0, 1.0),
    "sheen_roughness": ("Sheen Roughness", 0.0, 1.0),
}
# Sockets with limits that Cycles does not have, and sockets that count turns.
_NARROW = {"IOR", "Specular IOR Level"}
_TURNS = {"Anisotropic Rotation", "Rotation"}
_COLORS = {
    "base_color": "Base Color",
    "specular_tint": "Specular Tint",
    "coat_tint": "Coat Tint",
    "sheen_tint": "Sheen Tint",
}


def surface_of(material, report):
    """Returns the surface of a material: `Principled` or `Mix`; None if the material has only a volume, so
    that its objects are invisible. Without a material: Blender's grey."""
    if material is None:
        return matt(Value(_GREY))
    subject = f'material "{material.name}"'
    note_flags(material, "Material", subject, report)
    tree = compat.node_tree(material)
    if tree is None:
        return matt(Value(tuple(material.diffuse_color[:3])))
    return _SurfaceReader(subject, report).surface(tree)


class PhysicalReader(Reader):
    """Reads constants by the table of nodes of physical surfaces, lamps and skies."""

    def __init__(self, subject, report):
        super().__init__(subject, report, PHYSICAL)

    def constant(self, feed):
        return folded(feed)


class _SurfaceReader(PhysicalReader):
    """Reads the node tree of one material."""

    def surface(self, tree):
        """Returns the surface of a tree, or None if it has a volume and no surface."""
        output = output_node(tree)
        if output is None:
            self.note("has no output; it is black")
            return matt(Value(BLACK))
        feed = Feed(output)
        self.note_rest(feed)
        surface, volume = (follow(feed.input(name)) for name in ("Surface", "Volume"))
        if surface.node is None and volume.node is not None:
            self.note("has a volume and no surface: what has it is left out")
            return None
        if surface.node is None:
            self.note("has no surface; it is black, as in Blender")
        found = self._shader(surface)
        return self._with_volume(found, volume) if volume.node is not None else found

    def _with_volume(self, surface, volume):
        """Returns a surface with what its inside absorbs; notes other volumes."""
        is_glass = isinstance(surface, Principled) and not surface["transmission"].is_zero
        if volume.node.type != "VOLUME_ABSORPTION" or not is_glass:
            self.note("volume is not carried")
            return surface
        self.note_rest(volume)
        density = self.value(volume.input("Density"))
        color = self.color(volume.input("Color"))
        if density <= 0.0:
            return surface
        left = tuple(math.exp(min(max(c, 0.0), 1.0) - 1.0) for c in color)
        return surface.with_values(
            absorption_color=Value(left), absorption_distance=Value(1.0 / density)
        )

    # Shaders

    def _shader(self, feed):
        """Returns the surface of the shader that feeds a socket."""
        node = feed.node
        if node is None:
            return matt(Value(BLACK))
        if node.type == "MIX_SHADER":
            return self._mix(feed)
        if node.type == "ADD_SHADER":
            return self._add(feed)
        self.note_rest(feed)
        read = self._READERS.get(node.type)
        return read(self, feed) if read else self._stranger(feed)

    def _mix(self, feed):
        first, second = (follow(i) for i in feed.inputs() if i.socket.type == "SHADER")
        factor_input = feed.input("Fac")
        chain = follow(factor_input)
        if self.constant(chain) is None and image_behind(chain, self) is None:
            if _is_nothing(first) or _is_nothing(second):
                self.note(f"{feed.node.bl_label} is not carried, one of its shaders is")
                return self._shader(second if _is_nothing(first) else first)
        factor = self._number(factor_input, 0.0, 1.0)
        if factor.image is None and factor.value < _HARDLY:
            return self._shader(first)
        if factor.image is None and factor.value > 1.0 - _HARDLY:
            return self._shader(second)
        surfaces = self._shader(first), self._shader(second)
        if surfaces[0].is_invisible:
            return self._seen_through(surfaces[1], factor)
        if surfaces[1].is_invisible and factor.image is None:
            return self._seen_through(surfaces[0], Value(1.0 - factor.value))
        return Mix(*surfaces, factor)

    @staticmethod
    def _seen_through(surface, share):
        # As `alpha_texture`, an image without a channel would be its alpha.
        image = share.image
        if image and not image.channel and image.texture.has_alpha:
            return Mix(INVISIBLE, surface, share)
        return seen_through(surface, share)

    def _add(self, feed):
        parts = [follow(i) for i in feed.inputs() if i.socket.type == "SHADER"]
        surfaces = [self._shader(part) for part in parts if part.node is not None]
        if len(surfaces) < 2:
            return surfaces[0] if surfaces else matt(Value(BLACK))
        first, second = surfaces
        for light, surface in ((first, second), (second, first)):
            if _only_shines(light):
                return self._with_light(surface, light)
        bright = _doubled(first), _doubled(second)
        if None not in bright:
            return Mix(*bright, Value(0.5))
        self.note(f"{feed.node.bl_label} is carried as an even mix: its shaders are half as bright")
        return Mix(first, second, Value(0.5))

    def _with_light(self, surface, light):
        """Returns `surface` that also shines like `light`."""
        if isinstance(surface, Mix):
            parts = (self._with_light(part, light) for part in (surface.first, surface.second))
            return Mix(*parts, surface.factor)
        color, strength = light["emission_color"], light["emission_strength"]
        alpha = surface["alpha"]
        if alpha.image or alpha.value < _HARDLY:
            self.note("light that is added to a transparent surface is not carried")
            return surface
        if surface.emits:
            both = _sum_of_lights(surface, light, alpha.value)
            if both is None:
                self.note("of two added lights with an image, the first is carried")
                return surface
            color, strength = both
        elif alpha.value < 1.0:
            strength = strength.times(1.0 / alpha.value)
        if not (surface["coat"].is_zero and surface["sheen"].is_zero):
            self.note("light that is added to a coated surface shines through the coat")
        return surface.with_values(emission_color=color, emission_strength=strength)

    def _stranger(self, feed):
        """Returns the nearest surface to a shader without a counterpart, and notes it."""
        label = feed.node.bl_label
        socket = feed.input("Base Color") or feed.input("Color")
        if feed.node.type == "HOLDOUT" or socket is None:
            self.note(f"{label} is not carried; it is black")
            return matt(Value(BLACK))
        self.note(f"{label} is not carried, a matt surface of its colour is")
        return matt(self._color(socket))

    def _principled(self, feed):
        values = {}
        for name, (socket, low, high) in _NUMBERS.items():
            if input_ := feed.input(socket):
                values[name] = self._number(input_, low, high)
        for name, socket in _COLORS.items():
            values[name] = self._color(feed.input(socket))
        values["emission_strength"] = self._strength(feed.input("Emission Strength"))
        surface = Principled(values)
        if not surface["emission_strength"].is_zero:
            color = self._color(feed.input("Emission Color"), largest=None)
            surface = surface.with_values(emission_color=color)
        if not surface["coat"].is_zero and follow(feed.input("Coat Normal")).node:
            self.note("the coat's own normals are not carried, those of the surface are")
        surface = self._finish(surface, feed)
        alpha = surface["alpha"]
        if alpha.image and not alpha.image.channel and alpha.image.texture.has_alpha:
            return Mix(INVISIBLE, surface.with_values(alpha=Value(1.0)), alpha)
        return surface

    def _diffuse(self, feed):
        roughness = self._number(feed.input("Roughness"), 0.0, 1.0)
        return self._finish(matt(self._color(feed.input("Color")), roughness), feed)

    def _glossy(self, feed):
        color = self._color(feed.input("Color"))
        tint = WHITE if color.image else tint_of_even_metal(color.value)
        if color.image:
            self.note("a Glossy BSDF with an image is brighter at its rim")
        return self._metal_of(feed, color, Value(tint))

    def _metallic(self, feed):
        if feed.node.fresnel_type == "PHYSICAL_CONDUCTOR":
            n, k = (self.color(feed.input(name)) for name in ("IOR", "Extinction"))
            color, tint = metal_of_conductor(*(tuple(max(c, 0.0) for c in v) for v in (n, k)))
            return self._metal_of(feed, Value(color), Value(tint))
        color, tint = (self._color(feed.input(name)) for name in ("Base Color", "Edge Tint"))
        return self._metal_of(feed, color, tint)

    def _metal_of(self, feed, color, tint):
        metal = Principled(
            {
                "base_color": color,
                "metallic": Value(1.0),
                "specular_tint": tint,
                "roughness": self._number(feed.input("Roughness"), 0.0, 1.0),
                "anisotropic": self._number(feed.input("Anisotropy"), 0.0, 1.0),
                "anisotropic_rotation": self._number(feed.input("Rotation"), -_LARGEST, _LARGEST),
            }
        )
        return self._finish(metal, feed)

    def _glass(self, feed):
        color = self._color(feed.input("Color"))
        if color.image:
            self.note("the image of a Glass BSDF colours what it transmits by its square root")
            return self._glass_of(feed, color, Value(WHITE))
        if color.value != WHITE:
            self.note("reflections of coloured glass are white at its rim")
        return self._glass_of(feed, Value(_squared(color.value)), color)

    def _refraction(self, feed):
        self.note("Refraction BSDF is not carried, glass that reflects at its rim is")
        color = self._color(feed.input("Color"))
        squared = color if color.image else Value(_squared(color.value))
        return self._glass_of(feed, squared, Value(BLACK))

    def _glass_of(self, feed, color, tint):
        glass = Principled(
            {
                "base_color": color,
                "specular_tint": tint,
                "transmission": Value(1.0),
                "roughness": self._number(feed.input("Roughness"), 0.0, 1.0),
                "ior": self._number(feed.input("IOR"), 1.0, _LARGEST),
            }
        )
        return self._finish(glass, feed)

    def _sheen(self, feed):
        dull = {name: Value(value) for name, value in DULL.items()}
        fibres = {
            "base_color": Value(BLACK),
            "sheen": Value(1.0),
            "sheen_tint": self._color(feed.input("Color")),
            "sheen_roughness": self._number(feed.input("Roughness"), 0.0, 1.0),
        }
        return self._finish(Principled({**dull, **fibres}), feed)

    def _emission(self, feed):
        color = self._color(feed.input("Color"), largest=None)
        return glowing(color, self._strength(feed.input("Strength")))

    def _transparent(self, feed):
        color = self._color(feed.input("Color"))
        if color.image or color.value != WHITE:
            self.note("what is seen through it keeps its colour")
        return INVISIBLE

    _READERS = {
        "BSDF_PRINCIPLED": _principled,
        "BSDF_DIFFUSE": _diffuse,
        "BSDF_GLOSSY": _glossy,
        "BSDF_METALLIC": _metallic,
        "BSDF_GLASS": _glass,
        "BSDF_REFRACTION": _refraction,
        "BSDF_SHEEN": _sheen,
        "EMISSION": _emission,
        _TRANSPARENT: _transparent,
    }

    # Normals and tangents

    def _finish(self, surface, feed):
        """Returns the surface of a shader with its map of normals; notes a tangent without a
        counterpart."""
        if not surface["anisotropic"].is_zero:
            self._note_tangent(feed.input("Tangent"))
        normal = follow(feed.input("Normal"))
        if normal.node is None:
            return surface
        node = normal.node
        if node.type != "NORMAL_MAP":
            self.note(f"{node.bl_label} on Normal is not carried")
            return surface
        self.note_rest(normal)
        if getattr(node, "convention", "OPENGL") != "OPENGL":
            self.note("normal maps of DirectX are not carried: theirs bend the other way in v")
        found = image_behind(follow(normal.input("Color")), self)
        if found is None or found[0] != 1.0:
            if follow(normal.input("Color")).node is not None:
                self.note("normals that are no image are not carried")
            return surface
        if node.space != "TANGENT":
            return surface
        if node.uv_map and node.uv_map != found[1].texture.uv_map:
            self.note("a normal map's own uv map is not carried, that of its image is")
        strength = self._number(normal.input("Strength"), 0.0, _LARGEST)
        return surface.with_values(normal=Value(WHITE, found[1]), normal_strength=strength)

    def _note_tangent(self, input_):
        node = follow(input_).node
        if node is None:
            self.note("a brushed surface follows the uv map, as with a Tangent node of type UV Map")
        elif node.type != "TANGENT" or node.direction_type != "UV_MAP":
            self.note(f"{node.bl_label} on Tangent is not carried, the uv map is")

    # Values

    def _number(self, input_, low, high):
        """Returns a number within limits, and its image."""
        chain = follow(input_)
        found = self.constant(chain)
        if found is not None:
            number = _as_number(found)
            if input_.socket.name in _NARROW and not low <= number <= high:
                self.note(f"{input_.socket.name} below {low:g} or above {high:g} is not carried")
            if input_.socket.name in _TURNS:
                number %= 1.0
            return Value(min(max(number, low), high))
        image = image_behind(chain, self)
        if image is None:
            return Value(min(max(self.value(input_), low), high))
        return Value(max(_as_number(image[0]), 0.0), image[1])

    def _strength(self, input_):
        value = self._number(input_, -math.inf, math.inf)
        return Value(self.light((value.value,))[0], value.image)

    def _color(self, input_, largest=1.0):
        """Returns a colour of 0 to `largest` (None: without a limit), and its image."""
        chain = follow(input_)
        found, image = self.constant(chain), None
        if found is None:
            behind = image_behind(chain, self) or self._nearest_image(chain, input_)
            found, image = behind or (self.color(input_), None)
        color = self.light(found if isinstance(found, tuple) else (found,) * 3)
        if largest is not None and max(color) > largest:
            self.note("colours above 1 are not carried; they are 1")
            color = tuple(min(c, largest) for c in color)
        return Value(color, image)

    def _nearest_image(self, chain, input_):
        """Returns the nearest image behind nodes that have no counterpart, which is noted; or None."""
        image = nearest(chain, "TEX_IMAGE")
        found = image and image_behind(image, self)
        if found and image.node != chain.node:
            self.note_feed(chain, input_, "the image behind it is")
        return found


def _is_nothing(feed):
    return feed.node is None or feed.node.type == _TRANSPARENT


def _as_number(value):
    return luma(value) if isinstance(value, tuple) else value


def _squared(color):
    return tuple(c * c for c in color)


def _only_shines(surface):
    """Whether a surface shines and reflects nothing."""
    if not (isinstance(surface, Principled) and surface.emits):
        return False
    dull = all(surface[name] == Value(value) for name, value in DULL.items())
    return dull and surface["base_color"] == Value(BLACK) and surface["sheen"].is_zero


def _sum_of_lights(surface, light, alpha):
    """Returns colour and strength of the light of two surfaces; None if one has an image."""
    values = [s[n] for s in (surface, light) for n in ("emission_color", "emission_strength")]
    if any(value.image for value in values):
        return None
    first, strength, second, other = (value.value for value in values)
    total = tuple(a * strength + b * other / alpha for a, b in zip(first, second))
    return Value(total), Value(1.0)


def _doubled(surface):
    """Returns a surface that reflects twice as much, or None if there is none."""
    if not isinstance(surface, Principled) or surface["base_color"].image or surface.emits:
        return None
    color = tuple(2.0 * c for c in surface["base_color"].value)
    if max(color) > 1.0 or surface["alpha"] != Value(DEFAULTS["alpha"]):
        return None
    if surface["metallic"] == Value(1.0):
        tint = tint_of_even_metal(surface["base_color"].value)
        if surface["specular_tint"] != Value(tint):
            return None
        return surface.with_values(
            base_color=Value(color), specular_tint=Value(tint_of_even_metal(color))
        )
    dull = all(surface[name] == Value(value) for name, value in DULL.items())
    is_matt = dull and surface["sheen"].is_zero
    return surface.with_values(base_color=Value(color)) if is_matt else None
