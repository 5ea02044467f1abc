# SPDX-License-Identifier: GPL-3.0-or-later
"""Key frames as text, without the parts that the scene language supplies by default."""

import numpy as np

from .decimal_text import vectors
from .scene_text import block, exact

PARTS = {"pivot": slice(0, 3), "up": slice(3, 6), "right": slice(6, 9), "scale": slice(9, 12)}
NO_SCALE = (1.0, 1.0, 1.0)
STRAIGHT = (
    1e-8  # largest distance of a straight handle from the line, in units of the largest number
)


def still(placement):
    """One key frame that places a thing: pivot, up, right, and scale (12,) or not (9,)."""
    parts = [(name, placement[PARTS[name]]) for name in PARTS]
    parts = [(name, value) for name, value in parts[:3] + parts[3:] if len(value)]
    if len(placement) > 9 and tuple(placement[9:]) == NO_SCALE:
        parts.pop()
    return block("addKframe", [("time", 0), block("key", parts)])


def moving(keys, frames_per_second):
    """`addKframe` blocks of `fit.motion.KeyFrame`s.

    A key holds the values that have changed since the key before; a handle holds the values that do
    not lie on the straight line between two keys.
    """
    points, is_told = _points(keys)
    texts = iter(vectors(points[is_told]))
    blocks = []
    for key, told in zip(keys, is_told.tolist()):
        body = [("time", exact(key.time / frames_per_second))]
        for side, parts in zip(("pre", "key", "nex"), told):
            if any(parts):
                inner = [(name, next(texts)) for name, is_here in zip(PARTS, parts) if is_here]
                body.append(block(side, inner))
        blocks.append(block("addKframe", body))
    return blocks


def _points(keys):
    """Returns handle, key, handle of `n` key frames by their parts, (n, 3, 4, 3), and which vectors
    must be written, (n, 3, 4). Without a scale, there are 3 parts."""
    key = np.array([each.key for each in keys])
    width = key.shape[1]
    step = np.diff(key, axis=0) / 3.0
    lines = key[:-1] + step, key[1:] - step
    has_handles = [a.nex is not None and b.pre is not None for a, b in zip(keys, keys[1:])]
    nex, pre = (line.copy() for line in lines)
    for i in np.flatnonzero(has_handles):
        nex[i], pre[i] = keys[i].nex, keys[i + 1].pre
    parts = width // 3
    nothing = np.zeros((1, width))
    points = np.stack([np.vstack([nothing, pre]), key, np.vstack([nex, nothing])], axis=1)
    points = points.reshape(len(keys), 3, parts, 3)

    off = np.maximum(np.abs(nex - lines[0]), np.abs(pre - lines[1]))
    off = off.reshape(-1, parts, 3).max(axis=2)
    size = np.maximum(np.abs(key[:-1]), np.abs(key[1:])).reshape(-1, parts, 3).max(axis=2)
    bent = off > STRAIGHT * np.maximum(1.0, size)
    changed = (np.diff(key, axis=0) != 0.0).reshape(-1, parts, 3).any(axis=2)
    never, always = np.zeros((1, parts), bool), np.ones((1, parts), bool)
    if width > 9:
        always[0, 3] = tuple(key[0, 9:]) != NO_SCALE
    is_told = np.stack(
        [np.vstack([never, bent]), np.vstack([always, changed]), np.vstack([bent, never])], axis=1
    )
    return points, is_told
