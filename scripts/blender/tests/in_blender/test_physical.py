# SPDX-License-Identifier: GPL-3.0-or-later
"""Text of physical materials, lamps and skies: units, names, images."""

import math
import os
import unittest

import bpy
import numpy as np

from slo_rt.format.principled import tint_of_even_metal

from .. import scene_reader
from . import blend
from .light_scenes import image, textured
from .test_nodes import add, empty_material, output_of


class PhysicalTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene(integrator="PATH")
        self.thing = blend.cube()

    def exported(self, **options):
        self.path = blend.export(animation=False, **options)
        with open(self.path, encoding="utf-8") as file:
            self.text = file.read()
        return scene_reader.read(self.text)

    def picture(self, name):
        """Pixels of an exported image as Blender reads them, (height, width, channels)."""
        path = os.path.join(os.path.splitext(self.path)[0], name)
        found = bpy.data.images.load(path)
        found.colorspace_settings.name = "Non-Color"
        width, height = found.size
        pixels = np.array(found.pixels[:]).reshape(height, width, -1)
        bpy.data.images.remove(found)
        return pixels


class MaterialTest(PhysicalTest):
    SOCKETS = {
        "Base Color": ("base_color", (0.1, 0.2, 0.3)),
        "Metallic": ("metallic", 0.25),
        "Roughness": ("roughness", 0.25),
        "IOR": ("ior", 1.25),
        "Alpha": ("alpha", 0.25),
        "Diffuse Roughness": ("diffuse_roughness", 0.25),
        "Specular IOR Level": ("specular_ior_level", 0.25),
        "Specular Tint": ("specular_tint", (0.1, 0.2, 0.3)),
        "Anisotropic": ("anisotropic", 0.25),
        "Anisotropic Rotation": ("anisotropic_rotation", 0.25),
        "Transmission Weight": ("transmission", 0.25),
        "Coat Weight": ("coat", 0.25),
        "Coat Roughness": ("coat_roughness", 0.25),
        "Coat IOR": ("coat_ior", 1.25),
        "Coat Tint": ("coat_tint", (0.1, 0.2, 0.3)),
        "Sheen Weight": ("sheen", 0.25),
        "Sheen Roughness": ("sheen_roughness", 0.25),
        "Sheen Tint": ("sheen_tint", (0.1, 0.2, 0.3)),
        "Emission Color": ("emission_color", (2.5, 0.5, 0.25)),
        "Emission Strength": ("emission_strength", 2.5),
    }
    SWITCHES = ("Anisotropic", "Coat Weight", "Sheen Weight", "Emission Strength")

    def test_defaults_are_not_written(self):
        blend.paint(self.thing)
        block = self.exported().one("material_principled", "Paint")
        self.assertEqual((block.values, block.inner), ({}, []))

    def test_every_socket(self):
        shader = blend.paint(self.thing)
        for socket, (_, value) in self.SOCKETS.items():
            wanted = (*value, 1.0) if isinstance(value, tuple) else value
            shader.inputs[socket].default_value = wanted
        block = self.exported().one("material_principled", "Paint")
        self.assertEqual(set(block.values), {name for name, _ in self.SOCKETS.values()})
        for name, value in self.SOCKETS.values():
            found = block.vector(name) if isinstance(value, tuple) else block.number(name)
            np.testing.assert_allclose(found, value, rtol=1e-6)

    def test_every_socket_from_an_image(self):
        shader = blend.paint(self.thing)
        for name in self.SWITCHES:
            shader.inputs[name].default_value = 0.5
        tree = shader.id_data
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image(np.full((4, 4, 3), 0.5), "Grey", "Non-Color")
        separate = tree.nodes.new("ShaderNodeSeparateColor")
        tree.links.new(node.outputs["Color"], separate.inputs[0])
        for socket, (name, value) in self.SOCKETS.items():
            is_color = isinstance(value, tuple)
            output = node.outputs["Color"] if is_color else separate.outputs["Green"]
            tree.links.new(output, shader.inputs[socket])
            block = self.exported().one("material_principled", "Paint")
            self.assertNotIn(name, block.values, socket)
            if is_color:
                self.assertEqual(block.values[f"{name}_texture"], [["Grey"]])
            else:
                use = block.one(f"{name}_texture")
                self.assertEqual(use.values, {"texture": [["Grey"]], "channel": [["G"]]})
            tree.links.remove(shader.inputs[socket].links[0])

    def test_limits(self):
        shader = blend.paint(self.thing)
        for name, below, above in (
            ("metallic", 0.0, 1.0), ("roughness", 0.0, 1.0), ("alpha", 0.0, 1.0),
            ("ior", 1.0, 7.0), ("transmission", 0.0, 1.0), ("specular_ior_level", 0.0, 1.0),
        ):  # fmt: skip
            socket = next(s for s, (n, _) in self.SOCKETS.items() if n == name)
            for value, wanted in ((-2.0, below), (7.0, above)):
                node = add(shader.id_data, "ShaderNodeValue", None, shader.inputs[socket])
                node.outputs[0].default_value = value
                block = self.exported().one("material_principled", "Paint")
                default = {"alpha": 1.0, "metallic": 0.0, "transmission": 0.0}.get(name)
                self.assertAlmostEqual(block.number(name, default), wanted, places=6)
            shader.id_data.links.remove(shader.inputs[socket].links[0])

    def test_constants_are_computed(self):
        shader = blend.paint(self.thing)
        tree = shader.id_data
        math_node = add(tree, "ShaderNodeMath", None, shader.inputs["Roughness"])
        math_node.operation = "MULTIPLY"
        math_node.inputs[1].default_value = 0.5
        value = add(tree, "ShaderNodeValue", None, math_node.inputs[0])
        value.outputs[0].default_value = 0.5
        invert = add(tree, "ShaderNodeInvert", (0.25, 0.5, 0.75, 1.0), shader.inputs["Base Color"])
        self.assertEqual(invert.inputs["Fac"].default_value, 1.0)
        mix = tree.nodes.new("ShaderNodeMix")
        mix.data_type, mix.blend_type = "RGBA", "ADD"
        mix.inputs[0].default_value = 0.5
        for name, color in (("A", (0.1, 0.2, 0.3, 1.0)), ("B", (0.2, 0.2, 0.2, 1.0))):
            socket = next(s for s in mix.inputs if s.identifier == f"{name}_Color")
            socket.default_value = color
        output = next(s for s in mix.outputs if s.identifier == "Result_Color")
        tree.links.new(output, shader.inputs["Specular Tint"])
        block = self.exported().one("material_principled", "Paint")
        self.assertAlmostEqual(block.number("roughness"), 0.25)
        np.testing.assert_allclose(block.vector("base_color"), (0.75, 0.5, 0.25), rtol=1e-6)
        np.testing.assert_allclose(block.vector("specular_tint"), (0.2, 0.3, 0.4), rtol=1e-6)
        self.assertNotIn("not carried", self.text)

    def test_images_times_constants(self):
        shader = blend.paint(self.thing)
        tree = shader.id_data
        picture = image(np.full((4, 4, 3), 0.5), "Grey", "sRGB")
        mix = tree.nodes.new("ShaderNodeMix")
        mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
        mix.inputs[0].default_value = 1.0
        sockets = {s.identifier: s for s in (*mix.inputs, *mix.outputs)}
        sockets["B_Color"].default_value = (0.25, 0.5, 0.75, 1.0)
        textured(tree, picture, sockets["A_Color"])
        tree.links.new(sockets["Result_Color"], shader.inputs["Base Color"])
        block = self.exported().one("material_principled", "Paint")
        self.assertEqual(block.values["base_color_texture"], [["Grey"]])
        np.testing.assert_allclose(block.vector("base_color"), (0.25, 0.5, 0.75))
        self.assertNotIn("not carried", self.text)
        mix.blend_type = "SCREEN"
        block = self.exported().one("material_principled", "Paint")
        self.assertIn("Mix on Base Color is not carried, the image behind it is", self.text)
        self.assertNotIn("base_color", block.values)

    def test_mapping(self):
        shader = blend.paint(self.thing)
        tree = shader.id_data
        node = textured(tree, image(np.ones((4, 4, 3)), "P", "sRGB"), shader.inputs["Base Color"])
        mapping = add(tree, "ShaderNodeMapping", None, node.inputs["Vector"])
        source = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(source.outputs["UV"], mapping.inputs["Vector"])
        point = np.array([0.3, 0.8])
        for kind, scale in (
            ("POINT", (2.0, 3.0)),
            ("TEXTURE", (2.0, 2.0)),
            ("VECTOR", (2.0, -1.0)),
        ):
            mapping.vector_type = kind
            place, turn = np.array([0.2, 0.7]), 0.4
            mapping.inputs["Scale"].default_value = (*scale, 1.0)
            mapping.inputs["Rotation"].default_value = (0.0, 0.0, turn)
            if kind != "VECTOR":
                mapping.inputs["Location"].default_value = (*place, 0.0)
            rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            wanted = {
                "POINT": rotation @ (point * scale) + place,
                "TEXTURE": (rotation.T @ (point - place)) / scale,
                "VECTOR": rotation @ (point * scale),
            }[kind]
            use = self.exported().one("material_principled", "Paint").one("base_color_texture")
            scales = [use.number(f"scale_{axis}", 1.0) for axis in "UV"]
            offsets = [use.number(f"offset_{axis}", 0.0) for axis in "UV"]
            angle = math.radians(use.number("turn_deg", 0.0))
            ours = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            np.testing.assert_allclose(ours @ (point * scales) + offsets, wanted, atol=1e-5)
            self.assertNotIn("not carried", self.text)

    def test_alpha_of_an_image(self):
        shader = blend.paint(self.thing)
        pixels = np.zeros((4, 4, 4))
        pixels[..., 0], pixels[..., 3] = 1.0, np.linspace(0.2, 1.0, 4)
        picture = image(pixels, "Leaf", "sRGB")
        node = textured(shader.id_data, picture, shader.inputs["Base Color"])
        block = self.exported().one("material_principled", "Paint")
        self.assertEqual(self.picture("Leaf.png").shape[2], 4)  # Blender adds an alpha of 1
        np.testing.assert_allclose(self.picture("Leaf.png")[0, :, 0], pixels[0, :, 3], atol=0.003)
        shader.id_data.links.new(node.outputs["Alpha"], shader.inputs["Alpha"])
        block = self.exported().one("material_principled", "Paint")
        use = block.one("alpha_texture")
        self.assertEqual(use.values, {"texture": [["Leaf"]], "channel": [["A"]]})
        self.assertEqual(block.values["base_color_texture"], [["Leaf"]])
        found = self.picture("Leaf_alpha.png")
        np.testing.assert_allclose(found[0, :, 3], pixels[0, :, 3], atol=0.003)
        np.testing.assert_array_equal(found[..., 0], 1.0)

    def test_brightness_of_an_image_with_alpha_as_alpha(self):
        """`alpha_texture` would take the image's alpha."""
        shader = blend.paint(self.thing)
        node = textured(
            shader.id_data, image(np.full((4, 4, 4), 0.5), "P", "sRGB"), shader.inputs["Alpha"]
        )
        shader.id_data.links.new(node.outputs["Alpha"], shader.inputs["Roughness"])
        scene = self.exported()
        mix = scene.one("material_mix", "Paint")
        self.assertEqual(mix.values["factor_texture"], [["P"]])
        self.assertEqual(scene.one("material_principled", "Paint_1").number("alpha"), 0.0)

    def test_bytes_floats_and_their_curves(self):
        cases = (
            ("sRGB", False, "SRGB", "png"), ("Non-Color", False, "RAW", "png"),
            ("Linear Rec.709", True, "RAW", "exr"), ("Non-Color", True, "RAW", "exr"),
        )  # fmt: skip
        for space, is_float, encoding, ending in cases:
            self.setUp()
            shader = blend.paint(self.thing)
            values = np.random.default_rng(7).random((5, 19, 3)) * (9.0 if is_float else 1.0)
            if not is_float:
                values = np.rint(values * 255.0) / 255.0
            picture = image(values, "P", space, is_float)
            textured(shader.id_data, picture, shader.inputs["Base Color"])
            block = self.exported().one("texture", "P")
            self.assertEqual(block.values["encoding"], [[encoding]])
            self.assertEqual(block.values["filename"], [[f"scene/P.{ending}"]])
            np.testing.assert_allclose(self.picture(f"P.{ending}")[..., :3], values, rtol=1e-6)
            self.assertEqual(self.text.count("#"), 1, self.text)

    def test_wrap_and_filter(self):
        shader = blend.paint(self.thing)
        picture = image(np.ones((4, 4, 3)), "P", "sRGB")
        node = textured(shader.id_data, picture, shader.inputs["Base Color"])
        for extension, wrap in (("REPEAT", None), ("EXTEND", "CLAMP"), ("MIRROR", "MIRROR")):
            node.extension = extension
            values = self.exported().one("texture", "P").values
            self.assertEqual(values.get("wrap"), wrap and [[wrap]])
            self.assertNotIn("filter", values)
        node.interpolation = "Closest"
        self.assertEqual(self.exported().one("texture", "P").values["filter"], [["NEAREST"]])
        node.extension = "CLIP"
        self.exported()
        self.assertIn("its rim goes on, as with Extend", self.text)

    def test_two_ways_to_sample_one_image_share_its_file(self):
        shader = blend.paint(self.thing)
        picture = image(np.ones((4, 4, 3)), "P", "sRGB")
        textured(shader.id_data, picture, shader.inputs["Base Color"])
        textured(shader.id_data, picture, shader.inputs["Specular Tint"]).interpolation = "Closest"
        scene = self.exported()
        files = [block.values["filename"] for block in scene.all("texture")]
        self.assertEqual(files, [[["scene/P.png"]]] * 2)

    def test_uv_maps(self):
        shader = blend.paint(self.thing)
        tree = shader.id_data
        for socket, name in (("Base Color", "UVMap"), ("Specular Tint", "Other")):
            node = textured(tree, image(np.ones((4, 4, 3)), "P", "sRGB"), shader.inputs[socket])
            add(tree, "ShaderNodeUVMap", None, node.inputs["Vector"]).uv_map = name
        self.exported()
        self.assertIn("all its images use one uv map", self.text)

    def test_no_material_is_grey_and_matt(self):
        scene = self.exported()
        block = scene.one("material_principled")
        np.testing.assert_allclose(block.vector("base_color", (0.8,) * 3), (0.8,) * 3)
        self.assertEqual((block.number("ior"), block.number("specular_ior_level")), (1.0, 0.0))

    def test_own_phong_values_stay(self):
        blend.paint(self.thing)
        self.thing.data.materials[0].slo_rt.use_own = True
        scene = self.exported()
        scene.one("phong_info", "Paint")
        scene.one("material_phong", "Paint")


