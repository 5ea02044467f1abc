# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever a node has changes the exported scene, or is listed."""

import os
import subprocess
import unittest

import bpy

from slo_rt.convert.node_table import PHONG, PHYSICAL

from . import blend
from .test_nodes import GREEN, add, empty_material, halves, output_of, textured

# Blender's names of the nodes in the table.
KINDS = {
    "BSDF_PRINCIPLED": "ShaderNodeBsdfPrincipled",
    "BSDF_DIFFUSE": "ShaderNodeBsdfDiffuse",
    "BSDF_GLOSSY": "ShaderNodeBsdfAnisotropic",
    "BSDF_METALLIC": "ShaderNodeBsdfMetallic",
    "BSDF_GLASS": "ShaderNodeBsdfGlass",
    "BSDF_REFRACTION": "ShaderNodeBsdfRefraction",
    "BSDF_SHEEN": "ShaderNodeBsdfSheen",
    "EMISSION": "ShaderNodeEmission",
    "BACKGROUND": "ShaderNodeBackground",
    "BSDF_TRANSPARENT": "ShaderNodeBsdfTransparent",
    "MIX_SHADER": "ShaderNodeMixShader",
    "ADD_SHADER": "ShaderNodeAddShader",
    "OUTPUT_MATERIAL": "ShaderNodeOutputMaterial",
    "OUTPUT_WORLD": "ShaderNodeOutputWorld",
    "OUTPUT_LIGHT": "ShaderNodeOutputLight",
    "TEX_IMAGE": "ShaderNodeTexImage",
    "TEX_ENVIRONMENT": "ShaderNodeTexEnvironment",
    "NORMAL_MAP": "ShaderNodeNormalMap",
    "VOLUME_ABSORPTION": "ShaderNodeVolumeAbsorption",
    "MAPPING": "ShaderNodeMapping",
    "UVMAP": "ShaderNodeUVMap",
    "TEX_COORD": "ShaderNodeTexCoord",
    "RGB": "ShaderNodeRGB",
    "VALUE": "ShaderNodeValue",
}


