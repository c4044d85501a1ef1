"""The files that analyses of a study have written, so that those of a former study can go."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path, PurePosixPath

from pydantic import TypeAdapter, ValidationError

from debrisflow.errors import OutputError
from debrisflow.run.atomic import replaced
from debrisflow.run.reading import text_of, within
from debrisflow.run.refusals import refused
from debrisflow.study.names import CALIBRATION, MAPS, SENSITIVITY, WRITTEN

OF_ANALYSES = (MAPS, SENSITIVITY, CALIBRATION, f"{CALIBRATION}/{MAPS}")
"""Folders from which files are removed, and from no others."""
_NAMES = TypeAdapter(list[str])


def remove_former(folder: Path, written: Sequence[Path], spared: str = "") -> list[str]:
    """Remove what former analyses have written and this one has not, and return warnings.

    Only files that the list in the folder names are removed, from folders of analyses only; what
    people have put there stays.

    Parameters
    ----------
    folder : Path
        Of the study.
    written : sequence of Path
        Files of this analysis.
    spared : str, optional
        Folder whose files are kept and remembered, since its analysis is still to come.

    Raises
    ------
    OutputError
        If the operating system refuses.
    """
    own = {file.relative_to(folder).as_posix() for file in written}
    warnings = []
    try:
        former = _former(folder)
    except OutputError as error:
        warnings = [f"{error}; files of a former study may lie beside those of this one"]
        former = []
    kept = [name for name in former if spared and name.startswith(f"{spared}/")]
    for name in former:
        if name not in own and name not in kept:
            _remove(folder, name)
    text = json.dumps(sorted(own.union(kept)), indent=1)
    with replaced(folder / WRITTEN) as unfinished:
        unfinished.write_text(text + "\n", encoding="utf-8")
    return warnings


def _former(folder: Path) -> list[str]:
    """Return the names of the files that former analyses have written and that may be removed."""
    file = folder / WRITTEN
    if not file.exists():
        return []
    try:
        names = _NAMES.validate_json(text_of(file))
    except ValidationError as error:
        raise OutputError(f"{file} is damaged") from error
    return [name for name in names if _is_of_analysis(folder, name)]


def _is_of_analysis(folder: Path, name: str) -> bool:
    """Return whether a name is that of a file, no link, in a folder of analyses, no link either."""
    place = PurePosixPath(name)
    if place.parent.as_posix() not in OF_ANALYSES:
        return False
    try:
        file = within(folder, name)
    except ValueError:
        return False
    links = [folder.joinpath(*place.parts[:k]).is_symlink() for k in range(1, len(place.parts) + 1)]
    return file.is_file() and not any(links)


def _remove(folder: Path, name: str) -> None:
    try:
        (folder / name).unlink(missing_ok=True)
    except OSError as error:
        raise refused(folder / name, error) from error
