# SPDX-License-Identifier: GPL-3.0-or-later
"""slo-rt's physical surfaces, and Blender's shaders as settings of them."""

import math
from dataclasses import dataclass, field

from .scene_text import Element, block

BLACK = (0.0, 0.0, 0.0)
WHITE = (1.0, 1.0, 1.0)

DEFAULTS = {
    "base_color": (0.8, 0.8, 0.8),
    "metallic": 0.0,
    "roughness": 0.5,
    "diffuse_roughness": 0.0,
    "ior": 1.5,
    "alpha": 1.0,
    "normal": WHITE,  # only as an image
    "normal_strength": 1.0,
    "specular_ior_level": 0.5,
    "specular_tint": WHITE,
    "anisotropic": 0.0,
    "anisotropic_rotation": 0.0,
    "transmission": 0.0,
    "coat": 0.0,
    "coat_roughness": 0.03,
    "coat_ior": 1.5,
    "coat_tint": WHITE,
    "sheen": 0.0,
    "sheen_roughness": 0.5,
    "sheen_tint": WHITE,
    "emission_color": WHITE,
    "emission_strength": 0.0,
    "absorption_color": WHITE,
    "absorption_distance": 0.0,
    "thin": 0,
}

# Values that have no effect while another one is 0, or while there is no image of normals.
NEEDS = {
    "normal_strength": "normal",
    "anisotropic_rotation": "anisotropic",
    "coat_roughness": "coat",
    "coat_ior": "coat",
    "coat_tint": "coat",
    "sheen_roughness": "sheen",
    "sheen_tint": "sheen",
    "emission_color": "emission_strength",
    "absorption_color": "absorption_distance",
}

# A surface without reflections at any angle.
DULL = {"ior": 1.0, "specular_ior_level": 0.0}

# Blender's metals have their tint at this cosine.
_COSINE_OF_TINT = 1.0 / 7.0
_STEPS = 64  # of cosines that are compared


@dataclass(frozen=True)
class ImageUse:
    """An image as a surface uses it: the `texture` is whatever identifies it to the caller, `channel`
    is `R`, `G`, `B`, `A` or empty. Texture coordinates are scaled, then turned, then moved."""

    texture: object
    channel: str = ""
    scale: tuple = (1.0, 1.0)
    turn_deg: float = 0.0
    offset: tuple = (0.0, 0.0)

    def item(self, name, name_of):
        """Returns its attribute or block; `name_of(texture)` is the name of the texture's element."""
        body = [("channel", self.channel)] if self.channel else []
        for word, values, plain in (("scale", self.scale, 1.0), ("offset", self.offset, 0.0)):
            for axis, value in zip("UV", values):
                if value != plain:
                    body.append((f"{word}_{axis}", value))
        if self.turn_deg != 0.0:
            body.append(("turn_deg", self.turn_deg))
        texture = name_of(self.texture)
        return block(name, [("texture", texture), *body]) if body else (name, texture)


@dataclass(frozen=True)
class Value:
    """A number or colour, and the image that multiplies it, or None."""

    value: object
    image: ImageUse | None = None

    @property
    def is_zero(self):
        """Whether it is 0 everywhere."""
        return not any(self.value) if isinstance(self.value, tuple) else self.value == 0.0

    def times(self, factor):
        """Returns the value times a number."""
        if isinstance(self.value, tuple):
            return Value(tuple(factor * each for each in self.value), self.image)
        return Value(factor * self.value, self.image)

    def items(self, name, name_of):
        """Returns the attributes that say it."""
        if self.image is None:
            return [(name, self.value)]
        plain = WHITE if isinstance(self.value, tuple) else 1.0
        factor = [] if self.value == plain else [(name, self.value)]
        return [*factor, self.image.item(f"{name}_texture", name_of)]


@dataclass
class Principled:
    """The values of a `material_principled`, by name; those that are missing are defaults."""

    values: dict = field(default_factory=dict)

    def __getitem__(self, name):
        return self.values.get(name, Value(DEFAULTS[name]))

    @property
    def emits(self):
        """Whether it shines by itself."""
        return not (self["emission_strength"].is_zero or self["emission_color"].is_zero)

    @property
    def is_invisible(self):
        """Whether everything passes through it."""
        return self["alpha"].is_zero

    @property
    def is_brushed(self):
        """Whether it reflects differently along and across its uv map."""
        return not self["anisotropic"].is_zero

    def with_values(self, **values):
        """Returns a copy with other values."""
        return Principled({**self.values, **values})

    def uses(self):
        """Returns the images that have an effect."""
        return [self[name].image for name in DEFAULTS if self._counts(name) and self[name].image]

    def elements(self, name, new_name, name_of):
        """Returns its element, in a list."""
        del new_name
        body = []
        for key, default in DEFAULTS.items():
            value = self[key]
            if (value.image or not _is_near(value.value, default)) and self._counts(key):
                body += value.items(key, name_of)
        return [Element("material_principled", name, body)]

    def _counts(self, name):
        """Whether a value has an effect. Some have one only together with another one."""
        if name.startswith("emission_"):
            return self.emits
        needs = NEEDS.get(name)
        if needs == "normal":
            return self["normal"].image is not None
        return needs is None or not self[needs].is_zero


