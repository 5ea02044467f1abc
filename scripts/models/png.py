"""An RGB PNG writer, of 8 or 16 bits a channel.

It needs no library, so that the models need only Python, and because Pillow cannot write 16 bits of RGB.
"""

import os
import struct
import zlib

from mesh import ROOT


def write(name, width, height, pixel, bits=8):
    """Write textures/NAME.png; pixel(x, y) is an (r, g, b) in [0, 1], row 0 on top."""
    size, top = bits // 8, (1 << bits) - 1
    rows = bytearray()
    previous = bytearray(3 * size * width)
    for y in range(height):
        row = bytearray()
        for x in range(width):
            for c in pixel(x, y):
                row += min(max(int(c * top + .5), 0), top).to_bytes(size, "big")
        rows += b"\x02" + bytes((a - b) & 255 for a, b in zip(row, previous))
        previous = row
    path = os.path.join(ROOT, "textures", name + ".png")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    header = struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n")
        for kind, data in ((b"IHDR", header), (b"IDAT", zlib.compress(bytes(rows), 9)),
                           (b"IEND", b"")):
            file.write(struct.pack(">I", len(data)) + kind + data)
            file.write(struct.pack(">I", zlib.crc32(kind + data)))
    print("textures/%s.png: %dx%d, %d KB" % (name, width, height, os.path.getsize(path) // 1024))
