# SPDX-License-Identifier: GPL-3.0-or-later
"""The size of a scene, and the distances of its things from a point."""

import numpy as np

from ..fit.rigid import axes_of

# Least distance, in metres.
NEAREST = 1e-3
# A thing around a light or next to it is the light's own fixture (a bulb, a shade) if its diagonal
# is less than this fraction of the scene's.
FIXTURE = 0.05
DEFAULT_CLIP_START = 0.1


class Surroundings:
    """The things of a scene at one moment: the middles of their boxes (`centers`), the median of the
    middles (`center`), and the diagonal of the whole scene (`diagonal`)."""

    def __init__(self, things):
        placements = np.array([thing.placement for thing in things]).reshape(-1, 12)
        self._pivots = placements[:, :3]
        self._axes = axes_of(placements[:, 3:6], placements[:, 6:9])
        boxes = np.array([thing.original.box for thing in things]).reshape(-1, 2, 3)
        self._boxes = boxes * placements[:, None, 9:]
        middles = self._boxes.mean(axis=1)
        self.centers = self._pivots + np.einsum("nij,nj->ni", self._axes, middles)
        if not things:
            self.centers = np.zeros((1, 3))
        self.center = np.median(self.centers, axis=0)
        self._diagonals = np.linalg.norm(self._boxes[:, 1] - self._boxes[:, 0], axis=1)
        reach = self._diagonals.max(initial=0.0)
        self.diagonal = float(np.linalg.norm(np.ptp(self.centers, axis=0)) + reach)

    def eyes(self, position):
        """Returns a point (3,) in the space of each thing's box, and its distance to the box, 0 inside."""
        eyes = np.einsum("nji,nj->ni", self._axes, position - self._pivots)
        low, high = self._boxes[:, 0], self._boxes[:, 1]
        return eyes, np.linalg.norm(eyes - np.clip(eyes, low, high), axis=1)

    def distance(self, position):
        """Returns the typical distance, in metres, at which a light at `position` (3,) lights the scene.

        This is the distance to the middle of the scene, or the median distance to the surfaces of
        things if that is larger. The distance to a box around the point is the median over the box's
        faces. The light's own fixture does not count.
        """
        to_middle = float(np.linalg.norm(self.center - position))
        eyes, gaps = self.eyes(position)
        is_fixture = (gaps < self._diagonals) & (self._diagonals < FIXTURE * self.diagonal)
        if is_fixture.all():
            return max(to_middle, NEAREST)
        low, high = self._boxes[:, 0], self._boxes[:, 1]
        walls = np.median(np.hstack([eyes - low, high - eyes]), axis=1)
        to_things = np.where(gaps > 0.0, gaps, walls)[~is_fixture]
        return max(to_middle, float(np.median(to_things)), NEAREST)

    def note_clipping(self, camera, values, report):
        """Notes things in front of the start or behind the end of a camera's clipping range, which
        Blender does not show. `values` are the camera's numbers from `CameraReader`."""
        if not len(self._boxes) or camera.type != "CAMERA":
            return
        optics, subject = camera.data, f'camera "{camera.name}"'
        eyes, gaps = self.eyes(values[:3])
        gaze = np.einsum("nji,j->ni", self._axes, values[3:6])
        farthest = np.where(gaze > 0.0, self._boxes[:, 1], self._boxes[:, 0]) - eyes
        if np.sum(farthest * gaze, axis=1).max() > optics.clip_end:
            report.note(subject, f"what is behind its clip end, {optics.clip_end:g} m, is seen too")
        # A camera in a room is inside a box, whose walls are farther away.
        outside = (gaps > 0.0) | (optics.clip_start > DEFAULT_CLIP_START * 1.001)
        if (outside & (gaps < optics.clip_start)).any():
            report.note(
                subject, f"what is before its clip start, {optics.clip_start:g} m, is seen too"
            )