class ShaderTest(PhysicalTest):
    """Shaders that are settings of the Principled BSDF, and mixes of them."""

    def setUp(self):
        super().setUp()
        self.tree = empty_material(self.thing)
        self.output = output_of(self.tree).inputs["Surface"]

    def shader(self, kind, to=None, **values):
        node = add(self.tree, kind, None, to or self.output)
        for name, value in values.items():
            node.inputs[name.replace("_", " ")].default_value = value
        return node

    def mixed(self, kind="ShaderNodeMixShader", factor=None):
        node = self.shader(kind)
        if factor is not None:
            node.inputs[0].default_value = factor
        return node, [socket for socket in node.inputs if socket.type == "SHADER"]

    def one(self):
        return self.exported().one("material_principled", "Paint")

    def test_diffuse(self):
        self.shader("ShaderNodeBsdfDiffuse", Color=(0.1, 0.2, 0.3, 1.0), Roughness=0.5)
        block = self.one()
        np.testing.assert_allclose(block.vector("base_color"), (0.1, 0.2, 0.3), rtol=1e-6)
        self.assertEqual(block.number("diffuse_roughness"), 0.5)
        self.assertEqual((block.number("ior"), block.number("specular_ior_level")), (1.0, 0.0))

    def test_glossy_reflects_alike_at_all_angles(self):
        self.shader("ShaderNodeBsdfAnisotropic", Color=(0.5, 0.25, 1.0, 1.0), Roughness=0.25)
        block = self.one()
        self.assertEqual(block.number("metallic"), 1.0)
        color = block.vector("base_color")
        np.testing.assert_allclose(color, (0.5, 0.25, 1.0))
        np.testing.assert_allclose(
            block.vector("specular_tint", (1.0,) * 3), tint_of_even_metal(color), rtol=1e-6
        )

    def test_metallic(self):
        node = self.shader("ShaderNodeBsdfMetallic")
        node.inputs["Edge Tint"].default_value = (0.25, 0.5, 0.75, 1.0)
        np.testing.assert_allclose(self.one().vector("specular_tint"), (0.25, 0.5, 0.75))
        node.fresnel_type = "PHYSICAL_CONDUCTOR"
        n, k = (np.array(node.inputs[name].default_value) for name in ("IOR", "Extinction"))
        facing = ((n - 1.0) ** 2 + k * k) / ((n + 1.0) ** 2 + k * k)
        np.testing.assert_allclose(self.one().vector("base_color"), facing, rtol=1e-5)
        self.assertNotIn("not carried", self.text)

    def test_glass_is_tinted_at_each_surface(self):
        self.shader("ShaderNodeBsdfGlass", Color=(0.5, 1.0, 0.25, 1.0), Roughness=0.25, IOR=1.25)
        block = self.one()
        np.testing.assert_allclose(np.sqrt(block.vector("base_color")), (0.5, 1.0, 0.25), rtol=1e-6)
        self.assertEqual(block.number("transmission"), 1.0)
        self.assertEqual((block.number("ior"), block.number("roughness")), (1.25, 0.25))

    def test_absorption(self):
        self.shader("ShaderNodeBsdfGlass")
        volume = add(
            self.tree, "ShaderNodeVolumeAbsorption", (0.25, 0.5, 1.0, 1.0),
            output_of(self.tree).inputs["Volume"],
        )  # fmt: skip
        volume.inputs["Density"].default_value = 4.0
        block = self.one()
        distance = block.number("absorption_distance")
        left = np.array(block.vector("absorption_color")) ** (0.5 / distance)
        np.testing.assert_allclose(left, np.exp(-4.0 * 0.5 * np.array([0.75, 0.5, 0.0])), rtol=1e-6)

    def test_sheen(self):
        self.shader("ShaderNodeBsdfSheen", Color=(0.1, 0.2, 0.3, 1.0), Roughness=0.25)
        block = self.one()
        self.assertEqual((block.number("sheen"), block.number("sheen_roughness")), (1.0, 0.25))
        self.assertEqual(block.vector("base_color"), [0.0] * 3)

    def test_emission(self):
        self.shader("ShaderNodeEmission", Color=(3.0, 0.5, 0.25, 1.0), Strength=2.0)
        block = self.one()
        self.assertEqual(block.vector("emission_color"), [3.0, 0.5, 0.25])
        self.assertEqual(block.number("emission_strength"), 2.0)
        self.assertEqual(block.vector("base_color"), [0.0] * 3)

    def test_transparent(self):
        self.shader("ShaderNodeBsdfTransparent")
        self.assertEqual(self.one().number("alpha"), 0.0)

    def test_mixes(self):
        node, (first, second) = self.mixed(factor=0.25)
        self.shader("ShaderNodeBsdfDiffuse", first)
        self.shader("ShaderNodeBsdfGlass", second)
        scene = self.exported()
        block = scene.one("material_mix", "Paint")
        names = [block.values[name][0][0] for name in ("first", "second")]
        self.assertEqual(block.number("factor"), 0.25)
        self.assertEqual(scene.one("material_principled", names[1]).number("transmission"), 1.0)
        textured(self.tree, image(np.ones((4, 4, 3)), "F", "Non-Color"), node.inputs[0])
        block = self.exported().one("material_mix", "Paint")
        self.assertEqual(block.values["factor_texture"], [["F"]])
        self.assertNotIn("factor", block.values)

    def test_mixes_with_nothing_are_alpha(self):
        for order in (0, 1):
            self.setUp()
            node, sockets = self.mixed(factor=0.25)
            self.shader("ShaderNodeBsdfTransparent", sockets[order])
            self.shader("ShaderNodeBsdfDiffuse", sockets[1 - order])
            self.assertEqual(self.one().number("alpha"), (0.25, 0.75)[order])
        picture = image(np.ones((4, 4, 4)), "F", "Non-Color")
        textured(self.tree, picture, node.inputs[0], "Alpha")
        scene = self.exported()
        self.assertEqual(scene.one("material_mix").one("factor_texture").values["channel"], [["A"]])
        self.assertEqual(scene.one("material_principled", "Paint_2").number("alpha"), 0.0)

    def test_sums(self):
        _, (first, second) = self.mixed("ShaderNodeAddShader")
        self.shader("ShaderNodeBsdfDiffuse", first, Color=(0.25, 0.5, 0.125, 1.0))
        self.shader("ShaderNodeEmission", second, Strength=2.0)
        block = self.one()
        self.assertEqual(block.vector("base_color"), [0.25, 0.5, 0.125])
        self.assertEqual(block.number("emission_strength"), 2.0)
        self.shader("ShaderNodeBsdfAnisotropic", second, Color=(0.5, 0.25, 0.0, 1.0))
        scene = self.exported()
        self.assertEqual(scene.one("material_mix", "Paint").number("factor"), 0.5)
        half = scene.one("material_principled", "Paint_1")
        self.assertEqual(half.vector("base_color"), [0.5, 1.0, 0.25])
        self.assertNotIn("even mix", self.text)
        self.shader("ShaderNodeBsdfGlass", second)
        self.exported()
        self.assertIn("carried as an even mix", self.text)

    def test_light_added_to_a_transparent_surface(self):
        _, (first, second) = self.mixed("ShaderNodeAddShader")
        self.shader("ShaderNodeBsdfPrincipled", first, Alpha=0.5, Emission_Strength=1.0)
        self.shader("ShaderNodeEmission", second, Strength=2.0)
        block = self.one()
        np.testing.assert_allclose(block.vector("emission_color"), [5.0] * 3)
        self.shader("ShaderNodeBsdfTransparent", first)
        self.exported()
        self.assertIn("added to a transparent surface is not carried", self.text)


