"""Pictures and tables that analyses of a study have written, as its page shows them."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path
from typing import NamedTuple
from urllib.parse import quote

from debrisflow.errors import OutputError
from debrisflow.results.html import Picture, is_picture, picture_of
from debrisflow.run.reading import text_of
from debrisflow.study.names import FINDINGS

MOST_ROWS = 60  # of a table that is shown on the page
FIRST = ("tornado", "summary", "extents", "posterior")  # what answers, before what it comes from
STYLES = (".qml",)  # of rasters beside them


class Link(NamedTuple):
    """A file or folder, by its address relative to the page."""

    name: str
    address: str


class Table(NamedTuple):
    """A table as text.

    Attributes
    ----------
    link : Link
        To its file.
    notes : list of str
        The comments at its head; none if they are those of the table before.
    columns : list of str
    rows : list of list of str
        None where there are too many to be shown.
    length : int
        How many there are.
    """

    link: Link
    notes: list[str]
    columns: list[str]
    rows: list[list[str]]
    length: int


class Attachments(NamedTuple):
    """What a folder holds for the page.

    Attributes
    ----------
    pictures : list of Picture
    tables : list of Table
    sentences : list of str
        What was found, in words.
    links : list of Link
        To files that the page does not carry, as rasters.
    problems : list of str
        Files that cannot be read, and why.
    """

    pictures: list[Picture]
    tables: list[Table]
    sentences: list[str]
    links: list[Link]
    problems: list[str]

    def __bool__(self) -> bool:
        """Return whether there is anything."""
        return any(self)


def attachments(files: Iterable[Path], folder: Path, subjects: Sequence[str] = ()) -> Attachments:
    """Return pictures, tables and other files for a page.

    Parameters
    ----------
    files : iterable of Path
    folder : Path
        Of the page.
    subjects : sequence of str
        With which names of files begin, in the order in which these are shown.
    """
    before: list[str] = []
    found = Attachments([], [], [], [], [])
    for file in _in_order(files, subjects):
        link = Link(file.name, address(file, folder))
        if file.suffix == ".png" and is_picture(file):
            name = file.stem.replace("_", " ")
            found.pictures.append(picture_of(file, name, name))
        elif file.suffix == ".csv":
            try:
                table = table_of(text_of(file), link)
                same = table.notes == before
                found.tables.append(table._replace(notes=[]) if same else table)
                before = table.notes
            except (OutputError, csv.Error) as error:
                found.problems.append(f"{link.name} cannot be read: {error}")
        elif file.name == FINDINGS:
            found.sentences.extend(text_of(file).splitlines())
        else:
            found.links.append(link)
    return found


def _in_order(files: Iterable[Path], subjects: Sequence[str]) -> list[Path]:
    """Return the files that the page shows or links, in the order in which it does."""

    def place(file: Path) -> tuple[int, int, str]:
        own = max((one for one in subjects if file.stem.startswith(one)), key=len, default=None)
        number = len(subjects) if own is None else subjects.index(own)
        kinds = [k for k, kind in enumerate(FIRST) if file.stem.endswith(kind)]
        return number, min(kinds, default=len(FIRST)), file.name

    shown = [file for file in files if file.is_file() and file.suffix not in STYLES]
    return sorted(shown, key=place)


def address(file: Path, folder: Path) -> str:
    """Return how a page in a folder links to a file or folder: relative, where that is possible.

    Examples
    --------
    >>> address(Path("runs/a/members/0f"), Path("runs/a")), address(Path("b/x y"), Path("a"))
    ('members/0f', '../b/x%20y')
    """
    try:
        return quote(Path(os.path.relpath(file, folder)).as_posix())
    except ValueError:  # on another drive
        return file.absolute().as_uri()


def table_of(text: str, link: Link) -> Table:
    r"""Return a table, in the form of all tables of runs, from its text.

    Examples
    --------
    >>> table_of("# of what\nname,value\nmu,0.123456789\n", Link("a", "a.csv"))[1:]
    (['of what'], ['name', 'value'], [['mu', '0.1235']], 1)
    """
    lines = text.splitlines()
    notes = [line.removeprefix("#").strip() for line in lines if line.startswith("#")]
    rest = "\n".join(line for line in lines if not line.startswith("#"))
    columns, *rows = list(csv.reader(StringIO(rest))) or [[]]
    shown = [[_shortened(cell) for cell in row] for row in rows if len(rows) <= MOST_ROWS]
    return Table(link, notes, columns, shown, len(rows))


def _shortened(cell: str) -> str:
    """Return a cell for people: numbers of four digits, nothing for nan."""
    try:
        number = float(cell)
    except ValueError:
        return cell
    return "" if number != number else f"{number:.4g}"
