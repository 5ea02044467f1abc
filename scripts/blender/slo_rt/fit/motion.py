# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits key frames to sampled placements.

Between two key frames of slo-rt, pivot, up, right and scale are cubic Bézier curves in time. A stretch of
motion is fitted by one piece. If the piece misses the samples, it is divided, first at whole frames.
The times of the artist's own key frames are borders of pieces from the start. So a motion that is
cubic between them, such as Bézier curves with automatic handles, is reproduced exactly.

Times are in frames here. Samples are taken at multiples of a power of two of a frame, so that all
moving things are sampled at the same times.
"""

from dataclasses import dataclass

import numpy as np

from . import bezier
from .rigid import SMALLEST, angle_between, axes_of

POSITION_TOLERANCE = 1e-4  # of the thing's size
DIRECTION_TOLERANCE = np.radians(0.05)
# Between samples, the error of a piece is a little larger than at them.
MARGIN = 0.5
# If neighbouring samples are rotated by more than this, there are too few of them.
SAMPLE_TURN = np.radians(20.0)
COARSEST_STEP = 0.25
SHORTEST_PIECE = 1.0 / 64.0
INNER_SAMPLES = 8
# Number of placements that are processed together.
SAMPLES_AT_ONCE = 1 << 17
# Time by which a jump begins early.
LEAP = 1.0 / 256.0


@dataclass
class KeyFrame:
    """One key frame at `time` (frames): `key`, `pre`, `nex` hold pivot, up, right, and scale (12,) or
    not (9,).

    `pre` and `nex` are None if no motion leads in or out, or if it is straight at constant speed.
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
    """Place at which the key frames miss the motion: time (frames), fraction of the size, radians."""

    time: float
    position: float
    direction: float


@dataclass
class _Piece:
    start: float
    end: float
    control: np.ndarray  # (4, 12 or 9), or (2, 12 or 9); tidied
    is_straight: bool


def fit_key_frames(sample, start, end, size, breaks=()):
    """Does `fit_all` for one motion; `sample(times)` returns placements (n, 12 or 9) at times (n,)."""

    def sample_one(_who, times):
        return np.array([sample(row) for row in times])

    return fit_all(sample_one, start, end, [size], [breaks])[0]


def fit_all(sample, start, end, sizes, breaks, prepare=None, reach=None):
    """Returns the key frames of many motions from `start` to `end` (frames).

    `sample(who, times)` returns placements (n, k, 12 or 9) of the motions with numbers `who` (n,) at
    times (n, k). `prepare(times)` is called in advance with the times to be sampled next. `sizes` are
    the diagonals of the things, `breaks` lists of `Break`s. `reach` (n, 3) is how far a thing extends
    along its axes at a scale of 1; half of its size without it. Returns `(key_frames, misfit)` of each motion.
    `misfit` is None if the tolerances hold at all samples, otherwise the place at which the motion is
    too wild, such as a jump that no curve announces.

    Pieces of all motions that have the same pattern of samples are fitted together.
    """
    fitter = _Fitter(sample, sizes, prepare or (lambda times: None), reach)
    stretches, leaps = [], []
    for who, own in enumerate(breaks):
        borders = _borders(start, end, own)
        for (a, _), (b, leap) in zip(borders, borders[1:]):
            (leaps if leap else stretches).append((who, a, b))
    fitter.leap(leaps)
    while stretches:
        stretches = fitter.cover(stretches)
    return [
        (_join(sorted(pieces, key=lambda piece: piece.start)), fitter.misfits.get(who))
        for who, pieces in enumerate(fitter.pieces)
    ]


def sample_times(start, end):
    """Returns the times at which the piece from `start` to `end` is sampled, both included."""
    step = COARSEST_STEP
    while (end - start) / step <= INNER_SAMPLES:
        step /= 2.0
    first, last = int(np.floor(start / step)) + 1, int(np.ceil(end / step)) - 1
    return np.concatenate([[start], np.arange(first, last + 1) * step, [end]])


def middle(start, end):
    """Returns the time at which to divide a piece: a whole frame if there is one inside."""
    center = (start + end) / 2.0
    whole = float(np.round(center))
    return whole if start < whole < end else center


