# SPDX-License-Identifier: GPL-3.0-or-later
"""Curve fitting on motions that have a formula."""

import math
import unittest

import numpy as np

from slo_rt.convert.settings import Shutter
from slo_rt.fit import bezier, camera, motion, rigid


def rotation(axis, angle):
    """Rotation matrix by Rodrigues."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * (k @ k)


def placements(place, axis, angle):
    """A `sample` function from functions of time."""

    def sample(times):
        rows = []
        for time in times:
            axes = rotation(axis, angle(time))
            rows.append(np.concatenate([place(time), axes[:, 2], axes[:, 0]]))
        return np.array(rows)

    return sample


def at(keys, time):
    """A placement by key frames."""
    for a, b in zip(keys, keys[1:]):
        if a.time <= time <= b.time:
            u = (time - a.time) / (b.time - a.time)
            nex = a.nex if a.nex is not None else a.key + (b.key - a.key) / 3.0
            pre = b.pre if b.pre is not None else a.key + (b.key - a.key) * 2.0 / 3.0
            return bezier.evaluate(np.array([a.key, nex, pre, b.key]), np.array([u]))[0]
    raise AssertionError(time)


class BezierTest(unittest.TestCase):
    def test_fit_returns_the_curve(self):
        random = np.random.default_rng(3)
        for degree in range(1, 8):
            control = random.standard_normal((degree + 1, 3))
            u = np.linspace(0.0, 1.0, 30)
            fitted = bezier.fit(degree, u, bezier.evaluate(control, u))
            np.testing.assert_allclose(fitted, control, atol=1e-8)

    def test_few_samples(self):
        values = np.array([[0.0], [3.0]])
        np.testing.assert_allclose(bezier.fit(3, np.array([0.0, 1.0]), values)[:, 0], [0, 1, 2, 3])


class RigidTest(unittest.TestCase):
    def test_matrix_comes_back(self):
        random = np.random.default_rng(4)
        for _ in range(50):
            matrix = np.eye(4)
            matrix[:3] = random.standard_normal((3, 4))
            placement, shape = rigid.split_matrix(matrix)
            axes = rigid.axes_of(placement[3:6], placement[6:9])
            np.testing.assert_allclose(axes @ shape, matrix[:3, :3], atol=1e-12)
            self.assertAlmostEqual(np.linalg.det(axes), 1.0)
            self.assertEqual(np.sign(np.linalg.det(shape)), np.sign(np.linalg.det(matrix)))

    def test_scale_of_a_turned_thing_is_diagonal(self):
        matrix = np.eye(4)
        matrix[:3, :3] = rotation((1, 2, 3), 0.7) @ np.diag((2.0, -3.0, 4.0))
        _, shape = rigid.split_matrix(matrix)
        np.testing.assert_allclose(shape, np.diag((2.0, -3.0, 4.0)), atol=1e-12)

    def test_flat_things_have_an_orientation(self):
        for scale in ((1, 1, 0), (0, 1, 1), (1, 0, 0), (0, 0, 0), (0, 0, 1)):
            matrix = np.eye(4)
            matrix[:3, :3] = rotation((1, 2, 3), 0.7) @ np.diag(np.array(scale, float))
            placement, _ = rigid.split_matrix(matrix)
            axes = rigid.axes_of(placement[3:6], placement[6:9])
            np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)

    def test_affine_matrix_comes_back(self):
        random = np.random.default_rng(5)
        for _ in range(50):
            matrix = np.eye(4)
            matrix[:3] = random.standard_normal((3, 4))
            placement, rest = rigid.split_affine(matrix)
            whole = rigid.matrix_of(placement)
            np.testing.assert_allclose(whole[:3, :3] @ rest, matrix[:3, :3], atol=1e-12)
            np.testing.assert_allclose(np.abs(np.diag(rest)), 1.0, atol=1e-12)
            self.assertGreater(placement[9:].min(), 0.0)

    def test_scale_and_mirroring_leave_no_rest(self):
        """Single precision counts as rounding, also among very different scales."""
        for scale in (
            (2, 3, 4),
            (2, -3, 4),
            (-1, -1, -1),
            (0.01, 100, 1),
            (1, 1, 0),
            (0, 0, 0),
            (0, 2, 0),
        ):
            matrix = np.eye(4, dtype=np.float32)
            matrix[:3, :3] = rotation((1, 2, 3), 0.7) @ np.diag(np.array(scale, float))
            placement, rest = rigid.split_affine(matrix)
            mirrors = np.prod(np.sign(scale)) < 0
            np.testing.assert_array_equal(rest, rigid.MIRROR if mirrors else np.eye(3))
            sizes = np.abs(np.array(scale, float))
            off = np.abs(np.sort(placement[9:]) - np.sort(sizes))
            self.assertLessEqual(off.max(), 2e-6 * max(sizes.max(), 1.0))

    def test_quaternions_turn_as_matrices_do(self):
        random = np.random.default_rng(6)
        turns = [rotation(random.standard_normal(3), angle) for angle in np.linspace(-7.0, 7.0, 40)]
        turns += [rotation(axis, np.pi) for axis in np.eye(3)]
        for (w, *xyz), matrix in zip(rigid.quaternions(np.array(turns)), turns):
            for point in np.eye(3):
                twice = 2.0 * np.cross(xyz, point)
                turned = point + w * twice + np.cross(xyz, twice)
                np.testing.assert_allclose(turned, matrix @ point, atol=1e-12)


class MotionTest(unittest.TestCase):
    def check(self, sample, size, start=1.0, end=25.0, breaks=(), most=1000):
        keys, misfit = motion.fit_key_frames(sample, start, end, size, breaks)
        self.assertIsNone(misfit)
        times = np.linspace(start, end, 1009)
        fitted = np.array([at(keys, time) for time in times])
        true = sample(times)
        offset = np.linalg.norm(fitted[:, :3] - true[:, :3], axis=1).max() / size
        axes = [rigid.axes_of(x[:, 3:6], x[:, 6:9]) for x in (fitted, true)]
        turn = rigid.angle_between(*axes).max()
        self.assertLessEqual(offset, motion.POSITION_TOLERANCE)
        self.assertLessEqual(turn, motion.DIRECTION_TOLERANCE)
        self.assertLessEqual(len(keys), most)
        return keys

    def test_growth(self):
        """A scale is fitted as exactly as a position, and no handle reaches 0."""

        def sample(times):
            still = placements(lambda t: (0.0, 0.0, 0.0), (0, 0, 1), lambda t: 0.0)(times)
            growth = np.maximum(((times - 1.0) / 24.0) ** 3 * (1.0 + 0.3 * np.sin(times)), 1e-6)
            return np.hstack([still, growth[:, None] * (1.0, 2.0, 3.0)])

        keys, misfit = motion.fit_key_frames(sample, 1.0, 25.0, 6.0)
        self.assertIsNone(misfit)
        times = np.linspace(1.0, 25.0, 1009)
        fitted = np.array([at(keys, time) for time in times])
        off = np.abs(fitted[:, 9:] - sample(times)[:, 9:]).max()
        self.assertLess(off, 2.0 * motion.POSITION_TOLERANCE)
        for key in keys:
            for point in (key.pre, key.key, key.nex):
                self.assertTrue(point is None or (point[9:] > 0.0).all())

    def test_fast_spin(self):
        sample = placements(lambda t: (t, 0.0, 0.0), (1, 1, 0), lambda t: 5.2 * t)
        self.check(sample, 1.0)

    def test_screw(self):
        def place(t):
            return math.cos(t), math.sin(t), t

        self.check(placements(place, (0, 0, 1), lambda t: t), 2.0, most=120)

    def test_cubic_is_one_piece(self):
        def place(t):
            s = (t - 1.0) / 24.0
            return s**3, s * s - s, 4.0 * s

        keys = self.check(placements(place, (0, 0, 1), lambda t: 0.0), 1.0, most=2)
        self.assertEqual([key.time for key in keys], [1.0, 25.0])

    def test_straight_motion_needs_no_handles(self):
        keys = self.check(
            placements(lambda t: (t, 2 * t, 0.0), (0, 0, 1), lambda t: 0.0), 1.0, most=2
        )
        self.assertIsNone(keys[0].nex)
        self.assertIsNone(keys[1].pre)

    def test_breaks_divide(self):
        sample = placements(lambda t: (abs(t - 7.3), 0.0, 0.0), (0, 0, 1), lambda t: 0.0)
        keys = self.check(sample, 1.0, breaks=[motion.Break(7.3)], most=3)
        self.assertEqual([key.time for key in keys], [1.0, 7.3, 25.0])

    def test_leap(self):
        sample = placements(lambda t: (float(t >= 9.0) * 5.0, 0.0, 0.0), (0, 0, 1), lambda t: 0.0)
        keys, misfit = motion.fit_key_frames(sample, 1.0, 25.0, 1.0, [motion.Break(9.0, leap=True)])
        self.assertIsNone(misfit)
        # To rounding: sums of products differ between CPUs.
        self.assertAlmostEqual(at(keys, 8.99)[0], 0.0, places=12)
        self.assertAlmostEqual(at(keys, 9.0)[0], 5.0, places=12)
        self.assertLessEqual(len(keys), 5)

    def test_many_motions_are_fitted_together(self):
        """Gives the same result as for each motion by itself, and samples no more often than for one."""
        sizes = np.linspace(0.5, 2.0, 40)

        def place(t):
            return np.array([math.cos(0.3 * t), math.sin(0.3 * t), 0.1 * t])

        single = placements(place, (0, 0, 1), lambda t: 0.3 * t)
        asked, prepared = [], []

        def sample(who, times):
            asked.append(times.shape)
            rows = np.array([single(row) for row in times])
            rows[..., :3] *= sizes[who][:, None, None]
            return rows

        def count(which):
            asked.clear()
            breaks = [[motion.Break(5.0 + (who % 2))] for who in which]
            result = motion.fit_all(
                lambda who, times: sample(np.array(which)[who], times), 1.0, 25.0, sizes[which],
                breaks, prepared.append,
            )  # fmt: skip
            return result, len(asked)

        together, questions = count(list(range(40)))
        self.assertLessEqual(questions, sum(count([who])[1] for who in (0, 1)))
        for who, (keys, misfit) in enumerate(together):
            ((alone, _),) = count([who])[0]
            self.assertIsNone(misfit)
            self.assertEqual([key.time for key in keys], [key.time for key in alone])
            for a, b in zip(keys, alone):
                np.testing.assert_allclose(a.key, b.key, atol=1e-7)
        self.assertTrue(all((np.diff(times) > 0.0).all() for times in prepared))

    def test_leap_without_notice_is_told(self):
        sample = placements(lambda t: (float(t >= 9.1) * 5.0, 0.0, 0.0), (0, 0, 1), lambda t: 0.0)
        keys, misfit = motion.fit_key_frames(sample, 1.0, 25.0, 1.0)
        self.assertAlmostEqual(misfit.time, 9.1, delta=0.05)
        self.assertLess(len(keys), 60)
        self.assertEqual(at(keys, 8.9)[0], 0.0)

    def test_rest_before_and_after(self):
        def place(t):
            return min(max(t, 10.0), 12.0), 0.0, 0.0

        sample = placements(place, (0, 0, 1), lambda t: 0.0)
        keys = self.check(sample, 1.0, breaks=[motion.Break(10.0), motion.Break(12.0)], most=4)
        self.assertEqual(len(keys), 4)

    def test_samples_of_a_piece(self):
        for start, end in ((1.0, 25.0), (0.75, 1.25), (3.3, 3.4), (-0.25, 0.75)):
            times = motion.sample_times(start, end)
            self.assertEqual((times[0], times[-1]), (start, end))
            self.assertTrue((np.diff(times) > 0.0).all())
            self.assertGreaterEqual(len(times) - 2, motion.INNER_SAMPLES - 1)


class CameraTest(unittest.TestCase):
    def samples(self, position, forward, up):
        def sample(times):
            times = np.asarray(times)
            ones = np.ones(len(times))
            return camera.CameraSamples(
                times, *(np.array([f(t) for t in times], float) for f in (position, forward, up)),
                view=0.3 * ones, focus=7.0 * ones, lens_radius=0.0 * ones,
            )  # fmt: skip

        return sample

    def test_orbit_finds_what_it_looks_at(self):
        def position(t):
            return 6.0 * math.cos(t / 30.0), 6.0 * math.sin(t / 30.0), 2.0

        def forward(t):
            gaze = np.array((0.0, 0.0, 0.5)) - position(t)
            return gaze / np.linalg.norm(gaze)

        def up(t):
            right = np.cross(forward(t), (0, 0, 1))
            return np.cross(right / np.linalg.norm(right), forward(t))

        sample = self.samples(position, forward, up)
        segments, misfit = camera.fit_segments(sample, 1, 26, Shutter(-0.25, 0.5), 6.0)
        self.assertIsNone(misfit)
        self.assertLessEqual(len(segments), 3)
        for segment in segments:
            np.testing.assert_allclose(segment.targets, [[0.0, 0.0, 0.5]], atol=1e-7)
            np.testing.assert_array_equal(segment.sky, [camera.Z, camera.Z])

    def test_segments_join_at_whole_frames(self):
        def forward(t):
            return math.cos(t), math.sin(t), 0.0

        sample = self.samples(lambda t: (0.0, 0.0, 0.0), forward, lambda t: (0.0, 0.0, 1.0))
        shutter = Shutter(-0.5, 1.0)
        segments, misfit = camera.fit_segments(sample, 1, 11, shutter, 1.0)
        self.assertIsNone(misfit)
        self.assertEqual(segments[0].start, 0.5)
        self.assertEqual(segments[-1].end, 10.5)
        for a, b in zip(segments, segments[1:]):
            self.assertEqual(a.end, b.start)
            self.assertEqual((a.end - shutter.offset) % 1.0, 0.0)

    def test_looking_down(self):
        sample = self.samples(
            lambda t: (0.1 * t, 0.0, 5.0), lambda t: (0.0, 0.0, -1.0), lambda t: (0.0, 1.0, 0.0)
        )
        segments, misfit = camera.fit_segments(sample, 1, 11, Shutter(0.0, 0.0), 1.0)
        self.assertIsNone(misfit)
        self.assertEqual(len(segments), 1)
        np.testing.assert_array_equal(segments[0].sky[0], (0.0, 1.0, 0.0))
