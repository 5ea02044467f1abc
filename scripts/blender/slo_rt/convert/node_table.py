# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of what slo-rt reads of each node: `PHONG` for the integrator DISTRIBUTED, `PHYSICAL` for PATH.

A node's entry has all its sockets and properties: the ones that are read, the ones that are noted
unless they have the value at which they have no effect, and the ones that have no effect while
another one has none. A test compares the tables with Blender's nodes, so that none is forgotten. A
socket added by a newer Blender is noted if it is linked or not 0.
"""

from dataclasses import dataclass, field

WHITE = (1.0, 1.0, 1.0, 1.0)
ZERO = (0.0, 0.0, 0.0)
_GGX = ("GGX", "MULTI_GGX")
_KEEPS_ENERGY = ("MULTI_GGX",)


@dataclass(frozen=True)
class Entry:
    """Properties of a type of node; sockets by identifier.

    `read`: sockets that are read. `neutral`: sockets that are not read, and the value at which they
    have no effect; None: they have no effect unless linked. `follows`: sockets and properties that
    have no effect while another one, which is noted, has none. `properties`: values that are read or
    have no effect; None: the property is read, or noted by the code that reads the node.
    """

    read: frozenset = frozenset()
    neutral: dict = field(default_factory=dict)
    follows: frozenset = frozenset()
    properties: dict = field(default_factory=dict)


def _entry(read="", neutral=None, follows="", **properties):
    def names(text):
        return frozenset(name.strip() for name in text.split(",") if name.strip())

    return Entry(names(read), {"Normal": None, **(neutral or {})}, names(follows), properties)


@dataclass(frozen=True)
class NodeTable:
    """Entries by type of node, and notes on sockets and properties whose names do not say enough."""

    entries: dict
    messages: dict


_BOTH = {
    "EMISSION": _entry("Color, Strength"),
    "BACKGROUND": _entry("Color, Strength"),
    "BSDF_TRANSPARENT": _entry("Color"),
    "MIX_SHADER": _entry("Fac, Shader, Shader_001"),
    "ADD_SHADER": _entry("Shader, Shader_001"),
    "OUTPUT_WORLD": _entry("Surface", {"Volume": None}, target=None, is_active_output=None),
    "OUTPUT_LIGHT": _entry("Surface", target=None, is_active_output=None),
    "MAPPING": _entry("Vector, Location, Rotation, Scale", vector_type=None),
    "UVMAP": _entry(uv_map=None, from_instancer=None),
    "TEX_COORD": _entry("", {}, "object", from_instancer=None),
    "RGB": _entry(),
    "VALUE": _entry(),
}
_IMAGE = "projection_blend, color_mapping, image_user"  # an image notes its frames

_PHONG = {
    **_BOTH,
    "BSDF_PRINCIPLED": _entry(
        "Base Color, Metallic, Roughness, IOR, Alpha, Specular IOR Level, Transmission Weight,"
        "Emission Color, Emission Strength",
        {
            "Diffuse Roughness": 0.0,
            "Subsurface Weight": 0.0,
            "Specular Tint": WHITE,
            "Anisotropic": 0.0,
            "Coat Weight": 0.0,
            "Sheen Weight": 0.0,
            "Thin Film Thickness": 0.0,
        },
        "Subsurface Radius, Subsurface Scale, Subsurface IOR, Subsurface Anisotropy,"
        "Anisotropic Rotation, Tangent, Coat Roughness, Coat IOR, Coat Tint, Coat Normal,"
        "Sheen Roughness, Sheen Tint, Thin Film IOR, subsurface_method",
        distribution=_GGX,
    ),
    "BSDF_DIFFUSE": _entry("Color", {"Roughness": 0.0}),
    "BSDF_GLOSSY": _entry(
        "Color, Roughness", {"Anisotropy": 0.0}, "Rotation, Tangent", distribution=_GGX
    ),
    "BSDF_METALLIC": _entry(
        "Base Color, Roughness, IOR, Extinction",
        {"Anisotropy": 0.0, "Thin Film Thickness": 0.0},
        "Rotation, Tangent, Thin Film IOR, Edge Tint",  # Edge Tint is always noted
        distribution=_GGX,
        fresnel_type=None,
    ),
    "BSDF_GLASS": _entry(
        "Color, Roughness, IOR", {"Thin Film Thickness": 0.0}, "Thin Film IOR", distribution=_GGX
    ),
    "OUTPUT_MATERIAL": _entry(
        "Surface", {"Volume": None, "Displacement": None}, "Thickness", target=None,
        is_active_output=None,
    ),
    "TEX_IMAGE": _entry(
        "Vector", {}, _IMAGE,
        image=None,
        projection=("FLAT",),
        interpolation=("Linear",),
        extension=("REPEAT",),
        texture_mapping=None,
    ),
}  # fmt: skip

_PHYSICAL = {
    **_BOTH,
    "BSDF_PRINCIPLED": _entry(
        "Base Color, Metallic, Roughness, IOR, Alpha, Normal, Diffuse Roughness, Specular IOR Level,"
        "Specular Tint, Anisotropic, Anisotropic Rotation, Tangent, Transmission Weight, Coat Weight,"
        "Coat Roughness, Coat IOR, Coat Tint, Coat Normal, Sheen Weight, Sheen Roughness, Sheen Tint,"
        "Emission Color, Emission Strength",
        {"Subsurface Weight": 0.0, "Thin Film Thickness": 0.0},
        "Subsurface Radius, Subsurface Scale, Subsurface IOR, Subsurface Anisotropy, Thin Film IOR,"
        "subsurface_method",
        distribution=_KEEPS_ENERGY,
    ),
    "BSDF_DIFFUSE": _entry("Color, Roughness, Normal"),
    "BSDF_GLOSSY": _entry(
        "Color, Roughness, Normal, Anisotropy, Rotation, Tangent", distribution=_KEEPS_ENERGY
    ),
    "BSDF_METALLIC": _entry(
        "Base Color, Edge Tint, Roughness, IOR, Extinction, Normal, Anisotropy, Rotation, Tangent",
        {"Thin Film Thickness": 0.0},
        "Thin Film IOR",
        distribution=_KEEPS_ENERGY,
        fresnel_type=None,
    ),
    "BSDF_GLASS": _entry(
        "Color, Roughness, IOR, Normal", {"Thin Film Thickness": 0.0}, "Thin Film IOR",
        distribution=_KEEPS_ENERGY,
    ),
    "BSDF_REFRACTION": _entry("Color, Roughness, IOR, Normal", {}, "distribution"),  # always noted
    "BSDF_SHEEN": _entry("Color, Roughness, Normal", distribution=("MICROFIBER",)),
    "OUTPUT_MATERIAL": _entry(
        "Surface, Volume", {"Displacement": None}, "Thickness", target=None, is_active_output=None
    ),
    "VOLUME_ABSORPTION": _entry("Color, Density"),
    "NORMAL_MAP": _entry("Strength, Color", space=("TANGENT",), uv_map=None, convention=None),
    "TEX_IMAGE": _entry(
        "Vector", {}, _IMAGE,
        image=None,
        projection=("FLAT",),
        interpolation=("Linear", "Closest"),
        extension=("REPEAT", "EXTEND", "MIRROR"),
        texture_mapping=None,
    ),
    "TEX_ENVIRONMENT": _entry(
        "Vector", {}, "color_mapping, image_user",
        image=None,
        projection=("EQUIRECTANGULAR",),
        interpolation=("Linear", "Closest"),
        texture_mapping=None,
    ),
}  # fmt: skip

_PHONG_MESSAGES = {
    ("OUTPUT_MATERIAL", "Volume"): "volume is not carried",
    ("OUTPUT_MATERIAL", "Displacement"): "displacement is not carried",
    ("OUTPUT_WORLD", "Volume"): "volumes are not carried",
    ("BSDF_DIFFUSE", "Roughness"): "Diffuse Roughness is not carried",
    (
        "TEX_IMAGE",
        "interpolation",
    ): "interpolation {value} of an image is not carried: pixels are blurred, as with Linear",
    ("TEX_IMAGE", "projection"): "{value} projection of an image is not carried",
    ("TEX_IMAGE", "extension"): "images repeat in slo-rt: extension {value} is not carried",
}
for _kind in _PHONG:
    _PHONG_MESSAGES[_kind, "Normal"] = "normal and bump maps are not carried"

_PHYSICAL_MESSAGES = {
    ("OUTPUT_MATERIAL", "Displacement"): "displacement is not carried",
    ("OUTPUT_WORLD", "Volume"): "volumes are not carried",
    ("TEX_IMAGE", "interpolation"): (
        "interpolation {value} of an image is not carried: it is linear between pixels"
    ),
    ("TEX_IMAGE", "projection"): "{value} projection of an image is not carried",
    ("TEX_IMAGE", "extension"): (
        "extension {value} of an image is not carried: its rim goes on, as with Extend"
    ),
    ("BSDF_SHEEN", "distribution"): "{value} sheen is not carried: it is as with Microfiber",
    ("NORMAL_MAP", "space"): "normal maps in {value} space are not carried",
}
for _kind, _each in _PHYSICAL.items():
    if _each.properties.get("distribution") == _KEEPS_ENERGY:
        _PHYSICAL_MESSAGES[_kind, "distribution"] = (
            "distribution {value} is not carried: no light is lost between facets, as with "
            "Multiscatter GGX"
        )

PHONG = NodeTable(_PHONG, _PHONG_MESSAGES)
PHYSICAL = NodeTable(_PHYSICAL, _PHYSICAL_MESSAGES)

# Values at which a texture's own mapping (`ImageTexture.texture_mapping`) has no effect.
PLAIN_TEXTURE_MAPPING = {
    "translation": ZERO,
    "rotation": ZERO,
    "scale": (1.0, 1.0, 1.0),
    "mapping_x": "X",
    "mapping_y": "Y",
    "mapping_z": "Z",
    "use_min": False,
    "use_max": False,
}
