# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes images: as PNG files of linear light for Phong materials, as they are for physical surfaces."""

import functools
import hashlib
import os

import bpy
import numpy as np

from ..format import exr, png
from ..format.fingerprint import fingerprint

_LINEAR = {"Non-Color", "Linear Rec.709", "Linear", "Raw", "scene_linear"}


class _Picture:
    """The pixels of an image of Blender, to be written as a file with the ending `ending`.

    `kind` is whatever else its file depends on.
    """

    ending = "png"

    def __init__(self, image, kind):
        self.image = image
        self._kind = kind
        self.is_readable = image.size[0] > 0 and image.size[1] > 0

    @functools.cached_property
    def _values(self):
        image = self.image
        values = np.empty(image.size[0] * image.size[1] * image.channels, np.float32)
        image.pixels.foreach_get(values)
        return values

    def _content(self):
        """Returns an array of everything that is in its file."""
        return self._values

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
                image.colorspace_settings.name, self._kind,
            )
        )  # fmt: skip
        both = words.encode() + fingerprint(self._content())
        return hashlib.blake2b(both, digest_size=16).hexdigest()

    def _pixels(self):
        """Returns its pixels (height, width, channels), the top row first."""
        width, height = self.image.size
        return self._values.reshape(height, width, self.image.channels)[::-1]

    def _rgb(self):
        pixels = self._pixels()
        is_grey = self.image.channels < 3
        return np.repeat(pixels[..., :1], 3, axis=2) if is_grey else pixels[..., :3]

    def _notes_on_colors(self):
        space = self.image.colorspace_settings.name
        if not self.image.is_float and space != "sRGB" and space not in _LINEAR:
            return [f"its colour space, {space}, is taken for linear"]
        return []


class Picture(_Picture):
    """An image of Blender, or its alpha as grey, as linear light.

    Blender stores byte images as in their files, mostly in sRGB, so they are converted to linear
    light. Float images are linear already.
    """

    def __init__(self, image, is_alpha):
        super().__init__(image, is_alpha)
        self.is_alpha = is_alpha

    def write(self, path):
        """Writes a 16-bit PNG file; returns the notes on it."""
        image, notes = self.image, []
        width, height = image.size
        pixels = self._pixels()
        has_alpha = image.channels == 4 and image.alpha_mode != "NONE"
        if self.is_alpha:
            alpha = pixels[..., 3:4] if has_alpha else np.ones((height, width, 1), np.float32)
            png.write(path, png.levels(np.repeat(alpha, 3, axis=2)))
            return notes
        rgb = self._rgb()
        space = image.colorspace_settings.name
        notes += self._notes_on_colors()
        if has_alpha and pixels[..., 3].min() < 1.0:
            notes.append("the transparency of an image is not carried")
        if not image.is_float and space == "sRGB":
            png.write(path, _LINEAR_LEVELS[(rgb * 255.0 + 0.5).astype(np.uint8)])
            return notes
        if not np.isfinite(rgb).all():
            notes.append("what is no finite number in it is black")
            rgb = np.where(np.isfinite(rgb), rgb, 0.0)
        if rgb.max(initial=0.0) > 1.0 or rgb.min(initial=0.0) < 0.0:
            notes.append("values below 0 and above 1 are cut off")
        png.write(path, png.levels(rgb))
        return notes


class Original(_Picture):
    """An image of Blender as it is: bytes in a PNG file with their own curve, or linear floats in an
    EXR file.

    With `has_alpha`, alpha stands beside the colours; otherwise colours are multiplied by alpha if
    `is_associated`.
    """

    def __init__(self, image, has_alpha, is_associated):
        super().__init__(image, ("original", has_alpha, is_associated))
        self._has_alpha = has_alpha
        self._is_associated = is_associated
        self._file = _radiance_file(image) if image.is_float and not has_alpha else None
        self.ending = "hdr" if self._file else "exr" if image.is_float else "png"
        is_srgb = not image.is_float and image.colorspace_settings.name == "sRGB"
        self.encoding = "SRGB" if is_srgb else "RAW"

    def write(self, path):
        """Writes the file; returns the notes on it."""
        notes = self._notes_on_colors()
        if self._file:
            partial = f"{path}.part"
            with open(partial, "wb") as file:
                file.write(self._file)
            os.replace(partial, path)
        elif self.image.is_float:
            pixels = self._floats()
            if not np.isfinite(pixels).all():
                notes.append("what is no finite number in it is black")
                pixels = np.where(np.isfinite(pixels), pixels, 0.0)
            exr.write(path, pixels)
        else:
            png.write(path, self._bytes())
        return notes

    def _content(self):
        return np.frombuffer(self._file, np.uint8) if self._file else self._values

    def _bytes(self):
        values = np.rint(np.clip(self._rgb(), 0.0, 1.0) * 255.0).astype(np.uint8)
        if not (self._has_alpha or self._is_associated):
            return values
        alpha = np.rint(np.clip(self._pixels()[..., 3:4], 0.0, 1.0) * 255.0).astype(np.uint8)
        if self._has_alpha:
            return np.concatenate([values, alpha], axis=2)
        # In whole numbers, before the curve is removed, as in Cycles.
        return (values.astype(np.uint32) * alpha // 255).astype(np.uint8)

    def _floats(self):
        # Blender has multiplied their colours by alpha if they are to be.
        rgb = self._rgb()
        if not self._has_alpha:
            return rgb
        alpha = self._pixels()[..., 3:4]
        if self._is_associated:
            rgb = rgb / np.where(alpha > 0.0, alpha, 1.0)
        return np.concatenate([rgb, alpha], axis=2)


def _radiance_file(image):
    """Returns the contents of an unchanged Radiance file (.hdr) with the pixels of an image; None if
    there is no such file. Skies are large, so they are copied rather than read."""
    is_plain = image.colorspace_settings.name in _LINEAR and not image.is_dirty
    if image.source != "FILE" or image.file_format != "HDR" or not is_plain:
        return None
    try:
        if image.packed_file:
            data = image.packed_file.data
        else:
            path = bpy.path.abspath(image.filepath, library=image.library)
            with open(path, "rb") as file:
                data = file.read()
    except OSError:
        return None
    is_upright = b"\n\n-Y " in data[:4096]
    return data if data.startswith(b"#?") and is_upright else None


def linear_of_srgb(values):
    """Converts sRGB values in [0, 1] to linear light."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


# Of the 256 levels of a byte image in sRGB.
_LINEAR_LEVELS = png.levels(linear_of_srgb(np.arange(256) / 255.0))
