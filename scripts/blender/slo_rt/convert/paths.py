# SPDX-License-Identifier: GPL-3.0-or-later
"""Key frames of everything that moves: things, lamps, and spaces of instancers.

Key frames hold world matrices: whatever parents, constraints and drivers do, is sampled and fitted as
a whole. So motion blur is right without parents in the scene, and each element says where it is.
"""

from dataclasses import dataclass

import numpy as np

from ..fit.motion import fit_all
from ..fit.rigid import FLAT, split_affine
from .motion import space_key
from .places import frame_of
from .things import Lamp

# A shape counts as changing if its entries change by more than this fraction of the thing's size.
SHAPE_TOLERANCE = 1e-4
# A scale that changes by a smaller fraction does not change: matrices have single precision.
STEADY = 2e-6


@dataclass(eq=False)
class Mover:
    """What moves: a `Thing`, a `Lamp` or a `Space`, its key, the sources of its motion, how far it extends
    along its axes from its origin (`reach`), and the sides of the box around it (`sides`). `frame` is
    the instancer in whose space its key frames count."""

    item: object
    key: tuple
    sources: list
    reach: np.ndarray
    sides: np.ndarray
    least_size: float = 0.0
    frame: str | None = None

    @property
    def is_rigid(self):
        """Whether it cannot be scaled."""
        return isinstance(self.item, Lamp)


class Paths:
    """The key frames of movers. `reshaped` holds the movers whose shear or mirroring changes. `fit`
    returns the key frames by key; then `misfits` holds pairs of movers and `Misfit`s."""

    def __init__(self, movers, timeline):
        self._movers = movers
        self._timeline = timeline
        self._keys = [mover.key for mover in movers]
        self._frames = [mover.frame for mover in movers]
        self.reshaped = []
        self.misfits = []
        if movers:
            self._survey()

    def _survey(self):
        """Looks at the states that were sampled: which scales and shapes change, and how large all are."""
        reach = np.array([mover.reach for mover in self._movers])
        rigid = np.array([mover.is_rigid for mover in self._movers])
        self._reach = reach
        first = None
        for matrices in self._states():
            placements, rests = split_affine(matrices)
            known = ~_is_degenerate(matrices)
            scale = placements[:, 9:]
            if first is None:
                first, first_rests = placements.copy(), rests
                least, most = scale.copy(), scale.copy()
                has_axes = known.copy()
                miss = np.zeros(len(reach))
            late = known & ~has_axes
            first[late, :9], first_rests[late] = placements[late, :9], rests[late]
            has_axes |= known
            least, most = np.minimum(least, scale), np.maximum(most, scale)
            off = np.abs(rests - first_rests)
            # What is scaled to nothing has no shear.
            now = (scale[:, :, None] * off * reach[:, None, :]).max(axis=(1, 2))
            miss = np.maximum(miss, np.where(known, now, 0.0))
        self._first = first
        self._steady = (most - least <= STEADY * most).all(axis=1)
        self._scale = np.where(rigid[:, None], 1.0, first[:, 9:])
        self._is_rigid = rigid
        sides = np.array([mover.sides for mover in self._movers])
        sizes = np.linalg.norm(sides * most, axis=1)
        self.sizes = np.maximum(sizes, [mover.least_size for mover in self._movers])
        stretched = rigid & ((most - least > SHAPE_TOLERANCE * most).any(axis=1))
        changes = (miss > SHAPE_TOLERANCE * self.sizes) | stretched
        self.reshaped = [mover for mover, one in zip(self._movers, changes) if one]

    def _states(self):
        spaces = [(i, space_key(frame)) for i, frame in enumerate(self._frames) if frame]
        rows = np.array([i for i, _ in spaces], np.int64)
        for state in self._timeline.states([*self._keys, *(key for _, key in spaces)]):
            matrices = state[: len(self._keys)]
            if spaces:
                frames = frame_of(state[len(self._keys) :])
                matrices[rows] = np.linalg.inv(frames) @ matrices[rows]
            yield matrices

    def matrices(self, who, times):
        """Returns the matrices (n, k, 4, 4) of the movers with numbers `who` at times (n, k), in the
        spaces in which they move."""
        matrices = self._timeline.matrices([self._keys[number] for number in who], times)
        framed = [(row, self._frames[n]) for row, n in enumerate(who) if self._frames[n]]
        if framed:
            rows = np.array([row for row, _ in framed])
            keys = [space_key(frame) for _, frame in framed]
            frames = frame_of(self._timeline.matrices(keys, times[rows]))
            matrices[rows] = np.linalg.inv(frames) @ matrices[rows]
        return matrices

    def matrices_of(self, mover, times):
        """Returns the matrices (k, 4, 4) of one mover at times (k,)."""
        return self.matrices([self._movers.index(mover)], times[None])[0]

    def _sample(self, who, times):
        matrices = self.matrices(who, times)
        placements, _ = split_affine(matrices)
        fixed = (self._steady | self._is_rigid)[who]
        placements[fixed, :, 9:] = self._scale[who][fixed][:, None]
        degenerate = _is_degenerate(matrices)
        if degenerate.any():
            _fill(placements, degenerate, self._first[who])
        return placements

    def fit(self, first, last, breaks_of):
        """Returns the key frames from `first` to `last` (frames) by key; `breaks_of(mover)` returns
        `Break`s."""
        if not self._movers:
            return {}
        breaks = [breaks_of(mover) for mover in self._movers]
        visit = self._timeline.visit
        fitted = fit_all(self._sample, first, last, self.sizes, breaks, visit, self._reach)
        self.misfits = [(m, misfit) for m, (_, misfit) in zip(self._movers, fitted) if misfit]
        return {key: path for key, (path, _) in zip(self._keys, fitted)}


def _is_degenerate(matrices):
    """Whether an axis of matrices (..., 4, 4) is scaled to nothing."""
    lengths = np.linalg.norm(matrices[..., :3, :3], axis=-2)
    return ~(lengths.min(axis=-1) > FLAT * lengths.max(axis=-1))


def _fill(placements, degenerate, first):
    """Turns what is scaled to nothing as it is turned at the nearest other time, or else as in `first`
    (n, 12)."""
    for row in np.flatnonzero(degenerate.any(axis=1)):
        missing, known = np.flatnonzero(degenerate[row]), np.flatnonzero(~degenerate[row])
        if len(known):
            nearest = known[np.abs(missing[:, None] - known).argmin(axis=1)]
            placements[row, missing, 3:9] = placements[row, nearest, 3:9]
        else:
            placements[row, missing, 3:9] = first[row, 3:9]
