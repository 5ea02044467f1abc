# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of samples of the passes in which a frame is rendered. Independent of Blender.

The last pass is the picture. The passes before it show an early picture, or measure how long a
sample takes. They cost nothing extra if the program continues where the last pass ended (`goes_on`).
"""

EARLY = 1
GROWTH = 8  # a program that starts over spends a seventh of the time on all passes before the last
WORTH_SHARING = 64


def planned(samples, show_early, goes_on):
    """Returns the samples of the passes of a frame without a time limit."""
    passes = [EARLY]
    while goes_on and passes[-1] * GROWTH < samples:
        passes.append(passes[-1] * GROWTH)
    if not goes_on and samples >= WORTH_SHARING:
        passes.append(samples // GROWTH)
    return [count for count in passes if show_early and count < samples] + [samples]


def following(seconds, samples, measured, goes_on):
    """Returns the samples of the next pass of a frame that has a time limit, or None if the last pass
    was the picture.

    `measured` is a list of `(samples, seconds)` of the passes so far, and `samples` is the maximum.
    The estimate assumes that the whole time of a pass is proportional to its samples, so the limit
    holds except for the startup of a last short pass. If the program starts over, a pass is
    worthwhile only with twice the samples of the last.
    """
    if not measured:
        return min(EARLY, samples)
    count, duration = measured[-1]
    before = measured[-2][0] if goes_on and len(measured) > 1 else 0
    left = seconds - sum(duration for _, duration in measured)
    fitting = int(left / max(duration, 1e-6) * (count - before)) + (count if goes_on else 0)
    wanted = min(samples, GROWTH * count, fitting)
    worth = count + 1 if goes_on else 2 * count
    return wanted if count < samples and (wanted == samples or wanted >= worth) else None
