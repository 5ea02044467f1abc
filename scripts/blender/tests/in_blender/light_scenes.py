# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes of physical light, one for each group of features; each is a function of the scene."""

import math

import bpy
import numpy as np

from . import blend
from .test_nodes import add, empty_material, output_of

GREY = (0.5, 0.5, 0.5, 1.0)
BALLS = (-2.1, 0.0, 2.1)


def start(size):
    """A scene with a black world, seen from a little above."""
    scene = blend.fresh_scene(size, "PATH")
    camera = scene.camera
    camera.location = (0.0, -9.0, 3.0)
    camera.rotation_euler = (math.radians(75.0), 0.0, 0.0)
    world(scene, (0.0, 0.0, 0.0))
    return scene


def world(scene, color, strength=1.0):
    """A world of one colour; returns its Background."""
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength
    return background


def shader(thing, kind, to=None, **values):
    """A shader on an object without a material or, if given, on a socket `to`; returns its node."""
    tree = empty_material(thing, thing.name) if to is None else to.id_data
    node = add(tree, kind, None, output_of(tree).inputs["Surface"] if to is None else to)
    for name, value in values.items():
        node.inputs[name.replace("_", " ")].default_value = value
    return node


def principled(thing, **values):
    """A Principled BSDF on an object."""
    return shader(thing, "ShaderNodeBsdfPrincipled", **values)


def matt(thing, color=GREY, **values):
    """A Diffuse BSDF on an object."""
    return shader(thing, "ShaderNodeBsdfDiffuse", Color=color, **values)


def plane(size, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0)):
    """A square."""
    bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=rotation)
    return bpy.context.object


def floor(color=GREY):
    """A grey floor."""
    thing = plane(40.0)
    matt(thing, color)
    return thing


def ball(x, radius=1.0, y=0.0):
    """A smooth ball on the floor."""
    bpy.ops.mesh.primitive_uv_sphere_add(
        radius=radius, segments=96, ring_count=48, location=(x, y, radius)
    )
    bpy.ops.object.shade_smooth()
    return bpy.context.object


def light(kind, location, energy, rotation=(0.0, 0.0, 0.0), **values):
    """A lamp without Blender's soft falloff."""
    thing = blend.lamp(kind.title(), kind, location, energy)
    thing.rotation_euler = rotation
    if hasattr(thing.data, "use_soft_falloff"):
        thing.data.use_soft_falloff = False
    for name, value in values.items():
        setattr(thing.data, name, value)
    return thing


def image(values, name, space, is_float=False):
    """An image of values (height, width, 3 or 4), the bottom row first."""
    height, width, channels = values.shape
    found = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    found.colorspace_settings.name = space
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :channels] = values
    found.pixels.foreach_set(pixels.ravel())
    found.pack()
    return found


def waves(size=128, turns=3.0):
    """Smooth waves from 0 to 1 along both axes, (size, size, 2)."""
    at = (np.arange(size) + 0.5) / size * turns * 2.0 * math.pi
    u, v = np.meshgrid(at, at)
    return np.stack([0.5 + 0.5 * np.sin(u), 0.5 + 0.5 * np.cos(v)], axis=2)


def textured(tree, picture, to, output="Color"):
    """An image texture on a socket; returns its node."""
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = picture
    tree.links.new(node.outputs[output], to)
    return node


# Scenes


def diffuse_room(scene):
    half = math.pi / 2.0
    for place, turn, color in (
        ((0, 0, 0), (0, 0, 0), GREY),
        ((0, 0, 6), (0, 0, 0), (0.8, 0.8, 0.8, 1.0)),
        ((0, 3, 3), (half, 0, 0), (0.7, 0.7, 0.6, 1.0)),
        ((-4, 0, 3), (0, half, 0), (0.8, 0.1, 0.1, 1.0)),
        ((4, 0, 3), (0, half, 0), (0.1, 0.7, 0.2, 1.0)),
    ):
        matt(plane(12.0, place, turn), color)
    matt(ball(-1.2), (0.8, 0.8, 0.8, 1.0), Roughness=1.0)
    matt(ball(1.5, 0.7), (0.2, 0.3, 0.8, 1.0))
    light("AREA", (0.0, 0.0, 5.5), 300.0, size=2.0)


