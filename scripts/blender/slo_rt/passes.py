# SPDX-License-Identifier: GPL-3.0-or-later
"""With how many samples a frame is rendered, one pass after the other. Knows nothing of Blender.

The last pass is the picture; those before it show something early, or measure how long a sample
takes. A program that goes on from where the last pass ended (`goes_on`) loses nothing by them.
"""

EARLY = 1
GROWTH = 8  # a program that begins anew spends a seventh on all passes before the last
WORTH_SHARING = 64


def planned(samples, show_early, goes_on):
    """Samples of the passes of a frame that may take as long as it likes."""
    passes = [EARLY]
    while goes_on and passes[-1] * GROWTH < samples:
        passes.append(passes[-1] * GROWTH)
    if not goes_on and samples >= WORTH_SHARING:
        passes.append(samples // GROWTH)
    return [count for count in passes if show_early and count < samples] + [samples]


def following(seconds, samples, measured, goes_on):
    """Samples of the next pass of a frame that has a time limit, or None if the last pass was the
    picture.

    `measured` is a list of `(samples, seconds)` of the passes so far, and `samples` the most that
    are wanted. A pass is counted as all work in proportion to its samples, so that the limit holds,
    up to the start of a last short pass. A pass that begins anew is worth it only with twice the
    samples of the last.
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
