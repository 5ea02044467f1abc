# SPDX-License-Identifier: GPL-3.0-or-later
"""Images become PNG files of linear light, which is what slo-rt multiplies with."""

import numpy as np

from ..format import png16

_LINEAR = {"Non-Color", "Linear Rec.709", "Linear", "Raw", "scene_linear"}


def write_linear(image, path, is_alpha, report):
    """Writes an image to a 16-bit PNG file, or the grey of its alpha. Returns whether there was an
    image to write.

    Byte images are held by Blender as their file has them, in sRGB mostly, and are turned to linear
    light; float images are linear already.
    """
    subject = f'image "{image.name}"'
    if image.source in {"MOVIE", "SEQUENCE", "TILED"}:
        report.note(subject, "of movies, sequences and tiles only the first picture is carried")
    width, height = image.size
    if width == 0 or height == 0:
        report.note(subject, "can't be read; its surface has no texture")
        return False
    channels = image.channels
    values = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(values)
    pixels = values.reshape(height, width, channels)
    space = image.colorspace_settings.name
    if is_alpha:
        alpha = pixels[..., 3:4] if channels == 4 and image.alpha_mode != "NONE" else np.ones((height, width, 1), np.float32)
        png16.write(path, np.repeat(alpha, 3, axis=2)[::-1])
        return True
    rgb = np.repeat(pixels[..., :1], 3, axis=2) if channels < 3 else pixels[..., :3]
    if not image.is_float and space == "sRGB":
        rgb = linear_of_srgb(rgb)
    elif not image.is_float and space not in _LINEAR:
        report.note(subject, f"its colour space, {space}, is taken for linear")
    if channels == 4 and image.alpha_mode != "NONE" and pixels[..., 3].min() < 1.0:
        report.note(subject, "the transparency of an image is not carried")
    if not np.isfinite(rgb).all():
        report.note(subject, "what is no finite number in it is black")
        rgb = np.where(np.isfinite(rgb), rgb, 0.0)
    if rgb.max(initial=0.0) > 1.0 or rgb.min(initial=0.0) < 0.0:
        report.note(subject, "values below 0 and above 1 are cut off")
    png16.write(path, rgb[::-1])
    return True


def linear_of_srgb(values):
    """Linear light of sRGB values in [0, 1]."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
