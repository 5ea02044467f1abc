# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers of the tests in Blender: the extension, empty scenes, and things for them."""

import math
import os
import sys
import tempfile

import bpy

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
import slo_rt  # noqa: E402
import slo_rt.compat  # noqa: E402
import slo_rt.engine  # noqa: E402

FOLDER = tempfile.mkdtemp(prefix="slo-rt-test-")
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(slo_rt.__path__[0])))
# `$SLO_RT` of the environment in which the tests were started, or the program of this checkout.
PROGRAM = os.environ.get("SLO_RT") or os.path.join(ROOT, "target", "release", "slo-rt")
_registered = False


def fresh_scene(size=(64, 48), integrator="DISTRIBUTED"):
    """Makes Blender's default scene without cube and light, with our engine and one of its integrators,
    and with a camera 10 m in front of the origin that looks along y, z up."""
    global _registered
    bpy.ops.wm.read_factory_settings()
    bpy.context.preferences.filepaths.use_scripts_auto_execute = True
    if _registered:
        slo_rt.unregister()
    slo_rt.register()
    _registered = True
    for thing in list(bpy.data.objects):
        if thing.type != "CAMERA":
            bpy.data.objects.remove(thing)
    scene = bpy.context.scene
    scene.camera.location = (0.0, -10.0, 0.0)
    scene.camera.rotation_euler = (math.pi / 2.0, 0.0, 0.0)
    scene.render.engine = "SLO_RT"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.fps = 24
    scene.frame_start, scene.frame_end = 1, 25
    scene.frame_set(1)
    scene.slo_rt.samples = 4
    scene.slo_rt.integrator = integrator
    scene.view_settings.view_transform = "Standard"
    return scene


def cube(name="Cube", size=2.0):
    """A cube at the origin."""
    bpy.ops.mesh.primitive_cube_add(size=size)
    thing = bpy.context.object
    thing.name = name
    return thing


def lamp(name="Lamp", kind="POINT", location=(3.0, -5.0, 5.0), energy=500.0):
    """Adds a light; slo-rt supports only the kind POINT."""
    light = bpy.data.lights.new(name, kind)
    light.energy = energy
    if kind == "POINT":
        light.shadow_soft_size = 0.0
    thing = bpy.data.objects.new(name, light)
    thing.location = location
    bpy.context.scene.collection.objects.link(thing)
    return thing


def paint(thing, name="Paint", **sockets):
    """A material of the Principled BSDF for an object; returns its shader node."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    for socket, value in sockets.items():
        shader.inputs[socket.replace("_", " ")].default_value = value
    thing.data.materials.append(material)
    return shader


def key(thing, path, frame, value):
    """A key frame of an object."""
    setattr(thing, path, value)
    thing.keyframe_insert(path, frame=frame)


def curves(thing):
    """F-curves of an object, in any version."""
    return slo_rt.compat.fcurves(thing.animation_data)


def interpolation(thing, kind):
    """Sets the interpolation of all key frames of an object."""
    for curve in curves(thing):
        for point in curve.keyframe_points:
            point.interpolation = kind


def export(name="scene", **options):
    """Exports the scene; returns the path."""
    path = os.path.join(tempfile.mkdtemp(dir=FOLDER), f"{name}.txt")
    assert bpy.ops.slo_rt.export_scene(filepath=path, **options) == {"FINISHED"}
    return path


def work_folder():
    """Returns the folder in which the engine keeps the files of the scene."""
    return slo_rt.engine.work_folder(bpy.context.scene.name, bpy.context.view_layer.name)


def export_text(**options):
    """Exports the scene; returns the text."""
    with open(export(**options), encoding="utf-8") as file:
        return file.read()


def program():
    """The path of slo-rt."""
    os.environ["SLO_RT"] = PROGRAM
    return PROGRAM
