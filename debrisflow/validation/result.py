"""What a comparison gave, in files that later commands add to and the documentation is made of."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

from debrisflow.errors import OutputError
from debrisflow.run.atomic import replaced
from debrisflow.validation.comparison import Comparison, Level, Measured
from debrisflow.validation.convergence import Convergence, Step, convergence
from debrisflow.validation.curves import Curve, Kind, Panel, joined
from debrisflow.validation.row import Row, Verdict

RESULTS, CURVES = "results", "curves"
"""Folders of the figures and of the curves of each comparison."""


class Origin(NamedTuple):
    """When and by what a level was computed.

    Attributes
    ----------
    date : str
        Year, month, day.
    version, processor, python : str
    kernels : str
        Digest of the sources that the machine code comes from.
    """

    date: str
    version: str
    processor: str
    python: str
    kernels: str


class LevelResult(NamedTuple):
    """What one level gave.

    Attributes
    ----------
    label : str
    across : float
    origin : Origin
    seconds : float
        Processor time.
    rows : tuple of Row
        Empty if it failed.
    error : float
    failure : str
        Why nothing came out; empty as a rule.
    panels : tuple of Panel
    """

    label: str
    across: float
    origin: Origin
    seconds: float
    rows: tuple[Row, ...]
    error: float = nan
    failure: str = ""
    panels: tuple[Panel, ...] = ()


def level_result(
    level: Level, found: Measured, origin: Origin, seconds: float, failure: str = ""
) -> LevelResult:
    """Return what a level gave, from what was measured."""
    return LevelResult(
        level.label, level.across, origin, seconds, found.rows, found.error, failure, found.panels
    )


class Result(NamedTuple):
    """A comparison and the levels of it that were computed, from the coarsest on."""

    comparison: Comparison
    levels: tuple[LevelResult, ...]

    @property
    def rows(self) -> list[tuple[LevelResult, Row]]:
        """All rows with their levels."""
        return [(level, row) for level in self.levels for row in level.rows]

    @property
    def is_within(self) -> bool:
        """Whether every row with a limit is within it, and nothing failed."""
        held = all(row.is_within for _, row in self.rows if row.has_limit)
        return held and not self.failures

    @property
    def misses(self) -> list[str]:
        """Why rows are missed, each reason once, in the order of the rows."""
        known = [row.miss for _, row in self.rows if row.verdict is Verdict.KNOWN]
        return list(dict.fromkeys(known))

    @property
    def failures(self) -> list[str]:
        """What failed, and why."""
        return [f"{level.label}: {level.failure}" for level in self.levels if level.failure]

    @property
    def panels(self) -> list[Panel]:
        """The figure of all levels; computed curves bear the names of their levels."""
        named = [
            panel._replace(curves=tuple(_of_level(curve, level) for curve in panel.curves))
            for level in self.levels
            for panel in level.panels
        ]
        return [panel._replace(curves=_once(panel.curves)) for panel in joined(named)]

    @property
    def convergence(self) -> Convergence:
        """How the error falls."""
        return convergence([Step(le.label, le.across, le.error, le.seconds) for le in self.levels])

    def finest(self) -> Result:
        """Return the result at its finest level alone."""
        return self._replace(levels=self.levels[-1:])

    def with_levels(self, newer: Sequence[LevelResult]) -> Result:
        """Return the result with newer levels; those that other kernels gave are left out."""
        if not newer:
            return self
        by_label = {
            level.label: level
            for level in self.levels
            if level.origin.kernels == newer[0].origin.kernels
        }
        by_label |= {level.label: level for level in newer}
        known = [level.label for level in self.comparison.levels]
        there = [by_label[label] for label in known if label in by_label]
        return self._replace(levels=tuple(there))


def _of_level(curve: Curve, level: LevelResult) -> Curve:
    if curve.kind in (Kind.MEASURED, Kind.EXACT):
        return curve
    return curve._replace(label=", ".join(part for part in (level.label, curve.label) if part))


def _once(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """Return curves of which those of the reference stand only once."""
    return tuple(dict.fromkeys(curves))


class Count(NamedTuple):
    """How many rows with a limit are within it.

    Attributes
    ----------
    within, known, missed : int
        Of those that are held to a reference: within, missed as discussed, missed unexpectedly.
    conserved, not_conserved : int
        Of those on conservation.
    whole, comparisons : int
        Comparisons of which every row is within, and all.
    failures : int
        Levels that were not computed.
    """

    within: int
    known: int
    missed: int
    conserved: int
    not_conserved: int
    whole: int
    comparisons: int
    failures: int

    @property
    def held(self) -> int:
        """Rows that are held to a reference."""
        return self.within + self.known + self.missed


def count(results: Sequence[Result]) -> Count:
    """Return how many rows of results have each verdict."""
    rows = [row for result in results for _, row in result.rows if row.has_limit]
    physics = [row.verdict for row in rows if not row.is_conserved]
    kept = [row.is_within for row in rows if row.is_conserved]
    return Count(
        within=physics.count(Verdict.WITHIN),
        known=physics.count(Verdict.KNOWN),
        missed=physics.count(Verdict.MISSED),
        conserved=kept.count(True),
        not_conserved=kept.count(False),
        whole=sum(result.is_within for result in results),
        comparisons=len(results),
        failures=sum(len(result.failures) for result in results),
    )


def write_result(folder: Path, result: Result) -> None:
    """Write the figures and the curves of a comparison.

    Raises
    ------
    OutputError
        If the operating system refuses.
    """
    name = f"{result.comparison.name}.json"
    levels = [plain(level._replace(panels=())) for level in result.levels]
    drawn = {level.label: plain(level.panels) for level in result.levels}
    for path, content in ((folder / RESULTS / name, levels), (folder / CURVES / name, drawn)):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"{path.parent}: cannot be made: {error.strerror}") from error
        with replaced(path) as unfinished:
            unfinished.write_text(json.dumps(content, indent=1, allow_nan=False), encoding="utf-8")


def read_result(folder: Path, comparison: Comparison) -> Result:
    """Return what a folder has of a comparison, which may be nothing.

    Raises
    ------
    OutputError
        If a file is damaged.
    """
    path = folder / RESULTS / f"{comparison.name}.json"
    drawn = folder / CURVES / f"{comparison.name}.json"
    try:
        levels = json.loads(path.read_text(encoding="utf-8")) if path.exists() else []
        panels = json.loads(drawn.read_text(encoding="utf-8")) if drawn.exists() else {}
        found = [_level(one, panels.get(one["label"], [])) for one in levels]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise OutputError(
            f"{path}: cannot be read as the results of a comparison; remove it and its like in "
            f"{drawn.parent}, and compute it again with: debrisflow validate {comparison.name}"
        ) from error
    return Result(comparison, ()).with_levels(found)


def plain(value: Any) -> Any:
    """Return a record as JSON has it: tuples with names as objects, what is not finite as text."""
    if hasattr(value, "_asdict"):
        return {name: plain(part) for name, part in value._asdict().items()}
    if isinstance(value, Mapping):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    return str(value) if isinstance(value, float) and not isfinite(value) else value


def _level(one: dict[str, Any], panels: list[dict[str, Any]]) -> LevelResult:
    rows = tuple(_row(row) for row in one["rows"])
    known = {"rows": rows, "origin": Origin(**one["origin"]), "error": float(one["error"])}
    return LevelResult(**one | known | {"panels": tuple(_panel(panel) for panel in panels)})


def _row(one: dict[str, Any]) -> Row:
    numbers = {name: float(one[name]) for name in ("value", "low", "high", "expected", "worst")}
    return Row(**one | numbers)


def _panel(one: dict[str, Any]) -> Panel:
    curves = tuple(_curve(curve) for curve in one["curves"])
    return Panel(one["title"], one["x_label"], one["y_label"], curves)


def _curve(one: dict[str, Any]) -> Curve:
    x, y = (tuple(map(float, one[name])) for name in ("x", "y"))
    return Curve(one["label"], x, y, Kind(one["kind"]))
