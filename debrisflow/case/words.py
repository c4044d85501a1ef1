"""Words that messages about a case share."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher

ABSENT = object()  # in place of a value that is not there
MAP = 1.0e5  # m, from which on a coordinate is one of a map
NEAR = 0.75  # likeness of two words from which on one may be the other mistyped
LONGEST_WORD = 80  # that is compared with others
NEAR_IN_PART = 0.6  # of two that share a word between underscores: grain_size, grain_diameter


def either(choices: Iterable[str]) -> str:
    """Return ``'a', 'b' or 'c'``."""
    *first, last = (f"'{choice}'" for choice in choices)
    return f"{', '.join(first)} or {last}" if first else last


def place(value: float) -> str:
    """Return a coordinate, m, with six digits, or to a millimeter if it is one of a map.

    Examples
    --------
    >>> place(0.1 + 0.2), place(4000040.25)
    ('0.3', '4000040.25')
    """
    return f"{value:.6g}" if abs(value) < MAP else f"{value:.3f}".rstrip("0").rstrip(".")


def format_extent(box: tuple[float, ...]) -> str:
    """Return the extents of a box on a map, west, south, east, north, m, as in a case file.

    Examples
    --------
    >>> format_extent((500000.0, 4000000.0, 500200.0, 4000120.5))
    'x = [500000, 500200], y = [4000000, 4000120.5] m'
    """
    west, south, east, north = map(place, box)
    return f"x = [{west}, {east}], y = [{south}, {north}] m"


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return ``; did you mean '…'?`` for the known word that is nearest, or nothing.

    Examples
    --------
    >>> did_you_mean("grain_size", ["grain_diameter", "restitution"])
    "; did you mean 'grain_diameter'?"
    >>> did_you_mean("stop", ["slope", "vector"])
    ''
    """
    near = nearest(word, known)
    return f"; did you mean '{near}'?" if near else ""


def nearest(word: object, known: Iterable[str], in_part: float = NEAR_IN_PART) -> str | None:
    """Return the known word that is nearest to one, None if none is near.

    Parameters
    ----------
    word : object
    known : iterable of str
    in_part : float
        Likeness from which on words are near that share one between underscores.
    """
    text = str(word).lower()
    if len(text) > LONGEST_WORD:
        return None
    parts, found = set(text.split("_")), []
    for name in known:
        likeness = SequenceMatcher(None, name, text).ratio()
        if likeness >= (in_part if parts & set(name.split("_")) else NEAR) and name != word:
            found.append((likeness, name))
    return max(found)[1] if found else None
