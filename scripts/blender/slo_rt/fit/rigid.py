# SPDX-License-Identifier: GPL-3.0-or-later
"""Placements of rigid bodies as in the scene language: pivot, up and right."""

import numpy as np

# A body whose axes are shorter than this fraction of its longest one has no orientation.
FLAT = 1e-9


def split_matrix(matrix):
    """Splits object-to-world matrices into a rigid placement and a remainder for the vertices.

    `matrix` has shape (..., 4, 4) and acts on columns. Returns `(placement, shape)`: `placement`
    (..., 9) is pivot, up, right, the latter two unit vectors in world space; `shape` (..., 3, 3)
    holds scale, shear and mirroring, so that world = pivot + axes @ shape @ vertex, with the
    columns (right, forward, up) as axes. `right` follows the local x axis, `up` is as near to the
    local z axis as a right angle allows.
    """
    matrix = np.asarray(matrix, np.float64)
    linear = matrix[..., :3, :3]
    longest = np.linalg.norm(linear, axis=-2).max(axis=-1, keepdims=True)
    right = _direction(linear[..., :, 0], longest, (1.0, 0.0, 0.0))
    local_z = linear[..., :, 2]
    up = _direction(_across(local_z, right), longest, None)
    missing = ~np.any(up, axis=-1, keepdims=True)
    up = np.where(missing, _any_across(right), up)
    axes = axes_of(up, right)
    shape = np.swapaxes(axes, -1, -2) @ linear
    return np.concatenate([matrix[..., :3, 3], up, right], axis=-1), shape


def axes_of(up, right):
    """Returns the columns (right, forward, up) of a placement, shape (..., 3, 3), by Gram-Schmidt.

    `right` keeps its direction and `up` is adjusted, as in slo-rt.
    """
    right = _unit(right)
    up = _unit(_across(up, right))
    return np.stack([right, cross(up, right), up], axis=-1)


def angle_between(axes_a, axes_b):
    """Returns the largest angle in radians between corresponding columns, for small angles."""
    chord = np.linalg.norm(axes_a - axes_b, axis=-2).max(axis=-1)
    return 2.0 * np.arcsin(np.clip(chord / 2.0, 0.0, 1.0))


def cross(a, b):
    """Returns vector products, shape (..., 3); many times faster than numpy's for few vectors."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _across(vector, direction):
    """Returns the part of `vector` perpendicular to the unit vector `direction`."""
    along = np.sum(vector * direction, axis=-1, keepdims=True)
    return vector - along * direction


def _unit(vector):
    return vector / np.maximum(np.linalg.norm(vector, axis=-1, keepdims=True), 1e-300)


def _direction(vector, longest, otherwise):
    """Normalizes vectors; if a `vector` is too short, the result is `otherwise`, or zero."""
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    has_one = length > FLAT * np.maximum(longest, 1e-300)
    unit = vector / np.where(has_one, length, 1.0)
    return np.where(has_one, unit, 0.0 if otherwise is None else np.asarray(otherwise))


def _any_across(direction):
    """Returns a unit vector perpendicular to the unit vector `direction`, from z if they are not
    nearly parallel, otherwise from y."""
    z = np.broadcast_to((0.0, 0.0, 1.0), direction.shape)
    y = np.broadcast_to((0.0, 1.0, 0.0), direction.shape)
    other = np.where(np.abs(direction[..., 2:]) < 0.9, z, y)
    return _unit(_across(other, direction))
