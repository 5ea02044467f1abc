# SPDX-License-Identifier: GPL-3.0-or-later
"""Key frames through sampled placements.

Between two key frames of slo-rt, pivot, up and right are cubic Bézier curves in time. A stretch of
motion is fitted by one piece; where the piece misses the samples, it is divided, first at whole
frames. The times of the artist's own key frames are borders of pieces from the start, so that a
motion which is cubic between them, as that of Bézier curves with automatic handles is, comes back
as it was.

Times are in frames here; samples are taken at multiples of a power of two of a frame, so that all
things that move ask for the same times.
"""

from dataclasses import dataclass

import numpy as np

from . import bezier
from .rigid import angle_between, axes_of

POSITION_TOLERANCE = 1e-4  # of the thing's size
DIRECTION_TOLERANCE = np.radians(0.05)
# Between samples a piece misses by a little more than at them.
MARGIN = 0.5
# Turns between neighbouring samples beyond this say that there are too few of them.
SAMPLE_TURN = np.radians(20.0)
COARSEST_STEP = 0.25
SHORTEST_PIECE = 1.0 / 64.0
INNER_SAMPLES = 8
# How long before its time a leap begins.
LEAP = 1.0 / 256.0


@dataclass
class KeyFrame:
    """One key frame at `time` (frames): `key`, `pre`, `nex` hold pivot, up, right (9,).

    `pre` and `nex` are None where nothing leads in or out, or in a straight line at even speed.
    """

    time: float
    key: np.ndarray
    pre: np.ndarray | None = None
    nex: np.ndarray | None = None


@dataclass
class Break:
    """A time (frames) at which a new curve of the artist begins; `leap` if values jump there."""

    time: float
    leap: bool = False


@dataclass
class Misfit:
    """Where the key frames miss the motion: time (frames), fraction of the size, radians."""

    time: float
    position: float
    direction: float


@dataclass
class _Piece:
    start: float
    end: float
    control: np.ndarray  # (4, 9), or (2, 9) if straight


def fit_key_frames(sample, start, end, size, breaks=()):
    """Key frames of a motion from `start` to `end` (frames).

    `sample(times)` gives placements (n, 9) at times (n,). `size` is the diagonal of the thing.
    Returns `(key_frames, misfit)`; `misfit` is None if the tolerances hold at all samples,
    otherwise the place where the motion is too wild, such as a leap that no curve announces.
    """
    fitter = _Fitter(sample, size)
    borders = _borders(start, end, breaks)
    for (a, _), (b, leap) in zip(borders, borders[1:]):
        fitter.cover(a, b, leap)
    return _join(fitter.pieces), fitter.misfit


def sample_times(start, end):
    """Times at which the piece from `start` to `end` is looked at, both included."""
    step = COARSEST_STEP
    while (end - start) / step <= INNER_SAMPLES:
        step /= 2.0
    first, last = int(np.floor(start / step)) + 1, int(np.ceil(end / step)) - 1
    return np.concatenate([[start], np.arange(first, last + 1) * step, [end]])


def middle(start, end):
    """Where to divide a piece: at a whole frame if there is one inside."""
    center = (start + end) / 2.0
    whole = float(np.round(center))
    return whole if start < whole < end else center


class _Fitter:
    def __init__(self, sample, size):
        self.sample = sample
        self.size = max(size, 1e-12)
        self.pieces = []
        self.misfit = None

    def cover(self, start, end, leap):
        """Appends pieces from `start` to `end`."""
        ends = np.array([start, end])
        if leap:
            self._leap(start, end, *self.sample(ends))
            return
        times = sample_times(start, end)
        placements = self.sample(times)
        piece = _Piece(start, end, _fit_piece(times, placements))
        position, direction = self._miss(piece, times, placements)
        fits = position <= POSITION_TOLERANCE * MARGIN and direction <= DIRECTION_TOLERANCE * MARGIN
        if fits and _turn(placements) <= SAMPLE_TURN:
            self.pieces.append(piece)
        elif end - start > SHORTEST_PIECE * 1.5:
            center = middle(start, end)
            self.cover(start, center, False)
            self.cover(center, end, False)
        else:
            self.pieces.append(piece)
            self._remember(Misfit(start, position, direction))

    def _leap(self, start, end, before, after):
        """From one place to the other in half the time, so that rounded times can't fall into
        it."""
        landed = (start + end) / 2.0
        for a, b, values in ((start, landed, (before, after)), (landed, end, (after, after))):
            self.pieces.append(_Piece(a, b, bezier.fit(1, np.array([a, b]), np.array(values))))

    def _miss(self, piece, times, placements):
        u = (times - piece.start) / (piece.end - piece.start)
        fitted = bezier.evaluate(piece.control, u)
        offset = np.linalg.norm(fitted[:, :3] - placements[:, :3], axis=1).max() / self.size
        return offset, angle_between(_axes(fitted), _axes(placements)).max()

    def _remember(self, misfit):
        within = misfit.position <= POSITION_TOLERANCE and misfit.direction <= DIRECTION_TOLERANCE
        if not within and (self.misfit is None or misfit.position > self.misfit.position):
            self.misfit = misfit


def _fit_piece(times, placements):
    u = (times - times[0]) / (times[-1] - times[0])
    return bezier.fit(3, u, placements)


def _axes(placements):
    return axes_of(placements[:, 3:6], placements[:, 6:9])


def _turn(placements):
    axes = _axes(placements)
    return angle_between(axes[1:], axes[:-1]).max()


def _borders(start, end, breaks):
    """Borders of pieces as `(time, whether a leap ends there)`, rising from `start` to `end`."""
    borders = {start: False, end: False}
    for point in breaks:
        if not start < point.time <= end:
            continue
        borders[point.time] = borders.get(point.time, False) or point.leap
        if point.leap and point.time - LEAP > start:
            borders.setdefault(point.time - LEAP, False)
    return sorted(borders.items())


def _join(pieces):
    """Key frames of adjoining pieces; straight handles are left out, and rest is told once."""
    keys = [KeyFrame(pieces[0].start, _tidy(pieces[0].control)[0])]
    for piece in pieces:
        control = _tidy(piece.control)
        nex, pre = (None, None) if _is_straight(control) else control[1:3]
        keys[-1].nex = nex
        keys.append(KeyFrame(piece.end, control[-1], pre))
    return _without_middle_of_rest(keys)


def _tidy(control):
    return np.hstack([bezier.tidy(control[:, i : i + 3]) for i in (0, 3, 6)])


def _is_straight(control):
    if len(control) == 2:
        return True
    ends = control[[0, 3]]
    line = ends[0] + (ends[1] - ends[0]) * np.array([[1.0 / 3.0], [2.0 / 3.0]])
    return np.allclose(control[1:3], line, rtol=0.0, atol=1e-9)


def _without_middle_of_rest(keys):
    """Leaves out keys at which the thing rests before and after."""

    def rests(a, b):
        return a.nex is None and b.pre is None and np.array_equal(a.key, b.key)

    return [
        key
        for i, key in enumerate(keys)
        if not (0 < i < len(keys) - 1 and rests(keys[i - 1], key) and rests(key, keys[i + 1]))
    ]
