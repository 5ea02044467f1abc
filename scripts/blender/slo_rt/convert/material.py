# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: the surface shader of a node tree becomes a `phong_info`."""

from dataclasses import dataclass

import bpy

from .. import compat
from ..format.phong import BLACK, Phong, Surface, mean, phong_of_surface

# Sockets of the Principled BSDF that slo-rt has no word for, and the value at which they do nothing.
_SILENT_AT = {
    "Subsurface Weight": 0.0,
    "Anisotropic": 0.0,
    "Coat Weight": 0.0,
    "Sheen Weight": 0.0,
    "Thin Film Thickness": 0.0,
    "Diffuse Roughness": 0.0,
    "Anisotropy": 0.0,
    "Specular Tint": (1.0, 1.0, 1.0, 1.0),
}
_SIMPLE_SHADERS = {"BSDF_DIFFUSE", "BSDF_GLOSSY", "BSDF_METALLIC", "BSDF_GLASS", "EMISSION"}
_TRANSPARENT = "BSDF_TRANSPARENT"


@dataclass
class Texture:
    """An image on the base colour, `scale` times over one unit of uv coordinates."""

    image: bpy.types.Image
    scale: tuple = (1.0, 1.0)
    uv_map: str = ""


@dataclass
class Finish:
    """How a surface looks: Phong values, and the texture that multiplies ambient and diffuse, or
    None."""

    phong: Phong
    texture: Texture | None = None


def finish(material, ambient_light, report):
    """The finish of a material (None: Blender's default grey)."""
    if material is None:
        return Finish(phong_of_surface(Surface(), ambient_light))
    subject = f'material "{material.name}"'
    if material.slo_rt.use_own:
        return Finish(own_phong(material.slo_rt), _own_texture(material, subject, report))
    tree = compat.node_tree(material)
    if tree is None:
        return Finish(phong_of_surface(_viewport_surface(material), ambient_light))
    return _Reader(subject, report).finish(tree, ambient_light)


def own_phong(values):
    """The Phong values that the artist typed in (`MaterialSettings`)."""
    return Phong(
        **{
            name: tuple(value) if hasattr(value, "__len__") else value
            for name in Phong.__dataclass_fields__
            for value in [getattr(values, name)]
        }
    )


def _own_texture(material, subject, report):
    tree = compat.node_tree(material)
    reader = _Reader(subject, report)
    shader = reader.shader_of(tree) if tree else None
    socket = shader and (shader.inputs.get("Base Color") or shader.inputs.get("Color"))
    return reader.color(socket)[1] if socket else None


def _viewport_surface(material):
    return Surface(
        base_color=tuple(material.diffuse_color[:3]),
        metallic=material.metallic,
        roughness=material.roughness,
    )


