# SPDX-License-Identifier: GPL-3.0-or-later
"""slo-rt's description of a surface, and the conversion of physically based parameters to it."""

import math
from dataclasses import dataclass

from .scene_text import Element

BLACK = (0.0, 0.0, 0.0)

# Values that have no effect while another one is 0.
NEEDS = {
    "shininess": "specular",
    "diffuse_reflection": "reflectance",
    "diffuse_refraction": "refraction",
    "refraction_index": "refraction",
}


@dataclass
class Phong:
    """The values of a `phong_info`; colours are linear."""

    ambient: tuple = BLACK
    diffuse: tuple = BLACK
    specular: tuple = BLACK
    shininess: float = 0.0
    reflectance: float = 0.0
    diffuse_reflection: float = 0.0
    refraction: float = 0.0
    diffuse_refraction: float = 0.0
    refraction_index: float = 1.0

    @property
    def is_lit(self):
        """Whether it has colours that a texture multiplies."""
        return any(self.ambient) or any(self.diffuse)

    def element(self, name):
        """Returns its text, without values that are defaults or have no effect."""
        default = Phong()
        body = [
            (k, v)
            for k, v in vars(self).items()
            if tuple_of(v) != tuple_of(getattr(default, k)) and self._counts(k)
        ]
        return Element("phong_info", name, body)

    def _counts(self, name):
        """Whether a value has an effect. Some values have one only together with another value."""
        needs = NEEDS.get(name)
        return needs is None or any(tuple_of(getattr(self, needs)))


def blend(parts):
    """Mixes surfaces: returns `(Phong, whether nothing is lost)` for `(weight, Phong)` pairs.

    Colours add up, as light does. A surface has one roughness and one refraction index, which are
    taken from the part that reflects and refracts most.
    """

    def total(name):
        values = [(weight, tuple_of(getattr(phong, name))) for weight, phong in parts]
        summed = tuple(sum(w * v[i] for w, v in values) for i in range(len(values[0][1])))
        return summed if len(summed) > 1 else summed[0]

    def decide(strength, names):
        strong = [(weight * strength(p), p) for weight, p in parts if weight * strength(p) > 0.0]
        if not strong:
            return {}, True
        leader = max(strong, key=lambda part: part[0])[1]
        chosen = {name: getattr(leader, name) for name in names}
        return chosen, all(getattr(p, n) == v for _, p in strong for n, v in chosen.items())

    shine, one_shine = decide(
        lambda p: p.reflectance + mean(p.specular), ("shininess", "diffuse_reflection")
    )
    glass, one_glass = decide(lambda p: p.refraction, ("refraction_index", "diffuse_refraction"))
    sums = {n: total(n) for n in ("ambient", "diffuse", "specular", "reflectance", "refraction")}
    return Phong(**sums, **shine, **glass), one_shine and one_glass


def tuple_of(value):
    """Numbers and vectors as tuples, for comparison."""
    return (value,) if isinstance(value, (int, float)) else tuple(value)


@dataclass
class Surface:
    """A surface as artists set it: the sockets of the Principled BSDF that slo-rt supports."""

    base_color: tuple = (0.8, 0.8, 0.8)
    metallic: float = 0.0
    roughness: float = 0.5
    ior: float = 1.5
    specular_level: float = 0.5
    transmission: float = 0.0
    alpha: float = 1.0
    emission: tuple = BLACK


def spread_of_roughness(roughness):
    """Returns the standard deviation, in radians, of the directions in which a surface reflects.

    A microfacet distribution of width alpha = roughness^2 tilts facets by alpha / sqrt(2) on average,
    and a mirror deflects rays by twice its tilt.
    """
    return min(1.0, math.sqrt(2.0) * max(0.0, roughness) ** 2)


def reflectance_at_normal(ior, specular_level):
    """Returns the reflected share of light at normal incidence on a dielectric (Fresnel)."""
    fresnel = ((ior - 1.0) / (ior + 1.0)) ** 2
    return min(1.0, fresnel * 2.0 * specular_level)


def phong_of_surface(surface, ambient_light=BLACK):
    """Returns the Phong values nearest to `surface`, in a world with `ambient_light` from everywhere."""
    spread = spread_of_roughness(surface.roughness)
    dielectric = reflectance_at_normal(surface.ior, surface.specular_level)
    metal = mean(surface.base_color)
    solid = (1.0 - surface.metallic) * surface.alpha
    body = solid * (1.0 - surface.transmission)

    diffuse = tuple(body * c for c in surface.base_color)
    facing = tuple(
        surface.alpha * (surface.metallic * c + (1.0 - surface.metallic) * dielectric)
        for c in surface.base_color
    )
    reflectance = surface.alpha * (surface.metallic * metal + (1.0 - surface.metallic) * dielectric)
    through = solid * surface.transmission * metal * (1.0 - dielectric)
    see_through = 1.0 - surface.alpha
    ior = surface.ior if through > 0.0 else 1.0
    return Phong(
        ambient=tuple(d * a + e for d, a, e in zip(diffuse, ambient_light, surface.emission)),
        diffuse=diffuse,
        specular=tuple(min(1.0, f * _peak(surface.roughness)) for f in facing),
        shininess=_shininess(spread),
        reflectance=reflectance,
        diffuse_reflection=spread,
        refraction=through + see_through,
        diffuse_refraction=_spread_through(spread, ior) if through > 0.0 else 0.0,
        refraction_index=ior,
    )


def mean(color):
    """Returns one number for a colour: the mean of its channels."""
    return sum(color) / 3.0


def _shininess(spread):
    """Returns the exponent of the highlight whose lobe has this spread, limited so that it stays visible."""
    return min(1.0 / max(spread, 1e-3) ** 2, 2000.0)


def _peak(roughness):
    """Returns the peak of the highlight of a point lamp in units of the reflectance: 1 / (4 alpha^2)
    (GGX)."""
    return 1.0 / (4.0 * max(roughness, 0.05) ** 4)


def _spread_through(spread, ior):
    """Returns the spread of refracted rays. A facet deflects them less than reflected rays: by
    (1 - 1/ior) of its tilt on the way in and by ior - 1 on the way out, of which this is the
    geometric mean, instead of by 2 as a mirror."""
    return 0.5 * spread * math.sqrt(max(0.0, (1.0 - 1.0 / ior) * (ior - 1.0)))
