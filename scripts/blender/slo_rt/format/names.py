# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that the scene language and file systems accept."""

import re
import unicodedata

# White space and braces end a name in the scene language; file systems reject the others.
_UNSEEN = r"\s\u00a0\x00-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202f\ufeff\ud800-\udfff"
_UNFIT = re.compile(rf"[{_UNSEEN}{{}}/\\:*?\"<>|]+")
_RESERVED = {"con", "prn", "aux", "nul"} | {f"{n}{i}" for n in ("com", "lpt") for i in range(1, 10)}
_LONGEST = 120  # bytes; file systems take 255, of which endings and counts need some


def plain(name):
    """Returns `name` as a word for scenes and files: `Cube 1/2` becomes `Cube_1_2`."""
    word = _UNFIT.sub("_", unicodedata.normalize("NFC", name)).lstrip("#.")
    word = word.encode()[:_LONGEST].decode(errors="ignore").rstrip(".") or "unnamed"
    stem, dot, rest = word.partition(".")
    return f"{stem}_{dot}{rest}" if stem.lower() in _RESERVED else word


class Names:
    """Makes names that differ from each other, ignoring case."""

    def __init__(self):
        self._taken = set()
        self._counts = {}  # how often each wish occurred

    def new(self, wish):
        """Returns a name like `wish` that was not used before."""
        base = plain(wish)
        name, count = base, self._counts.get(base.casefold(), 1)
        while name.casefold() in self._taken:
            count += 1
            name = f"{base}_{count}"
        self._counts[base.casefold()] = count
        self._taken.add(name.casefold())
        return name
