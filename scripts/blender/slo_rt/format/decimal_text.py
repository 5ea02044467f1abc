# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts numbers to text: single numbers for people, millions of numbers for meshes."""

import math

import numpy as np

ROWS_AT_ONCE = 1 << 14  # rows that stay in the cache


def number(value):
    """Returns the text of one number: as short as single precision allows, nine digits if that is not
    enough.

    Whole numbers stay whole. Never exponents with a comma, never negative zero.

    # Errors `ValueError` for infinity and NaN.
    """
    if isinstance(value, (bool, int, np.integer)):
        return str(int(value))
    value = float(value)
    if not math.isfinite(value):
        raise ValueError(f"{value} is not a finite number")
    short = f"{value:.7g}"
    text = short if abs(float(short) - value) <= 6e-8 * abs(value) else f"{value:.9g}"
    return "0" if float(text) == 0.0 else text


def vector(values):
    """Text of a vector: `{ x y z }`."""
    return "{ " + " ".join(number(value) for value in values) + " }"


def vectors(values):
    """Texts of the rows of an array (n, 3), as `vector` of each."""
    values = np.asarray(values, np.float64)
    if not np.isfinite(values).all():
        raise ValueError("a number of a vector is not finite")
    short = _significant(values, 7)
    fits = np.abs(short - values) <= 6e-8 * np.abs(values)
    words = [
        word[:-2] if word.endswith(".0") else word
        for word in map(repr, np.where(fits, short, _significant(values, 9)).ravel().tolist())
    ]
    triples = iter(words)
    return [f"{{ {x} {y} {z} }}" for x, y, z in zip(triples, triples, triples)]


def _significant(values, digits):
    """Rounds numbers to a number of significant digits, to the nearest; never -0."""
    size = np.abs(values)
    decimals = digits - 1 - np.floor(np.log10(np.where(size > 0.0, size, 1.0)))
    scale = 10.0 ** np.clip(np.abs(decimals), 0, 300)
    rounded = np.where(
        decimals < 0, np.rint(values / scale) * scale, np.rint(values * scale) / scale
    )
    return rounded + 0.0


def integer_lines(values):
    """Rows of an array of integers (0 or more, shape (n, k)) as text, yielded in pieces of
    bytes."""
    for rows in _pieces(values):
        yield _digits_to_text(rows, 0)


def decimal_lines(values, digits):
    """Rows of an array of numbers (shape (n, k)) as text, yielded in pieces of bytes.

    All numbers are rounded to the same decimal place: the one that gives the largest of them
    `digits` significant digits. Trailing zeros are left out.
    """
    largest = float(np.abs(values).max()) if values.size else 0.0
    before_point = max(0, int(np.floor(np.log10(largest))) + 1) if largest > 0.0 else 0
    small = largest > 0.0 and largest < 1.0
    leading_zeros = max(0, -int(np.floor(np.log10(largest))) - 1) if small else 0
    decimals = max(0, min(digits + leading_zeros, 40) - before_point)
    if largest * 10.0**decimals >= 2.0**63 or not np.isfinite(largest):
        for rows in _pieces(values):
            yield _general_text(rows)
        return
    for rows in _pieces(values):
        scaled = np.rint(rows.astype(np.float64) * 10.0**decimals).astype(np.int64)
        yield _digits_to_text(scaled, decimals)


def _pieces(values):
    for start in range(0, len(values), ROWS_AT_ONCE):
        yield values[start : start + ROWS_AT_ONCE]


def _general_text(rows):
    line = " ".join(["%.9g"] * rows.shape[1]) + "\n"
    return ((line * len(rows)) % tuple(rows.ravel().tolist())).encode()


def _digits_to_text(rows, decimals):
    """Text of integers with a decimal point before the last `decimals` digits."""
    count, columns = rows.shape
    if count == 0:
        return b""
    flat = rows.reshape(-1)
    negative = flat < 0
    rest = np.abs(flat)
    largest = int(rest.max())
    rest = rest.astype(np.uint32 if largest < 2**32 else np.uint64)
    width = max(len(str(largest)), decimals + 1)
    whole = width - decimals

    # One row of characters per number: sign, whole part, point, decimals, separator.
    point = 1 if decimals else 0
    text = np.empty((flat.size, 1 + width + point + 1), np.uint8)
    keep = np.ones(text.shape, bool)
    text[:, 0] = ord("-")
    keep[:, 0] = negative
    places = [1 + k if k < whole else 1 + point + k for k in range(width)]
    for place in reversed(places):
        quotient = rest // 10
        text[:, place] = rest - quotient * 10 + ord("0")
        rest = quotient
    if point:
        text[:, 1 + whole] = ord(".")
    text[:, -1] = ord(" ")
    text[columns - 1 :: columns, -1] = ord("\n")

    _drop_zeros(text, keep, places[: whole - 1])
    if point:
        _drop_zeros(text, keep, list(reversed(places[whole:])))
        keep[:, 1 + whole] = keep[:, 2 + whole]
    return text[keep].tobytes()


def _drop_zeros(text, keep, places):
    """Marks zeros as unwanted, along `places` up to the first other digit."""
    leading = np.ones(len(text), bool)
    for place in places:
        leading &= text[:, place] == ord("0")
        keep[:, place] = ~leading
