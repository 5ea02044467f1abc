"""Candles and their flames."""

from lathe import Profile, lathe

RADIUS = 1.2
HEIGHTS = {"low": 4.6, "middle": 6.4, "tall": 8.8}
DIP = .34
"""Depth of the molten cup around the wick."""


def candle(height):
    """A candle on z = 0; v is near 1 at its top and falls by 1 over 9 cm."""
    r, h = RADIUS, height
    p = Profile(0, 0).line(r, 0).line(r, h, .14).line(r - .26, h, .10).line(r - .36, h - .16)
    p.curve(r - .5, h - DIP * .9, .5, h - DIP, 0, h - DIP, 6)
    return lathe(p, 48).map_uv(lambda q: (.5, .995 - (h - q[2]) / 9.0))


def flame(height=2.5):
    """A flame in still air, on z = 0; v runs along it."""
    h = height
    p = Profile(0, 0).curve(.26, 0, .42, .16 * h, .40, .30 * h, 8)
    p.curve(.37, .52 * h, .13, .72 * h, 0, h, 10)
    return lathe(p, 32).map_uv(lambda q: (.5, .01 + .98 * q[2] / h))


def build():
    for name, height in HEIGHTS.items():
        candle(height).write("candle_" + name)
    flame().write("flame")