class LampTest(PhysicalTest):
    """Lamps by the table of Blender's units."""

    def lamp(self, kind, **values):
        thing = blend.lamp("Lamp", kind, (1.0, 2.0, 3.0), 100.0)
        thing.data.color = (1.0, 0.5, 0.25)
        for name, value in values.items():
            setattr(thing.data, name, value)
        return thing

    def block(self, kind):
        return self.exported().one(kind, "Lamp")

    def test_point(self):
        thing = self.lamp("POINT")
        block = self.block("lamp_point")
        np.testing.assert_allclose(block.vector("power"), (100.0, 50.0, 25.0), rtol=1e-6)
        self.assertEqual(block.vector("position"), [1.0, 2.0, 3.0])
        self.assertEqual(set(block.values), {"power", "position"})
        thing.data.shadow_soft_size = 0.5
        block = self.block("lamp_point")
        self.assertIn("soft falloff", self.text)
        self.assertEqual(block.number("radius"), 0.5)
        self.assertEqual((block.number("camera_visible"), block.number("solid")), (0.0, 0.0))
        thing.visible_camera, thing.data.use_soft_falloff = True, False
        block = self.block("lamp_point")
        self.assertNotIn("camera_visible", block.values)
        self.assertNotIn("soft falloff", self.text)

    def test_power_without_normalization(self):
        self.lamp("POINT", normalize=False)
        power = self.block("lamp_point").vector("power")[0]
        self.assertAlmostEqual(power / (4.0 * math.pi), 100.0 / math.pi, places=4)
        bpy.data.lights["Lamp"].shadow_soft_size = 0.5
        power = self.block("lamp_point").vector("power")[0]
        self.assertAlmostEqual(power / (4.0 * math.pi**2 * 0.25), 100.0 / math.pi, places=4)

    def test_exposure_and_temperature(self):
        thing = self.lamp("POINT", exposure=1.0, use_temperature=True, temperature=3000.0)
        wanted = np.array([200.0, 100.0, 50.0]) * np.array(thing.data.temperature_color)
        np.testing.assert_allclose(self.block("lamp_point").vector("power"), wanted, rtol=1e-5)

    def test_spot(self):
        thing = self.lamp("SPOT", spot_size=1.0, spot_blend=0.25)
        thing.rotation_euler.x = math.pi / 2.0
        block = self.block("lamp_spot")
        solid_angle = 2.0 * math.pi * (1.0 - math.cos(0.5))
        intensity = block.vector("power")[0] / solid_angle
        self.assertAlmostEqual(intensity, 100.0 / (4.0 * math.pi), places=4)
        self.assertAlmostEqual(block.number("angle_deg"), math.degrees(1.0), places=4)
        self.assertEqual(block.number("blend"), 0.25)
        np.testing.assert_allclose(block.vector("target"), (1.0, 3.0, 3.0), atol=1e-6)
        thing.scale = (2.0, 2.0, 1.0)
        block = self.block("lamp_spot")
        half = math.radians(block.number("angle_deg") / 2.0)
        self.assertAlmostEqual(math.tan(half), 2.0 * math.tan(0.5), places=5)
        solid_angle = 2.0 * math.pi * (1.0 - math.cos(half))
        self.assertAlmostEqual(block.vector("power")[0] / solid_angle, intensity, places=4)

    def test_sun(self):
        thing = self.lamp("SUN", angle=0.25)
        thing.rotation_euler.x = math.pi / 2.0
        block = self.block("lamp_sun")
        np.testing.assert_allclose(block.vector("irradiance"), (100.0, 50.0, 25.0), rtol=1e-6)
        np.testing.assert_allclose(block.vector("direction"), (0.0, 1.0, 0.0), atol=1e-6)
        self.assertAlmostEqual(block.number("angle_deg"), math.degrees(0.25), places=5)
        thing.data.normalize = False
        area = math.pi * math.sin(0.125) ** 2
        self.assertAlmostEqual(self.block("lamp_sun").vector("irradiance")[0], 100.0 * area, 4)

    def test_areas(self):
        thing = self.lamp("AREA", shape="RECTANGLE", size=2.0, size_y=1.0)
        thing.rotation_euler = (0.5, 0.25, 1.0)
        for scale in ((1.0, 1.0, 1.0), (2.0, 3.0, 1.0), (-1.0, 1.0, 1.0)):
            thing.scale = scale
            block = self.block("lamp_rectangle")
            np.testing.assert_allclose(block.vector("power"), (100.0, 50.0, 25.0), rtol=1e-6)
            corners = np.array([block.vector(f"vertex{i}") for i in range(3)])
            sides = np.diff(corners, axis=0)
            area = np.linalg.norm(np.cross(*sides))
            self.assertAlmostEqual(area, 2.0 * abs(scale[0] * scale[1]), places=5)
            np.testing.assert_allclose((corners[0] + corners[2]) / 2.0, (1.0, 2.0, 3.0), atol=1e-5)
            bpy.context.view_layer.update()
            along = -np.array(thing.matrix_world)[:3, 2]
            self.assertAlmostEqual(np.dot(np.cross(*sides), along) / area, 1.0, places=5)
        thing.data.normalize = False
        self.assertAlmostEqual(self.block("lamp_rectangle").vector("power")[0], 200.0, places=3)

    def test_discs(self):
        thing = self.lamp("AREA", shape="DISK", size=2.0)
        thing.rotation_euler.x = math.pi / 2.0
        block = self.block("lamp_disc")
        self.assertEqual((block.number("radius"), block.vector("center")), (1.0, [1.0, 2.0, 3.0]))
        np.testing.assert_allclose(block.vector("normal"), (0.0, 1.0, 0.0), atol=1e-6)
        self.assertEqual(block.vector("power")[0], 100.0)
        thing.data.shape, thing.data.size_y = "ELLIPSE", 0.5
        self.assertAlmostEqual(self.block("lamp_disc").number("radius"), 0.5)
        self.assertIn("an ellipse becomes a disc of the same area", self.text)

    def test_light_groups(self):
        self.lamp("POINT")
        bpy.data.objects["Lamp"].lightgroup = "Key light"
        self.scene.world.lightgroup = "Sky"
        self.thing.lightgroup = "Screen"
        shader = blend.paint(self.thing)
        scene = self.exported()
        self.assertEqual(scene.one("lamp_point").values["light_group"], [["Key_light"]])
        self.assertEqual(scene.one("environment").values["light_group"], [["Sky"]])
        self.assertNotIn("light_group", scene.one("mesh").values)
        shader.inputs["Emission Strength"].default_value = 1.0
        self.thing.data.materials[0].cycles.emission_sampling = "NONE"
        mesh = self.exported().one("mesh")
        self.assertEqual(mesh.values["light_group"], [["Screen"]])
        self.assertEqual(mesh.number("sampled"), 0.0)

    def test_moving_lamps(self):
        thing = self.lamp("SPOT", spot_size=1.0)
        for frame, x, turn in ((1, 0.0, 0.0), (13, 2.0, 1.0), (25, 5.0, 0.5)):
            blend.key(thing, "location", frame, (x, 1.0, 3.0))
            blend.key(thing, "rotation_euler", frame, (turn, 0.0, 0.5))
        text = blend.export_text()
        self.assertNotIn("lights don't move", text)
        lamp = scene_reader.read(text).one("lamp_spot")
        for frame in (1.0, 4.5, 13.0, 20.0):
            self.scene.frame_set(int(frame), subframe=frame % 1.0)
            matrix = np.array(thing.matrix_world)
            pivot, axes = scene_reader.placement(lamp, frame / 24.0)
            turn = np.array(axes).T
            position = turn @ lamp.vector("position") + pivot
            target = turn @ lamp.vector("target") + pivot
            np.testing.assert_allclose(position, matrix[:3, 3], atol=1e-3)
            np.testing.assert_allclose(target - position, -matrix[:3, 2], atol=2e-3)


