# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions of things at any time, read from Blender's evaluated scene."""

import numpy as np

from .. import compat
from ..fit.motion import Break
from .checks import LARGEST, finite


def instance_key(instance):
    """Returns a key that identifies an instance of the dependency graph at all times."""
    name = instance.object.original.name_full
    if not instance.is_instance:
        return (name, "", ())
    return (name, instance.parent.original.name_full, tuple(instance.persistent_id))


class Timeline:
    """Samples the whole scene, at each time once.

    `set_frame(frame)` moves the dependency graph to a time in frames, fractions included. Matrices
    are read in columns. Things are numbered from 0 in the order in which they were first seen. It
    stores the first matrix of each thing, and for each time the matrices that differ from it.
    """

    def __init__(self, depsgraph, set_frame, cameras, read_camera):
        self._depsgraph = depsgraph
        self._set_frame = set_frame
        self._cameras = cameras
        self._read_camera = read_camera
        self._numbers = {}  # key -> number of a thing
        self._first = np.empty((0, 4, 4), np.float32)
        self._counts = np.empty(0, np.int64)  # number of times at which each thing was seen
        self._has_moved = np.empty(0, bool)
        self._changes = {}  # time -> (numbers, matrices)
        self._known_order = None  # the last instances: their signature and numbers
        self._camera_values = {}

    @property
    def samples(self):
        """Number of times that were sampled."""
        return len(self._changes)

    def visit(self, times):
        """Samples those of `times` (frames) that were not sampled yet."""
        for time in times:
            if time not in self._changes:
                self._set_frame(float(time))
                self._changes[time] = self._look()
                self._look_at_cameras(float(time))

    def _look(self):
        """Returns the numbers and matrices of things that have left their first position."""
        instances = self._depsgraph.object_instances
        count = len(instances)
        shown, ids = np.empty(count, bool), np.empty(count, np.int32)
        flat = np.empty(16 * count, np.float32)
        instances.foreach_get("show_self", shown)
        instances.foreach_get("random_id", ids)
        instances.foreach_get("matrix_world", flat)
        matrices = flat.reshape(count, 4, 4).transpose(0, 2, 1)[shown]
        numbers = self._numbers_of(instances, (shown.tobytes(), ids.tobytes()))
        new = numbers >= len(self._first)
        if new.any():
            self._first = np.concatenate([self._first, matrices[new]])
            self._counts = np.concatenate([self._counts, np.zeros(new.sum(), np.int64)])
            self._has_moved = np.concatenate([self._has_moved, np.zeros(new.sum(), bool)])
        self._counts[numbers] += 1
        elsewhere = (matrices != self._first[numbers]).any(axis=(1, 2))
        self._has_moved[numbers[elsewhere]] = True
        return numbers[elsewhere], matrices[elsewhere]

    def _numbers_of(self, instances, signature):
        """Returns the numbers of the visible instances, in order. Their names are read only if the
        instances differ from last time."""
        if self._known_order is None or self._known_order[0] != signature:
            keys = [instance_key(instance) for instance in instances if instance.show_self]
            numbers = [self._numbers.setdefault(key, len(self._numbers)) for key in keys]
            self._known_order = signature, np.array(numbers, np.int64)
        return self._known_order[1]

    def _look_at_cameras(self, time):
        for camera in self._cameras:
            values = self._read_camera(camera, self._depsgraph)
            finite(values, f'camera "{camera.name}"', f"its place or its lens at frame {time:g}")
            self._camera_values[camera.name_full, time] = values

    def moves(self, key):
        """Whether the thing was ever seen away from its first position."""
        number = self._numbers.get(key)
        return number is not None and bool(self._has_moved[number])

    def not_always_there(self):
        """Returns the keys of things that were visible only at some times."""
        return [k for k, number in self._numbers.items() if self._counts[number] < self.samples]

    def matrices(self, keys, times):
        """Returns the matrices to world space (n, k, 4, 4) of things at times (n, k).

        # Errors `ValueError` if one is not finite.
        """
        self.visit(np.unique(times))
        numbers = np.array([self._numbers[key] for key in keys])
        found = np.repeat(self._first[numbers][:, None], times.shape[1], axis=1).astype(np.float64)
        order = np.argsort(times, axis=None, kind="stable")
        flat_times = times.ravel()[order]
        starts = np.flatnonzero(np.diff(flat_times, prepend=np.nan))
        place = np.full(len(self._first), -1, np.int64)
        for chosen in np.split(order, starts[1:]):
            changed, matrices = self._changes[float(times.flat[chosen[0]])]
            place[changed] = np.arange(len(changed))
            rows = place[numbers[chosen // times.shape[1]]]
            known = rows >= 0
            found.reshape(-1, 4, 4)[chosen[known]] = matrices[rows[known]]
            place[changed] = -1
        if not (np.abs(found) <= LARGEST).all():
            for key, own in zip(keys, found):
                when = f"between frames {times.min():g} and {times.max():g}"
                finite(own, f'object "{key[0]}"', f"its place {when}")
        return found

    def camera_values(self, camera, times):
        """Returns the results of `read_camera` for a camera at times (n,), one row each."""
        self.visit(times)
        return np.array([self._camera_values[camera.name_full, time] for time in times], np.float64)


def breaks(thing, first, last, remapped=1.0):
    """Times of the key frames from `first` to `last` that `thing` (an object) may depend on; a key
    frame shows `remapped` times as late as it stands."""
    leaps = {}
    for owner in _sources(thing):
        for curve in compat.fcurves(owner.animation_data):
            constant = False
            for point in curve.keyframe_points:
                time = float(point.co[0]) * remapped
                leaps[time] = leaps.get(time, False) or constant
                constant = point.interpolation == "CONSTANT"
    return [Break(time, leap) for time, leap in sorted(leaps.items()) if first <= time <= last]


def _sources(thing):
    """Returns the object and all that it follows: parents, targets of constraints and drivers, data."""
    found, open_ = [], [thing]
    while open_:
        owner = open_.pop()
        if owner is None or owner in found:
            continue
        found.append(owner)
        open_ += [getattr(owner, "parent", None), getattr(owner, "data", None)]
        open_ += [getattr(c, "target", None) for c in getattr(owner, "constraints", ())]
        for driver in owner.animation_data.drivers if owner.animation_data else ():
            targets = [t for variable in driver.driver.variables for t in variable.targets]
            open_ += [target.id for target in targets]
    return [owner for owner in found if getattr(owner, "animation_data", None)]
