# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's camera becomes camera segments."""

import numpy as np

from ..fit.camera import CameraSamples, fit_segments
from ..fit.rigid import axes_of
from ..format.scene_text import Element, seconds

MILLIMETRE = 1e-3  # Blender counts lenses in millimetres and the scene in metres
SMALLEST_SCALE = 1e-20
SMALLEST_FSTOP = 1e-3
DEFAULT_CLIP_START = 0.1


class CameraReader:
    """Reads cameras of an evaluated scene, for a picture of `width` x `height` pixels."""

    def __init__(self, render, width, height):
        self._size = {
            "x": width,
            "y": height,
            "scale_x": render.pixel_aspect_x,
            "scale_y": render.pixel_aspect_y,
        }

    def __call__(self, camera, depsgraph):
        """Position, direction of view, up (world space), half the height of the view at distance 1,
        focus distance, lens radius; 12 numbers.

        # Errors `ValueError` for a camera without directions.
        """
        evaluated = camera.evaluated_get(depsgraph)
        matrix = np.array(evaluated.matrix_world, np.float64)
        lengths = np.linalg.norm(matrix[:3, :3], axis=0)
        if lengths.min() <= SMALLEST_SCALE:
            raise ValueError(f'camera "{camera.name}" is scaled to nothing: it looks nowhere')
        axes = matrix[:3, :3] / lengths
        position, forward = matrix[:3, 3], -axes[:, 2]
        projection = np.array(evaluated.calc_matrix_camera(depsgraph, **self._size))
        optics = evaluated.data
        focus, radius = self._focus(optics, position, forward, depsgraph)
        view = self._view(optics, projection, focus)
        return np.concatenate([position, forward, axes[:, 1], [view, focus, radius]])

    @staticmethod
    def _view(optics, projection, focus):
        half_height = 1.0 / projection[1, 1]
        return half_height / focus if optics.type == "ORTHO" else half_height

    @staticmethod
    def _focus(optics, position, forward, depsgraph):
        dof = optics.dof
        if dof.focus_object:
            target = dof.focus_object.evaluated_get(depsgraph).matrix_world.translation
            distance = abs(float(np.dot(np.array(target) - position, forward)))
        else:
            distance = dof.focus_distance
        if not dof.use_dof:
            return max(distance, 1e-6), 0.0
        fstop = max(dof.aperture_fstop, SMALLEST_FSTOP)
        return max(distance, 1e-6), optics.lens * MILLIMETRE / (2.0 * fstop)


def samples_of(times, rows):
    """`CameraSamples` from rows of `CameraReader`."""
    return CameraSamples(
        times=np.asarray(times, np.float64),
        position=rows[:, 0:3],
        forward=rows[:, 3:6],
        up=rows[:, 6:9],
        view=rows[:, 9],
        focus=rows[:, 10],
        lens_radius=rows[:, 11],
    )


def shots(scene, first, last):
    """`(camera, first frame, frame after the last)` from `first` to `last`: markers cut between
    cameras."""
    cuts = {first: scene.camera}
    markers = sorted((m.frame, m.camera) for m in scene.timeline_markers if m.camera)
    for frame, camera in markers:
        cuts[max(first, frame)] = camera
    starts = sorted(frame for frame in cuts if frame <= last)
    return [(cuts[a], a, b) for a, b in zip(starts, starts[1:] + [last + 1])]


def segments_of_shot(timeline, camera, first, stop, shutter, size):
    """Camera segments of one shot, frames `first` to before `stop`; as `fit_segments`."""

    def sample(times):
        return samples_of(times, timeline.camera_values(camera, times))

    return fit_segments(sample, first, stop, shutter, size)


def segment_element(name, segment, fps, shutter):
    """The text of a segment."""
    offset = shutter.offset
    scene_times = [
        ("sceneStart", seconds(segment.start / fps)),
        ("sceneEnd", seconds(segment.end / fps)),
    ]
    lens_is_open = any(segment.lens_radius)
    body = [
        ("videoStart", seconds((segment.start - offset) / fps)),
        ("videoEnd", seconds((segment.end - offset) / fps)),
        *(scene_times if offset else []),
        *(("addPosition", point) for point in segment.positions),
        *(("addTarget", point) for point in segment.targets),
        *_pair("sky", segment.sky),
        *_pair("fov", segment.view),
    ]
    if lens_is_open:
        body += [*_pair("dof", segment.focus), *_pair("lensRadius", segment.lens_radius)]
    if shutter.duration > 0.0:
        body.append(("blurDuration", seconds(shutter.duration / fps)))
    return Element("CamSegment", name, body)


def _pair(name, values):
    start, end = values
    moves = np.any(np.abs(np.subtract(end, start)) > 1e-9)
    return [(f"{name}Start", start)] + ([(f"{name}End", end)] if moves else [])


def note_limits(camera, render, report):
    """Notes what of `camera` slo-rt has no word for."""
    optics, subject = camera.data, f'camera "{camera.name}"'
    if optics.type == "ORTHO":
        report.note(
            subject,
            "orthographic; rendered in perspective, with the same height in the focus plane",
        )
    elif optics.type != "PERSP":
        report.note(subject, "a panorama; rendered in perspective")
    if optics.shift_x or optics.shift_y:
        report.note(subject, "the shift of the lens is not carried")
    if optics.dof.use_dof and (optics.dof.aperture_blades or optics.dof.aperture_ratio != 1.0):
        report.note(subject, "the aperture is a circle, whatever its blades and ratio")
    if render.pixel_aspect_x != render.pixel_aspect_y:
        change = "less" if render.pixel_aspect_x > render.pixel_aspect_y else "more"
        report.note(
            subject,
            f"pixels are square in slo-rt: the picture shows {change} at its sides than Blender's",
        )


def note_clipping(camera, values, things, report):
    """Notes what lies before the start or behind the end of a camera's clipping, which Blender does
    not show; `values` is what `CameraReader` says of it."""
    if not things:
        return
    optics, subject = camera.data, f'camera "{camera.name}"'
    placements = np.array([thing.placement for thing in things])
    boxes = np.array([thing.box for thing in things])
    axes = axes_of(placements[:, 3:6], placements[:, 6:9])
    position, forward = values[:3], values[3:6]
    eye = np.einsum("nji,nj->ni", axes, position - placements[:, :3])
    gaps = np.linalg.norm(eye - np.clip(eye, boxes[:, 0], boxes[:, 1]), axis=1)
    gaze = np.einsum("nji,j->ni", axes, forward)
    farthest = np.where(gaze > 0.0, boxes[:, 1], boxes[:, 0]) - eye
    if np.sum(farthest * gaze, axis=1).max() > optics.clip_end:
        report.note(subject, f"what is behind its clip end, {optics.clip_end:g} m, is seen too")
    # Around a camera in a room is a box, whose walls are farther off.
    outside = (gaps > 0.0) | (optics.clip_start > DEFAULT_CLIP_START * 1.001)
    if (outside & (gaps < optics.clip_start)).any():
        report.note(subject, f"what is before its clip start, {optics.clip_start:g} m, is seen too")
