"""What ``validate`` writes into a folder: results, figures, a table, a report and a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile

from debrisflow.errors import DebrisflowError, OutputError
from debrisflow.run.atomic import replaced
from debrisflow.validation.comparison import Comparison
from debrisflow.validation.figures import draw, drawn
from debrisflow.validation.page import PAGE, page
from debrisflow.validation.register import COMPARISONS
from debrisflow.validation.report import write_report
from debrisflow.validation.result import (
    LevelResult,
    Result,
    read_result,
    write_result,
)
from debrisflow.validation.row import Verdict
from debrisflow.validation.table import write_table


class NotReproducedError(DebrisflowError):
    """What this installation computes is not what the comparison with a reference expects."""

    exit_code = 5


def results_in(folder: Path) -> list[Result]:
    """Return the results that a folder has, in the order of the register.

    Raises
    ------
    OutputError
        If a file is damaged.
    """
    found = [read_result(folder, comparison) for comparison in COMPARISONS.values()]
    return [result for result in found if result.levels]


class Validation:
    """Results as they come, in a folder that may have others already."""

    def __init__(self, folder: Path, comparisons: Sequence[Comparison]) -> None:
        self.folder = folder
        self._newer: dict[str, list[LevelResult]] = {one.name: [] for one in comparisons}
        self._before = {one.name: read_result(folder, one) for one in comparisons}

    @classmethod
    def begin(cls, folder: Path, comparisons: Sequence[Comparison]) -> Validation:
        """Return the results of a folder, which is made if it is not there.

        Raises
        ------
        OutputError
            If the folder cannot be written, or a file in it is damaged.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with TemporaryFile(dir=folder):  # now, and not after minutes of computation
                pass
        except OSError as error:
            raise OutputError(f"{folder}: cannot be written: {error.strerror}") from error
        return cls(folder, comparisons)

    def add(self, name: str, found: LevelResult) -> Comparison:
        """Keep what a level gave, in the folder too, and return its comparison."""
        self._newer[name].append(found)
        write_result(self.folder, self._before[name].with_levels(self._newer[name]))
        return COMPARISONS[name]

    @property
    def computed(self) -> list[Result]:
        """What was computed now."""
        return [
            Result(COMPARISONS[name], ()).with_levels(levels)
            for name, levels in self._newer.items()
            if levels
        ]

    def write(self) -> list[Path]:
        """Write figures of what was computed now, and table, report and page of all in the folder.

        Raises
        ------
        OutputError
            If the operating system refuses.
        """
        results = results_in(self.folder)
        for result in results:
            if self._newer.get(result.comparison.name):
                draw(result, self.folder)
        text = self.folder / PAGE
        with replaced(text) as unfinished:
            unfinished.write_text(page(results, drawn(self.folder)), encoding="utf-8")
        return [write_table(self.folder, results), text, write_report(self.folder, results)]

    def refuse_unexplained(self) -> None:
        """Raise if something that was computed now is missed for no known reason.

        Raises
        ------
        NotReproducedError
        """
        missed = [
            f"{result.comparison.name}, {level.label}: {row.measure}, {row.shown_value()} "
            f"({row.shown_limit()})"
            for result in self.computed
            for level, row in result.rows
            if row.verdict is Verdict.MISSED
        ]
        failed = [
            f"{result.comparison.name}, {failure}"
            for result in self.computed
            for failure in result.failures
        ]
        if missed or failed:
            raise NotReproducedError(
                "\n".join(
                    [
                        "this installation does not give what it should:",
                        *(f"  {line}" for line in (*missed, *failed)),
                        "Please report it with the output of: debrisflow info",
                    ]
                )
            )
