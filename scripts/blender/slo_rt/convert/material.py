# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts the surface shader of a material's node tree to a `phong_info`."""

from dataclasses import dataclass

from .. import compat
from ..format.phong import BLACK, Phong, Surface, blend, mean, phong_of_surface
from .flags import note_flags
from .nodes import Feed, Reader, constant, follow, nearest, output_node
from .texture import Texture, read_texture

_TRANSPARENT = "BSDF_TRANSPARENT"
_MIXES = {"MIX_SHADER", "ADD_SHADER"}
_KNOWN = {
    "BSDF_PRINCIPLED", "BSDF_DIFFUSE", "BSDF_GLOSSY", "BSDF_METALLIC", "BSDF_GLASS", "EMISSION",
    _TRANSPARENT,
}  # fmt: skip
# These do not resemble a matt surface of their colour.
_BLACK = {"HOLDOUT"}
_GLASSY = {"BSDF_REFRACTION"}
# Factors of a mix closer to 0 or 1 show one shader only.
_HARDLY = 1e-6
SMALLEST_IOR = 1e-3


@dataclass
class Finish:
    """The appearance of a surface: Phong values, and the texture that multiplies ambient and diffuse,
    or None."""

    phong: Phong
    texture: Texture | None = None


def finish(material, ambient_light, report):
    """Returns the finish of a material (None: Blender's default grey), or None if the material has only
    a volume and no surface, so that its objects are invisible."""
    if material is None:
        return Finish(phong_of_surface(Surface(), ambient_light))
    subject = f'material "{material.name}"'
    note_flags(material, "Material", subject, report)
    tree = compat.node_tree(material)
    if material.slo_rt.use_own:
        texture = _MaterialReader(subject, report, ambient_light).own_texture(tree)
        return Finish(own_phong(material.slo_rt), texture)
    if tree is None:
        return Finish(phong_of_surface(_viewport_surface(material), ambient_light))
    return _MaterialReader(subject, report, ambient_light).finish(tree)


def own_phong(values):
    """Returns the Phong values that the artist entered (`MaterialSettings`)."""
    return Phong(
        **{
            name: tuple(value) if hasattr(value, "__len__") else value
            for name in Phong.__dataclass_fields__
            for value in [getattr(values, name)]
        }
    )


def _viewport_surface(material):
    return Surface(
        base_color=tuple(material.diffuse_color[:3]),
        metallic=material.metallic,
        roughness=material.roughness,
    )


