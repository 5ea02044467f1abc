# SPDX-License-Identifier: GPL-3.0-or-later
"""Bézier curves through samples, by least squares."""

from math import comb

import numpy as np


def basis(degree, u):
    """Bernstein polynomials at `u` (n,), shape (n, degree + 1)."""
    u = np.asarray(u, np.float64)[:, None]
    k = np.arange(degree + 1)
    binomials = np.array([comb(degree, int(i)) for i in k], np.float64)
    return binomials * u**k * (1.0 - u) ** (degree - k)


def evaluate(control, u):
    """Points of the curve with `control` (degree + 1, d) at `u` (n,), shape (n, d)."""
    return basis(len(control) - 1, u) @ control


def fit(degree, u, values):
    """Control points of the curve that starts and ends at the first and last of `values` (n, d) and
    is nearest to the others in the mean.

    `u` (n,) rises from 0 to 1. Where there are too few samples for the degree, the curve with the
    shortest control points about the straight line is taken.
    """
    line = np.linspace(0.0, 1.0, degree + 1)[:, None]
    control = values[0] * (1.0 - line) + values[-1] * line
    if degree >= 2 and len(u) > 2:
        weights = basis(degree, u)
        remainder = values - weights @ control
        inner, *_ = np.linalg.lstsq(weights[1:-1, 1:-1], remainder[1:-1], rcond=None)
        control[1:-1] += inner
    return control


def tidy(points):
    """The same points without digits that single precision never had: to 1e-8 of the largest."""
    largest = np.abs(points).max()
    if largest == 0.0:
        return points
    return np.round(points, int(8 - np.ceil(np.log10(largest)))) + 0.0
