# SPDX-License-Identifier: GPL-3.0-or-later
"""Render settings, film and shutter."""

from dataclasses import dataclass

import numpy as np

from ..format.scene_text import Element

# A preview shows the light of so many photons directly.
PREVIEW_SAMPLES = 4
PREVIEW_PHOTONS = 60000
PREVIEW_NEAREST = 100


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
    body = _sampling(values)
    body += [
        ("recursion", values.recursion),
        ("generatorType", values.generator),
        ("lightSamplingType", "SAMPLE_ALL_AT_TIME" if _is_auto(values) else values.light_sampling),
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
    return Element("settings", "blender", [*body, *_machine(values), ("background", background)])


def physical_settings_element(scene):
    """Makes `settings` for the integrators PATH and PHOTON_MAP from the artist's values and Cycles'
    bounces."""
    values = scene.slo_rt
    if values.integrator == "PHOTON_MAP":
        size = values.photon_map_size
        more = [("photonMapSize", size), ("causticMapSize", size)]
        more += [("cacheError", values.cache_error)] if values.cache_error > 0.0 else []
    else:
        more = [("photons", values.photons)] if values.photons > 0.0 else []
    return _physical_settings(scene, values.integrator, _sampling(values), more)


def preview_settings_element(scene):
    """Makes `settings` for a preview: the light of few photons, shown directly."""
    count = min(PREVIEW_SAMPLES, scene.slo_rt.samples)
    more = [("gather", 0), ("photonMapSize", PREVIEW_PHOTONS), ("causticMapSize", PREVIEW_PHOTONS)]
    more.append(("photonNearest", PREVIEW_NEAREST))
    return _physical_settings(scene, "PHOTON_MAP", [("imageSamples", count)], more)


def _physical_settings(scene, integrator, sampling, more):
    values = scene.slo_rt
    cycles = getattr(scene, "cycles", None)
    has_bounces = values.use_cycles_bounces and cycles is not None
    body = [
        ("integrator", integrator),
        *sampling,
        ("recursion", cycles.max_bounces if has_bounces else values.bounces),
        ("generatorType", values.generator),
        *more,
    ]
    if not _is_auto(values):
        body.append(("lightSamplingType", values.light_sampling))
    body.append(("accelerator", values.accelerator))
    if values.spatial_splits:
        body.append(("spatialSplits", 1))
    return Element("settings", "blender", body + _machine(values))


def _is_auto(values):
    return values.light_sampling == "AUTO"


def _sampling(values):
    body = [("imageSamples", values.samples)]
    if values.noise > 0.0:
        body += [
            ("imageMinSamples", min(values.min_samples, values.samples)),
            ("noise", values.noise),
        ]
    return body


def _machine(values):
    threads = [("parallelThreads", values.threads)] if values.threads else []
    return threads + ([("seed", values.seed)] if values.seed else [])


# slo-rt's names of Blender's view transforms.
_TONE_MAPS = {"Standard": "NONE", "AgX": "AGX", "Raw": "NONE"}


def is_carried(name, value):
    """Whether the film of an exported scene shows a view setting as Blender does."""
    return name == "exposure" or (name == "view_transform" and value in _TONE_MAPS)


def film_element(size, prefix, output, view):
    """Makes a `Film`; PNG files get sRGB values, since they are meant for display. `view` holds the view
    settings that they show, or is None."""
    body = [("width", size[0]), ("height", size[1]), ("prefix", prefix), ("output", output)]
    if output == "EXR_IMAGE":
        return Element("Film", "film", body)
    is_raw = view is not None and view.view_transform == "Raw"
    body.append(("encoding", "RAW" if is_raw else "SRGB"))
    if view is not None:
        if view.exposure != 0.0:
            body.append(("exposure", view.exposure))
        tone_map = _TONE_MAPS.get(view.view_transform, "NONE")
        if tone_map != "NONE":
            body.append(("toneMap", tone_map))
    return Element("Film", "film", body)