class _Reader:
    """Reads the node tree of one material."""

    def __init__(self, subject, report):
        self.subject = subject
        self.report = report

    def note(self, message):
        self.report.note(self.subject, message)

    def finish(self, tree, ambient_light):
        shader = self.shader_of(tree)
        if shader is None:
            self.note("has no surface; rendered black")
            return Finish(Phong())
        surface, texture = self.surface(shader)
        if surface.emission != BLACK:
            self.note("shines by itself, and on nothing else: only lights light other things")
        if texture and surface.emission != BLACK:
            self.note("the texture colours what the surface emits, too")
        if texture and (surface.metallic > 0.0 or surface.transmission > 0.0):
            self.note(
                "the texture colours neither reflections nor what is seen through the surface"
            )
        elif surface.metallic > 0.0 and _is_coloured(surface.base_color):
            self.note("reflections of metals are grey in slo-rt; highlights keep their colour")
        if surface.transmission > 0.0 and _is_coloured(surface.base_color):
            self.note("glass is grey in slo-rt")
        return Finish(phong_of_surface(surface, ambient_light), texture)

    def shader_of(self, tree):
        """The node that shades the surface: the first one behind mixes that slo-rt can read."""
        output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
        if output is None:
            return None
        for name in ("Volume", "Displacement"):
            if output.inputs[name].is_linked:
                self.note(f"{name.lower()} is not carried")
        return self._shader_behind(output.inputs["Surface"])

    def _shader_behind(self, socket):
        node = _source_node(socket)
        if node is None or _is_known(node):
            return node
        inner = [i for i in node.inputs if i.type == "SHADER" and i.is_linked]
        if not inner:
            self.note(f"{node.bl_label} is not carried")
            return None
        # Of a mix of something with nothing, something is what the artist looks at.
        inner.sort(key=lambda i: getattr(_source_node(i), "type", None) == _TRANSPARENT)
        self.note(f"{node.bl_label} is not carried, one of its shaders is")
        found = (self._shader_behind(i) for i in inner)
        return next((shader for shader in found if shader), None)

    def surface(self, node):
        """`(Surface, Texture or None)` of a shader node."""
        self._note_silent(node)
        if node.type == "BSDF_PRINCIPLED":
            return self._principled(node)
        color, texture = self.color(node.inputs.get("Color") or node.inputs["Base Color"])
        roughness = self.value(node, "Roughness", 0.5)
        if node.type == _TRANSPARENT:
            if texture or any(c < 1.0 for c in color):
                self.note("what is seen through it keeps its colour")
            return Surface(alpha=0.0), None
        if node.type == "BSDF_DIFFUSE":
            if roughness != 0.0:
                self.note("Diffuse Roughness is not carried")
            return Surface(color, specular_level=0.0), texture
        if node.type == "EMISSION":
            strength = self.value(node, "Strength", 1.0)
            light = tuple(c * strength for c in color)
            return Surface(BLACK, specular_level=0.0, emission=light), texture
        if node.type == "BSDF_GLASS":
            ior = self.value(node, "IOR", 1.5)
            return Surface(color, roughness=roughness, ior=ior, transmission=1.0), texture
        if node.type == "BSDF_METALLIC":
            self.note("of the Metallic BSDF, Base Color and Roughness are carried")
        return Surface(color, metallic=1.0, roughness=roughness), texture

    def _note_silent(self, node):
        """Notes sockets that do something in Blender and nothing in slo-rt."""
        for name, silent in _SILENT_AT.items():
            socket = node.inputs.get(name)
            if socket and (socket.is_linked or _plain(socket.default_value) != silent):
                self.note(f"{name} is not carried")
        for name in ("Normal", "Coat Normal"):
            if node.inputs.get(name) and node.inputs[name].is_linked:
                self.note("normal and bump maps are not carried")

    def _principled(self, node):
        color, texture = self.color(node.inputs["Base Color"])
        strength = self.value(node, "Emission Strength", 0.0)
        emission = BLACK
        if strength > 0.0:
            emission_color, _ = self.color(node.inputs["Emission Color"], textured=False)
            emission = tuple(c * strength for c in emission_color)
        surface = Surface(
            base_color=color,
            metallic=self.value(node, "Metallic", 0.0),
            roughness=self.value(node, "Roughness", 0.5),
            ior=self.value(node, "IOR", 1.5),
            specular_level=self.value(node, "Specular IOR Level", 0.5),
            transmission=self.value(node, "Transmission Weight", 0.0),
            alpha=self.value(node, "Alpha", 1.0),
            emission=emission,
        )
        return surface, texture

    def value(self, node, name, otherwise):
        """A number of a socket; what is linked to it counts only if it is a constant."""
        socket = node.inputs.get(name)
        if socket is None:
            return otherwise
        source = _source_node(socket)
        if source is not None and source.type == "VALUE":
            return source.outputs[0].default_value
        if source is not None:
            self.note(f"{source.bl_label} on {name} is not carried, the socket's own value is")
        return socket.default_value

    def color(self, socket, textured=True):
        """`(colour, Texture or None)` of a socket."""
        source = _source_node(socket)
        if source is None:
            return tuple(socket.default_value[:3]), None
        if source.type == "RGB":
            return tuple(source.outputs[0].default_value[:3]), None
        image_node = _first_image_node(source) if textured else None
        if image_node is None:
            self.note(
                f"{source.bl_label} on {socket.name} is not carried, the socket's own value is"
            )
            return tuple(socket.default_value[:3]), None
        if image_node != source:
            self.note(f"{source.bl_label} on {socket.name} is not carried, the image behind it is")
        return (1.0, 1.0, 1.0), self._texture(image_node)

    def _texture(self, node):
        if node.projection != "FLAT":
            self.note(f"{node.projection.lower()} projection of an image is not carried")
        if node.extension != "REPEAT":
            self.note("images repeat in slo-rt")
        scale, uv_map = (1.0, 1.0), ""
        source = _source_node(node.inputs["Vector"])
        if source is not None and source.type == "MAPPING":
            scale = self._mapping_scale(source)
            source = _source_node(source.inputs["Vector"])
        if source is not None and source.type == "UVMAP":
            uv_map = source.uv_map
        elif source is not None and not _gives_uv(source):
            self.note(f"{source.bl_label} as texture coordinates is not carried, the uv map is")
        return Texture(node.image, scale, uv_map)

    def _mapping_scale(self, node):
        location, rotation, scale = (node.inputs.get(n) for n in ("Location", "Rotation", "Scale"))
        moved = any(s and (s.is_linked or any(s.default_value)) for s in (location, rotation))
        if moved or scale.is_linked or node.vector_type != "POINT":
            self.note("of a texture's mapping only the scale is carried")
        return tuple(scale.default_value[:2])


def _is_known(node):
    return node.type in _SIMPLE_SHADERS or node.type in {"BSDF_PRINCIPLED", _TRANSPARENT}


def _plain(value):
    """A socket's value as number or tuple."""
    return tuple(value) if hasattr(value, "__len__") else value


def _source_node(socket):
    """The node that feeds a socket, reroutes followed, or None."""
    while socket.is_linked:
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def with_node_trees(owner):
    """`owner` (a material, world, light or scene), its node tree, and all groups in there."""
    found, open_ = [], [owner, getattr(owner, "node_tree", None)]
    while open_:
        tree = open_.pop()
        if tree is None or tree in found:
            continue
        found.append(tree)
        open_ += [getattr(node, "node_tree", None) for node in getattr(tree, "nodes", ())]
    return found


def _first_image_node(node):
    """The nearest image texture with an image at or behind `node`, or None."""
    seen, open_ = set(), [node]
    while open_:
        node = open_.pop(0)
        if node.type == "TEX_IMAGE" and node.image:
            return node
        if node in seen:
            continue
        seen.add(node)
        behind = (
            _source_node(s) for s in node.inputs if s.type == "RGBA" or node.type == "REROUTE"
        )
        open_ += [n for n in behind if n is not None]
    return None


def _gives_uv(node):
    """Whether a Texture Coordinate node is used by its UV output."""
    return node.type == "TEX_COORD" and any(
        link.from_socket.name == "UV" for output in node.outputs for link in output.links
    )


def _is_coloured(color):
    return max(color) - min(color) > 0.02 * max(max(color), mean(color), 1e-6)