def metals(scene):
    floor()
    world(scene, (0.4, 0.5, 0.7))
    light("AREA", (3.0, -4.0, 6.0), 600.0, (0.6, 0.4, 0.0), size=3.0)
    gold = {"Base_Color": (1.0, 0.75, 0.3, 1.0), "Metallic": 1.0}
    for x, roughness in zip(BALLS, (0.15, 0.4, 0.9)):
        principled(ball(x, 0.8), **gold, Roughness=roughness, Specular_Tint=(0.9, 0.8, 1.0, 1.0))
    shader(ball(-1.1, 0.5, -2.0), "ShaderNodeBsdfMetallic", Roughness=0.3)
    shader(ball(1.1, 0.5, -2.0), "ShaderNodeBsdfAnisotropic", Color=GREY, Roughness=0.3)


def glass(scene):
    floor()
    world(scene, (0.6, 0.7, 1.0))
    light("AREA", (0.0, 0.0, 7.0), 500.0, size=6.0)
    for x, roughness, color in zip(
        BALLS, (0.0, 0.3, 0.1), ((1.0, 1.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0), (0.5, 0.9, 0.6, 1.0))
    ):
        principled(
            ball(x), Base_Color=color, Roughness=roughness, Transmission_Weight=1.0, IOR=1.45
        )
    shader(ball(0.0, 0.4, -2.5), "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.5)


def coat(scene):
    floor()
    world(scene, (0.5, 0.5, 0.5))
    light("AREA", (-3.0, -4.0, 6.0), 600.0, (0.6, -0.4, 0.0), size=2.0)
    for x, weight, roughness, tint in zip(
        BALLS, (1.0, 0.5, 1.0), (0.1, 0.3, 0.05), (1.0, 1.0, 0.6)
    ):
        principled(
            ball(x), Base_Color=(0.6, 0.1, 0.05, 1.0), Roughness=0.7, Coat_Weight=weight,
            Coat_Roughness=roughness, Coat_IOR=1.6, Coat_Tint=(1.0, tint, tint, 1.0),
        )  # fmt: skip


def sheen(scene):
    floor()
    world(scene, (0.5, 0.5, 0.5))
    light("AREA", (0.0, 3.0, 5.0), 500.0, (-0.5, 0.0, 0.0), size=2.0)
    for x, roughness in zip(BALLS[:2], (0.3, 0.8)):
        principled(
            ball(x), Base_Color=(0.1, 0.1, 0.3, 1.0), Roughness=0.8, Sheen_Weight=1.0,
            Sheen_Roughness=roughness, Sheen_Tint=(1.0, 0.9, 0.7, 1.0),
        )  # fmt: skip
    shader(ball(BALLS[2]), "ShaderNodeBsdfSheen", Color=(0.9, 0.5, 0.5, 1.0), Roughness=0.5)


def textures(scene):
    thing = plane(9.0, (0.0, 1.0, 0.0))
    node = principled(thing)
    tree = node.id_data
    u, v = waves()[..., 0], waves()[..., 1]
    colors = image(np.stack([u, v, 1.0 - u], axis=2), "Colours", "sRGB")
    picture = textured(tree, colors, node.inputs["Base Color"])
    picture.extension = "MIRROR"
    mapping = add(tree, "ShaderNodeMapping", None, picture.inputs["Vector"])
    mapping.inputs["Scale"].default_value = (2.0, 1.0, 1.0)
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, 0.4)
    mapping.inputs["Location"].default_value = (0.2, 0.1, 0.0)
    source = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(source.outputs["UV"], mapping.inputs["Vector"])
    separate = add(tree, "ShaderNodeSeparateColor", None, node.inputs["Metallic"])
    tree.links.new(separate.outputs["Green"], node.inputs["Roughness"])
    tree.links.new(separate.outputs["Blue"], node.inputs["Metallic"])
    parts = image(np.stack([0.0 * u, 0.3 + 0.6 * u, v], axis=2), "Parts", "Non-Color")
    textured(tree, parts, separate.inputs["Color"])
    bump = add(tree, "ShaderNodeNormalMap", None, node.inputs["Normal"])
    bump.inputs["Strength"].default_value = 0.7
    x, y = 0.35 * (2.0 * u - 1.0), 0.2 * (2.0 * v - 1.0)
    normals = np.stack([x, y, np.sqrt(1.0 - x * x - y * y)], axis=2) * 0.5 + 0.5
    textured(tree, image(normals, "Normals", "Non-Color"), bump.inputs["Color"])
    world(scene, (0.3, 0.3, 0.4))
    light("SUN", (0.0, 0.0, 5.0), 2.0, (0.5, 0.4, 0.0), angle=0.1)


