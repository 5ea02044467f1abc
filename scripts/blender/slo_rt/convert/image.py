# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes images as PNG files of linear light, which slo-rt multiplies colours by."""

import hashlib

import numpy as np

from ..format import png16
from ..format.fingerprint import fingerprint

_LINEAR = {"Non-Color", "Linear Rec.709", "Linear", "Raw", "scene_linear"}


class Picture:
    """An image of Blender, or its alpha as grey, to be written as a file.

    Blender stores byte images as in their files, mostly in sRGB, so they are converted to linear
    light. Float images are linear already.
    """

    def __init__(self, image, is_alpha):
        self.image = image
        self.is_alpha = is_alpha
        self.is_readable = image.size[0] > 0 and image.size[1] > 0
        if self.is_readable:
            self._values = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
            image.pixels.foreach_get(self._values)

    @property
    def subject(self):
        """Its name in notes."""
        return f'image "{self.image.name}"'

    def digest(self):
        """Hash of everything that its file depends on, as 32 hexadecimal digits."""
        image = self.image
        words = repr(
            (
                tuple(image.size), image.channels, image.is_float, image.alpha_mode,
                image.colorspace_settings.name, self.is_alpha,
            )
        )  # fmt: skip
        both = words.encode() + fingerprint(self._values)
        return hashlib.blake2b(both, digest_size=16).hexdigest()

    def write(self, path):
        """Writes a 16-bit PNG file; returns the notes on it."""
        image, notes = self.image, []
        width, height = image.size
        pixels = self._values.reshape(height, width, image.channels)[::-1]
        has_alpha = image.channels == 4 and image.alpha_mode != "NONE"
        if self.is_alpha:
            alpha = pixels[..., 3:4] if has_alpha else np.ones((height, width, 1), np.float32)
            png16.write(path, png16.levels(np.repeat(alpha, 3, axis=2)))
            return notes
        rgb = np.repeat(pixels[..., :1], 3, axis=2) if image.channels < 3 else pixels[..., :3]
        space = image.colorspace_settings.name
        if not image.is_float and space != "sRGB" and space not in _LINEAR:
            notes.append(f"its colour space, {space}, is taken for linear")
        if has_alpha and pixels[..., 3].min() < 1.0:
            notes.append("the transparency of an image is not carried")
        if not image.is_float and space == "sRGB":
            png16.write(path, _LINEAR_LEVELS[(rgb * 255.0 + 0.5).astype(np.uint8)])
            return notes
        if not np.isfinite(rgb).all():
            notes.append("what is no finite number in it is black")
            rgb = np.where(np.isfinite(rgb), rgb, 0.0)
        if rgb.max(initial=0.0) > 1.0 or rgb.min(initial=0.0) < 0.0:
            notes.append("values below 0 and above 1 are cut off")
        png16.write(path, png16.levels(rgb))
        return notes


def linear_of_srgb(values):
    """Converts sRGB values in [0, 1] to linear light."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


# Of the 256 levels of a byte image in sRGB.
_LINEAR_LEVELS = png16.levels(linear_of_srgb(np.arange(256) / 255.0))
