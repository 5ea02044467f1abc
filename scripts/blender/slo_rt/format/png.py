# SPDX-License-Identifier: GPL-3.0-or-later
"""PNG files of 8 or 16 bits a channel."""

import os
import struct
import zlib

import numpy as np

_COLOR_TYPES = {3: 2, 4: 6}  # by the number of channels


def levels(values):
    """Converts values in [0, 1] to 16-bit levels; values outside are clamped."""
    return np.rint(np.clip(values, 0.0, 1.0) * 65535.0).astype(">u2")


def write(path, pixels):
    """Writes an image, whole or not at all.

    `pixels` has shape (height, width, 3 or 4), the top row first. It holds bytes, or `levels`, which
    are stored unchanged.
    """
    height, width, channels = pixels.shape
    values = np.ascontiguousarray(pixels, "u1" if pixels.dtype == np.uint8 else ">u2")
    bits, length = 8 * values.itemsize, channels * width * values.itemsize
    rows = np.zeros((height, 1 + length), np.uint8)  # each row starts with its filter: none
    rows[:, 1:] = values.view(np.uint8).reshape(height, length)
    header = struct.pack(">IIBBBBB", width, height, bits, _COLOR_TYPES[channels], 0, 0, 0)
    partial = f"{path}.part"
    with open(partial, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in (
            (b"IHDR", header),
            (b"IDAT", zlib.compress(rows, 1)),
            (b"IEND", b""),
        ):
            file.write(struct.pack(">I", len(data)) + kind + data)
            file.write(struct.pack(">I", zlib.crc32(kind + data)))
    os.replace(partial, path)
