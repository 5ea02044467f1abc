# SPDX-License-Identifier: GPL-3.0-or-later
"""With how many samples a frame is rendered, one pass after the other. Knows nothing of Blender.

Each pass renders the whole picture anew, and the last one counts. Passes before it show something early, or
measure how long a sample takes.
"""

EARLY = 1
GROWTH = 8  # so that all passes before the last cost a seventh of it
WORTH_SHARING = 64


def planned(samples, show_early):
    """Samples of the passes of a frame that may take as long as it likes; the last is the picture."""
    passes = [EARLY, samples // GROWTH] if samples >= WORTH_SHARING else [EARLY]
    return [count for count in passes if show_early and count < samples] + [samples]


def following(seconds, samples, measured):
    """Samples of the next pass of a frame that has a time limit, or None if the last pass was the picture.

    `measured` is a list of `(samples, seconds)` of the passes so far, and `samples` the most that are wanted.
    A pass is counted as all work in proportion to its samples, so that the limit holds; the next one has
    at least twice as many samples, or it is not worth it.
    """
    if not measured:
        return min(EARLY, samples)
    count, duration = measured[-1]
    left = seconds - sum(duration for _, duration in measured)
    fitting = int(left / max(duration, 1e-6) * count)
    wanted = min(samples, GROWTH * count, fitting)
    return wanted if count < samples and (wanted == samples or wanted >= 2 * count) else None