class WorldTest(PhysicalTest):
    def background(self):
        return self.scene.world.node_tree.nodes["Background"]

    def sky(self):
        """An Environment Texture; returns its node."""
        tree = self.scene.world.node_tree
        node = add(tree, "ShaderNodeTexEnvironment", None, self.background().inputs["Color"])
        values = np.random.default_rng(3).random((4, 8, 3)) * 1e5
        self.values = values.astype(np.float32)
        node.image = image(values, "Sky", "Linear Rec.709", is_float=True)
        return node

    def test_color(self):
        self.background().inputs[0].default_value = (0.25, 0.5, 1.0, 1.0)
        self.background().inputs[1].default_value = 2.0
        scene = self.exported()
        self.assertEqual(scene.one("environment").vector("radiance"), [0.5, 1.0, 2.0])
        self.assertNotIn("background", scene.one("settings").values)
        self.scene.world.cycles_visibility.camera = False
        self.assertEqual(self.exported().one("environment").number("camera_visible"), 0.0)
        self.background().inputs[1].default_value = 0.0
        self.assertEqual(self.exported().all("environment"), [])

    def test_image(self):
        self.sky()
        self.background().inputs[1].default_value = 2.0
        scene = self.exported()
        block = scene.one("environment")
        self.assertEqual(block.values["texture"], [["Sky"]])
        self.assertEqual(block.number("strength"), 2.0)
        self.assertEqual(set(block.values), {"texture", "strength"})
        np.testing.assert_array_equal(self.picture("Sky.exr")[..., :3], self.values)

    def test_a_radiance_file_is_copied(self):
        node = self.sky()
        path = os.path.join(blend.FOLDER, "sky.hdr")
        node.image.filepath_raw, node.image.file_format = path, "HDR"
        node.image.save()
        with open(path, "rb") as file:
            wanted = file.read()
        for is_packed in (False, True):
            node.image = bpy.data.images.load(path)
            node.image.name = "Copy"
            if is_packed:
                node.image.pack()
            block = self.exported().one("texture")
            name = block.values["filename"][0][0]
            self.assertTrue(name.endswith(".hdr"), name)
            with open(os.path.join(os.path.dirname(self.path), name), "rb") as file:
                self.assertEqual(file.read(), wanted)
        node.image.pixels[0] = 7.0
        self.assertTrue(self.exported().one("texture").values["filename"][0][0].endswith(".exr"))

    def test_the_image_behind_other_nodes(self):
        node = self.sky()
        tree = self.scene.world.node_tree
        gamma = add(tree, "ShaderNodeGamma", None, self.background().inputs["Color"])
        tree.links.new(node.outputs[0], gamma.inputs["Color"])
        self.assertIn("texture", self.exported().one("environment").values)
        self.assertIn("Gamma on Color is not carried, the image behind it is", self.text)

    def test_a_mix_by_kind_of_ray(self):
        self.sky()
        tree = self.scene.world.node_tree
        mix = add(tree, "ShaderNodeMixShader", None, output_of(tree).inputs["Surface"])
        tree.links.new(self.background().outputs[0], mix.inputs[1])
        add(tree, "ShaderNodeBackground", (1.0, 0.0, 0.0, 1.0), mix.inputs[2])
        add(tree, "ShaderNodeLightPath", None, mix.inputs[0])
        self.assertIn("texture", self.exported().one("environment").values)
        self.assertIn("Mix Shader is not carried, its first shader is", self.text)

    def test_turn(self):
        node = self.sky()
        tree = self.scene.world.node_tree
        mapping = add(tree, "ShaderNodeMapping", None, node.inputs["Vector"])
        source = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(source.outputs["Generated"], mapping.inputs["Vector"])
        mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.5)
        for kind, sign in (("POINT", -1.0), ("TEXTURE", 1.0), ("VECTOR", -1.0)):
            mapping.vector_type = kind
            turn = self.exported().one("environment").number("turn_deg")
            self.assertAlmostEqual(turn, sign * math.degrees(0.5), places=4)
            self.assertNotIn("not carried", self.text)


