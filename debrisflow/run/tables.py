"""Time series as CSV files: comments, a line of column names, rows; writing and reading."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.errors import OutputError, shown, steers
from debrisflow.run.atomic import replaced
from debrisflow.run.reading import text_of
from debrisflow.run.refusals import refused, removed

Row = Sequence[float | int | str]
Table = dict[str, NDArray[np.float64]]


def write_table(
    path: Path, columns: Sequence[str], head: Sequence[str], rows: Iterable[Row]
) -> None:
    """Write a whole table: its head as comments, the names of its columns, its rows.

    The first column, the time, is written with all digits, so that it can be compared exactly; the
    others have nine digits.
    """
    with replaced(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {line}\n" for line in head)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(_printed(row) for row in rows)


def rows_where(table: Table, chosen: NDArray[np.bool_]) -> Table:
    """Return some rows of a table."""
    return {name: values[chosen] for name, values in table.items()}


def read_table(path: Path, grows: bool = True, needed: Iterable[str] = ()) -> Table:
    """Return the columns of a table of numbers, (rows,) float64 arrays by their names.

    Parameters
    ----------
    path : Path
    grows : bool
        A last line without a line end is still being written, and is left out.
    needed : iterable of str
        Names of columns that the file must have.

    Raises
    ------
    OutputError
        If the file is missing or lacks a column, or if a row is not numbers or not as long as the
        line of names.
    """
    text = text_of(path)
    whole = text[: text.rfind("\n") + 1 if grows else None].splitlines()
    lines = [line for line in whole if line.strip() and not line.startswith("#")]
    if not lines:
        raise OutputError(f"{path} is damaged: it names no columns")
    names = [name.strip() for name in lines[0].split(",")]
    if twice := [name for k, name in enumerate(names) if name in names[:k]]:
        raise OutputError(f"{path} is damaged: it has two columns {shown(twice[0])}")
    if not all(names) or any(map(steers, names)):
        raise OutputError(f"{path} is damaged: its columns have no names of their own")
    if missing := [name for name in needed if name not in names]:
        raise OutputError(f"{path} has no column {missing[0]}, but {', '.join(names)}")
    if not lines[1:]:
        return {name: np.empty(0) for name in names}
    try:
        rows = np.loadtxt(lines[1:], delimiter=",", ndmin=2)
        return dict(zip(names, rows.T.copy(), strict=True))
    except ValueError as error:
        wanted = (
            "rows are numbers, as many as there are names, with commas between them, and nan where "
            "there is none"
        )
        raise OutputError(f"{path} is damaged: {str(error).rstrip('.')}; {wanted}") from error


class Series:
    """A table to which rows are added during a run, also after an interruption.

    Parameters
    ----------
    path : Path
        A file that is there already is continued.
    columns : sequence of str
        Names of the columns; the first is the time.
    head : sequence of str
        Lines that explain the columns, written as comments.
    """

    def __init__(self, path: Path, columns: Sequence[str], head: Sequence[str]) -> None:
        self.path = path
        self.columns = tuple(columns)
        self.head = tuple(head)
        if not path.exists():
            write_table(path, columns, head, [])
        self._open()

    def append(self, rows: Iterable[Row]) -> None:
        """Write rows; who reads the file sees them when this returns.

        Raises
        ------
        OutputError
            If the operating system refuses, or the file was removed.
        """
        with self._told():
            self._writer.writerows(_printed(row) for row in rows)
            self._file.flush()

    def flush(self) -> None:
        """Bring what was written to the disk, where it survives a loss of power."""
        with self._told():
            os.fsync(self._file.fileno())

    def truncate_after(self, time: float) -> None:
        """Remove the rows later than a time, s, and a last row without its line end.

        Raises
        ------
        OutputError
            If the file has other columns, or rows that are no rows of it.
        """
        self.close()
        try:
            text = self.path.read_text(encoding="utf-8")
            rows = csv.reader(text[: text.rfind("\n") + 1].splitlines())
            lines = [line for line in rows if line and not line[0].startswith("#")]
            if not lines or tuple(lines[0]) != self.columns:
                raise OutputError(f"{self.path} has other columns than {', '.join(self.columns)}")
            kept = [line for line in lines[1:] if float(line[0]) <= time]
        except (OSError, ValueError, csv.Error) as error:
            raise OutputError(f"{self.path} is damaged: {error}") from error
        if any(len(line) != len(self.columns) for line in kept):
            raise OutputError(f"{self.path} is damaged: a row has too few or too many columns")
        write_table(self.path, self.columns, self.head, kept)
        self._open()

    def close(self) -> None:
        """Close the file."""
        with suppress(OSError):  # of rows that could not be written, as was told then
            self._file.close()

    def _open(self) -> None:
        try:
            self._file = self.path.open("a", newline="", encoding="utf-8")
        except OSError as error:
            raise refused(self.path, error) from error
        self._writer = csv.writer(self._file, lineterminator="\n")

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Tell in plain words why the file cannot be written, also one removed while it is open."""
        try:
            if not os.path.samestat(os.fstat(self._file.fileno()), self.path.stat()):
                raise removed(self.path)
            yield
        except FileNotFoundError as error:
            raise removed(self.path) from error
        except OSError as error:
            raise refused(self.path, error) from error


def _printed(row: Row) -> list[str]:
    first, *others = row
    time = first if isinstance(first, str) else repr(float(first))
    return [time, *(f"{v:.9g}" if isinstance(v, float) else str(v) for v in others)]
