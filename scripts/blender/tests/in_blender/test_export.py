# SPDX-License-Identifier: GPL-3.0-or-later
"""Contents of exported scene texts, meshes and textures."""

import math
import os
import subprocess
import unittest

import bpy
import numpy as np

from .. import scene_reader
from . import blend


def mesh_of(path):
    """Arrays of a `.slo` file by section."""
    with open(path, encoding="utf-8") as file:
        words = file.read().replace("{", " { ").replace("}", " } ").split()
    assert words[:2] == ["slo_mesh", "1"]
    sections, at = {}, 2
    while at < len(words):
        end = words.index("}", at)
        width = 2 if words[at] == "uvs" else 3
        kind = int if "face" in words[at] else float
        sections[words[at]] = np.array([kind(w) for w in words[at + 2 : end]]).reshape(-1, width)
        at = end + 1
    return sections


def volume(mesh):
    """Signed volume of a closed mesh: positive if its triangles are counter-clockwise from
    outside."""
    a, b, c = (mesh["vertices"][mesh["faces"][:, i]] for i in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


class MeshTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()

    def export(self, *things):
        bpy.ops.object.select_all(action="DESELECT")
        for thing in things:
            thing.select_set(True)
        path = os.path.join(blend.FOLDER, "mesh.slo")
        self.assertEqual(bpy.ops.slo_rt.export_mesh(filepath=path), {"FINISHED"})
        return mesh_of(path)

    def test_cube(self):
        mesh = self.export(blend.cube())
        self.assertEqual((len(mesh["vertices"]), len(mesh["faces"])), (8, 12))
        self.assertAlmostEqual(volume(mesh), 8.0)
        self.assertNotIn("normals", mesh)

    def test_scale_is_baked_and_mirrors_turn_triangles(self):
        thing = blend.cube()
        for scale, expected in (
            ((1.0, 2.0, 3.0), 48.0),
            ((-1.0, 2.0, 3.0), 48.0),
            ((-1, -1, -1), 8.0),
        ):
            thing.scale = scale
            thing.rotation_euler = (0.3, 0.5, 0.7)
            thing.location = (5.0, 5.0, 5.0)
            mesh = self.export(thing)
            self.assertAlmostEqual(volume(mesh), expected, places=4)
            self.assertLess(np.abs(mesh["vertices"].mean(axis=0)).max(), 1e-6)

    def test_modifiers_are_applied(self):
        thing = blend.cube()
        thing.modifiers.new("Smooth", "SUBSURF").levels = 2
        self.assertEqual(len(self.export(thing)["faces"]), 192)

    def test_polygons_are_triangulated(self):
        bpy.ops.mesh.primitive_circle_add(vertices=9, fill_type="NGON")
        mesh = self.export(bpy.context.object)
        self.assertEqual(len(mesh["faces"]), 7)
        a, b, c = (mesh["vertices"][mesh["faces"][:, i]] for i in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0
        self.assertAlmostEqual(area, 9.0 / 2.0 * math.sin(2.0 * math.pi / 9.0), places=5)

    def test_smooth_normals_point_outward(self):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=2.0)
        bpy.ops.object.shade_smooth()
        thing = bpy.context.object
        for scale in ((1.0, 1.0, 1.0), (-1.0, 1.0, 1.0)):
            thing.scale = scale
            mesh = self.export(thing)
            self.assertEqual(len(mesh["normals"]), len(mesh["vertices"]))
            outward = np.sum(mesh["normals"] * mesh["vertices"], axis=1) / 2.0
            self.assertGreater(outward.min(), 0.99)
        thing.scale = (1.0, 1.0, 4.0)
        mesh = self.export(thing)
        expected = mesh["vertices"] / np.array([1.0, 1.0, 16.0])
        expected /= np.linalg.norm(expected, axis=1, keepdims=True)
        self.assertGreater(np.sum(expected * mesh["normals"], axis=1).min(), 0.99)

    def test_sharp_edges_divide_vertices(self):
        bpy.ops.mesh.primitive_cylinder_add(vertices=16)
        thing = bpy.context.object
        for polygon in thing.data.polygons:
            polygon.use_smooth = len(polygon.vertices) == 4
        mesh = self.export(thing)
        self.assertEqual(len(mesh["vertices"]), 64)
        corners = mesh["normals"][mesh["faces"]]
        flat = np.abs(corners[:, :, 2]) > 0.999
        self.assertEqual(int(flat.all(axis=1).sum()), 28)
        self.assertEqual(int(flat.any(axis=1).sum()), 28)

    def test_custom_normals(self):
        thing = blend.cube()
        thing.data.normals_split_custom_set([(0.0, 0.0, 1.0)] * len(thing.data.loops))
        mesh = self.export(thing)
        self.assertLess(np.abs(mesh["normals"] - (0.0, 0.0, 1.0)).max(), 1e-3)

    def test_uvs_of_corners(self):
        mesh = self.export(blend.cube())
        self.assertEqual(mesh["face_uvs"].shape, mesh["faces"].shape)
        self.assertEqual(len(mesh["vertices"]), 8)
        self.assertEqual(len(mesh["uvs"]), 14)
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3)
        mesh = self.export(bpy.context.object)
        where = mesh["vertices"][mesh["faces"]][..., :2] / 2.0 + 0.5
        self.assertLess(np.abs(mesh["uvs"][mesh["face_uvs"]] - where).max(), 1e-6)

    def test_several_objects_give_several_files(self):
        things = [blend.cube("One thing"), blend.cube("Other")]
        for thing in things:
            thing.select_set(True)
        path = os.path.join(blend.FOLDER, "many.slo")
        bpy.ops.slo_rt.export_mesh(filepath=path)
        for name in ("many_One_thing.slo", "many_Other.slo"):
            self.assertEqual(len(mesh_of(os.path.join(blend.FOLDER, name))["faces"]), 12)


class SceneTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()

    def export(self, warning="", **options):
        """Exports the scene and returns it read back, its text and its folder; the program must accept it."""
        path = blend.export(**options)
        check = subprocess.run(
            [blend.program(), "--check", "--scene", path],
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(check.returncode, 0, check.stderr)
        self.assertEqual("warning" in check.stderr, bool(warning), check.stderr)
        self.assertIn(warning, check.stderr)
        with open(path, encoding="utf-8") as file:
            text = file.read()
        return scene_reader.read(text), text, os.path.dirname(path)

    def material(self, name="Paint", **sockets):
        material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0, 0):
            material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        for socket, value in sockets.items():
            shader.inputs[socket.replace("_", " ")].default_value = value
        return material, shader

    def image(self, width=4, height=2, space="sRGB"):
        image = bpy.data.images.new("Check er", width, height)
        image.colorspace_settings.name = space
        pixels = np.ones((height, width, 4), np.float32)
        pixels[0, 0, :3] = (1.0, 0.5, 0.0)
        image.pixels.foreach_set(pixels.ravel())
        image.pack()
        return image

    def textured(self, shader):
        nodes, links = shader.id_data.nodes, shader.id_data.links
        node = nodes.new("ShaderNodeTexImage")
        node.image = self.image()
        links.new(node.outputs["Color"], shader.inputs["Base Color"])
        return node

    def test_names_with_spaces_and_letters(self):
        for name in ("Big cube", "Big/cube", "Kůň {1}", "#hash", "big CUBE"):
            blend.cube(name)
        scene, _, _ = self.export(name="my scene")
        names = [element.name for element in scene.all("mesh")]
        self.assertEqual(
            sorted(names), sorted(["Big_cube", "Big_cube_2", "Kůň_1_", "hash", "big_CUBE_3"])
        )

    def test_materials_divide_meshes(self):
        thing = blend.cube()
        for name in ("Red", "Blue"):
            thing.data.materials.append(self.material(name)[0])
        for polygon in thing.data.polygons[:2]:
            polygon.material_index = 1
        scene, _, folder = self.export()
        faces = {}
        for element in scene.all("mesh"):
            path = os.path.join(folder, element.values["filename"][0][0])
            faces[element.values["material"][0][0]] = len(mesh_of(path)["faces"])
        self.assertEqual(faces, {"Red": 8, "Blue": 4})

    def test_principled_surfaces(self):
        thing = blend.cube()
        material, _ = self.material(
            Base_Color=(0.5, 0.5, 0.5, 1.0), Metallic=1.0, Roughness=0.3, Emission_Strength=0.0
        )
        thing.data.materials.append(material)
        phong = self.export()[0].one("phong_info", "Paint")
        self.assertAlmostEqual(phong.number("reflectance"), 0.5)
        self.assertAlmostEqual(phong.number("diffuse_reflection"), math.sqrt(2.0) * 0.09, places=6)
        self.assertNotIn("diffuse", phong.values)

    def test_glass(self):
        thing = blend.cube()
        material, _ = self.material(
            Base_Color=(1.0, 1.0, 1.0, 1.0), Transmission_Weight=1.0, IOR=1.33, Roughness=0.0
        )
        thing.data.materials.append(material)
        phong = self.export()[0].one("phong_info", "Paint")
        fresnel = (0.33 / 2.33) ** 2
        self.assertAlmostEqual(phong.number("refraction_index"), 1.33, places=6)
        self.assertAlmostEqual(phong.number("reflectance"), fresnel, places=6)
        self.assertAlmostEqual(phong.number("refraction"), 1.0 - fresnel, places=6)

    def test_own_phong_values(self):
        thing = blend.cube()
        material, _ = self.material()
        material.slo_rt.use_own = True
        material.slo_rt.reflectance = 0.25
        material.slo_rt.diffuse = (0.25, 0.5, 0.75)
        thing.data.materials.append(material)
        phong = self.export()[0].one("phong_info", "Paint")
        self.assertEqual(phong.vector("diffuse"), [0.25, 0.5, 0.75])
        self.assertEqual(phong.number("reflectance"), 0.25)

    def test_texture(self):
        thing = blend.cube()
        blend.lamp()
        material, shader = self.material()
        self.textured(shader)
        thing.data.materials.append(material)
        scene, text, folder = self.export()
        self.assertEqual(scene.one("material_texture").values["texture"], [["Check_er"]])
        path = os.path.join(folder, scene.one("texture").values["filename"][0][0])
        picture = bpy.data.images.load(path)
        picture.colorspace_settings.name = "Non-Color"
        pixels = np.array(picture.pixels[:]).reshape(2, 4, 4)
        linear = ((0.5 + 0.055) / 1.055) ** 2.4
        self.assertLess(np.abs(pixels[0, 0, :3] - (1.0, linear, 0.0)).max(), 1e-2)
        self.assertLess(np.abs(pixels[1] - 1.0).max(), 1e-4)
        self.assertNotIn("Not carried", text)

    def test_what_is_lost_is_told(self):
        thing = blend.cube()
        material, shader = self.material(Coat_Weight=0.5, Subsurface_Weight=0.1)
        nodes, links = shader.id_data.nodes, shader.id_data.links
        links.new(nodes.new("ShaderNodeBump").outputs[0], shader.inputs["Normal"])
        links.new(nodes.new("ShaderNodeTexNoise").outputs[0], shader.inputs["Roughness"])
        node = self.textured(shader)
        links.new(nodes.new("ShaderNodeTexCoord").outputs["Object"], node.inputs["Vector"])
        thing.data.materials.append(material)
        for kind in ("SPOT", "SUN"):
            lamp = bpy.data.objects.new(kind, bpy.data.lights.new(kind, kind))
            self.scene.collection.objects.link(lamp)
        bpy.ops.object.pointcloud_random_add()
        self.scene.camera.data.shift_x = 0.1
        key = thing.shape_key_add(name="Basis")
        key = thing.shape_key_add(name="Fat")
        key.data[0].co.x += 1.0
        key.value = 0.0
        key.keyframe_insert("value", frame=1)
        key.value = 1.0
        key.keyframe_insert("value", frame=25)
        blend.key(thing, "hide_render", 1, False)
        blend.key(thing, "hide_render", 20, True)
        _, text, _ = self.export()
        for words in (
            "Coat Weight is not carried",
            "Subsurface Weight is not carried",
            "normal and bump maps are not carried",
            "on Roughness is not carried",
            "as texture coordinates is not carried",
            "spot lights are not carried",
            "a sun without size",
            "pointcloud objects are not carried",
            "the shift of the lens is not carried",
            "appears or vanishes",
        ):
            self.assertIn(words, text)

    def test_visibility_and_levels_are_those_of_rendering(self):
        shown, hidden = blend.cube("Shown"), blend.cube("Hidden")
        hidden.hide_render = True
        shown.hide_viewport = True
        modifier = shown.modifiers.new("Smooth", "SUBSURF")
        modifier.levels, modifier.render_levels = 0, 1
        scene, _, folder = self.export()
        element = scene.one("mesh")
        self.assertEqual(element.name, "Shown")
        path = os.path.join(folder, element.values["filename"][0][0])
        self.assertEqual(len(mesh_of(path)["faces"]), 48)

    def test_instances_share_a_file(self):
        bpy.ops.mesh.primitive_cube_add(size=0.2)
        child = bpy.context.object
        parent = blend.cube("Parent")
        child.parent = parent
        parent.instance_type = "VERTS"
        scene, _, _ = self.export()
        files = [e.values["filename"][0][0] for e in scene.all("mesh")]
        self.assertEqual(len(set(files)), 2)
        hidden = [e.name for e in scene.all("mesh") if "hidden" in e.values]
        self.assertEqual([e.values["of"][0] for e in scene.all("copy")], [hidden] * 8)

    def test_settings_reach_the_scene(self):
        values = self.scene.slo_rt
        values.samples, values.noise, values.min_samples = 128, 0.01, 8
        values.generator, values.accelerator, values.threads, values.seed = "PSEUDO", "KDTREE", 2, 7
        values.shadow_samples, values.recursion, values.shadow = 3, 2, "OPAQUE"
        values.spatial_splits = True
        self.scene.render.resolution_percentage = 50
        self.scene.render.fps, self.scene.render.fps_base = 30, 1.001
        blend.cube()
        scene, _, _ = self.export()
        settings = scene.all("settings")[0]
        for keyword, value in (
            ("imageSamples", "128"), ("imageMinSamples", "8"), ("generatorType", "PSEUDO"),
            ("accelerator", "KDTREE"), ("parallelThreads", "2"), ("seed", "7"), ("spatialSplits", "1"),
            ("softShadowSamples", "3"), ("recursion", "2"), ("shadow", "OPAQUE"), ("noise", "0.01"),
        ):  # fmt: skip
            self.assertEqual(settings.values[keyword], [[value]], keyword)
        camera = scene.one("Camera")
        self.assertAlmostEqual(camera.number("fps"), 30.0 / 1.001, places=5)
        film = camera.one("Film")
        self.assertEqual((film.number("width"), film.number("height")), (32.0, 24.0))

    def test_export_leaves_the_scene_as_it_was(self):
        blend.cube()
        self.scene.render.engine = "CYCLES"
        self.scene.frame_set(7)
        self.export()
        self.assertEqual(self.scene.render.engine, "CYCLES")
        self.assertEqual(self.scene.frame_current, 7)

    def test_what_changes_is_as_at_the_first_frame_whatever_frame_is_shown(self):
        lamp = bpy.data.lights.new("Lamp", "POINT")
        thing = bpy.data.objects.new("Lamp", lamp)
        thing.location = (0.0, -3.0, 3.0)
        self.scene.collection.objects.link(thing)
        material, shader = self.material()
        blend.cube().data.materials.append(material)
        color = shader.inputs["Base Color"]
        for frame, energy, rgb in ((1, 1000.0, (1.0, 0.0, 0.0)), (25, 10.0, (0.0, 0.0, 1.0))):
            lamp.energy = energy
            lamp.keyframe_insert("energy", frame=frame)
            color.default_value = (*rgb, 1.0)
            color.keyframe_insert("default_value", frame=frame)
        texts = []
        for shown in (1, 25):
            self.scene.frame_set(shown)
            texts.append(blend.export_text())
        self.assertEqual(*texts)
        info = scene_reader.read(texts[0]).all("phong_info")[0]
        self.assertGreater(info.values["diffuse"][0][0], info.values["diffuse"][0][2])

    def test_lamps_are_as_at_the_first_frame(self):
        self.scene.slo_rt.integrator = "PATH"
        blend.cube()
        lamp = blend.lamp()
        for frame, energy in ((1, 1000.0), (25, 10.0)):
            lamp.data.energy = energy
            lamp.data.keyframe_insert("energy", frame=frame)
        scene, text, _ = self.export()
        self.assertEqual(scene.one("lamp_point").vector("power"), [1000.0] * 3)
        self.assertIn("its changes over time are not carried", text)

    def test_no_camera_is_an_error(self):
        blend.cube()
        self.scene.camera = None
        with self.assertRaisesRegex(RuntimeError, "(?i)camera"):
            blend.export()

    def test_empty_scene(self):
        scene, _, _ = self.export(warning="the scene has no objects")
        self.assertEqual(scene.all("mesh"), [])
