# SPDX-License-Identifier: GPL-3.0-or-later
"""Physical surfaces as text, without Blender."""

import unittest

from slo_rt.format import scene_text
from slo_rt.format.names import Names
from slo_rt.format.principled import (
    INVISIBLE,
    ImageUse,
    Mix,
    Principled,
    Value,
    glowing,
    matt,
    metal,
    metal_of_conductor,
    seen_through,
    tint_of_even_metal,
)


def text(surface):
    """The elements of a surface named `a`, with textures that are names already."""
    names = Names()
    return scene_text.write(surface.elements(names.new("a"), names.new, str))


class TextTest(unittest.TestCase):
    def test_defaults(self):
        self.assertEqual(text(Principled()), "material_principled a {  }\n")
        nearly = Principled({"coat": Value(1.0), "coat_roughness": Value(0.029999999329447746)})
        self.assertEqual(text(nearly), "material_principled a { coat 1 }\n")

    def test_values_without_an_effect(self):
        for name, value in (
            ("coat_roughness", 0.5), ("sheen_tint", (0.5, 0.5, 0.5)), ("normal_strength", 0.5),
            ("anisotropic_rotation", 0.5), ("emission_strength", 1.0),
        ):  # fmt: skip
            values = {name: Value(value), "emission_color": Value((0.0, 0.0, 0.0))}
            self.assertNotIn(name, text(Principled(values)))
            self.assertEqual(Principled(values).uses(), [])

    def test_images(self):
        plain = Principled({"roughness": Value(1.0, ImageUse("t"))})
        self.assertEqual(text(plain), "material_principled a { roughness_texture t }\n")
        use = ImageUse("t", "G", (2.0, 1.0), 30.0, (0.0, 0.5))
        moved = text(Principled({"roughness": Value(0.5, use), "normal": Value((1.0,) * 3, use)}))
        block = "{ texture t  channel G  scale_U 2  offset_V 0.5  turn_deg 30 }"
        for line in ("roughness 0.5", f"roughness_texture {block}", f"normal_texture {block}"):
            self.assertIn(f"    {line}\n", moved)

    def test_mixes_are_named_after_their_parts(self):
        inner = Mix(matt(Value((0.5,) * 3)), INVISIBLE, Value(1.0, ImageUse("t")))
        found = text(Mix(inner, glowing(Value((1.0,) * 3), Value(2.0)), Value(0.25)))
        self.assertIn("material_mix a_1 { first a_1_1  second a_1_2  factor_texture t }", found)
        self.assertIn("material_mix a { first a_1  second a_2  factor 0.25 }", found)
        self.assertLess(found.index("material_principled a_1_1"), found.index("material_mix a_1"))


class MeaningTest(unittest.TestCase):
    def test_seen_through(self):
        half = seen_through(Principled({"alpha": Value(0.5)}), Value(0.5))
        self.assertEqual(half["alpha"], Value(0.25))
        image = Value(1.0, ImageUse("t", "A"))
        self.assertEqual(seen_through(half, image)["alpha"], Value(0.25, image.image))
        both = seen_through(seen_through(half, image), image)
        self.assertIsInstance(both, Mix)
        self.assertTrue(both.first.is_invisible)

    def test_light(self):
        lamp = glowing(Value((1.0, 0.0, 0.0)), Value(2.0))
        self.assertTrue(lamp.emits)
        self.assertTrue(Mix(matt(Value((0.5,) * 3)), lamp, Value(0.5)).emits)
        self.assertFalse(matt(Value((0.5,) * 3)).emits)

    def check_fit(self, facing, tint, reflectance):
        """No other tint makes a metal more like `reflectance(cosine)`."""

        def misfit(other):
            cosines = [(step + 0.5) / 200 for step in range(200)]
            return sum(c * (metal(c, facing, other) - reflectance(c)) ** 2 for c in cosines)

        for other in (tint - 0.02, tint + 0.02):
            if 0.0 <= other <= 1.0:
                self.assertGreater(misfit(other), misfit(tint))

    def test_even_metals(self):
        color = (0.0, 0.3, 0.9, 1.0)
        for facing, tint in zip(color, tint_of_even_metal(color)):
            self.check_fit(facing, tint, lambda _, facing=facing: facing)
            self.assertAlmostEqual(metal(1.0, facing, tint), facing)

    def test_conductors(self):
        """Against Fresnel's equations with complex numbers."""
        n, k = (0.05, 1.5, 2.7), (4.0, 0.1, 3.0)
        color, tint = metal_of_conductor(n, k)
        for index in range(3):
            eta = complex(n[index], -k[index])

            def reflectance(cosine, eta=eta):
                inside = (1.0 - (1.0 - cosine**2) / eta**2) ** 0.5
                across = abs((cosine - eta * inside) / (cosine + eta * inside)) ** 2
                along = abs((eta * cosine - inside) / (eta * cosine + inside)) ** 2
                return 0.5 * (across + along)

            self.assertAlmostEqual(color[index], reflectance(1.0))
            self.check_fit(color[index], tint[index], reflectance)


if __name__ == "__main__":
    unittest.main()
