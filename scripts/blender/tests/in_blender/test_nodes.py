# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees: links are followed as Cycles does."""

import unittest

import bpy
import numpy as np

from . import blend
from .test_pictures import picture

GREEN = (0.0, 1.0, 0.0, 1.0)


def empty_material(thing, name="Paint"):
    """A material of an object with nothing but an output; returns its tree."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    tree.nodes.new("ShaderNodeOutputMaterial")
    thing.data.materials.append(material)
    return tree


def output_of(tree):
    """The output node."""
    return next(node for node in tree.nodes if node.type.startswith("OUTPUT_"))


def add(tree, kind, color=None, to=None):
    """A node with a colour, linked to a socket."""
    node = tree.nodes.new(kind)
    if color is not None:
        owner = node.outputs[0] if kind == "ShaderNodeRGB" else node.inputs["Color"]
        owner.default_value = color
    if to is not None:
        tree.links.new(node.outputs[0], to)
    return node


def shine(tree, color=GREEN):
    """An Emission on the output."""
    return add(tree, "ShaderNodeEmission", color, output_of(tree).inputs["Surface"])


def image(pixels, name="Picture"):
    """A packed image of pixels (height, width, 4), the bottom row first."""
    pixels = np.asarray(pixels, np.float32)
    found = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], alpha=True)
    found.pixels.foreach_set(pixels.ravel())
    found.pack()
    return found


def halves(left=(1.0, 0.0, 0.0, 1.0), right=GREEN, size=64):
    """An image whose halves have two colours."""
    pixels = np.empty((size, size, 4))
    pixels[:, : size // 2], pixels[:, size // 2 :] = left, right
    return image(pixels)


def textured(tree, picture_, output="Color"):
    """An Emission with an image; returns the image node."""
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = picture_
    tree.links.new(node.outputs[output], shine(tree).inputs["Color"])
    return node


def group_of(tree, kind="NodeSocketColor", passes=True):
    """A group node whose output is its input, or nothing."""
    inner = bpy.data.node_groups.new("Group", "ShaderNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        inner.interface.new_socket("Value", in_out=direction, socket_type=kind)
    start, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    if passes:
        inner.links.new(start.outputs[0], end.inputs[0])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = inner
    return node


# Trees that must look as in Cycles, by name: functions of an empty tree.


def muted_link(tree):
    lamp = shine(tree)
    add(tree, "ShaderNodeRGB", (1.0, 0.0, 0.0, 1.0), lamp.inputs["Color"])
    lamp.inputs["Color"].links[0].is_muted = True


def muted_link_to_the_output(tree):
    shine(tree)
    output_of(tree).inputs["Surface"].links[0].is_muted = True


def muted_node(tree):
    lamp = shine(tree)
    gamma = add(tree, "ShaderNodeGamma", None, lamp.inputs["Color"])
    add(tree, "ShaderNodeRGB", (0.0, 0.0, 1.0, 1.0), gamma.inputs["Color"])
    gamma.mute = True


def muted_node_without_a_link(tree):
    gamma = add(tree, "ShaderNodeGamma", (1.0, 0.0, 0.0, 1.0), shine(tree).inputs["Color"])
    gamma.mute = True


def muted_source(tree):
    add(tree, "ShaderNodeRGB", (1.0, 0.0, 0.0, 1.0), shine(tree).inputs["Color"]).mute = True


def muted_shader(tree):
    shine(tree).mute = True


def muted_output(tree):
    shine(tree)
    output_of(tree).mute = True


def muted_mix(tree):
    mixed(1.0)(tree)
    next(node for node in tree.nodes if node.type == "MIX_SHADER").mute = True


def reroutes(tree):
    lamp = shine(tree)
    first, second = (tree.nodes.new("NodeReroute") for _ in range(2))
    add(tree, "ShaderNodeRGB", (0.0, 0.0, 1.0, 1.0), first.inputs[0])
    tree.links.new(first.outputs[0], second.inputs[0])
    tree.links.new(second.outputs[0], lamp.inputs["Color"])


def reroute_from_nowhere(tree):
    tree.links.new(tree.nodes.new("NodeReroute").outputs[0], shine(tree).inputs["Color"])


def colour_through_a_group(tree):
    lamp, group = shine(tree), group_of(tree)
    add(tree, "ShaderNodeRGB", (0.0, 0.0, 1.0, 1.0), group.inputs[0])
    tree.links.new(group.outputs[0], lamp.inputs["Color"])


def own_colour_of_a_group(tree):
    lamp, group = shine(tree), group_of(tree)
    group.inputs[0].default_value = (1.0, 0.0, 1.0, 1.0)
    tree.links.new(group.outputs[0], lamp.inputs["Color"])


def group_in_a_group(tree):
    outer = group_of(tree, passes=False)
    inner_tree = outer.node_tree
    inner = group_of(inner_tree)
    ends = {node.type: node for node in inner_tree.nodes}
    inner_tree.links.new(ends["GROUP_INPUT"].outputs[0], inner.inputs[0])
    inner_tree.links.new(inner.outputs[0], ends["GROUP_OUTPUT"].inputs[0])
    outer.inputs[0].default_value = (1.0, 1.0, 0.0, 1.0)
    tree.links.new(outer.outputs[0], shine(tree).inputs["Color"])


def group_with_an_own_end(tree):
    group = group_of(tree, passes=False)
    end = next(node for node in group.node_tree.nodes if node.type == "GROUP_OUTPUT")
    end.inputs[0].default_value = (0.0, 1.0, 1.0, 1.0)
    tree.links.new(group.outputs[0], shine(tree).inputs["Color"])


def group_without_an_end(tree):
    group = group_of(tree)
    for node in [n for n in group.node_tree.nodes if n.type == "GROUP_OUTPUT"]:
        group.node_tree.nodes.remove(node)
    tree.links.new(group.outputs[0], shine(tree).inputs["Color"])


def shader_in_a_group(tree):
    group = group_of(tree, "NodeSocketShader", passes=False)
    inner = group.node_tree
    end = next(node for node in inner.nodes if node.type == "GROUP_OUTPUT")
    add(inner, "ShaderNodeEmission", (0.0, 0.0, 1.0, 1.0), end.inputs[0])
    tree.links.new(group.outputs[0], output_of(tree).inputs["Surface"])


def image_in_a_group(tree):
    group = group_of(tree, passes=False)
    inner = group.node_tree
    end = next(node for node in inner.nodes if node.type == "GROUP_OUTPUT")
    node = add(inner, "ShaderNodeTexImage", None, end.inputs[0])
    node.image = halves()
    tree.links.new(group.outputs[0], shine(tree).inputs["Color"])


def value_on_colour(tree):
    add(tree, "ShaderNodeValue", None, shine(tree).inputs["Color"]).outputs[0].default_value = 0.5


def colour_on_value(tree):
    add(tree, "ShaderNodeRGB", (1.0, 0.0, 0.5, 1.0), shine(tree).inputs["Strength"])


def mixed(factor, colors=((1.0, 0.0, 0.0, 1.0), (0.0, 0.5, 1.0, 1.0)), linked=False):
    """A Mix Shader of two lamps; None for no shader."""

    def build(tree):
        mix = add(tree, "ShaderNodeMixShader", None, output_of(tree).inputs["Surface"])
        mix.inputs[0].default_value = 0.5 if linked else factor
        if linked:
            add(tree, "ShaderNodeValue", None, mix.inputs[0]).outputs[0].default_value = factor
        for i, color in enumerate(colors):
            if color:
                add(tree, "ShaderNodeEmission", color, mix.inputs[1 + i])

    return build


def added(tree):
    node = add(tree, "ShaderNodeAddShader", None, output_of(tree).inputs["Surface"])
    for i, color in enumerate(((0.5, 0.0, 0.0, 1.0), (0.0, 0.0, 0.5, 1.0))):
        add(tree, "ShaderNodeEmission", color, node.inputs[i])


def see_through(factor):
    """A lamp, mixed with nothing."""

    def build(tree):
        mix = add(tree, "ShaderNodeMixShader", None, output_of(tree).inputs["Surface"])
        mix.inputs[0].default_value = factor
        add(tree, "ShaderNodeBsdfTransparent", None, mix.inputs[1])
        add(tree, "ShaderNodeEmission", GREEN, mix.inputs[2])

    return build


def alpha_as_colour(tree):
    pixels = np.zeros((4, 4, 4))
    pixels[..., 2], pixels[..., 3] = 1.0, 0.25
    textured(tree, image(pixels), "Alpha")


def no_surface(tree):
    pass


def no_output(tree):
    tree.nodes.clear()


def missing_uv_map(tree):
    pixels = np.ones((8, 8, 4))
    pixels[2:6, 2:6, :2] = 0.0
    node = textured(tree, image(pixels))
    add(tree, "ShaderNodeUVMap", None, node.inputs["Vector"]).uv_map = "gone"


def scaled(kind, scale):
    """An image behind a Mapping of a type."""

    def build(tree):
        node = textured(tree, halves())
        mapping = add(tree, "ShaderNodeMapping", None, node.inputs["Vector"])
        mapping.vector_type = kind
        mapping.inputs["Scale"].default_value = scale
        source = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(source.outputs["UV"], mapping.inputs["Vector"])
        tree.links.new(source.outputs["Normal"], tree.nodes.new("ShaderNodeGamma").inputs[1])

    return build


AS_IN_CYCLES = [
    muted_link, muted_link_to_the_output, muted_node, muted_node_without_a_link, muted_source,
    muted_shader, muted_output, muted_mix, reroutes, reroute_from_nowhere, colour_through_a_group,
    own_colour_of_a_group, group_in_a_group, group_with_an_own_end, group_without_an_end,
    shader_in_a_group, image_in_a_group, value_on_colour, colour_on_value, mixed(0.0), mixed(1.0),
    mixed(0.25), mixed(7.0), mixed(-1.0), mixed(0.75, linked=True), mixed(0.25, ((1,) * 4, None)),
    mixed(1.0, ((1,) * 4, None)), added, see_through(0.0), see_through(0.3), see_through(1.0),
    alpha_as_colour, no_surface, no_output, missing_uv_map, scaled("POINT", (2.0, 1.0, 1.0)),
    scaled("TEXTURE", (2.0, 1.0, 1.0)), scaled("VECTOR", (-1.0, 1.0, 1.0)),
]  # fmt: skip


class LooksTest(unittest.TestCase):
    """A square that fills the picture, with a blue one behind it, by both renderers."""

    integrator = "DISTRIBUTED"

    def setUp(self):
        blend.program()

    def frame(self):
        scene = blend.fresh_scene((32, 24), self.integrator)
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
        for y in (0.0, 3.0):
            bpy.ops.mesh.primitive_plane_add(size=8.0 + 4.0 * y, location=(0.3, y, 0.2))
            bpy.context.object.rotation_euler.x = np.pi / 2.0
            self.tree = empty_material(bpy.context.object, f"Paint {y}")
            if y:
                shine(self.tree, (0.0, 0.0, 0.7, 1.0))
        self.tree = bpy.data.materials["Paint 0.0"].node_tree
        return scene

    def colors(self, scene, engine):
        """Mean colours of both sides of the picture's middle."""
        render = scene.render
        picture(scene, engine, 8)
        pixels = bpy.data.images.load(render.filepath)
        values = np.array(pixels.pixels[:]).reshape(24, 32, -1)[..., :3]
        bpy.data.images.remove(pixels)
        return np.array(
            [values[8:16, 8:13].mean(axis=(0, 1)), values[8:16, 19:24].mean(axis=(0, 1))]
        )

    def test_as_in_cycles(self):
        for build in AS_IN_CYCLES:
            with self.subTest(build.__qualname__):
                scene = self.frame()
                build(self.tree)
                ours, theirs = (self.colors(scene, name) for name in ("SLO_RT", "CYCLES"))
                np.testing.assert_allclose(ours, theirs, atol=0.03)

    def test_worlds_as_in_cycles(self):
        def reroute(tree, back, out):
            dot = tree.nodes.new("NodeReroute")
            tree.links.new(back.outputs[0], dot.inputs[0])
            tree.links.new(dot.outputs[0], out)

        def constants(tree, back, out):
            add(tree, "ShaderNodeRGB", (0.1, 0.7, 0.3, 1.0), back.inputs["Color"])
            add(tree, "ShaderNodeValue", None, back.inputs["Strength"]).outputs[0].default_value = 2

        def muted(tree, back, out):
            tree.links.new(tree.nodes.new("ShaderNodeTexSky").outputs[0], back.inputs["Color"])
            back.inputs["Color"].links[0].is_muted = True

        def mix(tree, back, out):
            node = add(tree, "ShaderNodeMixShader", None, out)
            node.inputs[0].default_value = 0.25
            tree.links.new(back.outputs[0], node.inputs[1])
            add(tree, "ShaderNodeBackground", (1.0, 0.0, 0.0, 1.0), node.inputs[2])

        def shining(tree, back, out):
            add(tree, "ShaderNodeEmission", (0.2, 0.3, 0.4, 1.0), out)

        def nothing(tree, back, out):
            tree.links.clear()

        for build in (reroute, constants, muted, mix, shining, nothing):
            with self.subTest(build.__name__):
                scene = blend.fresh_scene((32, 24), self.integrator)
                tree = scene.world.node_tree
                back = tree.nodes["Background"]
                back.inputs[0].default_value, back.inputs[1].default_value = (0.0, 0.2, 1, 1), 0.8
                build(tree, back, output_of(tree).inputs["Surface"])
                ours, theirs = (self.colors(scene, name) for name in ("SLO_RT", "CYCLES"))
                np.testing.assert_allclose(ours, theirs, atol=0.005)

    def test_nodes_of_lights_as_in_cycles(self):
        def strong(tree, lamp):
            lamp.inputs["Strength"].default_value = 2.5
            lamp.inputs["Color"].default_value = (1.0, 0.3, 0.1, 1.0)

        def constants(tree, lamp):
            add(tree, "ShaderNodeRGB", (0.1, 0.7, 0.3, 1.0), lamp.inputs["Color"])
            add(tree, "ShaderNodeValue", None, lamp.inputs["Strength"]).outputs[0].default_value = 2

        def muted(tree, lamp):
            strong(tree, lamp)
            lamp.mute = True

        def unlinked(tree, lamp):
            tree.links.clear()

        def off(tree, lamp):
            strong(tree, lamp)
            self.light.use_nodes = False

        for build in (strong, constants, muted, unlinked, off):
            if build is off and bpy.app.version >= (6, 0, 0):
                continue
            with self.subTest(build.__name__):
                scene = self.frame()
                add(
                    self.tree, "ShaderNodeBsdfDiffuse", None, output_of(self.tree).inputs["Surface"]
                )
                thing = blend.lamp("Sun", "SUN", energy=1.0)
                thing.rotation_euler.x = np.pi / 2.0
                self.light = thing.data
                self.light.angle = 0.0
                self.light.use_nodes = True
                tree = self.light.node_tree
                build(tree, next(node for node in tree.nodes if node.type == "EMISSION"))
                ours, theirs = (self.colors(scene, name) for name in ("SLO_RT", "CYCLES"))
                np.testing.assert_allclose(ours, theirs, atol=0.01)

    def test_each_material_has_its_uv_map(self):
        scene = self.frame()
        thing = next(o for o in bpy.data.objects if o.type == "MESH" and o.location.y == 0.0)
        mesh = thing.data
        mesh.clear_geometry()
        corners = [(x, y, 0) for y in (-4, 4) for x in (-4, 0, 4)]
        mesh.from_pydata(corners, [], [(0, 1, 4, 3), (1, 2, 5, 4)])
        mesh.polygons[1].material_index = 1
        both = halves()
        trees = [self.tree, empty_material(thing, "Second")]
        for tree, name in zip(trees, ("Left", "Right")):
            node = textured(tree, both)
            add(tree, "ShaderNodeUVMap", None, node.inputs["Vector"]).uv_map = name
        for name, u in (("Left", 0.25), ("Right", 0.75)):
            for corner in mesh.uv_layers.new(name=name).uv:
                corner.vector = (u, 0.5)
        ours, theirs = (self.colors(scene, name) for name in ("SLO_RT", "CYCLES"))
        np.testing.assert_allclose(ours, theirs, atol=0.02)
        self.assertGreater(ours[0, 0], 0.9)
        self.assertGreater(ours[1, 1], 0.9)

    def test_a_volume_without_a_surface_is_not_seen(self):
        scene = self.frame()
        tree = self.tree
        volume = tree.nodes.new("ShaderNodeVolumePrincipled")
        volume.inputs["Density"].default_value = 0.001
        tree.links.new(volume.outputs[0], output_of(tree).inputs["Volume"])
        ours, theirs = (self.colors(scene, name) for name in ("SLO_RT", "CYCLES"))
        np.testing.assert_allclose(ours, theirs, atol=0.05)
        self.assertGreater(ours[:, 2].min(), 0.6)
        text = blend.export_text(animation=False)
        self.assertIn("has a volume and no surface", text)
        self.assertEqual(text.count("\nmesh "), 1)


class PhysicalLooksTest(LooksTest):
    """The same with the integrator PATH."""

    integrator = "PATH"
