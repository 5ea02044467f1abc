# SPDX-License-Identifier: GPL-3.0-or-later
"""With how many samples a frame is rendered, one pass after the other. Knows nothing of Blender.

Each pass renders the whole picture anew, and only the last one counts. Passes before it show something early, or
measure how long a sample takes.
"""

EARLY = 1
SHARE = 8  # a pass of an eighth of the samples is worth showing, and costs little
WORTH_SHARING = 64


def planned(samples, show_early, seconds):
    """Samples of the passes; the last is the picture. With a time limit (`seconds` > 0) the last is decided
    by `within`, when the others have been measured."""
    passes = []
    if show_early or seconds > 0.0:
        passes.append(EARLY)
    if seconds > 0.0:
        passes.append(SHARE)
    elif show_early and samples >= WORTH_SHARING:
        passes.append(samples // SHARE)
    return [count for count in passes if count < samples] + [samples]


def within(seconds, samples, measured):
    """Samples that fit into what is left of `seconds`, at least one and at most `samples`.

    `measured` is a list of `(samples, seconds)` of passes; two of them tell what a pass takes apart from
    its samples.
    """
    spent = sum(duration for _, duration in measured)
    (few, short), (many, long) = measured[0], measured[-1]
    if many > few:
        each = max((long - short) / (many - few), 1e-9)
        fixed = max(short - each * few, 0.0)
    else:
        each, fixed = max(short / few, 1e-9), 0.0
    return max(1, min(samples, int((seconds - spent - fixed) / each)))
