# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers that no picture can be made of, found while it is still known whose they are."""

import numpy as np

# The square of more is infinite in single precision. Blender turns infinite places into such.
LARGEST = 1e18


def finite(values, subject, what="its place"):
    """`values` as they are.

    # Errors `ValueError` that names `subject` (such as `object "Cube"`) and `what` of it is infinite,
    nearly so, or not a number.
    """
    if not (np.abs(values) <= LARGEST).all():
        raise ValueError(f"{subject}: {what} is not a finite number")
    return values
