# SPDX-License-Identifier: GPL-3.0-or-later
"""Where things are at any time, read from Blender's evaluated scene."""

import numpy as np

from .. import compat
from ..fit.motion import Break
from .checks import finite


def instance_key(instance):
    """What tells an instance of the dependency graph from all others, at all times."""
    name = instance.object.original.name_full
    if not instance.is_instance:
        return (name, "", ())
    return (name, instance.parent.original.name_full, tuple(instance.persistent_id))


class Timeline:
    """Samples the whole scene, at each time once.

    `set_frame(frame)` takes the dependency graph to a time in frames, fractions included.
    """

    def __init__(self, depsgraph, set_frame, cameras, read_camera):
        self._depsgraph = depsgraph
        self._set_frame = set_frame
        self._cameras = cameras
        self._read_camera = read_camera
        self._times = {}
        self._first = {}
        self._changed = {}
        self._camera_values = {}
        self._seen = {}

    @property
    def samples(self):
        """How many times were looked at."""
        return len(self._times)

    def visit(self, times):
        """Makes sure that `times` (frames) were looked at."""
        for time in times:
            if time not in self._times:
                self._times[time] = True
                self._set_frame(float(time))
                self._look(float(time))

    def _look(self, time):
        for instance in self._depsgraph.object_instances:
            if not instance.show_self:
                continue
            key = instance_key(instance)
            self._seen[key] = self._seen.get(key, 0) + 1
            # Blender's own matrices compare and copy many times quicker than arrays are made.
            matrix = instance.matrix_world.copy()
            first = self._first.setdefault(key, matrix)
            if first != matrix:
                self._changed.setdefault(key, {})[time] = matrix
        for camera in self._cameras:
            values = self._read_camera(camera, self._depsgraph)
            finite(values, f'camera "{camera.name}"', f"its place or its lens at frame {time:g}")
            self._camera_values[camera.name_full, time] = values

    def moves(self, key):
        """Whether the thing was ever seen at another place than at first."""
        return key in self._changed

    def not_always_there(self):
        """Keys of things that were seen at some times only."""
        return [key for key, count in self._seen.items() if count < len(self._times)]

    def matrices(self, key, times):
        """Matrices to world space (n, 4, 4) of a thing at times (n,).

        # Errors `ValueError` where one is not finite.
        """
        self.visit(times)
        changed, first = self._changed.get(key, {}), self._first[key]
        matrices = np.array([changed.get(time, first) for time in times], np.float64)
        when = f"between frames {times[0]:g} and {times[-1]:g}"
        return finite(matrices, f'object "{key[0]}"', f"its place {when}")

    def camera_values(self, camera, times):
        """What `read_camera` said of a camera at times (n,), one row each."""
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
    """The object and all that it follows: parents, targets of constraints and drivers, its data."""
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
