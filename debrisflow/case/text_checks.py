"""Texts of a case: they are printed and logged, and so must be plain."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from debrisflow.case.problems import Problem, Problems
from debrisflow.errors import steers


def plain_texts(data: Mapping[str, Any]) -> Problems:
    """Yield the texts of a case, as read from TOML, that would steer a terminal or forge a log.

    The notes may have several lines, all others one.

    Examples
    --------
    >>> [problem.key for problem in plain_texts({"title": "a flume", "notes": chr(27) + "[2J"})]
    ['notes']
    """
    for key, value in _texts(data, ""):
        if steers(value) or (key != "notes" and len(value.splitlines()) > 1):
            yield Problem(key, "has control characters; write plain text", value)


def _texts(value: Any, place: str) -> Iterator[tuple[str, str]]:
    """Yield all texts in nested tables and lists with their keys."""
    if isinstance(value, str):
        yield place, value
        return
    parts: Iterable[tuple[Any, Any]] = ()
    if isinstance(value, Mapping):
        parts = value.items()
    elif isinstance(value, list):
        parts = enumerate(value)
    for key, part in parts:
        yield from _texts(part, f"{place}.{key}" if place else str(key))
