# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds numbers that cannot be rendered while their owner is still known."""

import numpy as np

# The square of a larger number is infinite in single precision. Blender turns infinite positions
# into such numbers.
LARGEST = 1e18


def finite(values, subject, what="its place"):
    """Returns `values` unchanged.

    # Errors `ValueError` that names `subject` (such as `object "Cube"`) and `what` of it is infinite,
    nearly so, or not a number.
    """
    if not (np.abs(values) <= LARGEST).all():
        raise ValueError(f"{subject}: {what} is not a finite number")
    return values
