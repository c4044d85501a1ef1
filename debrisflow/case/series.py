"""Series of numbers by time from a CSV file beside the case."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from io import StringIO
from math import isfinite
from pathlib import Path

from debrisflow.files import text_of

MOST_BYTES = 16_000_000  # half a million rows, which become part of the case


class UnreadableSeriesError(ValueError):
    """The first thing that is wrong with a file of a series."""


def read_series(
    path: Path, columns: Sequence[str], optional: Sequence[str] = ()
) -> dict[str, list[float]]:
    """Return columns of a CSV file, ``time`` among them, which increases.

    The first line names the columns, in any order; others are ignored, and so are empty lines
    and those that start with ``#``.

    Parameters
    ----------
    path : Path
    columns : sequence of str
        Those that the file must have.
    optional : sequence of str
        Those that it may have.

    Raises
    ------
    UnreadableSeriesError
        If there is something wrong with the contents of the file.
    OSError
        If the file cannot be read.
    """
    try:
        lines = list(_rows(StringIO(text_of(path, MOST_BYTES), newline="")))
    except UnicodeDecodeError as error:
        raise UnreadableSeriesError("is not a text file in UTF-8") from error
    except csv.Error as error:
        raise UnreadableSeriesError(str(error)) from error
    header = [name.strip() for name in lines[0][1]] if lines else []
    for name in columns:
        if name not in header:
            found = f", only {', '.join(header)}" if header else ""
            raise UnreadableSeriesError(f"has no column '{name}'{found}")
        if header.count(name) > 1:
            raise UnreadableSeriesError(f"has two columns '{name}'")
    place = {name: header.index(name) for name in (*columns, *optional) if name in header}
    series: dict[str, list[float]] = {name: [] for name in place}
    for number, row in lines[1:]:
        for name, column in place.items():
            series[name].append(_number(row, column, f"line {number}, column '{name}'"))
        times = series["time"]
        if len(times) > 1 and times[-1] <= times[-2]:
            message = f"line {number}: time {times[-1]:g} s is not later than the one before"
            raise UnreadableSeriesError(message)
    if not series["time"]:
        raise UnreadableSeriesError("has no rows")
    return series


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
        raise UnreadableSeriesError(f"{where}: '{text}' is not a number")
    return value
