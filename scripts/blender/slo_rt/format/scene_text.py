# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene text: elements and attributes in the three forms of the scene language."""

import math
from dataclasses import dataclass, field

from .decimal_text import number, vector

LINE_WIDTH = 110


@dataclass
class Element:
    """`kind name { body }`; without a kind, the block `name { body }`.

    The body is a list of `(keyword, value)` with numbers, names or vectors (tuples) as values, and
    of further elements.
    """

    kind: str
    name: str
    body: list = field(default_factory=list)


def block(name, body):
    """The block `name { body }`."""
    return Element("", name, body)


def exact(value):
    """Returns the shortest text of a number in double precision that can be read back without loss.

    Frame rates and times need this: if they were rounded differently, frames would cross the borders
    of camera segments, and later frames even more so.

    # Errors `ValueError` for infinity and NaN.
    """
    value = float(value) + 0.0
    if not math.isfinite(value):
        raise ValueError(f"{value} is not a finite number")
    return repr(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def write(elements, comments=()):
    """The text of a scene: `comments` as lines on top, then the elements.

    Elements of one line stand together. An empty line separates longer elements and changes of kind.

    # Errors `ValueError` that names the element with a number that is not finite.
    """
    lines = [f"# {comment}".rstrip() for comment in comments]
    previous, long_before = None, True
    for element in elements:
        try:
            text = _element(element, "")
        except ValueError as error:
            raise ValueError(f"{element.kind} {element.name}: {error}") from error
        is_long = len(text) > 1
        if lines and (is_long or long_before or element.kind != previous):
            lines.append("")
        lines += text
        previous, long_before = element.kind, is_long
    return "\n".join(lines) + "\n"


def _element(element, indent):
    head = f"{element.kind} {element.name}".strip()
    if not _is_deep(element):
        single = f"{indent}{head} {{ " + "  ".join(_inline(item) for item in element.body) + " }"
        if len(single) <= LINE_WIDTH and "\n" not in single:
            return [single]
    lines = [f"{indent}{head} {{"]
    for item in element.body:
        if isinstance(item, Element):
            lines += _element(item, indent + "    ")
        else:
            lines.append(f"{indent}    {_inline(item)}")
    return lines + [f"{indent}}}"]


def _is_deep(element):
    """Whether the element reads better over several lines: key frames and camera segments do."""
    nested = [item for item in element.body if isinstance(item, Element)]
    return len(nested) > 1 or any(item.kind for item in nested)


def _inline(item):
    if isinstance(item, Element):
        head = f"{item.kind} {item.name}".strip()
        return f"{head} {{ " + " ".join(_inline(inner) for inner in item.body) + " }"
    keyword, value = item
    if isinstance(value, str):
        return f"{keyword} {value}"
    return f"{keyword} {vector(value) if hasattr(value, '__len__') else number(value)}"
