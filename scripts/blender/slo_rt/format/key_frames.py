# SPDX-License-Identifier: GPL-3.0-or-later
"""Key frames as text. What the scene language supplies by itself is left out."""

import numpy as np

from .scene_text import block, exact

PARTS = {"pivot": slice(0, 3), "up": slice(3, 6), "right": slice(6, 9)}
STRAIGHT = 1e-8  # how far a handle may lie from a straight line, in units of the largest number


def still(placement):
    """One key frame that places a thing: pivot, up, right (9,)."""
    return block("addKframe", [("time", 0), block("key", _parts(placement, PARTS))])


def moving(keys, frames_per_second):
    """`addKframe` blocks of `fit.motion.KeyFrame`s.

    A key says what has changed since the key before; a handle what does not lie on the straight line
    between two keys.
    """
    bent = [_bent(a, b) for a, b in zip(keys, keys[1:], strict=False)]
    blocks = []
    for i, key in enumerate(keys):
        changed = PARTS if i == 0 else _changed(keys[i - 1].key, key.key)
        body = [("time", exact(key.time / frames_per_second))]
        if i > 0 and bent[i - 1]:
            body.append(block("pre", _parts(key.pre, bent[i - 1])))
        if changed:
            body.append(block("key", _parts(key.key, changed)))
        if i < len(bent) and bent[i]:
            body.append(block("nex", _parts(key.nex, bent[i])))
        blocks.append(block("addKframe", body))
    return blocks


def _parts(placement, names):
    return [(name, placement[PARTS[name]]) for name in PARTS if name in names]


def _changed(before, after):
    return [name for name, part in PARTS.items() if not np.array_equal(before[part], after[part])]


def _bent(a, b):
    """Names of the parts that don't go straight and evenly from key frame `a` to `b`."""
    if a.nex is None or b.pre is None:
        return []
    step = (b.key - a.key) / 3.0
    off = np.maximum(np.abs(a.nex - (a.key + step)), np.abs(b.pre - (b.key - step)))
    size = np.maximum(np.abs(a.key), np.abs(b.key))
    return [
        n for n, part in PARTS.items() if off[part].max() > STRAIGHT * max(1.0, size[part].max())
    ]
