"""A hydrograph from a CSV file, put into the case as a table so that the case stands alone."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from math import isfinite
from pathlib import Path

from debrisflow.case.problems import Problem
from debrisflow.case.tables import Hydrograph

KEY = "inflow.hydrograph"
COLUMNS = tuple(Hydrograph.model_fields)


class UnreadableHydrographError(ValueError):
    """The first thing that is wrong with a hydrograph file."""


def inline_hydrograph(data: dict[str, object], folder: Path) -> list[Problem]:
    """Replace the name of a hydrograph file by its contents.

    Parameters
    ----------
    data : dict
        The case as read from TOML; changed in place.
    folder : Path
        Folder of the case file, in which the name is looked up.

    Returns
    -------
    list of Problem
        What kept the file from being read; then the name stays where it was.
    """
    inflow = data.get("inflow")
    name = inflow.get("hydrograph") if isinstance(inflow, dict) else None
    if not isinstance(inflow, dict) or not isinstance(name, str):
        return []
    try:
        inflow["hydrograph"] = read_hydrograph(folder / name)
    except OSError as error:
        return [Problem(KEY, f"cannot be read: {(error.strerror or str(error)).lower()}", name)]
    except (UnreadableHydrographError, UnicodeDecodeError, csv.Error) as error:
        return [Problem(KEY, str(error), name)]
    return []


def read_hydrograph(path: Path) -> dict[str, list[float]]:
    """Return the columns time, discharge and concentration of a CSV file.

    The first line names the columns, in any order; others are ignored, and so are empty lines
    and those that start with ``#``.
    """
    with path.open(newline="", encoding="utf-8-sig") as file:
        lines = list(_rows(file))
    header = [name.strip() for name in lines[0][1]] if lines else []
    for name in COLUMNS:
        if name not in header:
            found = f", only {', '.join(header)}" if header else ""
            raise UnreadableHydrographError(f"has no column '{name}'{found}")
    place = {name: header.index(name) for name in COLUMNS}
    columns: dict[str, list[float]] = {name: [] for name in COLUMNS}
    for number, row in lines[1:]:
        for name in COLUMNS:
            columns[name].append(_number(row, place[name], f"line {number}, column '{name}'"))
        times = columns["time"]
        if len(times) > 1 and times[-1] <= times[-2]:
            message = f"line {number}: time {times[-1]:g} s is not later than the one before"
            raise UnreadableHydrographError(message)
    if not columns["time"]:
        raise UnreadableHydrographError("has no rows")
    return columns


def _rows(file: Iterable[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the cells of each line that holds any."""
    reader = csv.reader(file)
    for row in reader:
        if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#"):
            yield reader.line_num, row


def _number(row: list[str], column: int, where: str) -> float:
    """Return a cell as a finite number."""
    text = row[column].strip() if column < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise UnreadableHydrographError(f"{where}: '{text}' is not a number")
    return value
