# SPDX-License-Identifier: GPL-3.0-or-later
"""Placements of rigid bodies as in the scene language: pivot, up and right."""

import numpy as np

# A body whose axes are shorter than this fraction of its longest one has no orientation.
FLAT = 1e-9
# Smallest scale of a placement, in units of the longest axis, and of 1 for what is scaled to nothing.
SMALLEST = 1e-6
# A scale that differs from 1 by less is 1: matrices have single precision.
ROUNDING = 1e-6
# Axes whose directions have a larger cosine are sheared.
SHEAR = 1e-5
MIRROR = np.diag((1.0, -1.0, 1.0))


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
    x, y, z = (_direction(linear[..., :, i], longest) for i in range(3))
    right = _first(x, lambda: _unit(cross(y, z)), lambda: _any_across(_first(y, lambda: z)))
    right = _first(right, lambda: np.broadcast_to((1.0, 0.0, 0.0), x.shape))
    up = _direction(_across(linear[..., :, 2], right), longest)
    up = _first(up, lambda: _unit(cross(right, y)), lambda: _any_across(right))
    axes = axes_of(up, right)
    shape = np.swapaxes(axes, -1, -2) @ linear
    return np.concatenate([matrix[..., :3, 3], up, right], axis=-1), shape


def split_affine(matrix):
    """Splits object-to-world matrices into a placement with a scale and a remainder for the vertices.

    Returns `(placement, rest)`: `placement` (..., 12) is pivot, up, right and scale, all factors of
    which are more than 0; `rest` (..., 3, 3) holds shear and mirroring, so that world = pivot + axes
    @ diag(scale) @ rest @ vertex. Without shear, `rest` is exactly the identity, or `MIRROR` for a
    negative scale.
    """
    rigid, shape = split_matrix(matrix)
    size = np.abs(np.diagonal(shape, axis1=-2, axis2=-1))
    longest = size.max(axis=-1, keepdims=True)
    scale = np.maximum(size, SMALLEST * np.where(longest > 0.0, longest, 1.0))
    rest = np.where((size < scale)[..., :, None], np.eye(3), shape / scale[..., :, None])
    scale = np.where(np.abs(scale - 1.0) < ROUNDING, 1.0, scale)
    plain = np.where(np.linalg.det(shape)[..., None, None] < 0.0, MIRROR, np.eye(3))
    rest = np.where(is_sheared(matrix)[..., None, None], rest, plain)
    return np.concatenate([rigid, scale], axis=-1), rest


def is_sheared(matrix):
    """Whether axes of matrices (..., 4, 4) that have a length are not perpendicular."""
    linear = np.asarray(matrix, np.float64)[..., :3, :3]
    longest = np.linalg.norm(linear, axis=-2).max(axis=-1, keepdims=True)
    axes = np.stack([_direction(linear[..., :, i], longest) for i in range(3)], axis=-1)
    cosines = np.swapaxes(axes, -1, -2) @ axes
    return np.abs(cosines[..., (0, 0, 1), (1, 2, 2)]).max(axis=-1) > SHEAR


def matrix_of(placement):
    """Returns the matrices (..., 4, 4) of placements (..., 12), with their scale."""
    result = np.zeros((*placement.shape[:-1], 4, 4))
    axes = axes_of(placement[..., 3:6], placement[..., 6:9])
    result[..., :3, :3] = axes * placement[..., None, 9:12]
    result[..., :3, 3] = placement[..., :3]
    result[..., 3, 3] = 1.0
    return result


def quaternions(axes):
    """Returns the unit quaternions w, x, y, z (n, 4) of rotations (n, 3, 3)."""
    # The column of w^2, x^2, y^2, z^2 that is largest gives the others without loss.
    xx, yy, zz = axes[:, 0, 0], axes[:, 1, 1], axes[:, 2, 2]
    squares = np.stack([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz])
    wx, wy, wz = (axes[:, b, a] - axes[:, a, b] for a, b in ((1, 2), (2, 0), (0, 1)))
    xy, yz, zx = (axes[:, b, a] + axes[:, a, b] for a, b in ((0, 1), (1, 2), (2, 0)))
    products = np.array(
        [
            [squares[0], wx, wy, wz],
            [wx, squares[1], xy, zx],
            [wy, xy, squares[2], yz],
            [wz, zx, yz, squares[3]],
        ]
    )
    best = np.argmax(squares, axis=0)
    return _unit(products[best, :, np.arange(len(axes))])


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


def _direction(vector, longest):
    """Normalizes vectors; if a `vector` is too short, the result is zero."""
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    has_one = length > FLAT * np.maximum(longest, 1e-300)
    return np.where(has_one, vector / np.where(has_one, length, 1.0), 0.0)


def _first(vectors, *others):
    """Returns `vectors`, with the result of the first of `others` that is not zero in place of zeros."""
    for other in others:
        missing = ~np.any(vectors, axis=-1, keepdims=True)
        if missing.any():
            vectors = np.where(missing, other(), vectors)
    return vectors


def _any_across(direction):
    """Returns a unit vector perpendicular to the unit vector `direction`, from z if they are not
    nearly parallel, otherwise from y; zero for zero."""
    z = np.broadcast_to((0.0, 0.0, 1.0), direction.shape)
    y = np.broadcast_to((0.0, 1.0, 0.0), direction.shape)
    other = np.where(np.abs(direction[..., 2:]) < 0.9, z, y)
    result = _unit(_across(other, direction))
    return np.where(np.any(direction, axis=-1, keepdims=True), result, 0.0)
