# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts Blender's camera to camera segments."""

import numpy as np

from ..fit.camera import CameraSamples, fit_segments
from ..format.scene_text import Element, exact

MILLIMETRE = 1e-3  # Blender counts lenses in millimetres and the scene in metres
SMALLEST_SCALE = 1e-20
SMALLEST_FSTOP = 1e-3
# Lens of objects that are neither cameras nor lights, as in Cycles.
BARE_LENS, BARE_SENSOR = 50.0, 36.0
BARE_FOCUS = 10.0
# A camera is noted if the cosines between its axes are larger.
SHEAR_TOLERANCE = 1e-4


class CameraReader:
    """Reads cameras of an evaluated scene, for a picture of `width` x `height` pixels.

    Any object can be the camera: a light sees the area that it lights, and other objects have a
    lens of 50 mm, as in Cycles.
    """

    def __init__(self, render, width, height, report):
        self._report = report
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
        self._note_axes(camera, axes)
        position, forward = matrix[:3, 3], -axes[:, 2]
        focus, radius = BARE_FOCUS, 0.0
        if evaluated.type == "CAMERA":
            focus, radius = self._focus(evaluated.data, position, forward, depsgraph)
        view = self._view(evaluated, focus, depsgraph)
        return np.concatenate([position, forward, axes[:, 1], [view, focus, radius]])

    def _note_axes(self, camera, axes):
        """Notes a camera whose axes are not a right-handed system of right angles."""
        subject = f'camera "{camera.name}"'
        if np.linalg.det(axes) < 0.0:
            self._report.note(
                subject, "mirrored by a negative scale in Blender; slo-rt's picture is not mirrored"
            )
        if np.abs(axes.T @ axes - np.eye(3)).max() > SHEAR_TOLERANCE:
            self._report.note(subject, "sheared in Blender; slo-rt's picture is not")

    def _view(self, evaluated, focus, depsgraph):
        """Half the height of the view at distance 1."""
        if evaluated.type not in {"CAMERA", "LIGHT"}:
            sides = [self._size[side] * self._size[f"scale_{side}"] for side in "xy"]
            return BARE_SENSOR / (2.0 * BARE_LENS) * sides[1] / max(sides)
        half_height = 1.0 / evaluated.calc_matrix_camera(depsgraph, **self._size)[1][1]
        is_parallel = evaluated.type == "CAMERA" and evaluated.data.type == "ORTHO"
        return half_height / focus if is_parallel else half_height

    @staticmethod
    def _focus(optics, position, forward, depsgraph):
        dof = optics.dof
        if dof.focus_object:
            target = _focus_point(dof, depsgraph)
            distance = abs(float(np.dot(np.array(target) - position, forward)))
        else:
            distance = dof.focus_distance
        if not dof.use_dof:
            return max(distance, 1e-6), 0.0
        fstop = max(dof.aperture_fstop, SMALLEST_FSTOP)
        return max(distance, 1e-6), optics.lens * MILLIMETRE / (2.0 * fstop)


def _focus_point(dof, depsgraph):
    """Returns the position of the focus object, or of the head of its bone."""
    target = dof.focus_object.evaluated_get(depsgraph)
    bone = target.pose.bones.get(dof.focus_subtarget) if target.pose else None
    return (target.matrix_world @ bone.matrix if bone else target.matrix_world).translation


def samples_of(times, rows):
    """Makes `CameraSamples` from rows of `CameraReader`."""
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
    cameras, as in Blender.

    Before the first marker the first marker's camera counts; of several markers on one frame, the
    first in the list; a camera that is hidden in renders never.
    """
    markers = [m for m in scene.timeline_markers if m.camera and not m.camera.hide_render]
    markers.sort(key=lambda marker: marker.frame)
    cuts = {}
    for marker in markers:
        cuts.setdefault(marker.frame, marker.camera)
    before = [frame for frame in cuts if frame <= first]
    at_first = cuts[max(before) if before else min(cuts)] if cuts else scene.camera
    cuts = {first: at_first, **{f: camera for f, camera in cuts.items() if first < f <= last}}
    starts = sorted(cuts)
    return [(cuts[a], a, b) for a, b in zip(starts, starts[1:] + [last + 1])]


def segments_of_shot(timeline, camera, first, stop, shutter, size):
    """Camera segments of one shot, frames `first` to before `stop`; as `fit_segments`."""

    def sample(times):
        return samples_of(times, timeline.camera_values(camera, times))

    return fit_segments(sample, first, stop, shutter, size)


def segment_element(name, segment, fps, shutter):
    """Returns the text of a segment."""
    offset = shutter.offset
    scene_times = [
        ("sceneStart", exact(segment.start / fps)),
        ("sceneEnd", exact(segment.end / fps)),
    ]
    lens_is_open = any(segment.lens_radius)
    body = [
        ("videoStart", exact(_whole(segment.start - offset) / fps)),
        ("videoEnd", exact(_whole(segment.end - offset) / fps)),
        *(scene_times if offset else []),
        *(("addPosition", point) for point in segment.positions),
        *(("addTarget", point) for point in segment.targets),
        *_pair("sky", segment.sky),
        *_pair("fov", segment.view),
    ]
    if lens_is_open:
        body += [*_pair("dof", segment.focus), *_pair("lensRadius", segment.lens_radius)]
    if shutter.duration > 0.0:
        body.append(("blurDuration", exact(shutter.duration / fps)))
    return Element("CamSegment", name, body)


def _whole(frame):
    """Removes the rounding error of adding and subtracting a shutter's offset from a time in frames."""
    return round(frame, 9)


def _pair(name, values):
    start, end = values
    moves = np.any(np.abs(np.subtract(end, start)) > 1e-9)
    return [(f"{name}Start", start)] + ([(f"{name}End", end)] if moves else [])


def note_limits(camera, render, report):
    """Notes the properties of `camera` that slo-rt lacks."""
    subject = f'camera "{camera.name}"'
    if render.pixel_aspect_x != render.pixel_aspect_y:
        change = "less" if render.pixel_aspect_x > render.pixel_aspect_y else "more"
        report.note(
            subject,
            f"pixels are square in slo-rt: the picture shows {change} at its sides than Blender's",
        )
    if camera.type != "CAMERA":
        lens = "its cone" if camera.type == "LIGHT" else f"a lens of {BARE_LENS:g} mm"
        report.note(subject, f"no camera, but an object; the picture shows what it sees by {lens}")
        return
    optics = camera.data
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
