# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits camera segments to sampled cameras.

In a camera segment of slo-rt, position and target follow Bézier curves of any degree; the sky
vector, the size of the view, the focus distance and the lens radius are linear. Segments begin and
end at whole frames of the video, and there may be gaps between them. Times are in frames.
"""

from dataclasses import dataclass

import numpy as np

from . import bezier
from .motion import DIRECTION_TOLERANCE, MARGIN, POSITION_TOLERANCE
from .rigid import angle_between

DEGREES = (0, 1, 2, 3, 4, 5)
DEGREES_WITHIN_A_FRAME = (0, 1, 2, 3, 4, 5, 6, 7)
# Relative errors: 3e-4 of the size of the view is a sixth of a pixel at the edge of a thousand.
VIEW_TOLERANCE = 3e-4
FOCUS_TOLERANCE = 1e-3
# Duration in frames of a segment of one still frame, since a segment must not be empty.
SHORTEST_SEGMENT = 0.5
SAMPLES_OF_A_SHUTTER = 17
Z = np.array([0.0, 0.0, 1.0])


@dataclass
class CameraSamples:
    """The camera at `times` (n,): vectors (n, 3), directions unit, in world space; scalars (n,).

    `view` is half the height of the view at distance 1, `focus` is the distance of the plane in
    focus, and `lens_radius` is 0 for a pinhole.
    """

    times: np.ndarray
    position: np.ndarray
    forward: np.ndarray
    up: np.ndarray
    view: np.ndarray
    focus: np.ndarray
    lens_radius: np.ndarray


@dataclass
class Segment:
    """A camera segment from `start` to `end` (frames): control points, and pairs of first and
    last."""

    start: float
    end: float
    positions: np.ndarray
    targets: np.ndarray
    sky: tuple
    view: tuple
    focus: tuple
    lens_radius: tuple


def fit_segments(sample, first, stop, shutter, size, is_last=True):
    """Returns camera segments for the frames from `first` to before `stop`.

    `sample(times)` returns `CameraSamples`. `shutter` has `offset` and `duration` in frames. `size`
    is the length that errors of positions are relative to. The camera does not matter while no
    shutter is open. `is_last`: no segment follows at `stop`. Returns `(segments, misfit)`: times in
    frames of the scene, and `(frame, length, radians)` of the worst frame that exceeds the
    tolerances, or None.
    """
    is_leaf = stop - first == 1
    times = visible_times(first, stop, shutter, is_last)
    segment, miss = _best(sample(times), size, DEGREES_WITHIN_A_FRAME if is_leaf else DEGREES)
    if miss[0] <= 1.0 or is_leaf:
        return [segment], (first, *miss[1:]) if miss[0] > 1.0 / MARGIN else None
    center = (first + stop) // 2
    left, left_misfit = fit_segments(sample, first, center, shutter, size, False)
    right, right_misfit = fit_segments(sample, center, stop, shutter, size, is_last)
    misfits = [misfit for misfit in (left_misfit, right_misfit) if misfit]
    return left + right, max(misfits, key=lambda misfit: misfit[1], default=None)


def visible_times(first, stop, shutter, is_last):
    """Returns the times (frames of the scene) at which a segment for the frames `first` to before
    `stop` is sampled.

    These are times while a shutter is open, and the end, at which the next segment begins. A segment
    that no other follows, or of one frame, ends with its last shutter.
    """
    steps = np.linspace(
        0.0, shutter.duration, SAMPLES_OF_A_SHUTTER if shutter.duration > 0.0 else 1
    )
    times = [frame + shutter.offset + steps for frame in range(first, stop)]
    if stop - first > 1 and not is_last:
        times.append([stop + shutter.offset])
    elif shutter.duration <= 0.0:
        times.append([stop - 1 + shutter.offset + SHORTEST_SEGMENT])
    return np.unique(np.concatenate(times))


def _best(samples, size, degrees):
    """Returns the segment of the lowest degree that fits, or else the nearest one, and its error:
    `(in units of the tolerances, length, radians)`."""
    best = None
    for degree in degrees:
        segment = _fit(samples, degree)
        miss = _miss(segment, samples, size)
        if best is None or miss[0] < best[1][0]:
            best = segment, miss
        if miss[0] <= 1.0:
            break
    return best


def _fit(samples, degree):
    times = samples.times
    u = (times - times[0]) / (times[-1] - times[0])
    distance = samples.focus.mean()
    gaze = common_target(samples.position, samples.forward)
    if gaze is None:
        targets = _curve(degree, u, samples.position + samples.forward * distance)
    else:
        targets = bezier.tidy(np.vstack([gaze, samples.position]))[:1]
    return Segment(
        start=times[0],
        end=times[-1],
        positions=_curve(degree, u, samples.position),
        targets=targets,
        sky=_sky(samples),
        view=_ends(samples.view),
        focus=_ends(samples.focus),
        lens_radius=_ends(samples.lens_radius),
    )


def _curve(degree, u, points):
    rests = np.ptp(points, axis=0).max() <= 1e-7 * np.abs(points).max()
    curve = points[:1] if degree == 0 or rests else bezier.fit(degree, u, points)
    return bezier.tidy(curve)


def _ends(values):
    return float(values[0]), float(values[-1])


def _sky(samples):
    """Returns the sky vectors of start and end: z if the camera is never rolled, or else its own up
    vector."""
    sideways = np.abs(np.cross(samples.forward, samples.up)[:, 2])
    upright = (sideways < 1e-5) & (samples.up[:, 2] > 0.05)
    return (Z, Z) if upright.all() else (samples.up[0], samples.up[-1])


def common_target(position, forward):
    """Returns the point that a moving camera looks at all the time, or None.

    It is the point nearest to all lines of view, if it lies ahead of all cameras and on their lines
    within a twentieth of the tolerance.
    """
    spread = np.linalg.norm(np.ptp(position, axis=0))
    if spread <= 1e-9:
        return None
    across = np.eye(3) - forward[:, :, None] * forward[:, None, :]
    matrix = across.sum(axis=0)
    if np.linalg.cond(matrix) > 1e8:
        return None
    point = np.linalg.solve(matrix, (across @ position[:, :, None]).sum(axis=0)[:, 0])
    gaze = point - position
    distance = np.linalg.norm(gaze, axis=1)
    ahead = np.sum(gaze * forward, axis=1)
    off = np.linalg.norm(gaze - ahead[:, None] * forward, axis=1)
    allowed = 0.2 * DIRECTION_TOLERANCE * distance
    return point if (ahead > 0.0).all() and (off <= allowed).all() else None


def axes(position, target, sky):
    """Returns the axes (columns right, up, forward) of cameras, shape (n, 3, 3), as in slo-rt."""
    forward = target - position
    forward = forward / np.linalg.norm(forward, axis=-1, keepdims=True)
    right = np.cross(forward, sky)
    right = right / np.maximum(np.linalg.norm(right, axis=-1, keepdims=True), 1e-300)
    return np.stack([right, np.cross(right, forward), forward], axis=-1)


def _miss(segment, samples, size):
    times = samples.times
    u = (times - times[0]) / (times[-1] - times[0])
    position = bezier.evaluate(segment.positions, u)
    target = bezier.evaluate(segment.targets, u)
    sky = bezier.evaluate(np.array(segment.sky), u)
    true_axes = np.stack(
        [np.cross(samples.forward, samples.up), samples.up, samples.forward], axis=-1
    )
    offset = np.linalg.norm(position - samples.position, axis=1).max() / size
    turn = angle_between(axes(position, target, sky), true_axes).max()
    in_units = [
        offset / (POSITION_TOLERANCE * MARGIN),
        turn / (DIRECTION_TOLERANCE * MARGIN),
        _relative_miss(segment.view, u, samples.view) / VIEW_TOLERANCE,
    ]
    if samples.lens_radius.any():
        in_units += [
            _relative_miss(segment.focus, u, samples.focus) / FOCUS_TOLERANCE,
            _relative_miss(segment.lens_radius, u, samples.lens_radius) / FOCUS_TOLERANCE,
        ]
    return max(in_units), offset * size, turn


def _relative_miss(ends, u, values):
    linear = ends[0] + (ends[1] - ends[0]) * u
    return np.abs(linear - values).max() / max(np.abs(values).max(), 1e-300)