class _Fitter:
    def __init__(self, sample, sizes, prepare, reach):
        self.sample = sample
        self.prepare = prepare
        self.sizes = np.maximum(np.asarray(sizes, np.float64), 1e-12)
        half = np.repeat(self.sizes[:, None] / 2.0, 3, axis=1)
        self.reach = half if reach is None else np.asarray(reach, np.float64)
        self.pieces = [[] for _ in sizes]
        self.misfits = {}

    def cover(self, stretches):
        """Fits stretches `(who, start, end)` by pieces. Appends the pieces that fit, and returns the
        halves of the other stretches."""
        patterns, asked = {}, {}
        for stretch in stretches:
            _, start, end = stretch
            if (start, end) not in asked:
                times = sample_times(start, end)
                u = (times - start) / (end - start)
                asked[start, end] = times, np.round(u, 12).tobytes()
            patterns.setdefault(asked[start, end][1], []).append(stretch)
        self.prepare(np.unique(np.concatenate([times for times, _ in asked.values()])))
        halves = []
        for alike in patterns.values():
            size = max(1, SAMPLES_AT_ONCE // len(asked[alike[0][1:]][0]))
            for at in range(0, len(alike), size):
                some = alike[at : at + size]
                halves += self._cover_alike(some, np.array([asked[s[1:]][0] for s in some]))
        return halves

    def _cover_alike(self, stretches, times):
        """Does `cover` for stretches with the same pattern of samples at `times` (n, k)."""
        who = np.array([stretch[0] for stretch in stretches])
        placements = self.sample(who, times)
        u = (times[0] - times[0, 0]) / (times[0, -1] - times[0, 0])
        control = bezier.fit_many(3, u, placements)
        if control.shape[-1] > 9:
            # Handles of 0 or less are not allowed.
            control[..., 9:] = np.maximum(control[..., 9:], SMALLEST * placements[..., 9:].max())
        tidied = _tidy(control)
        straight = _is_straight(tidied)
        axes = _axes(placements)
        fitted = bezier.basis(3, u) @ control
        gaps = np.linalg.norm(fitted[..., :3] - placements[..., :3], axis=-1)
        growth = (
            np.abs(fitted[..., 9:] - placements[..., 9:])
            * self.reach[who][:, None, : fitted.shape[-1] - 9]
        )
        gaps = np.maximum(gaps, growth.max(axis=-1, initial=0.0))
        position = gaps.max(axis=1) / self.sizes[who]
        direction = angle_between(_axes(fitted), axes).max(axis=1)
        turn = angle_between(axes[:, 1:], axes[:, :-1]).max(axis=1)
        fits = (
            (position <= POSITION_TOLERANCE * MARGIN)
            & (direction <= DIRECTION_TOLERANCE * MARGIN)
            & (turn <= SAMPLE_TURN)
        )
        halves = []
        for i, (number, start, end) in enumerate(stretches):
            if fits[i]:
                self.pieces[number].append(_Piece(start, end, tidied[i], straight[i]))
            elif end - start > SHORTEST_PIECE * 1.5:
                center = middle(start, end)
                halves += [(number, start, center), (number, center, end)]
            else:
                self.pieces[number].append(_Piece(start, end, tidied[i], straight[i]))
                self._remember(number, Misfit(start, float(position[i]), float(direction[i])))
        return halves

    def leap(self, stretches):
        """Moves from one placement to the other in half the time, so that no rounded time can fall
        into the jump."""
        if not stretches:
            return
        ends = np.array([stretch[1:] for stretch in stretches])
        self.prepare(np.unique(ends))
        places = self.sample(np.array([stretch[0] for stretch in stretches]), ends)
        for (number, start, end), (before, after) in zip(stretches, _tidy(places)):
            landed = (start + end) / 2.0
            for a, b, control in ((start, landed, (before, after)), (landed, end, (after, after))):
                self.pieces[number].append(_Piece(a, b, np.array(control), True))

    def _remember(self, who, misfit):
        within = misfit.position <= POSITION_TOLERANCE and misfit.direction <= DIRECTION_TOLERANCE
        known = self.misfits.get(who)
        if not within and (known is None or misfit.position > known.position):
            self.misfits[who] = misfit


def _axes(placements):
    return axes_of(placements[..., 3:6], placements[..., 6:9])


def _borders(start, end, breaks):
    """Returns the borders of pieces as `(time, whether a jump ends there)`, rising from `start` to `end`."""
    borders = {start: False, end: False}
    for point in breaks:
        if not start < point.time <= end:
            continue
        borders[point.time] = borders.get(point.time, False) or point.leap
        if point.leap and point.time - LEAP > start:
            borders.setdefault(point.time - LEAP, False)
    return sorted(borders.items())


def _join(pieces):
    """Returns the key frames of adjoining pieces, without straight handles and repeated keys at rest."""
    keys = [KeyFrame(pieces[0].start, pieces[0].control[0])]
    for piece in pieces:
        control = piece.control
        nex, pre = (None, None) if piece.is_straight else control[1:3]
        keys[-1].nex = nex
        keys.append(KeyFrame(piece.end, control[-1], pre))
    return _without_middle_of_rest(keys)


def _tidy(control):
    """Rounds control points (n, m, 12 or 9) to the digits of single precision, separately for pivot, up,
    right and scale."""
    parts = range(0, control.shape[-1], 3)
    return np.concatenate([bezier.tidy_many(control[..., i : i + 3]) for i in parts], axis=-1)


def _is_straight(control):
    """Returns which curves with control points (n, 4, 12 or 9) are straight with constant speed."""
    line = control[:, :1] + (control[:, 3:] - control[:, :1]) * np.array([[1.0 / 3.0], [2.0 / 3.0]])
    return np.abs(control[:, 1:3] - line).max(axis=(1, 2)) <= 1e-9


def _without_middle_of_rest(keys):
    """Removes keys at which the thing is at rest before and after."""

    def rests(a, b):
        return a.nex is None and b.pre is None and np.array_equal(a.key, b.key)

    return [
        key
        for i, key in enumerate(keys)
        if not (0 < i < len(keys) - 1 and rests(keys[i - 1], key) and rests(key, keys[i + 1]))
    ]
