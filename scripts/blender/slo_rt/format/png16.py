# SPDX-License-Identifier: GPL-3.0-or-later
"""PNG files of 16 bits a channel."""

import os
import struct
import zlib

import numpy as np


def levels(values):
    """Converts values in [0, 1] to 16-bit levels; values outside are clamped."""
    return np.rint(np.clip(values, 0.0, 1.0) * 65535.0).astype(">u2")


def write(path, pixels):
    """Writes an image, whole or not at all.

    `pixels` has shape (height, width, 3), the top row first, and holds `levels`, which are stored
    unchanged.
    """
    height, width, _ = pixels.shape
    values = np.ascontiguousarray(pixels, ">u2")
    rows = np.zeros((height, 1 + 6 * width), np.uint8)  # each row starts with its filter: none
    rows[:, 1:] = values.view(np.uint8).reshape(height, 6 * width)
    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
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