def alpha(scene):
    floor()
    world(scene, (0.3, 0.3, 0.3))
    light("AREA", (1.0, -1.0, 6.0), 500.0, (0.1, 0.1, 0.0), size=3.0)
    for x, share in zip(BALLS[:2], (0.3, 0.7)):
        principled(ball(x, 0.9), Base_Color=(0.8, 0.3, 0.1, 1.0), Alpha=share, Roughness=0.9)
    thing = plane(2.4, (BALLS[2], 0.0, 1.4), (1.2, 0.0, 0.3))
    node = principled(thing, Roughness=0.8)
    pixels = np.concatenate([np.full((128, 128, 3), 0.6), waves()[..., :1]], axis=2)
    picture = image(pixels, "Leaf", "sRGB")
    textured(node.id_data, picture, node.inputs["Base Color"])
    source = textured(node.id_data, picture, node.inputs["Alpha"], "Alpha")
    node.id_data.links.new(source.outputs["Color"], node.inputs["Base Color"])


def emission(scene):
    floor()
    matt(plane(12.0, (0.0, 3.0, 3.0), (math.pi / 2.0, 0.0, 0.0)), (0.7, 0.7, 0.7, 1.0))
    principled(ball(-2.0, 0.5), Emission_Color=(1.0, 0.5, 0.2, 1.0), Emission_Strength=12.0)
    matt(ball(0.2, 0.9), (0.7, 0.7, 0.7, 1.0))
    glow = shader(plane(1.5, (2.6, 0.5, 1.0), (1.3, 0.0, -0.5)), "ShaderNodeEmission", Strength=6.0)
    colors = np.concatenate([waves(turns=2.0), np.full((128, 128, 1), 0.3)], axis=2)
    textured(glow.id_data, image(colors, "Screen", "sRGB"), glow.inputs["Color"])


def lamps(scene):
    floor()
    for x in BALLS:
        matt(ball(x, 0.5))
    light("POINT", (-3.0, 0.0, 2.0), 60.0, shadow_soft_size=0.3, color=(1.0, 0.6, 0.4))
    light("SPOT", (-0.8, 0.5, 4.0), 400.0, shadow_soft_size=0.2, spot_size=0.7, spot_blend=0.2)
    light("AREA", (1.0, 1.0, 3.0), 60.0, (0.2, 0.3, 0.0), shape="RECTANGLE", size=1.5, size_y=0.5)
    disc = light("AREA", (3.0, 0.0, 2.5), 60.0, (0.0, -0.4, 0.0), shape="DISK", size=1.0)
    disc.data.color = (0.4, 0.6, 1.0)