class ListTest(unittest.TestCase):
    """Whatever a node has changes the exported scene, or is listed."""

    integrator = "DISTRIBUTED"
    entries = PHONG.entries
    # Surface shaders, with values that give other values an effect.
    shaders = {
        "BSDF_PRINCIPLED": {"Emission Strength": 1.0, "Transmission Weight": 0.5, "Metallic": 0.5},
        "BSDF_DIFFUSE": {},
        "BSDF_GLOSSY": {},
        "BSDF_METALLIC": {},
        "BSDF_GLASS": {},
        "EMISSION": {},
        "BSDF_TRANSPARENT": {},
    }

    def setUp(self):
        self.scene = blend.fresh_scene(integrator=self.integrator)
        self.thing = blend.cube()
        blend.lamp()

    def exported(self):
        """The text, with what is listed, and the textures."""
        path = blend.export(animation=False)
        with open(path, encoding="utf-8") as file:
            found = [file.read()]
        folder = os.path.splitext(path)[0]
        for name in sorted(os.listdir(folder)):
            with open(os.path.join(folder, name), "rb") as file:
                found.append(file.read())
        return found

    def check(self, what, change, undo):
        before = self.exported()
        change()
        self.assertNotEqual(self.exported(), before, what)
        undo()
        self.assertEqual(self.exported(), before, what)

    def check_sockets(self, tree, node):
        entry = self.entries[node.type]
        for socket in node.inputs:
            if not socket.enabled or socket.identifier in entry.follows:
                continue
            what = node.type, socket.identifier
            if socket.type != "SHADER":
                noise = tree.nodes.new("ShaderNodeTexNoise")
                before = list(link.from_socket for link in socket.links)
                self.check(
                    what,
                    lambda s=socket, n=noise: tree.links.new(n.outputs[0], s),
                    lambda s=socket, b=before: self.relink(tree, s, b),
                )
            if hasattr(socket, "default_value") and not socket.hide_value and not socket.is_linked:
                self.check_value(what, socket)

    def relink(self, tree, socket, sources):
        for link in list(socket.links):
            tree.links.remove(link)
        for source in sources:
            tree.links.new(source, socket)

    def check_value(self, what, socket):
        before = socket.default_value
        if hasattr(before, "__len__"):
            before = tuple(before)
            other = (0.31, 0.42, 0.53, 1.0)[: len(before)]
        else:
            other = 0.37
        self.check(
            what,
            lambda: setattr(socket, "default_value", other),
            lambda: setattr(socket, "default_value", before),
        )

    def check_properties(self, node):
        base = {p.identifier for p in bpy.types.ShaderNode.bl_rna.properties}
        entry = self.entries[node.type]
        for each in node.bl_rna.properties:
            name = each.identifier
            if name in base or each.type != "ENUM" or name in entry.follows:
                continue
            before = getattr(node, name)
            fine = entry.properties.get(name) or (before,)
            for item in each.enum_items:
                if item.identifier not in fine:
                    self.check(
                        (node.type, name, item.identifier),
                        lambda n=name, i=item: setattr(node, n, i.identifier),
                        lambda n=name, b=before: setattr(node, n, b),
                    )

    def test_the_table_knows_all_that_nodes_have(self):
        tree = empty_material(self.thing)
        base = {p.identifier for p in bpy.types.ShaderNode.bl_rna.properties}
        self.assertLessEqual(set(self.entries), set(KINDS))
        for kind, entry in self.entries.items():
            node = tree.nodes.new(KINDS[kind])
            self.assertEqual(node.type, kind)
            known = entry.read | entry.follows | set(entry.neutral) | {"Weight"}
            sockets = {socket.identifier for socket in node.inputs}
            self.assertLessEqual(sockets, known, kind)
            names = {each.identifier for each in node.bl_rna.properties} - base
            self.assertLessEqual(names, set(entry.properties) | entry.follows, kind)
            for name, value in entry.neutral.items():
                socket = next((s for s in node.inputs if s.identifier == name), None)
                if value is not None and socket:
                    fresh = socket.default_value
                    fresh = tuple(fresh) if hasattr(fresh, "__len__") else fresh
                    self.assertEqual(fresh, value, (kind, name))

    def test_sockets_and_properties_of_shaders(self):
        for kind, values in self.shaders.items():
            self.setUp()
            tree = empty_material(self.thing)
            surface = output_of(tree).inputs["Surface"]
            node = add(tree, KINDS[kind], None, surface)
            for name, value in values.items():
                node.inputs[name].default_value = value
            self.check_sockets(tree, node)
            self.check_properties(node)

    def test_sockets_of_outputs_and_mixes(self):
        tree = empty_material(self.thing)
        output = output_of(tree)
        mix = add(tree, "ShaderNodeMixShader", None, output.inputs["Surface"])
        for i, color in ((1, (1, 0, 0, 1)), (2, GREEN)):
            add(tree, "ShaderNodeBsdfDiffuse", color, mix.inputs[i])
        self.check_sockets(tree, mix)
        self.check_sockets(tree, output)
        for name, kind in (
            ("Volume", "ShaderNodeVolumeScatter"),
            ("Surface", "ShaderNodeBsdfToon"),
        ):
            node = tree.nodes.new(kind)
            before = list(link.from_socket for link in output.inputs[name].links)
            self.check(
                name,
                lambda n=node, s=name: tree.links.new(n.outputs[0], output.inputs[s]),
                lambda b=before, s=name: self.relink(tree, output.inputs[s], b),
            )

    def test_images(self):
        tree = empty_material(self.thing)
        node = textured(tree, halves())
        mapping = add(tree, "ShaderNodeMapping", None, node.inputs["Vector"])
        source = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(source.outputs["UV"], mapping.inputs["Vector"])
        self.check_properties(node)
        self.check_sockets(tree, mapping)
        mapping.vector_type = "NORMAL"
        self.assertIn("only the scale is carried", self.exported()[0])
        mapping.vector_type = "POINT"
        for name, value in (("translation", (0.5, 0, 0)), ("rotation", (0, 0, 1)), ("scale", (2, 1, 1)),
                            ("use_min", True), ("mapping_x", "Y")):  # fmt: skip
            before = getattr(node.texture_mapping, name)
            before = tuple(before) if hasattr(before, "copy") else before
            self.check(
                name,
                lambda n=name, v=value: setattr(node.texture_mapping, n, v),
                lambda n=name, b=before: setattr(node.texture_mapping, n, b),
            )
        for output in source.outputs:
            if output.name != "UV":
                tree.links.new(output, mapping.inputs["Vector"])
                self.assertIn(f"({output.name}) as texture coordinates is not", self.exported()[0])
        scaled = tree.nodes.new("ShaderNodeVectorMath")
        tree.links.new(scaled.outputs[0], mapping.inputs["Vector"])
        self.assertIn("Vector Math (Vector) as texture coordinates is not", self.exported()[0])
        self.assertNotIn("Vector is not carried", self.exported()[0])
        tree.links.new(source.outputs["UV"], mapping.inputs["Vector"])
        source.from_instancer = True
        self.assertIn("coordinates of the instancer", self.exported()[0])
        tree.links.remove(mapping.inputs["Vector"].links[0])
        self.assertIn("one point of the image", self.exported()[0])

    def test_sockets_of_worlds_and_lights(self):
        world = self.scene.world.node_tree
        self.check_sockets(world, world.nodes["Background"])
        out = output_of(world)
        node = world.nodes.new("ShaderNodeVolumeScatter")
        self.check(
            "volume",
            lambda: world.links.new(node.outputs[0], out.inputs["Volume"]),
            lambda: self.relink(world, out.inputs["Volume"], []),
        )
        light = bpy.data.objects["Lamp"].data
        light.use_nodes = True
        tree = light.node_tree
        lamp = next(node for node in tree.nodes if node.type == "EMISSION")
        self.check_sockets(tree, lamp)
        falloff = tree.nodes.new("ShaderNodeLightFalloff")
        tree.links.new(falloff.outputs["Linear"], lamp.inputs["Strength"])
        self.assertIn('light "Lamp": Light Falloff on Strength is not carried', self.exported()[0])
        tree.links.new(
            tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], output_of(tree).inputs[0]
        )
        self.assertIn('light "Lamp": Diffuse BSDF is not carried: it is black', self.exported()[0])

    def test_numbers_that_no_surface_has(self):
        """Values that only nodes can have; the program must accept the scene."""
        tree = empty_material(self.thing)
        shader = add(tree, "ShaderNodeBsdfPrincipled", None, output_of(tree).inputs["Surface"])
        for name in ("Metallic", "Roughness", "IOR", "Alpha", "Transmission Weight",
                     "Specular IOR Level", "Emission Strength", "Base Color"):  # fmt: skip
            for value in (-2.0, 7.0):
                node = add(tree, "ShaderNodeValue", None, shader.inputs[name])
                node.outputs[0].default_value = value
                path = blend.export(animation=False)
                check = [blend.program(), "--check", "--scene", path]
                done = subprocess.run(check, capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 0, (name, value, done.stderr))
                tree.links.remove(shader.inputs[name].links[0])
        node = add(tree, "ShaderNodeValue", None, shader.inputs["Emission Strength"])
        node.outputs[0].default_value = -1.0
        self.assertIn("negative light and colours are not carried", self.exported()[0])

    def test_negative_light(self):
        before = self.exported()[0]
        lamp = bpy.data.objects["Lamp"].data
        lamp.energy = -lamp.energy
        self.assertIn('light "Lamp": negative light', self.exported()[0])
        lamp.energy = -lamp.energy
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = -1.0
        self.assertIn('world "World": negative light', self.exported()[0])
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 1.0
        self.assertEqual(self.exported()[0], before)

    def test_strangers_are_matt_and_listed(self):
        for kind, words in (
            ("ShaderNodeBsdfToon", "a matt surface of its colour is"),
            ("ShaderNodeBsdfTranslucent", "a matt surface of its colour is"),
            ("ShaderNodeSubsurfaceScattering", "a matt surface of its colour is"),
            ("ShaderNodeBsdfRefraction", "glass of its colour is"),
            ("ShaderNodeHoldout", "it is black"),
        ):
            self.setUp()
            tree = empty_material(self.thing)
            node = add(tree, kind, None, output_of(tree).inputs["Surface"])
            if "Color" in node.inputs:
                node.inputs["Color"].default_value = (0.125, 0.25, 0.5, 1.0)
            text = self.exported()[0]
            self.assertIn(words, text)
            self.assertEqual("diffuse { 0.125 0.25 0.5 }" in text, "matt" in words)


