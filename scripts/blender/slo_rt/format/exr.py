# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenEXR files, in full or half precision."""

import os
import struct
import zlib

import numpy as np

_MAGIC = struct.pack("<II", 20000630, 2)
_ZIP, _ROWS = 3, 16  # a compression, and how many rows it compresses at once
_TYPES = {2: 1, 4: 2}  # of pixels, by their size in bytes: half and float
_LARGEST_HALF = 65504.0


def write(path, pixels):
    """Writes an image, whole or not at all.

    `pixels` has shape (height, width, 3 or 4), the top row first, in single precision. They are stored
    in half precision if that loses nothing.
    """
    height, width, channels = pixels.shape
    values = np.ascontiguousarray(pixels, "<f4")
    if np.abs(values).max(initial=0.0) <= _LARGEST_HALF:
        short = values.astype("<f2")
        if np.array_equal(short.astype("<f4"), values):
            values = short
    # Channels are in the order of their names: alpha, blue, green, red.
    order = [3, 2, 1, 0] if channels == 4 else [2, 1, 0]
    planes = np.ascontiguousarray(values[..., order].transpose(0, 2, 1))
    blocks = [
        _compressed(planes[start : start + _ROWS].tobytes()) for start in range(0, height, _ROWS)
    ]
    header = _header(width, height, ["RGBA"[i] for i in order], _TYPES[values.itemsize])
    offset = len(header) + 8 * len(blocks)
    partial = f"{path}.part"
    with open(partial, "wb") as file:
        file.write(header)
        for data in blocks:
            file.write(struct.pack("<Q", offset))
            offset += 8 + len(data)
        for number, data in enumerate(blocks):
            file.write(struct.pack("<iI", number * _ROWS, len(data)) + data)
    os.replace(partial, path)


def _header(width, height, names, kind):
    channels = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", kind, 0, 1, 1) for name in names
    )
    box = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    attributes = [
        ("channels", "chlist", channels + b"\0"),
        ("compression", "compression", struct.pack("<B", _ZIP)),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
        ("screenWindowCenter", "v2f", struct.pack("<ff", 0.0, 0.0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
    ]
    body = b"".join(
        f"{name}\0{kind}\0".encode() + struct.pack("<i", len(data)) + data
        for name, kind, data in attributes
    )
    return _MAGIC + body + b"\0"


def _compressed(data):
    """Returns rows compressed as ZIP does it; as they are if that is not shorter."""
    raw = np.frombuffer(data, np.uint8)
    split = np.concatenate([raw[0::2], raw[1::2]])
    # Differences to the byte before, plus 128.
    steps = split.copy()
    steps[1:] = split[1:] - split[:-1] + np.uint8(128)
    packed = zlib.compress(steps, 1)
    return packed if len(packed) < len(data) else data