class _MaterialReader(Reader):
    """Reads the node tree of one material."""

    def __init__(self, subject, report, ambient_light):
        super().__init__(subject, report)
        self.ambient_light = ambient_light

    def finish(self, tree):
        """Returns the `Finish` of a tree, or None if it has a volume and no surface."""
        output = output_node(tree)
        if output is None:
            self.note("has no output; it is black")
            return Finish(Phong())
        feed = Feed(output)
        self.note_rest(feed)
        surface, volume = (follow(feed.input(name)) for name in ("Surface", "Volume"))
        if surface.node is None and volume.node is not None:
            self.note("has a volume and no surface: what has it is left out")
            return None
        if surface.node is None:
            self.note("has no surface; it is black, as in Blender")
            return Finish(Phong())
        return self._shader(surface)

    def own_texture(self, tree):
        """Returns the texture of a tree whose other nodes do not matter."""
        output = tree and output_node(tree)
        open_ = [follow(Feed(output).input("Surface"))] if output else []
        while open_:
            feed = open_.pop(0)
            if feed.node is None:
                continue
            socket = feed.input("Base Color") or feed.input("Color")
            texture = self.textured_color(socket)[1] if socket else None
            if texture:
                return texture
            open_ += [follow(i) for i in feed.inputs() if i.socket.type == "SHADER"]
        return None

    # Shaders

    def _shader(self, feed):
        """Returns the `Finish` of the shader that feeds a socket."""
        node = feed.node
        if node is None:
            return Finish(Phong())
        if node.type in _MIXES:
            return self._mix(feed)
        self.note_rest(feed)
        if node.type in _KNOWN:
            surface, texture = self._surface(feed)
            self._note_surface(surface, texture)
            return Finish(phong_of_surface(surface, self.ambient_light), texture)
        return self._stranger(feed)

    def _mix(self, feed):
        """Mixes two known shaders; of other mixes it takes one shader."""
        first, second = (follow(i) for i in feed.inputs() if i.socket.type == "SHADER")
        if feed.node.type == "ADD_SHADER":
            return self._blend(feed, ((1.0, first), (1.0, second)))
        factor = constant(follow(feed.input("Fac")))
        if factor is None:
            self.note(f"{feed.node.bl_label} is not carried, one of its shaders is")
            return self._shader(_something(first, second))
        factor = mean(factor) if isinstance(factor, tuple) else factor
        factor = min(max(factor, 0.0), 1.0)
        return self._blend(feed, ((1.0 - factor, first), (factor, second)))

    def _blend(self, feed, parts):
        parts = [(weight, self._shader(part)) for weight, part in parts if weight > _HARDLY]
        if len(parts) == 1 and parts[0][0] > 1.0 - _HARDLY:
            return parts[0][1]
        heaviest = max(parts, key=lambda part: part[0])[1]
        lit = [finish for _, finish in parts if finish.phong.is_lit]
        textures = [finish.texture for finish in lit]
        if any(texture != textures[0] for texture in textures):
            self.note(
                f"of {feed.node.bl_label} with a texture, the shader that is seen most is carried"
            )
            return heaviest
        phong, is_exact = blend([(weight, finish.phong) for weight, finish in parts])
        if not is_exact:
            self.note(
                f"{feed.node.bl_label}: the shaders share one roughness and one refraction index, "
                "those of the one that is seen most"
            )
        return Finish(phong, textures[0] if textures else None)

    def _stranger(self, feed):
        """Returns the nearest `Finish` to a shader without a counterpart in slo-rt, and notes it."""
        node = feed.node
        socket = feed.input("Base Color") or feed.input("Color")
        if node.type in _BLACK or socket is None:
            self.note(f"{node.bl_label} is not carried; it is black")
            return Finish(Phong())
        color, texture = self.textured_color(socket)
        surface = Surface(color, specular_level=0.0)
        what = "a matt surface"
        if node.type in _GLASSY:
            what = "glass"
            surface = Surface(
                color,
                roughness=self.unit(feed.input("Roughness")),
                ior=self._ior(feed, 1.45),
                transmission=1.0,
            )
        self.note(f"{node.bl_label} is not carried, {what} of its colour is")
        return Finish(phong_of_surface(surface, self.ambient_light), texture)

    def _surface(self, feed):
        """`(Surface, Texture or None)` of a known shader."""
        kind = feed.node.type
        if kind == "BSDF_PRINCIPLED":
            return self._principled(feed)
        if kind == "BSDF_METALLIC":
            return self._metal(feed)
        color, texture = self.textured_color(feed.input("Color"))
        if kind == _TRANSPARENT:
            if texture or any(c < 1.0 for c in color):
                self.note("what is seen through it keeps its colour")
            return Surface(alpha=0.0), None
        if kind == "BSDF_DIFFUSE":
            return Surface(color, specular_level=0.0), texture
        if kind == "EMISSION":
            strength = self.value(feed.input("Strength"), 1.0)
            light = self.light(tuple(c * strength for c in color))
            return Surface(BLACK, specular_level=0.0, emission=light), texture
        if kind == "BSDF_GLASS":
            roughness, ior = self.unit(feed.input("Roughness")), self._ior(feed, 1.5)
            return Surface(color, roughness=roughness, ior=ior, transmission=1.0), texture
        roughness = self.unit(feed.input("Roughness"))
        return Surface(color, metallic=1.0, roughness=roughness), texture

    def _metal(self, feed):
        roughness = self.unit(feed.input("Roughness"))
        if feed.node.fresnel_type == "PHYSICAL_CONDUCTOR":
            self.note(
                "of the Metallic BSDF, Roughness and what it reflects straight on are carried"
            )
            n, k = (self.color(feed.input(name)) for name in ("IOR", "Extinction"))
            color = tuple(((a - 1.0) ** 2 + b * b) / ((a + 1.0) ** 2 + b * b) for a, b in zip(n, k))
            return Surface(color, metallic=1.0, roughness=roughness), None
        self.note("of the Metallic BSDF, Base Color and Roughness are carried")
        color, texture = self.textured_color(feed.input("Base Color"))
        return Surface(color, metallic=1.0, roughness=roughness), texture

    def _principled(self, feed):
        color, texture = self.textured_color(feed.input("Base Color"))
        strength = self.value(feed.input("Emission Strength"))
        emission = BLACK
        if strength != 0.0:
            light = tuple(c * strength for c in self.color(feed.input("Emission Color")))
            emission = self.light(light)
        surface = Surface(
            base_color=color,
            metallic=self.unit(feed.input("Metallic")),
            roughness=self.unit(feed.input("Roughness"), 0.5),
            ior=self._ior(feed, 1.5),
            specular_level=max(self.value(feed.input("Specular IOR Level"), 0.5), 0.0),
            transmission=self.unit(feed.input("Transmission Weight")),
            alpha=self.unit(feed.input("Alpha"), 1.0),
            emission=emission,
        )
        return surface, texture

    def _ior(self, feed, otherwise):
        return max(self.value(feed.input("IOR"), otherwise), SMALLEST_IOR)

    def _note_surface(self, surface, texture):
        """Notes how slo-rt treats a surface differently that it can read."""
        if surface.emission != BLACK:
            self.note("shines by itself, and on nothing else: only lights light other things")
        if texture and surface.emission != BLACK and surface.base_color != BLACK:
            self.note("the texture colours what the surface emits, too")
        if texture and (surface.metallic > 0.0 or surface.transmission > 0.0):
            self.note(
                "the texture colours neither reflections nor what is seen through the surface"
            )
        elif surface.metallic > 0.0 and _is_coloured(surface.base_color):
            self.note("reflections of metals are grey in slo-rt; highlights keep their colour")
        if surface.transmission > 0.0 and _is_coloured(surface.base_color):
            self.note("glass is grey in slo-rt")

    # Colours

    def textured_color(self, input_):
        """`(colour, Texture or None)` of a colour socket; a texture's colour is white."""
        feed = follow(input_)
        image = None
        if feed.node is not None and constant(feed) is None:
            image = nearest(feed, "TEX_IMAGE")
        if image is None:
            return self.light(self.color(input_)), None
        if image.node != feed.node:
            self.note_feed(feed, input_, "the image behind it is")
        return (1.0, 1.0, 1.0), read_texture(image, self)


def _something(first, second):
    """Returns the visible part of a mix of a shader with nothing."""
    for feed in (first, second):
        if feed.node is not None and feed.node.type != _TRANSPARENT:
            return feed
    return first if first.node is not None else second


def _is_coloured(color):
    return max(color) - min(color) > 0.02 * max(max(color), mean(color), 1e-6)
