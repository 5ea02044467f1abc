"""EXR files as slo-rt writes them, and how their light is shown."""

import struct

import numpy as np


def read_exr(path):
    """Returns red, green and blue [row, column, channel] of a file as slo-rt writes it: RLE, floats."""
    data = path.read_bytes()
    place, header = 8, {}
    while data[place]:
        name, kind, rest = (
            data[place:].split(b"\0", 2) if place + 200 > len(data) else data[place : place + 200].split(b"\0", 2)
        )
        place += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<I", data, place)
        header[name.decode()] = data[place + 4 : place + 4 + size]
        place += 4 + size
    if header["compression"] != b"\1":
        raise ValueError(f"{path} is not compressed by RLE")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    offsets = struct.unpack_from(f"<{height}Q", data, place + 1)
    picture = np.empty((height, width, 3), np.float32)
    for offset in offsets:
        y, size = struct.unpack_from("<ii", data, offset)
        raw = data[offset + 8 : offset + 8 + size]
        if size < 12 * width:
            raw = unpacked(raw)
        planes = np.frombuffer(raw, "<f4").reshape(3, width)  # blue, green, red
        picture[y - y0] = planes[::-1].T
    return picture.astype(float)


def unpacked(packed):
    out, i = bytearray(), 0
    while i < len(packed):
        count = packed[i] - 256 if packed[i] > 127 else packed[i]
        if count < 0:
            out += packed[i + 1 : i + 1 - count]
            i += 1 - count
        else:
            out += packed[i + 1 : i + 2] * (count + 1)
            i += 2
    steps = np.frombuffer(bytes(out), np.uint8).astype(np.int64)
    steps[1:] -= 128
    values = np.cumsum(steps).astype(np.uint8)
    half = (len(values) + 1) // 2
    mixed = np.empty_like(values)
    mixed[0::2], mixed[1::2] = values[:half], values[half:]
    return mixed.tobytes()


def shown(picture):
    linear = np.clip(picture, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