def _is_near(value, default):
    """Whether a value is a default as single precision holds it."""
    pairs = zip(value, default) if isinstance(value, tuple) else [(value, default)]
    return all(abs(a - b) <= 1e-7 for a, b in pairs)


@dataclass
class Mix:
    """Two surfaces (`Principled` or `Mix`); `factor`, a `Value`, is the share of the second."""

    first: object
    second: object
    factor: Value

    @property
    def emits(self):
        """Whether one of the surfaces shines by itself."""
        return self.first.emits or self.second.emits

    @property
    def is_invisible(self):
        """Whether everything passes through it."""
        return self.first.is_invisible and self.second.is_invisible

    @property
    def is_brushed(self):
        """Whether one of the surfaces is."""
        return self.first.is_brushed or self.second.is_brushed

    def uses(self):
        """Returns the images that have an effect."""
        own = [self.factor.image] if self.factor.image else []
        return [*own, *self.first.uses(), *self.second.uses()]

    def elements(self, name, new_name, name_of):
        """Returns the elements of the surfaces, then its own; `new_name(wish)` makes names."""
        found, names = [], []
        for number, surface in ((1, self.first), (2, self.second)):
            names.append(new_name(f"{name}_{number}"))
            found += surface.elements(names[-1], new_name, name_of)
        body = [("first", names[0]), ("second", names[1]), *self.factor.items("factor", name_of)]
        return [*found, Element("material_mix", name, body)]


def seen_through(surface, share):
    """Returns `surface` where its `share`, a `Value`, is seen, and what is behind it elsewhere."""
    alpha = surface["alpha"] if isinstance(surface, Principled) else None
    if alpha is not None and not (alpha.image and share.image):
        both = Value(alpha.value * share.value, alpha.image or share.image)
        return surface.with_values(alpha=both)
    return Mix(INVISIBLE, surface, share)


INVISIBLE = Principled({"alpha": Value(0.0)})


def matt(color, roughness=Value(0.0)):
    """Returns a diffuse surface without reflections; `color` and `roughness` are `Value`s."""
    dull = {name: Value(value) for name, value in DULL.items()}
    return Principled({"base_color": color, "diffuse_roughness": roughness, **dull})


def glowing(color, strength):
    """Returns a surface that shines and reflects nothing."""
    return matt(Value(BLACK)).with_values(emission_color=color, emission_strength=strength)


def tint_of_even_metal(color):
    """Returns the `specular_tint` with which a metal of this colour reflects nearly as much at the rim
    as straight on."""
    return tuple(_tint(facing, lambda _, facing=facing: facing) for facing in color)


def metal_of_conductor(n, k):
    """Returns `(base_color, specular_tint)` of a conductor with refractive indices `n` and extinction
    coefficients `k`, three numbers each."""
    facing = tuple(_conductor(1.0, a, b) for a, b in zip(n, k))
    tints = (
        _tint(f, lambda cosine, a=a, b=b: _conductor(cosine, a, b)) for f, a, b in zip(facing, n, k)
    )
    return facing, tuple(tints)


def metal(cosine, facing, tint):
    """Returns the reflectance of a metal as slo-rt and Blender compute it (F82 tint)."""
    rim = 1.0 - cosine
    dip = cosine * rim**6 / (_COSINE_OF_TINT * (1.0 - _COSINE_OF_TINT) ** 6)
    return _schlick(cosine, facing) - dip * _schlick(_COSINE_OF_TINT, facing) * (1.0 - tint)


def _schlick(cosine, facing):
    return facing + (1.0 - facing) * (1.0 - cosine) ** 5


def _tint(facing, reflectance):
    """Returns the tint that makes `metal` most like `reflectance(cosine)`, by least squares over the
    directions that a surface sees."""
    above, norm = 0.0, 0.0
    for step in range(_STEPS):
        cosine = (step + 0.5) / _STEPS
        dip = metal(cosine, facing, 1.0) - metal(cosine, facing, 0.0)
        above += cosine * dip * (metal(cosine, facing, 1.0) - reflectance(cosine))
        norm += cosine * dip * dip
    return min(max(1.0 - above / norm, 0.0), 1.0)


def _conductor(cosine, n, k):
    """Returns the reflectance of a conductor by Fresnel's equations."""
    square = cosine * cosine
    sine = 1.0 - square
    inner = n * n - k * k - sine
    both = math.sqrt(inner * inner + 4.0 * n * n * k * k)
    a = math.sqrt(max(0.5 * (both + inner), 0.0))
    across = (both + square - 2.0 * a * cosine) / (both + square + 2.0 * a * cosine)
    more, less = square * both + sine * sine, 2.0 * a * cosine * sine
    return 0.5 * across * (1.0 + (more - less) / (more + less))
