# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists set: of the scene, of materials, of lights."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
)


class RenderSettings(bpy.types.PropertyGroup):
    """Settings of a scene (`scene.slo_rt`)."""

    samples: IntProperty(
        name="Samples",
        description="Camera samples per pixel: pixel, shutter and lens all at once",
        default=64,
        min=1,
        max=65535,
        soft_max=4096,
    )
    noise: FloatProperty(
        name="Noise",
        description="Error at which a pixel is done before all samples are taken; 0: take all",
        default=0.0,
        min=0.0,
        soft_max=0.1,
        precision=4,
        step=0.1,
    )
    min_samples: IntProperty(
        name="Minimum",
        description="Samples before a pixel may be done",
        default=16,
        min=1,
        max=65535,
        soft_max=1024,
    )
    time: FloatProperty(
        name="Time",
        description="Seconds that a frame may take, more or less: fewer samples are taken if need be. "
        "0: as long as it takes. Frames then depend on the machine",
        default=0.0,
        min=0.0,
        soft_max=3600.0,
        subtype="TIME_ABSOLUTE",
    )
    recursion: IntProperty(
        name="Recursion",
        description="Reflections and refractions after the first hit",
        default=4,
        min=0,
        max=1000,
        soft_max=32,
    )
    shadow_samples: IntProperty(
        name="Shadow",
        description="Shadow rays per area light at the first hit",
        default=1,
        min=1,
        max=65535,
        soft_max=64,
    )
    reflection_samples: IntProperty(
        name="Reflection",
        description="Rays for each rough reflection at the first hit",
        default=1,
        min=1,
        max=65535,
        soft_max=64,
    )
    refraction_samples: IntProperty(
        name="Refraction",
        description="Rays for each rough refraction at the first hit",
        default=1,
        min=1,
        max=65535,
        soft_max=64,
    )
    generator: EnumProperty(
        name="Generator",
        description="Where sample points come from",
        items=[
            ("QUASI", "Sobol", "Owen-scrambled Sobol points: the least noise"),
            ("ZERO_TWO", "(0,2)-sequence", "The scrambled (0,2)-sequence of the thesis"),
            ("PSEUDO", "Random", "Independent random numbers"),
        ],
        default="QUASI",
    )
    light_sampling: EnumProperty(
        name="Lights",
        description="Which lights a hit asks",
        items=[
            ("SAMPLE_ALL_AT_TIME", "All", "Every light at every hit"),
            ("SAMPLE_ONE_AT_TIME", "One", "One light at random: quicker with many lights, noisier"),
        ],
        default="SAMPLE_ALL_AT_TIME",
    )
    accelerator: EnumProperty(
        name="Accelerator",
        description="Structure for the rays; the picture is the same",
        items=[
            ("BVH", "BVH", "8-wide hierarchy of boxes: mostly the quickest"),
            ("KDTREE", "kd-tree", "kd-tree by the surface area heuristic"),
            ("CWBVH", "CWBVH", "Compressed wide hierarchy"),
        ],
        default="BVH",
    )
    shadow: EnumProperty(
        name="Shadows of glass",
        description="What glass does to light on its way to a surface",
        items=[
            ("TRANSPARENT", "Transparent", "Glass lets light through, unbent"),
            ("OPAQUE", "Opaque", "Everything throws a full shadow, as in the thesis"),
        ],
        default="TRANSPARENT",
    )
    world_light: FloatProperty(
        name="World Light",
        description="How much of the background's light reaches every surface, wherever it is; "
        "slo-rt has no light that bounces from surface to surface",
        default=1.0,
        min=0.0,
        soft_max=1.0,
    )
    threads: IntProperty(
        name="Threads",
        description="Threads of the program; 0: as many as the machine has",
        default=0,
        min=0,
        max=65536,
        soft_max=128,
    )
    seed: IntProperty(name="Seed", description="Seed of the noise", default=0, min=0)
    show_early: BoolProperty(
        name="Early Pictures",
        description="Render with few samples first, so that there is something to see soon. "
        "Not in animations and not in the background",
        default=True,
    )


class MaterialSettings(bpy.types.PropertyGroup):
    """Phong values of a material (`material.slo_rt`), used instead of its nodes if `use_own` is
    on."""

    use_own: BoolProperty(
        name="Own Phong Values",
        description="Use the values below, not what the nodes say; a texture of the nodes stays",
        default=False,
    )
    ambient: FloatVectorProperty(
        name="Ambient",
        description="Light that the surface has by itself",
        subtype="COLOR",
        default=(0.0, 0.0, 0.0),
        min=0.0,
        soft_max=1.0,
    )
    diffuse: FloatVectorProperty(
        name="Diffuse", subtype="COLOR", default=(0.8, 0.8, 0.8), min=0.0, soft_max=1.0
    )
    specular: FloatVectorProperty(
        name="Specular",
        description="Colour of highlights",
        subtype="COLOR",
        default=(0.2, 0.2, 0.2),
        min=0.0,
        soft_max=1.0,
    )
    shininess: FloatProperty(
        name="Shininess",
        description="Exponent of highlights: the more, the smaller",
        default=50.0,
        min=0.0,
        soft_max=1000.0,
    )
    reflectance: FloatProperty(
        name="Reflectance",
        description="How much of a mirrored ray is added",
        default=0.0,
        min=0.0,
        soft_max=1.0,
    )
    diffuse_reflection: FloatProperty(
        name="Spread",
        description="Spread of mirrored rays in radians; 0 is a mirror",
        default=0.0,
        min=0.0,
        soft_max=1.0,
    )
    refraction: FloatProperty(
        name="Refraction",
        description="How much of a refracted ray is added",
        default=0.0,
        min=0.0,
        soft_max=1.0,
    )
    diffuse_refraction: FloatProperty(
        name="Spread",
        description="Spread of refracted rays in radians; 0 is clear",
        default=0.0,
        min=0.0,
        soft_max=1.0,
    )
    refraction_index: FloatProperty(
        name="Index",
        description="Refraction index inside: glass 1.5, water 1.33",
        default=1.5,
        min=0.01,
        soft_max=3.0,
    )


class LightSettings(bpy.types.PropertyGroup):
    """How a light is carried over (`light.slo_rt`)."""

    distance: FloatProperty(
        name="Bright at",
        description="Light does not fall off with distance in slo-rt. At this distance it is as bright "
        "as in Blender; 0: at the middle of the scene",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        subtype="DISTANCE",
    )
    brightness: FloatProperty(
        name="Brightness", description="Multiplies the light", default=1.0, min=0.0, soft_max=10.0
    )


classes = (RenderSettings, MaterialSettings, LightSettings)
OWNERS = (
    (bpy.types.Scene, RenderSettings),
    (bpy.types.Material, MaterialSettings),
    (bpy.types.Light, LightSettings),
)


def attach():
    """Gives scenes, materials and lights their settings, after the classes are registered."""
    for owner, group in OWNERS:
        owner.slo_rt = PointerProperty(type=group)


def detach():
    """Takes the settings away again."""
    for owner, _ in OWNERS:
        del owner.slo_rt
