"""Words that messages about a case share."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

ABSENT = object()  # in place of a value that is not there


def either(choices: Iterable[str]) -> str:
    """Return ``'a', 'b' or 'c'``."""
    *first, last = (f"'{choice}'" for choice in choices)
    return f"{', '.join(first)} or {last}" if first else last


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """Return ``; did you mean '…'?`` for the known word that is nearest, or nothing."""
    others = [name for name in known if name != word]
    near = get_close_matches(str(word).lower(), others, n=1, cutoff=0.6)
    return f"; did you mean '{near[0]}'?" if near else ""
