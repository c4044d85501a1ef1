"""A page on a whole study: one HTML file that needs nothing else, with links to its runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from debrisflow import __version__
from debrisflow.results.html import write_html
from debrisflow.results.parameters import summary as case_in_words
from debrisflow.run.duration import duration
from debrisflow.run.names import POSTPROCESS
from debrisflow.study.attachments import Attachments, Link, address, attachments
from debrisflow.study.designs import is_sample
from debrisflow.study.distributions import AnyParameter, Choice, Value
from debrisflow.study.member import Member, shown_values
from debrisflow.study.names import CALIBRATION, MAPS, REPORT, SENSITIVITY, TABLE
from debrisflow.study.outcome import FINISHED, STOPPED
from debrisflow.study.places import flat
from debrisflow.study.results import Results
from debrisflow.study.statistics import Summary, summaries
from debrisflow.study.wording import (
    calibration_in_words,
    design_in_words,
    law_in_words,
    observation_in_words,
)

MOST_LISTED = 500  # members in the table of all
PACKAGE = "debrisflow.study"


class Varied(NamedTuple):
    """A parameter as the page shows it.

    Attributes
    ----------
    name, keys, law : str
    is_factor : bool
    span : str
        What the members have of it.
    """

    name: str
    keys: str
    law: str
    is_factor: bool
    span: str


class Linked(NamedTuple):
    """A member with what the page says of it.

    Attributes
    ----------
    number : int
    values, state, message : str
    folder, report : Link or None
        Of its run, where they are there.
    figures : list of float or None
        Its quantities; None where it has none.
    """

    number: int
    values: str
    state: str
    message: str
    folder: Link | None
    report: Link | None
    figures: list[float | None]


class Marked(NamedTuple):
    """A quantity with its worst and its median member, and their values of it."""

    name: str
    worst: Linked
    worst_value: float | None
    middle: Linked
    middle_value: float | None


def study_report(
    results: Results, folder: Path, written: Sequence[Path], warnings: Sequence[str] = ()
) -> Path:
    """Write ``report.html`` of a study into its folder, and return it.

    Parameters
    ----------
    results : Results
        Of the design.
    folder : Path
        Of the study.
    written : sequence of Path
        What analyses have written into its folders ``sensitivity``, ``maps`` and ``calibration``;
        other files in these may be those of a former study and are not on the page.
    warnings : sequence of str, optional
        What is missing, and why.

    Raises
    ------
    OutputError
        If the page cannot be written.
    """
    path = folder / REPORT
    contents = _asked(results) | _members(results, folder) | _attached(results, folder, written)
    write_html(
        path,
        "study.html",
        contents | _origin(results) | {"warnings": warnings},
        package=PACKAGE,
        style="study.css",
    )
    return path


def _asked(results: Results) -> dict[str, Any]:
    """Return what the study file asks for."""
    study, base = results.study, results.base
    return {
        "language": "en",
        "title": study.title,
        "notes": study.notes.split("\n\n") if study.notes else [],
        "case": Path(study.case).name,
        "case_title": base.title,
        "case_summary": case_in_words(base),
        "changes": [(key, _shown(value)) for key, value in flat(study.set)],
        "parameters": [_varied(one, results.members) for one in study.parameter],
        "correlations": study.correlation,
        "design": design_in_words(study.design),
        "is_sample": is_sample(study.design),
        "fit": calibration_in_words(study.calibration) if study.calibration else "",
        "observations": [observation_in_words(one) for one in study.observation],
    }


def _members(results: Results, folder: Path) -> dict[str, Any]:
    """Return what became of the members."""
    linked = list(_linked(results, folder))
    rows = summaries(results)
    return {
        "count": len(linked),
        "counts": Counter(one.state for one in linked),
        "without": [one for one in linked if one.state != FINISHED],
        "stopped": STOPPED,
        "members": linked[:MOST_LISTED],
        "left_out": max(len(linked) - MOST_LISTED, 0),
        "table": Link(TABLE, TABLE) if (folder / TABLE).is_file() else None,
        "quantities": rows,
        "marked": [found for k, row in enumerate(rows) if (found := _marked(k, row, linked))],
        "arrivals": [row.name for row in rows if row.least_is_worst],
        "has_unequal": any(0 < row.count < len(linked) for row in rows),
    }


def _attached(results: Results, folder: Path, written: Sequence[Path]) -> dict[str, Any]:
    """Return what the analyses of the study have written, by their folders."""

    def found(place: Path) -> Attachments:
        files = [file for file in written if file.parent == place]
        return attachments(files, folder, list(results.units))

    fitted = folder / CALIBRATION
    return {
        "sensitivity": found(folder / SENSITIVITY),
        "maps": found(folder / MAPS),
        "calibration": found(fitted),
        "posterior_maps": found(fitted / MAPS),
    }


def _origin(results: Results) -> dict[str, Any]:
    """Return what the results come from."""
    from debrisflow.run.loop import program

    seed = getattr(results.study.design, "seed", None)
    return {
        "version": __version__,
        "program": program(),
        "seed": "none" if seed is None else seed,
        "computed": len({one.digest for one in results.members}),
        "seconds": duration(sum(_seconds(results))),
        "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    }


def _seconds(results: Results) -> list[float]:
    """Return the wall time of each run, once where members have the same content."""
    pairs = zip(results.members, results.outcomes, strict=True)
    return list({member.digest: outcome.seconds for member, outcome in pairs}.values())


def _varied(parameter: AnyParameter, members: Sequence[Member]) -> Varied:
    values = [one.values[parameter.name] for one in members]
    if isinstance(parameter, Choice):
        used = [value for value in parameter.values if value in values]
        span = ", ".join(map(_shown, used))
    else:
        numbers = [float(value) for value in values]
        span = f"{min(numbers):.4g} to {max(numbers):.4g}" if numbers else ""
    keys = ", ".join(parameter.keys)
    return Varied(parameter.name, keys, law_in_words(parameter), parameter.is_factor, span)


def _shown(value: Value | object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _linked(results: Results, folder: Path) -> Iterator[Linked]:
    triples = zip(results.members, results.outcomes, results.figures, strict=True)
    for member, outcome, figures in triples:
        report = member.folder / POSTPROCESS / REPORT
        known = [figures[name].value if name in figures else None for name in results.units]
        yield Linked(
            member.number,
            shown_values(member.values),
            outcome.state,
            outcome.message,
            _link(member.folder, folder),
            _link(report, folder),
            known,
        )


def _link(file: Path, folder: Path) -> Link | None:
    """Return a link from a page in a folder to a file or folder, None if there is none."""
    return Link(file.name, address(file, folder)) if file.exists() else None


def _marked(place: int, row: Summary, linked: Sequence[Linked]) -> Marked | None:
    """Return a quantity with its worst and its median member, None if no member has it."""
    if row.worst is None or row.middle is None:
        return None
    worst, middle = linked[row.worst], linked[row.middle]
    return Marked(row.name, worst, worst.figures[place], middle, middle.figures[place])