class PhysicalListTest(ListTest):
    """The same with the integrator PATH."""

    integrator = "PATH"
    entries = PHYSICAL.entries
    shaders = {
        **ListTest.shaders,
        "BSDF_PRINCIPLED": {
            **ListTest.shaders["BSDF_PRINCIPLED"],
            "Anisotropic": 0.5, "Coat Weight": 0.5, "Sheen Weight": 0.5,
        },
        "BSDF_GLOSSY": {"Anisotropy": 0.5},
        "BSDF_METALLIC": {"Anisotropy": 0.5},
        "BSDF_REFRACTION": {},
        "BSDF_SHEEN": {},
    }  # fmt: skip

    def test_images(self):
        tree = empty_material(self.thing)
        node = textured(tree, halves())
        mapping = add(tree, "ShaderNodeMapping", None, node.inputs["Vector"])
        source = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(source.outputs["UV"], mapping.inputs["Vector"])
        self.check_properties(node)
        self.check_sockets(tree, mapping)
        for name, values in (("interpolation", ("Closest",)), ("extension", ("EXTEND", "MIRROR"))):
            before = getattr(node, name)
            for value in values:
                self.check(
                    value,
                    lambda n=name, v=value: setattr(node, n, v),
                    lambda n=name, b=before: setattr(node, n, b),
                )
                setattr(node, name, value)
                self.assertNotIn("not carried", self.exported()[0])
                setattr(node, name, before)
        mapping.vector_type = "NORMAL"
        self.assertIn("mapping of type Normal is not carried", self.exported()[0])
        mapping.vector_type = "POINT"
        mapping.inputs["Rotation"].default_value[0] = 1.0
        self.assertIn("only the rotation about z is carried", self.exported()[0])
        for output in source.outputs:
            if output.name != "UV":
                tree.links.new(output, mapping.inputs["Vector"])
                self.assertIn(f"({output.name}) as texture coordinates is not", self.exported()[0])

    def test_skies(self):
        world = self.scene.world.node_tree
        node = world.nodes.new("ShaderNodeTexEnvironment")
        node.image = halves()
        world.links.new(node.outputs[0], world.nodes["Background"].inputs["Color"])
        self.assertNotIn("not carried", self.exported()[0])
        self.check_properties(node)
        mapping = add(world, "ShaderNodeMapping", None, node.inputs["Vector"])
        source = world.nodes.new("ShaderNodeTexCoord")
        world.links.new(source.outputs["Generated"], mapping.inputs["Vector"])
        self.assertNotIn("not carried", self.exported()[0])
        self.check_sockets(world, mapping)
        world.links.new(source.outputs["Camera"], mapping.inputs["Vector"])
        self.assertIn("(Camera) as coordinates of the sky is not carried", self.exported()[0])
        sky = world.nodes.new("ShaderNodeTexSky")
        world.links.new(sky.outputs[0], world.nodes["Background"].inputs["Color"])
        self.assertIn("Sky Texture on Color is not carried", self.exported()[0])

    def test_normal_maps(self):
        tree = empty_material(self.thing)
        shader = add(tree, "ShaderNodeBsdfPrincipled", None, output_of(tree).inputs["Surface"])
        node = add(tree, "ShaderNodeNormalMap", None, shader.inputs["Normal"])
        node.inputs["Strength"].default_value = 0.5
        image = add(tree, "ShaderNodeTexImage", None, node.inputs["Color"])
        image.image = halves()
        self.assertIn("normal_strength 0.5", self.exported()[0])
        self.assertNotIn("not carried", self.exported()[0])
        self.check_properties(node)
        self.check_sockets(tree, node)
        node.uv_map = "Other"
        self.assertIn("a normal map's own uv map is not carried", self.exported()[0])

    def test_what_glass_absorbs(self):
        tree = empty_material(self.thing)
        output = output_of(tree)
        add(tree, "ShaderNodeBsdfGlass", None, output.inputs["Surface"])
        node = add(tree, "ShaderNodeVolumeAbsorption", None, output.inputs["Volume"])
        self.assertNotIn("not carried", self.exported()[0])
        self.check_sockets(tree, node)
        add(tree, "ShaderNodeBsdfDiffuse", None, output.inputs["Surface"])
        self.assertIn("volume is not carried", self.exported()[0])

    def test_strangers_are_matt_and_listed(self):
        for kind, words in (
            ("ShaderNodeBsdfToon", "a matt surface of its colour is"),
            ("ShaderNodeBsdfTranslucent", "a matt surface of its colour is"),
            ("ShaderNodeSubsurfaceScattering", "a matt surface of its colour is"),
            ("ShaderNodeBsdfRefraction", "glass that reflects at its rim is"),
            ("ShaderNodeHoldout", "it is black"),
        ):
            self.setUp()
            tree = empty_material(self.thing)
            node = add(tree, kind, None, output_of(tree).inputs["Surface"])
            if "Color" in node.inputs:
                node.inputs["Color"].default_value = (0.125, 0.25, 0.5, 1.0)
            text = self.exported()[0]
            self.assertIn(words, text)
            self.assertEqual("base_color { 0.125 0.25 0.5 }" in text, "matt" in words)
