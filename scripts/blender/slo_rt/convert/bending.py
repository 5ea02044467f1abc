# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that change their shape: armatures, shape keys, cloth, whatever moves vertices.

A mesh is read at times between the first and the last moment that a job shows, in order. Between
whole frames, as few shapes as possible are kept: a stretch is divided in two until the straight way
of all vertices from shape to shape is near enough to that in Blender.
"""

from dataclasses import dataclass

import numpy as np

from . import mesh as meshes
from .checks import finite

# Largest distance of a vertex from its way in Blender, in units of the thing's size: a quarter of a
# pixel if it fills a thousand.
TOLERANCE = 2.5e-4
# A vertex that moves by less, in the same units, is at rest.
REST = 1e-6
# Most pieces of a stretch: the times at which meshes are read.
PIECES = 4


def watched(times, is_blurred):
    """Returns those of `times` (frames, rising) at which meshes are read, and which of them are borders
    of stretches: the first, the last, and whole frames. Without blur, only borders count."""
    times = np.asarray(times, np.float64)
    is_border = times == np.round(times)
    is_border[[0, -1]] = True
    borders = np.flatnonzero(is_border)
    if not is_blurred:
        return times[borders], np.ones(len(borders), bool)
    chosen = [borders[-1:]]
    for a, b in zip(borders, borders[1:]):
        pieces = min(PIECES, b - a)
        chosen.append(a + np.arange(pieces) * (b - a) // pieces)
    chosen = np.sort(np.concatenate(chosen))
    return times[chosen], is_border[chosen]


@dataclass(eq=False)
class _Sample:
    """A shape: `positions` of the mesh, with `rest`; the parts of `shape` as `Skin.take` wants them; the
    paths of its files once they are written."""

    positions: np.ndarray
    shape: tuple
    files: list | None = None


class Bending:
    """A mesh that may change its shape. `skins` holds names and `Skin`s of its parts. Shapes go to
    `store(sequence, name, arrays) -> filename`, with the same `sequence` for all shapes of a part.

    After the last `look`, `is_broken` tells whether the faces changed, and `finish` gives files to its parts.
    """

    def __init__(self, name, topology, skins):
        self.name = name
        self.is_broken = False
        self._topology = topology
        self._skins = skins
        self._still = []
        self._size = 0.0
        self._stretch = []  # (time, sample) since the last border
        self._kept = []  # (time, sample) of the shapes that are kept
        self._last = None

    def begin(self, still, box):
        """Sets the `(name, material, arrays)` to write if the mesh does not change its shape, and the box
        around it."""
        self._still = still
        self._size = max(float(np.linalg.norm(box[1] - box[0])), 1e-12)

    def look(self, time, is_border, mesh, rest, store):
        """Reads the shape at the next time; `mesh` is None if it is the same as before."""
        if self.is_broken:
            return
        if mesh is not None:
            if meshes.topology(mesh) != self._topology:
                self.is_broken = True
                self._stretch, self._kept, self._last = [], [], None
                return
            self.take(time, is_border, meshes.read_shape(mesh), rest, store)
        elif self._last is not None:
            self._add(time, is_border, self._last, store)

    def take(self, time, is_border, shape, rest, store):
        """Does `look` with what `read_shape` returns."""
        positions = shape[0] if rest is None else (shape[0] @ rest.T).astype(np.float32)
        finite(positions, f'object "{self.name}"', f"a vertex at frame {time:g}")
        before = self._last
        if before is None or _distance(positions, before.positions) > REST * self._size:
            self._last = _Sample(positions, (*shape, rest))
        self._add(time, is_border, self._last, store)

    def _add(self, time, is_border, sample, store):
        self._stretch.append((time, sample))
        if is_border:
            for at, kept in self._divide(self._stretch):
                self._keep(at, kept, store)
            for _, passed in self._stretch:
                if passed is not sample:
                    passed.positions = None
            self._stretch = [(time, sample)]

    def _divide(self, stretch):
        """Returns the shapes of a stretch that are kept, without the first one."""
        (start, first), (end, last) = stretch[0], stretch[-1]
        for time, sample in stretch[1:-1]:
            u = (time - start) / (end - start)
            way = first.positions + np.float32(u) * (last.positions - first.positions)
            if _distance(way, sample.positions) > TOLERANCE * self._size:
                middle = len(stretch) // 2
                return self._divide(stretch[: middle + 1]) + self._divide(stretch[middle:])
        return stretch[-1:]

    def _keep(self, time, sample, store):
        kept = self._kept
        if kept and sample is not kept[0][1]:
            for each in (kept[0][1], sample):
                self._write(each, store)
        if len(kept) > 1 and kept[-1][1] is sample and kept[-2][1] is sample:
            kept.pop()  # it rests
        kept.append((time, sample))

    def _write(self, sample, store):
        if sample.files is None:
            shapes = [(name, skin.shape(*sample.shape)) for name, skin in self._skins]
            sample.files = [
                store((id(self), i), name, arrays) for i, (name, arrays) in enumerate(shapes)
            ]
            sample.shape = None

    @property
    def bends(self):
        """Whether it has several shapes."""
        return any(sample is not self._kept[0][1] for _, sample in self._kept)

    def finish(self, parts, store):
        """Gives `parts` their shapes, or files of the still mesh, which go to `store(name, arrays)`."""
        if not self.bends:
            for part, (name, _, arrays) in zip(parts, self._still):
                part.filename = store(name, arrays)
            return
        for i, part in enumerate(parts):
            part.shapes = [(time, sample.files[i]) for time, sample in self._kept]


def _distance(a, b):
    """Returns the largest distance along an axis."""
    return float(np.abs(a - b).max(initial=0.0))
