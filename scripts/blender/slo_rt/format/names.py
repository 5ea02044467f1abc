# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that the scene language and file systems accept."""

import re

# White space and braces end a name in the scene language; the others are refused by file systems.
_UNFIT = re.compile(r"[\s\u00a0\x00-\x1f{}/\\:*?\"<>|]+")
_RESERVED = {"con", "prn", "aux", "nul"} | {f"{n}{i}" for n in ("com", "lpt") for i in range(1, 10)}


def plain(name):
    """`name` as one word that can stand in a scene and as a file: `Cube 1/2` becomes `Cube_1_2`."""
    word = _UNFIT.sub("_", name).lstrip("#").rstrip(".")[:80]
    return f"{word}_" if word.lower() in _RESERVED else word or "unnamed"


class Names:
    """Hands out names that differ from each other, capitals not counted."""

    def __init__(self):
        self._taken = set()

    def new(self, wish):
        """A name like `wish` that was not handed out before."""
        base = plain(wish)
        name, count = base, 1
        while name.casefold() in self._taken:
            count += 1
            name = f"{base}_{count}"
        self._taken.add(name.casefold())
        return name
