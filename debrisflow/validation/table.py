"""The results as text for a terminal, and as a table for other programs."""

from __future__ import annotations

import csv
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path

from debrisflow.run.atomic import replaced
from debrisflow.validation.comparison import Comparison
from debrisflow.validation.result import LevelResult, Result, count
from debrisflow.validation.row import PERCENT, Row, Verdict, shown

TABLE = "table.csv"
COLUMNS = [
    "name",
    "level",
    "measure",
    "value",
    "unit",
    "expected",
    "low",
    "high",
    "verdict",
    "reason",
    "miss",
    "reference",
    "date",
    "version",
    "processor",
]
WIDTH = 100
INDENT = " " * 10


def level_lines(comparison: Comparison, found: LevelResult) -> Iterator[str]:
    """Yield the rows of one level of a comparison, with limits, reasons and verdicts."""
    yield f"{comparison.name}, {found.label} ({found.seconds:.0f} s): {comparison.title}"
    yield from _wrapped(f"reference: {comparison.reference}", "  ")
    if found.failure:
        yield from _wrapped(f"failed: {found.failure}", "  ")
    for row in found.rows:
        yield from row_lines(row)


def row_lines(row: Row) -> Iterator[str]:
    r"""Yield a row and, of a miss, why.

    Examples
    --------
    >>> from debrisflow.validation.row import at_most
    >>> print("\n".join(row_lines(at_most("rms of the front", 0.026, 0.04, "8 % apart", "%"))))
      within  rms of the front: 2.6 %; at most 4 %: 8 % apart
    """
    held = row.shown_limit()
    limit = f"; {held}: {row.reason}" if held else ""
    mark = "MISSED" if row.verdict is Verdict.MISSED else row.verdict.value
    yield from _wrapped(f"{row.measure}: {row.shown_value()}{limit}", f"  {mark:<8}", INDENT)
    if row.miss and row.verdict is Verdict.KNOWN:
        yield from _wrapped(f"why: {row.miss}", INDENT)
    if row.miss and row.verdict is Verdict.WITHIN:
        yield from _wrapped("elsewhere a miss, and within its limit here", INDENT)


def _wrapped(text: str, first: str, later: str | None = None) -> list[str]:
    later = " " * len(first) if later is None else later
    return textwrap.wrap(text, WIDTH, initial_indent=first, subsequent_indent=later)


def summary(results: Sequence[Result]) -> str:
    """Return how many rows are within their limits, missed and failed."""
    found = count(results)
    share = f" ({shown(found.within / found.held, PERCENT)})" if found.held else ""
    parts = [
        f"{found.within} of {found.held} rows within their limits{share}",
        f"{found.known} missed as the table discusses",
        f"{found.missed} missed unexpectedly",
        f"{found.conserved} of {found.conserved + found.not_conserved} checks of conservation hold",
        f"{found.whole} of {found.comparisons} comparisons without a miss",
    ]
    return ", ".join([*parts, f"{found.failures} not computed"] if found.failures else parts)


def write_table(folder: Path, results: Sequence[Result]) -> Path:
    """Write all rows as a CSV file and return it.

    Raises
    ------
    OutputError
        If the operating system refuses.
    """
    path = folder / TABLE
    with replaced(path) as unfinished, unfinished.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for result in results:
            for level, row in result.rows:
                one, made = result.comparison, level.origin
                limits = (row.expected, row.low, row.high)
                told = (row.verdict.value, row.reason, row.miss, one.reference)
                figures = (one.name, level.label, row.measure, row.value, row.unit)
                writer.writerow((*figures, *limits, *told, made.date, made.version, made.processor))
    return path