class SettingsTest(PhysicalTest):
    def test_bounces(self):
        self.scene.cycles.max_bounces = 7
        self.assertEqual(self.exported().one("settings").number("recursion"), 7.0)
        self.scene.slo_rt.use_cycles_bounces = False
        self.scene.slo_rt.bounces = 5
        self.assertEqual(self.exported().one("settings").number("recursion"), 5.0)

    def test_lights_that_are_asked(self):
        self.assertNotIn("lightSamplingType", self.exported().one("settings").values)
        self.scene.slo_rt.light_sampling = "SAMPLE_ALL_AT_TIME"
        values = self.exported().one("settings").values
        self.assertEqual(values["lightSamplingType"], [["SAMPLE_ALL_AT_TIME"]])

    def test_view(self):
        view = self.scene.view_settings

        def film():
            values = self.exported().one("Camera").one("Film").values
            return {n: values[n][0][0] for n in ("encoding", "exposure", "toneMap") if n in values}

        self.assertEqual(film(), {"encoding": "SRGB"})
        view.view_transform = "AgX"
        view.exposure = 0.5
        self.assertEqual(film(), {"encoding": "SRGB", "exposure": "0.5", "toneMap": "AGX"})
        self.assertNotIn("colours are", self.text)
        view.gamma = 2.0
        self.assertEqual(film()["toneMap"], "AGX")
        self.assertIn("colours are changed by gamma 2.0 in Blender, not here", self.text)
        view.gamma, view.view_transform = 1.0, "Raw"
        self.assertEqual(film(), {"encoding": "RAW", "exposure": "0.5"})

    def test_photons_are_written_if_there_are_any(self):
        blend.lamp()
        self.assertNotIn("photons", self.exported().one("settings").values)
        self.scene.slo_rt.photons = 0.5
        self.assertEqual(self.exported().one("settings").values["photons"], [["0.5"]])
        self.scene.slo_rt.integrator = "DISTRIBUTED"
        self.assertNotIn("photons", self.exported().one("settings").values)

    def test_distributed_is_as_ever(self):
        self.scene.slo_rt.integrator = "DISTRIBUTED"
        blend.lamp()
        scene = self.exported()
        self.assertEqual(scene.all("environment") + scene.all("lamp_point"), [])
        scene.one("light_point")
        values = scene.one("settings").values
        self.assertNotIn("integrator", values)
        self.assertEqual(values["lightSamplingType"], [["SAMPLE_ALL_AT_TIME"]])
        scene.one("phong_info")
