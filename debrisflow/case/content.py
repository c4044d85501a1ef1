"""What a case consists of, its files among it, as one number by which results are traced to it."""

from __future__ import annotations

import json
import tomllib
from hashlib import file_digest, sha256
from pathlib import Path
from typing import Any

from debrisflow.case.loading import dump_case
from debrisflow.case.resolved import ResolvedCase
from debrisflow.errors import CaseError

FILES = ("dem", "file", "raster")
"""Fields of a resolved case that name files; hydrographs, motions and lines are written into it."""


def digest_of_content(case: ResolvedCase) -> str:
    """Return the SHA-256 of a case with that of each file in the place of its name.

    The same case in another folder has the same one; with another DEM, raster, mesh or file of
    polygons it has another one.  A ``.prj`` or ``.dbf`` beside a file does not count.

    Raises
    ------
    CaseError
        If a file cannot be read.
    """
    content = _with_content(tomllib.loads(dump_case(case)))
    return sha256(json.dumps(content).encode()).hexdigest()


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
        with file.open("rb") as content:
            return file_digest(content, "sha256").hexdigest()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise CaseError(f"{file} cannot be read: {reason}") from error