def spot(scene):
    floor()
    matt(plane(12.0, (0.0, 3.0, 3.0), (math.pi / 2.0, 0.0, 0.0)))
    matt(ball(0.0, 0.7))
    light("SPOT", (-2.5, -2.0, 5.0), 900.0, (0.5, -0.3, 0.0), spot_size=0.8, spot_blend=0.6)
    light("SPOT", (2.5, -3.0, 4.0), 900.0, (0.9, 0.3, 0.0), spot_size=0.6, spot_blend=0.0)


def sun(scene):
    floor()
    world(scene, (0.1, 0.15, 0.3))
    for x in BALLS:
        matt(ball(x, 0.8))
    light("SUN", (0.0, 0.0, 9.0), 2.0, (0.7, 0.5, 0.0), angle=math.radians(8.0))
    light("SUN", (0.0, 0.0, 9.0), 1.0, (0.4, -0.8, 0.0), angle=0.0, color=(1.0, 0.4, 0.2))


def sky(scene):
    floor()
    background = world(scene, (0.0, 0.0, 0.0), 1.5)
    tree = scene.world.node_tree
    rows, columns = 64, 128
    v, u = np.mgrid[:rows, :columns] / np.array([rows, columns]).reshape(2, 1, 1)
    bright = np.exp(-(((u - 0.3) / 0.05) ** 2) - (((v - 0.75) / 0.08) ** 2))
    values = np.stack([0.2 + 30.0 * bright, 0.3 + 20.0 * bright, 0.2 + v + 10.0 * bright], axis=2)
    node = add(tree, "ShaderNodeTexEnvironment", None, background.inputs["Color"])
    node.image = image(values, "Sky", "Linear Rec.709", is_float=True)
    mapping = add(tree, "ShaderNodeMapping", None, node.inputs["Vector"])
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, 1.0)
    source = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(source.outputs["Generated"], mapping.inputs["Vector"])
    matt(ball(BALLS[0], 0.8), (0.8, 0.8, 0.8, 1.0))
    principled(ball(BALLS[1], 0.8), Metallic=1.0, Roughness=0.25)
    principled(ball(BALLS[2], 0.8), Roughness=0.2)


def mix(scene):
    floor()
    world(scene, (0.5, 0.5, 0.6))
    light("AREA", (2.0, -3.0, 6.0), 500.0, (0.5, 0.3, 0.0), size=2.0)

    def mixed(thing, kind, factor, first, second):
        node = shader(thing, kind)
        sockets = [s for s in node.inputs if s.type == "SHADER"]
        for socket, (name, values) in zip(sockets, (first, second)):
            shader(thing, name, socket, **values)
        if kind == "ShaderNodeMixShader":
            node.inputs[0].default_value = factor
        return node

    red = "ShaderNodeBsdfDiffuse", {"Color": (0.7, 0.1, 0.1, 1.0)}
    blue = "ShaderNodeBsdfDiffuse", {"Color": (0.1, 0.2, 0.7, 1.0)}
    gloss = "ShaderNodeBsdfAnisotropic", {"Color": (0.9, 0.9, 0.9, 1.0), "Roughness": 0.2}
    nothing = "ShaderNodeBsdfTransparent", {}
    mixed(ball(BALLS[0], 0.8), "ShaderNodeMixShader", 0.3, red, gloss)
    node = mixed(ball(BALLS[1], 0.8), "ShaderNodeMixShader", 0.5, red, blue)
    factor = np.repeat(waves()[..., :1], 3, axis=2)
    textured(node.id_data, image(factor, "Factor", "Non-Color"), node.inputs[0])
    mixed(ball(BALLS[2], 0.8), "ShaderNodeMixShader", 0.6, nothing, red)
    glow = "ShaderNodeEmission", {"Color": (0.2, 0.6, 0.2, 1.0), "Strength": 0.3}
    mixed(ball(0.0, 0.4, -2.5), "ShaderNodeAddShader", None, blue, glow)


SCENES = (
    diffuse_room, metals, glass, coat, sheen, textures, alpha, emission, lamps, spot, sun, sky, mix,
)  # fmt: skip
