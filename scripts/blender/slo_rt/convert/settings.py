# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings, film and shutter."""

from dataclasses import dataclass

import numpy as np

from ..format.scene_text import Element


@dataclass
class Shutter:
    """When the shutter is open: for `duration` frames, starting `offset` frames after the frame's
    time."""

    offset: float
    duration: float

    @classmethod
    def of(cls, render, view_layer):
        """Reads the shutter from Blender's render settings."""
        if not (render.use_motion_blur and view_layer.use_motion_blur):
            return cls(0.0, 0.0)
        duration = render.motion_blur_shutter
        before = {"START": 0.0, "CENTER": 0.5, "END": 1.0}[render.motion_blur_position]
        return cls(-before * duration, duration)


def frames_per_second(render):
    """Returns the frames per second of the video.

    Blender stores the base in single precision, where 1.001 is 1.00100004673. The shortest decimal
    number that rounds to it is the artist's value.
    """
    return render.fps / float(str(np.float32(render.fps_base)))


def picture_size(render):
    """Returns the width and height of the picture in pixels."""
    percentage = render.resolution_percentage
    sides = (render.resolution_x * percentage // 100, render.resolution_y * percentage // 100)
    return max(sides[0], 1), max(sides[1], 1)


def settings_element(values, background):
    """Makes `settings` from the artist's values (`RenderSettings`) and the colour of the background."""
    body = [("imageSamples", values.samples)]
    if values.noise > 0.0:
        body += [
            ("imageMinSamples", min(values.min_samples, values.samples)),
            ("noise", values.noise),
        ]
    body += [
        ("recursion", values.recursion),
        ("generatorType", values.generator),
        ("lightSamplingType", values.light_sampling),
        ("accelerator", values.accelerator),
        ("shadow", values.shadow),
    ]
    if values.spatial_splits:
        body.append(("spatialSplits", 1))
    for keyword, count in (
        ("softShadowSamples", values.shadow_samples),
        ("diffuseReflectionSamples", values.reflection_samples),
        ("diffuseRefractionSamples", values.refraction_samples),
    ):
        if count != 1:
            body.append((keyword, count))
    if values.threads:
        body.append(("parallelThreads", values.threads))
    if values.seed:
        body.append(("seed", values.seed))
    return Element("settings", "blender", body + [("background", background)])


def film_element(size, prefix, output):
    """Makes a `Film`; PNG files get sRGB values, since they are meant for display."""
    body = [("width", size[0]), ("height", size[1]), ("prefix", prefix), ("output", output)]
    return Element("Film", "film", body + ([] if output == "EXR_IMAGE" else [("encoding", "SRGB")]))
