# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the instances of a dependency graph are at one moment, in columns."""

import numpy as np

from ..fit.rigid import is_sheared, matrix_of, split_affine
from .checks import LARGEST, finite


class Places:
    """Where the instances of a dependency graph are, in columns: `matrices` (n, 4, 4), `placements` (n,
    12), `shown` and `has_particles` (n,). `rests` (n, 3, 3) must be done to their vertices. If `frames` has the full
    name of an instancer for a row, this is so in the instancer's space, without the shear that the
    instance has in world space; `local` has its placement there. `codes` tell different `rests` apart."""

    def __init__(self, depsgraph):
        instances = depsgraph.object_instances
        count = len(instances)
        flat, self.shown = np.empty(16 * count, np.float32), np.empty(count, bool)
        instances.foreach_get("matrix_world", flat)
        instances.foreach_get("show_self", self.shown)
        self.has_particles = np.empty(count, bool)
        instances.foreach_get("show_particles", self.has_particles)
        self.shown, self.has_particles = self.shown.tolist(), self.has_particles.tolist()
        self.matrices = flat.reshape(count, 4, 4).transpose(0, 2, 1).astype(np.float64)
        self._finite = (np.abs(self.matrices) <= LARGEST).all(axis=(1, 2))
        self.frames = {}
        self.local = {}
        with np.errstate(all="ignore"):
            self.placements, self.rests = split_affine(self.matrices)
            sheared = is_sheared(self.matrices) & self.shown
            if sheared.any():
                self._straighten(instances, sheared)
        is_plain = (self.rests == np.eye(3)).all(axis=(1, 2))
        self.codes = [b"" if p else r.tobytes() for p, r in zip(is_plain.tolist(), self.rests)]

    def check(self, row, thing):
        """Checks the matrix of an instance of an object.

        # Errors `ValueError` if it is not finite.
        """
        if not self._finite[row]:
            subject = "light" if thing.type == "LIGHT" else "object"
            finite(self.matrices[row], f'{subject} "{thing.name}"')

    def _straighten(self, instances, sheared):
        rows_of, spaces = {}, {}
        for row, instance in enumerate(instances):
            if sheared[row] and instance.is_instance:
                name = instance.parent.original.name_full
                rows_of.setdefault(name, []).append(row)
                spaces[name] = instance.parent.matrix_world
        for name, rows in rows_of.items():
            space = frame_of(np.array(spaces[name], np.float64))
            local = np.linalg.inv(space) @ self.matrices[rows]
            is_straight = ~is_sheared(local)
            straight = np.array(rows)[is_straight]
            placements, self.rests[straight] = split_affine(local[is_straight])
            self.frames.update(dict.fromkeys(straight.tolist(), name))
            self.local.update(zip(straight.tolist(), placements))


def frame_of(matrix):
    """Returns the spaces (..., 4, 4) in which instances of instancers with these matrices hang: without
    shear and mirroring."""
    return matrix_of(split_affine(matrix)[0])
