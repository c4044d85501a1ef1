"""A file of scenarios: a CSV table of values of the parameters, one member a row."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from io import StringIO
from math import isclose, isfinite
from pathlib import Path

from debrisflow.case.words import did_you_mean, either
from debrisflow.errors import CaseError
from debrisflow.files import text_of
from debrisflow.study.distributions import AnyParameter, Choice, Continuous, Value, Values

LABEL = "scenario"  # a column for the reader of the file


def read_scenarios(path: Path, parameters: Sequence[AnyParameter]) -> list[Values]:
    """Return the values of each row.

    The first line names the columns: every parameter, in any order, and ``scenario``, which is
    for people only, if wanted.  Empty lines and those that start with ``#`` are left out.

    Parameters
    ----------
    path : Path
    parameters : sequence of AnyParameter

    Raises
    ------
    CaseError
        At the first thing that is wrong with the file, with its line and column.
    """
    lines = _lines(path)
    if not lines:
        raise CaseError(f"{path}: is empty; its first line must name the parameters")
    header = [name.strip() for name in lines[0][1]]
    _expect_columns(path, header, [parameter.name for parameter in parameters])
    if not lines[1:]:
        raise CaseError(f"{path}: has no rows below its header")
    points = []
    for number, row in lines[1:]:
        if len(row) != len(header):
            raise CaseError(
                f"{path}: line {number}: has {len(row)} values, but the header has {len(header)}"
            )
        cells = dict(zip(header, map(str.strip, row), strict=True))
        points.append(_point(parameters, cells, f"{path}: line {number}"))
    return points


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Return the number and the cells of each line that holds any."""
    try:
        reader = csv.reader(StringIO(text_of(path), newline=""))
        return [
            (reader.line_num, row)
            for row in reader
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")
        ]
    except OSError as error:
        raise CaseError(f"{path}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise CaseError(f"{path}: is not a text file in UTF-8") from error
    except csv.Error as error:
        raise CaseError(f"{path}: {error}") from error


def _expect_columns(path: Path, header: Sequence[str], names: Sequence[str]) -> None:
    for name in names:
        if name not in header:
            raise CaseError(f"{path}: has no column '{name}', but each parameter needs one")
    for name in header:
        if header.count(name) > 1:
            raise CaseError(f"{path}: has two columns '{name}'")
        if name not in names and name != LABEL:
            raise CaseError(
                f"{path}: column '{name}': no parameter has this name, and only '{LABEL}' may hold "
                f"words for the reader{did_you_mean(name, names)}"
            )


def _point(parameters: Sequence[AnyParameter], cells: dict[str, str], where: str) -> Values:
    values: Values = {}
    for one in parameters:
        read: Callable[..., Value] = _chosen if isinstance(one, Choice) else _number
        try:
            values[one.name] = read(one, cells[one.name])
        except ValueError as error:
            raise CaseError(f"{where}, column '{one.name}': {error}") from error
    return values


def _chosen(parameter: Choice, text: str) -> Value:
    """Return the value of a choice that a cell names."""
    for value in parameter.values:
        if text == value or (isinstance(value, float) and _as_number(text) == value):
            return value
    known = [value if isinstance(value, str) else f"{value:g}" for value in parameter.values]
    raise ValueError(f"must be {either(known)}, not '{text}'{did_you_mean(text, known)}")


def _number(parameter: Continuous, text: str) -> float:
    """Return a number within the bounds of its distribution."""
    value = _as_number(text)
    if value is None:
        raise ValueError(f"'{text}' is not a number")
    low, high = parameter.law.support()
    if not isclose(value, min(max(value, low), high), abs_tol=1e-12):
        raise ValueError(
            f"{value:g} is not within the bounds of its distribution, {low:g} to {high:g}"
        )
    return value


def _as_number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if isfinite(value) else None
