# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares our picture of a scene with Cycles' picture: positions, sharpness, blur and brightness.

Shading differs, so things glow white in front of black, and silhouettes are compared.
"""

import math
import os
import subprocess
import unittest

import bpy
import numpy as np

from slo_rt import engine, exports

from . import blend

SIZE = (160, 120)


def glowing(strength=1.0):
    """A material that only shines."""
    material = bpy.data.materials.new("Glow")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = strength
    links.new(emission.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def matt(value):
    """A material without highlights."""
    material = bpy.data.materials.new("Matt")
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (value, value, value, 1.0)
    links.new(diffuse.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def picture(scene, engine, samples):
    """Linear grey values (height, width) of the scene by an engine, the bottom row first."""
    render = scene.render
    render.engine = engine
    scene.slo_rt.samples = samples
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type = "BOX"
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = os.path.join(blend.FOLDER, f"{engine}.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath)
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[..., :3].mean(axis=2)


def moments(grey):
    """Returns the total light, its centre (x, y) in pixels, and its spread along both axes and
    between them."""
    total = float(grey.sum())
    y, x = np.mgrid[: grey.shape[0], : grey.shape[1]] + 0.5
    center = np.array([(grey * x).sum(), (grey * y).sum()]) / total
    dx, dy = x - center[0], y - center[1]
    spread = (
        np.array([(grey * dx * dx).sum(), (grey * dy * dy).sum(), (grey * dx * dy).sum()]) / total
    )
    return total, center, spread


class PictureTest(unittest.TestCase):
    def setUp(self):
        blend.program()
        self.scene = scene = blend.fresh_scene(SIZE)
        scene.world.color = (0.0, 0.0, 0.0)
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0

    def both(self, samples=64):
        ours = picture(self.scene, "SLO_RT", samples)
        theirs = picture(self.scene, "CYCLES", samples)
        return ours, theirs

    def compare(self, samples=64, center=0.1, spread=0.03, overlap=0.99):
        """Silhouettes: the same light, its centre within `center` pixels, its spread within a
        fraction."""
        ours, theirs = self.both(samples)
        (light, place, width), (light2, place2, width2) = moments(ours), moments(theirs)
        shared = np.minimum(ours, theirs).sum() / np.maximum(ours, theirs).sum()
        off = np.linalg.norm(place - place2)
        wide = np.abs(width - width2).max() / max(width2[:2].max(), 1e-9)
        print(
            f"  {self.id().rsplit('.')[-1]}: light {light / light2:.4f}, centre off by {off:.3f} px, "
            f"spread by {100 * wide:.2f} %, overlap {100 * shared:.2f} %"
        )
        self.assertGreater(light2, 50.0)
        self.assertAlmostEqual(light / light2, 1.0, delta=0.02)
        self.assertLess(off, center)
        self.assertLess(wide, spread)
        self.assertGreater(shared, overlap)
        return ours, theirs

    def glow_all(self):
        material = glowing()
        for thing in bpy.data.objects:
            if thing.type in {"MESH", "CURVE", "FONT", "META", "SURFACE"}:
                thing.data.materials.append(material)

    def test_geometry_and_framing(self):
        camera = self.scene.camera
        camera.location = (6.0, -7.0, 5.0)
        camera.rotation_euler = (1.1, 0.1, 0.7)
        bpy.ops.mesh.primitive_monkey_add(location=(0.3, 0.2, 0.1), rotation=(0.2, 0.4, 0.9))
        bpy.context.object.scale = (1.3, 0.7, -1.0)
        bpy.context.object.modifiers.new("Smooth", "SUBSURF").render_levels = 1
        bpy.ops.mesh.primitive_torus_add(location=(-1.5, 1.5, 0.5), rotation=(0.5, 0.1, 0.0))
        bpy.ops.object.text_add(location=(-1.0, 0.0, -2.0), rotation=(1.2, 0.0, 0.5))
        bpy.context.object.data.extrude = 0.1
        self.glow_all()
        self.compare(overlap=0.97)

    def test_sensor_fit(self):
        camera = self.scene.camera.data
        blend.cube(size=3.0)
        self.glow_all()
        for fit, size in (("VERTICAL", (160, 90)), ("HORIZONTAL", (90, 160)), ("AUTO", (90, 160))):
            self.scene.render.resolution_x, self.scene.render.resolution_y = size
            camera.sensor_fit, camera.sensor_height, camera.lens = fit, 20.0, 40.0
            self.compare(overlap=0.97)

    def test_instances(self):
        bpy.ops.mesh.primitive_cone_add(radius1=0.5, depth=1.0, location=(0.0, 0.0, 50.0))
        child = bpy.context.object
        bpy.ops.mesh.primitive_ico_sphere_add(radius=2.0, subdivisions=1)
        parent = bpy.context.object
        child.parent = parent
        parent.instance_type = "VERTS"
        parent.show_instancer_for_render = False
        child.location = (0.0, 0.0, 0.0)
        parent.rotation_euler = (0.3, 0.4, 0.5)
        self.glow_all()
        self.compare(overlap=0.96)

    def test_focus(self):
        camera = self.scene.camera.data
        camera.dof.use_dof = True
        camera.dof.focus_distance = 6.0
        camera.dof.aperture_fstop = 0.05
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.6, location=(1.0, 0.0, 0.4))
        self.glow_all()
        blurred, _ = self.compare(samples=256, overlap=0.93)
        self.assertGreater((blurred > 0.02).sum(), 1.5 * (blurred > 0.5).sum())
        camera.dof.focus_distance = 10.0
        sharp, _ = self.compare(samples=64, overlap=0.97)
        self.assertLess((sharp > 0.02).sum(), 0.8 * (blurred > 0.02).sum())

    def test_blur_direction(self):
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5)
        thing = bpy.context.object
        self.glow_all()
        for frame, x, z in ((1, -3.0, -1.5), (11, 3.0, 0.0)):
            blend.key(thing, "location", frame, (x, 0.0, z))
        blend.interpolation(thing, "LINEAR")
        render = self.scene.render
        render.use_motion_blur = True
        render.motion_blur_shutter = 1.0
        self.scene.frame_set(6)
        centers = {}
        for position in ("START", "CENTER", "END"):
            render.motion_blur_position = position
            ours, _ = self.compare(samples=256, overlap=0.95)
            centers[position] = moments(ours)[1][0]
        self.assertGreater(centers["START"], centers["CENTER"] + 2.0)
        self.assertGreater(centers["CENTER"], centers["END"] + 2.0)

    def test_blur_of_a_spin_and_of_the_camera(self):
        thing = blend.cube(size=1.0)
        thing.scale = (3.0, 0.3, 0.3)
        self.glow_all()
        blend.key(thing, "rotation_euler", 1, (0.0, 0.0, 0.0))
        blend.key(thing, "rotation_euler", 11, (0.0, 4.0, 0.0))
        blend.key(self.scene.camera, "location", 1, (0.0, -10.0, 0.0))
        blend.key(self.scene.camera, "location", 11, (2.0, -10.0, 1.0))
        self.scene.render.use_motion_blur = True
        self.scene.render.motion_blur_shutter = 1.0
        self.scene.frame_set(5)
        self.compare(samples=256, overlap=0.93, spread=0.04)

    def test_exported_animation_is_what_f12_shows(self):
        """The fit over all frames agrees with the fit of one shutter."""
        thing = blend.cube(size=1.0)
        thing.scale = (3.0, 0.4, 0.4)
        self.glow_all()
        for frame, turn, x in ((1, 0.0, -2.0), (12, 2.0, 1.0), (25, 7.0, 0.0)):
            blend.key(thing, "rotation_euler", frame, (0.3, turn, 0.0))
            blend.key(thing, "location", frame, (x, 0.0, 0.0))
        blend.key(self.scene.camera, "location", 1, (0.0, -10.0, 0.0))
        blend.key(self.scene.camera, "location", 25, (1.0, -8.0, 1.0))
        self.scene.render.use_motion_blur = True
        self.scene.slo_rt.samples = 64
        path = os.path.join(blend.FOLDER, "all.txt")
        exports.export_scene(
            self.scene, self.scene.view_layers[0], path, 1, 25, "all_", "EXR_IMAGE"
        )
        for frame in (3, 17):
            self.scene.frame_set(frame)
            shown = picture(self.scene, "SLO_RT", 64)
            subprocess.run(
                [blend.PROGRAM, "-q", "-s", path, f"--frame={frame}", "-od", blend.FOLDER],
                check=True,
                stdout=subprocess.DEVNULL,
            )
            name = os.path.join(blend.FOLDER, f"all_{frame:05d}.exr")
            rendered = engine.linear_pixels(name)[..., :3].mean(axis=2)
            self.assertGreater(shown.sum(), 50.0)
            self.assertLess(np.abs(shown - rendered).sum(), 0.002 * shown.sum())

    def test_brightness_of_lights(self):
        """A plane at the distance for which lights are carried over is as bright as in Cycles."""
        bpy.ops.mesh.primitive_plane_add(size=0.4, rotation=(math.pi / 2.0, 0.0, 0.0))
        bpy.context.object.data.materials.append(matt(0.8))
        self.scene.cycles.max_bounces = 0
        for kind, power in (("POINT", 200.0), ("SUN", 2.0), ("AREA", 100.0)):
            light = bpy.data.lights.new(kind, kind)
            light.energy = power
            light.color = (1.0, 0.7, 0.5)
            lamp = bpy.data.objects.new(kind, light)
            self.scene.collection.objects.link(lamp)
            lamp.location = (0.0, -5.0, 12.0) if kind != "AREA" else (0.0, -12.0, 0.0)
            lamp.rotation_euler = (math.atan2(5.0, 12.0), 0.0, 0.0)
            if kind == "AREA":
                light.size = 0.5
                lamp.rotation_euler = (math.pi / 2.0, 0.0, 0.0)
            if kind == "SUN":
                light.angle = 0.0
            if kind == "POINT":
                light.shadow_soft_size = 0.0
                light.slo_rt.distance = 0.0
            ours, theirs = self.both(samples=64)
            middle = np.s_[58:62, 78:82]
            ratio = ours[middle].mean() / theirs[middle].mean()
            print(f"  {kind}: {ours[middle].mean():.4f}, {ratio:.4f} of that of Cycles")
            self.assertGreater(ours[middle].mean(), 0.005)
            self.assertAlmostEqual(ratio, 1.0, delta=0.03)
            bpy.data.objects.remove(lamp)
