# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits Bézier curves to samples by least squares."""

from math import comb

import numpy as np


def basis(degree, u):
    """Returns the Bernstein polynomials at `u` (n,), shape (n, degree + 1)."""
    u = np.asarray(u, np.float64)[:, None]
    k = np.arange(degree + 1)
    binomials = np.array([comb(degree, int(i)) for i in k], np.float64)
    return binomials * u**k * (1.0 - u) ** (degree - k)


def evaluate(control, u):
    """Returns points of the curve with `control` (degree + 1, d) at `u` (n,), shape (n, d)."""
    return basis(len(control) - 1, u) @ control


def fit_many(degree, u, values):
    """Does `fit` for each of `values` (n, k, d); returns control points (n, degree + 1, d)."""
    line = np.linspace(0.0, 1.0, degree + 1)[:, None]
    control = values[:, :1] * (1.0 - line) + values[:, -1:] * line
    if degree >= 2 and len(u) > 2:
        weights = basis(degree, u)
        remainder = values - weights @ control
        control[:, 1:-1] += np.linalg.pinv(weights[1:-1, 1:-1]) @ remainder[:, 1:-1]
    return control


def fit(degree, u, values):
    """Returns the control points of the curve that starts and ends at the first and last of `values`
    (n, d) and fits the others by least squares.

    `u` (n,) rises from 0 to 1. If there are too few samples for the degree, it returns the curve
    whose control points deviate least from the straight line.
    """
    return fit_many(degree, u, np.asarray(values)[None])[0]


def tidy_many(points):
    """Does `tidy` for each of `points` (n, m, d)."""
    largest = np.abs(points).max(axis=(1, 2), keepdims=True)
    decimals = 8 - np.ceil(np.log10(np.where(largest > 0.0, largest, 1.0)))
    scale = 10.0 ** np.clip(np.abs(decimals), 0, 300)
    coarse, fine = np.rint(points / scale) * scale, np.rint(points * scale) / scale
    return np.where(decimals < 0, coarse, fine) + 0.0


def tidy(points):
    """Rounds points to the digits of single precision: to 1e-8 of the largest number."""
    return tidy_many(points[None])[0]
