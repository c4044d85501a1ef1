"""What a case consists of, its files among it, as one number by which results are traced to it."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any

from debrisflow.case.loading import dump_case
from debrisflow.case.resolved import ResolvedCase
from debrisflow.errors import CaseError
from debrisflow.files import MOST_BINARY, opened

FILES = ("dem", "file", "raster")
"""Fields of a resolved case that name files; hydrographs, motions and lines are written into it."""


Content = dict[str, Any]


def content_of(case: ResolvedCase) -> Content:
    """Return the tables of a case with the SHA-256 of each file in the place of its name.

    A ``.prj`` or ``.dbf`` beside a file does not count.

    Raises
    ------
    CaseError
        If a file cannot be read.
    """
    content: Content = _with_content(tomllib.loads(dump_case(case)))
    return content


def digest_of(content: Content) -> str:
    """Return the SHA-256 of the content of a case.

    The same case in another folder has the same one; with another DEM, raster, mesh or file of
    polygons it has another one.
    """
    return sha256(json.dumps(content).encode()).hexdigest()


def changes(before: Content, now: Content) -> list[str]:
    """Return the values in which the contents of two cases differ, a line each.

    Examples
    --------
    >>> changes({"time": {"end": 2.0}}, {"time": {"end": 3.0}, "title": "x"})
    ['time.end: 2.0, now 3.0', 'title: not given, now x']
    """
    old, new = dict(_values(before, "")), dict(_values(now, ""))
    return [
        f"{key}: {_named(key, old)}, now {_named(key, new)}"
        for key in sorted(old.keys() | new.keys())
        if old.get(key) != new.get(key)
    ]


def _values(part: Any, key: str) -> Iterator[tuple[str, Any]]:
    """Yield the values within a part of a content by their dotted keys."""
    if isinstance(part, dict):
        entries = list(part.items())
    elif isinstance(part, list) and any(isinstance(entry, dict) for entry in part):
        entries = [(entry.get("name", number), entry) for number, entry in enumerate(part)]
    else:
        yield key, part
        return
    for name, entry in entries:
        yield from _values(entry, f"{key}.{name}" if key else str(name))


def _named(key: str, values: Mapping[str, Any]) -> str:
    if key not in values:
        return "not given"
    is_file = key.rpartition(".")[2] in FILES
    return f"a file with SHA-256 {values[key][:8]}..." if is_file else str(values[key])


def _with_content(part: Any) -> Any:
    """Return a part of a case with digests for names of files."""
    if isinstance(part, list):
        return [_with_content(entry) for entry in part]
    if not isinstance(part, dict):
        return part
    return {
        key: _digest(Path(value)) if key in FILES else _with_content(value)
        for key, value in part.items()
    }


def _digest(file: Path) -> str:
    try:
        with opened(file, MOST_BINARY) as content:
            return file_digest(content, "sha256").hexdigest()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise CaseError(f"{file} cannot be read: {reason}") from error
