# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions of things at any time, read from Blender's evaluated scene."""

import bpy
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


def space_key(instancer):
    """Returns the key of the space of an instancer with this full name."""
    return (instancer, "space", ())


def changed_shapes(depsgraph):
    """Returns the full names of the objects whose geometry Blender has evaluated anew."""
    return {
        update.id.original.name_full
        for update in depsgraph.updates
        if update.is_updated_geometry and isinstance(update.id, bpy.types.Object)
    }


def _changes(depsgraph):
    """Returns the original objects, by full name, that Blender has evaluated anew; whether it lists
    other changes too, such as of visibility; and whether geometry changed, from which instances may
    come."""
    found, has_others, has_geometry = {}, False, False
    for update in depsgraph.updates:
        if isinstance(update.id, bpy.types.Object):
            original = update.id.original
            found[original.name_full] = original
            has_geometry |= update.is_updated_geometry
            has_others |= not (update.is_updated_geometry or update.is_updated_transform)
        elif isinstance(update.id, bpy.types.Collection):
            has_others = True
    return found, has_others, has_geometry


class Timeline:
    """Samples the whole scene, at each time once.

    `set_frame(frame)` moves the dependency graph to a time in frames, fractions included. Matrices
    are read in columns. Things are numbered from 0 in the order in which they were first seen. It
    stores the first matrix of each thing, and for each time the matrices that differ from it. The job
    begins at the time `begin`, with visible instances of these `keys`. `instancers` are objects whose
    matrices are read too, whether they are visible or not.
    """

    def __init__(self, depsgraph, set_frame, begin, cameras, read_camera, keys, instancers=()):
        self.begin = begin
        self._depsgraph = depsgraph
        self._set_frame = set_frame
        self._cameras = cameras
        self._instancers = list(instancers)
        self._read_camera = read_camera
        self._keys_then = keys
        self._numbers = {}  # key -> number of a thing
        self._linked = set()  # full names of instancers and of what they show
        self._first = np.empty((0, 4, 4), np.float32)
        self._now = np.empty((0, 4, 4), np.float32)
        self._counts = np.empty(0, np.int64)  # number of times at which each thing was seen
        self._has_moved = np.empty(0, bool)
        self._changes = {}  # time -> (numbers, matrices)
        self._known_order = None  # the last instances: their identities and numbers
        self._shown = np.empty(0, bool)
        self._hidden = {}  # whether objects were hidden when they were last evaluated
        self._camera_values = {}

    @property
    def samples(self):
        """Number of times that were sampled."""
        return len(self._changes)

    def visit(self, times, looks=None):
        """Samples those of `times` (frames) that were not sampled yet. `looks` holds functions by time,
        which are called at their times."""
        for time in times:
            look = looks.get(float(time)) if looks else None
            if time in self._changes and look is None:
                continue
            numbers = self.go(time)
            if time not in self._changes:
                self._changes[time] = self._remember(numbers)
                self._look_at_cameras(float(time))
            if look:
                look()

    def go(self, time):
        """Moves to a time and reads where everything is. Returns the numbers of what is visible."""
        self._set_frame(float(time))
        changed, has_others, has_geometry = _changes(self._depsgraph)
        has_others |= self._hides(changed)
        if self._known_order and not has_others and self._linked.isdisjoint(changed):
            count = len(self._shown)
            if not has_geometry or len(self._depsgraph.object_instances) == count:
                return self._look_at(changed.values())
        return self._look_at_all(not has_others)

    def _hides(self, changed):
        """Whether an object has vanished or appeared since it was evaluated for the last time."""
        hides = False
        for name, original in changed.items():
            is_hidden = original.evaluated_get(self._depsgraph).hide_render
            hides |= self._hidden.get(name) != is_hidden
            self._hidden[name] = is_hidden
        return hides

    def _remember(self, numbers):
        """Returns the numbers and matrices of those visible things that have left their first position."""
        self._counts[numbers] += 1
        elsewhere = numbers[(self._now[numbers] != self._first[numbers]).any(axis=(1, 2))]
        self._has_moved[elsewhere] = True
        return elsewhere, self._now[elsewhere]

    def instances(self, keys):
        """Yields `(key, instance)` of the visible instances with these keys, in the last state that was
        sampled."""
        wanted = {self._numbers[key]: key for key in keys if key in self._numbers}
        if not wanted:
            return
        order = iter(self._known_order[1].tolist())
        for instance in self._depsgraph.object_instances:
            key = wanted.get(next(order)) if instance.show_self else None
            if key is not None and instance.object.original.name_full == key[0]:
                yield key, instance

    def _look_at(self, objects):
        """Reads the matrices of objects that are no instances. Returns the numbers of what is visible."""
        for each in objects:
            number = self._numbers.get((each.name_full, "", ()))
            if number is not None:
                self._now[number] = each.evaluated_get(self._depsgraph).matrix_world
        return self._known_order[2]

    def _look_at_all(self, is_same_shown):
        """Reads all matrices. Returns the numbers of what is visible. `is_same_shown`: whether it depends
        on the instances alone. Each column takes as long as a walk over all instances."""
        instances = self._depsgraph.object_instances
        count = len(instances)
        flat, ids = np.empty(16 * count, np.float32), np.empty(count, np.int32)
        instances.foreach_get("matrix_world", flat)
        instances.foreach_get("random_id", ids)
        if self._known_order is None or not is_same_shown or self._known_order[0] != ids.tobytes():
            self._shown = np.empty(count, bool)
            instances.foreach_get("show_self", self._shown)
            self._read_order(instances, ids.tobytes())
        numbers = self._known_order[2]
        matrices = flat.reshape(count, 4, 4).transpose(0, 2, 1)[self._shown]
        if self._instancers:
            own = [each.evaluated_get(self._depsgraph).matrix_world for each in self._instancers]
            matrices = np.concatenate([matrices, np.array(own, np.float32)])
        more = len(self._numbers) - len(self._first)
        if more:
            self._now = np.concatenate([self._now, np.zeros((more, 4, 4), np.float32)])
        self._now[numbers] = matrices
        if more:
            self._first = np.concatenate([self._first, self._now[-more:]])
            self._counts = np.concatenate([self._counts, np.zeros(more, np.int64)])
            self._has_moved = np.concatenate([self._has_moved, np.zeros(more, bool)])
        return numbers

    def _read_order(self, instances, signature):
        """Finds the numbers of the visible instances, in order, and of the spaces of the instancers."""
        keys = self._keys_then
        if self._known_order is not None:
            keys = [instance_key(instance) for instance in instances if instance.show_self]
        self._linked.update(name for key in keys if key[1] for name in key[:2])
        numbers = [self._number(key) for key in keys]
        spaces = [self._number(space_key(each.name_full)) for each in self._instancers]
        every = np.array(numbers + spaces, np.int64)
        self._linked.update(each.name_full for each in self._instancers)
        self._known_order = signature, every[: len(numbers)], every

    def _number(self, key):
        return self._numbers.setdefault(key, len(self._numbers))

    def _look_at_cameras(self, time):
        for camera in self._cameras:
            values = self._read_camera(camera, self._depsgraph)
            finite(values, f'camera "{camera.name}"', f"its place or its lens at frame {time:g}")
            self._camera_values[camera.name_full, time] = values

    def moves(self, key):
        """Whether the thing was ever seen away from its first position."""
        number = self._numbers.get(key)
        return number is not None and bool(self._has_moved[number])

    def states(self, keys):
        """Yields the matrices (n, 4, 4) of things at the times that were sampled, in order, except that
        their first positions come once."""
        numbers = np.array([self._numbers[key] for key in keys], np.int64)
        place = np.full(len(self._first), -1, np.int64)
        place[numbers] = np.arange(len(numbers))
        has_first = False
        for time in sorted(self._changes):
            changed, matrices = self._changes[time]
            rows = place[changed]
            is_moved = (rows >= 0).any()
            if has_first and not is_moved:
                continue
            has_first |= not is_moved
            now = self._first[numbers].astype(np.float64)
            now[rows[rows >= 0]] = matrices[rows >= 0]
            yield now

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
