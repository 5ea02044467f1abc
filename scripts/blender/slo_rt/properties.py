# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings by the artist: of the scene, of materials, of lights."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
)


MOST_SAMPLES = 65535


def _samples(name, description, default=1, soft_max=64):
    return IntProperty(
        name=name,
        description=description,
        default=default,
        min=1,
        max=MOST_SAMPLES,
        soft_max=soft_max,
    )


def _number(name, description, default=0.0, soft_max=1.0, **options):
    options.setdefault("min", 0.0)
    return FloatProperty(
        name=name, description=description, default=default, soft_max=soft_max, **options
    )


def _color(name, description, default):
    return FloatVectorProperty(
        name=name,
        description=description,
        subtype="COLOR",
        default=(default, default, default),
        min=0.0,
        soft_max=1.0,
    )


class RenderSettings(bpy.types.PropertyGroup):
    """Settings of a scene (`scene.slo_rt`)."""

    integrator: EnumProperty(
        name="Integrator",
        description="Which light is found",
        items=[
            ("PATH", "Path", "All light, as in Cycles: also from surface to surface"),
            (
                "PHOTON_MAP",
                "Photon Map",
                "All light by photons: smooth after few samples, with small errors that more samples do "
                "not remove",
            ),
            (
                "DISTRIBUTED",
                "Distributed",
                "Lights, mirrors and glass with Phong materials, as in the thesis: no light from "
                "surface to surface",
            ),
        ],
        default="PATH",
    )
    samples: _samples(
        "Samples", "Camera samples per pixel: pixel, shutter and lens all at once", 64, 4096
    )
    noise: _number(
        "Noise",
        "Error at which a pixel is done before all samples are taken; 0: take all",
        soft_max=0.1,
        max=1.0,
        precision=4,
        step=0.1,
    )
    min_samples: _samples("Minimum", "Samples before a pixel may be done", 16, 1024)
    time: _number(
        "Time",
        "Seconds that a frame may take, more or less: fewer samples are taken if need be. "
        "0: as long as it takes. Frames then depend on the machine",
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
    use_cycles_bounces: BoolProperty(
        name="Bounces of Cycles",
        description="As many bounces as Cycles' Max Bounces (Total)",
        default=True,
    )
    bounces: IntProperty(
        name="Bounces",
        description="Bounces of light after the first hit",
        default=12,
        min=0,
        max=1000,
        soft_max=64,
    )
    photons: _number(
        "Photons",
        "Light paths from lamps for each sample, which find caustics: light by way of mirrors and "
        "through glass. 0: none; 0.5 is usual",
        soft_max=4.0,
        max=100.0,
    )
    photon_map_size: IntProperty(
        name="Photons",
        description="Photons of all light, and as many of caustics, at most",
        default=1000000,
        min=1,
        max=1 << 26,
    )
    cache_error: _number(
        "Cache Error",
        "Error that is allowed between the points at which light is gathered; 0: no cache, each "
        "sample gathers light",
        default=0.2,
        soft_max=0.5,
        max=100.0,
    )
    shadow_samples: _samples("Shadow", "Shadow rays per area light at the first hit")
    reflection_samples: _samples("Reflection", "Rays for each rough reflection at the first hit")
    refraction_samples: _samples("Refraction", "Rays for each rough refraction at the first hit")
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
            ("AUTO", "Automatic", "One with the integrator Path, all with Distributed"),
            ("SAMPLE_ALL_AT_TIME", "All", "Every light at every hit"),
            ("SAMPLE_ONE_AT_TIME", "One", "One light at random: quicker with many lights, noisier"),
        ],
        default="AUTO",
    )
    accelerator: EnumProperty(
        name="Accelerator",
        description="Structure for the rays; the picture is the same",
        items=[
            ("BVH", "BVH", "8-wide hierarchy of boxes: mostly the quickest"),
            ("KDTREE", "kd-tree", "kd-tree by the surface area heuristic"),
            ("CWBVH", "CWBVH", "For measuring: may miss hits at edges"),
        ],
        default="BVH",
    )
    spatial_splits: BoolProperty(
        name="Spatial Splits",
        description="Cut long triangles in the BVH: faster bounces among them, slower shadows and building",
        default=False,
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
    world_light: _number(
        "World Light",
        "How much of the background's light reaches every surface, wherever it is; "
        "slo-rt has no light that bounces from surface to surface",
        1.0,
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
    show_preview: BoolProperty(
        name="Preview First",
        description="Show the light of photons first: the whole scene without noise, though blurred, in "
        "the time of a few samples. Not in animations and not in the background",
        default=False,
    )

    @property
    def is_physical(self):
        """Whether lamps, materials and skies are those of Cycles."""
        return self.integrator != "DISTRIBUTED"


class MaterialSettings(bpy.types.PropertyGroup):
    """Phong values of a material (`material.slo_rt`), used instead of its nodes if `use_own` is
    on."""

    use_own: BoolProperty(
        name="Own Phong Values",
        description="Use the values below, not what the nodes say; a texture of the nodes stays",
        default=False,
    )
    ambient: _color("Ambient", "Light that the surface has by itself", 0.0)
    diffuse: _color("Diffuse", "Colour in the light", 0.8)
    specular: _color("Specular", "Colour of highlights", 0.2)
    shininess: _number("Shininess", "Exponent of highlights: the more, the smaller", 50.0, 1000.0)
    reflectance: _number("Reflectance", "How much of a mirrored ray is added")
    diffuse_reflection: _number("Spread", "Spread of mirrored rays in radians; 0 is a mirror")
    refraction: _number("Refraction", "How much of a refracted ray is added")
    diffuse_refraction: _number("Spread", "Spread of refracted rays in radians; 0 is clear")
    refraction_index: _number(
        "Index", "Refraction index inside: glass 1.5, water 1.33", 1.5, 3.0, min=0.01
    )


class LightSettings(bpy.types.PropertyGroup):
    """How a light is carried over (`light.slo_rt`)."""

    distance: _number(
        "Bright at",
        "Light does not fall off with distance in slo-rt. At this distance it is as bright "
        "as in Blender; 0: at the middle of the scene",
        soft_max=100.0,
        subtype="DISTANCE",
    )
    brightness: _number("Brightness", "Multiplies the light", 1.0, 10.0)


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
    """Removes the settings again."""
    for owner, _ in OWNERS:
        del owner.slo_rt
