"""What is made of the members of a study: tables, maps, sensitivity, a fit and a report."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from debrisflow.errors import DebrisflowError, shown
from debrisflow.run.atomic import made
from debrisflow.run.tables import Row, write_table
from debrisflow.study.distributions import Value
from debrisflow.study.lacking import damage, lacking_quantities, without_damaged
from debrisflow.study.names import CALIBRATION, EFFECTS, MAPS, SENSITIVITY, TABLE
from debrisflow.study.report import study_report
from debrisflow.study.results import Results
from debrisflow.study.sweep import Sweep, Told
from debrisflow.study.written import remove_former

if TYPE_CHECKING:
    from distributed import Client

UNFITTED = "the calibration is not on this page: it was not over when the page was made"
HEAD = ("members of the study; nan where a run gives no answer, empty where there is no run",)


class Analysis(NamedTuple):
    """What was made of the members of a study.

    Attributes
    ----------
    results : Results
        With the members that turned out to be damaged.
    files : list of Path
    warnings : list of str
    errors : list of DebrisflowError
        Why parts of it are missing; they are on the page too.
    """

    results: Results
    files: list[Path]
    warnings: list[str]
    errors: list[DebrisflowError]


def analyze(
    sweep: Sweep, results: Results, client: Client, threads: int = 1, told: Told | None = None
) -> Analysis:
    """Write what a study wants of its members into its folder, and remove what it wants no more.

    The page is written before a calibration begins, which may take long or not succeed, and again
    afterwards.

    Parameters
    ----------
    sweep : Sweep
        Open.
    results : Results
        Of its design.
    client : distributed.Client
        Of the workers, for the further runs of a calibration.
    threads : int
        Of each member.
    told : callable, optional
        Called with each further member and its outcome.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    results, folder = without_damaged(results), sweep.folder
    damaged = damage(results)
    errors: list[DebrisflowError] = [damaged] if damaged else []
    warnings = list(lacking_quantities(results))
    written = [write_members(results, folder / TABLE)]
    if results.finished:
        with _kept(errors):
            written += write_study_maps(results, folder / MAPS)
        with _kept(errors):
            written += write_sensitivities(results, folder / SENSITIVITY)
    if sweep.study.calibration and not damaged:
        from debrisflow.study.fit import fit

        warnings += remove_former(folder, written, spared=CALIBRATION)
        study_report(results, folder, written, [*warnings, *map(str, errors), UNFITTED])
        with _kept(errors):
            written += fit(sweep, client, threads, told, folder / CALIBRATION)
    warnings += remove_former(folder, written)
    page = study_report(results, folder, written, [*warnings, *map(str, errors)])
    return Analysis(results, [*written, page], warnings, errors)


@contextmanager
def _kept(errors: list[DebrisflowError]) -> Iterator[None]:
    """Keep the error of a part of the analysis, so that the other parts are written."""
    try:
        yield
    except DebrisflowError as error:
        errors.append(error)


def write_study_maps(results: Results, target: Path) -> list[Path]:
    """Write the maps that a study asks for, and return the files; none without any."""
    if not results.study.map:
        return []
    from debrisflow.study.maps.files import write_maps
    from debrisflow.study.maps.grid import grid_of

    grid = grid_of(results.base, results.study.area)
    return write_maps(results.study, results.folders, grid, target)


def write_sensitivities(results: Results, target: Path) -> list[Path]:
    """Write and draw what the parameters do to the quantities, and return the files."""
    from debrisflow.study.plots.drawn import draw_sensitivity
    from debrisflow.study.sensitivity import sensitivity_table, write_sensitivity

    study, points = results.study, [member.values for member in results.members]
    quantities = {name: results.values_of(name) for name in results.units}
    effects = sensitivity_table(study, points, quantities)
    made(target)
    written = [target / EFFECTS]
    write_sensitivity(written[0], effects)
    for name, values in quantities.items():
        own = [one for one in effects if one.quantity == name]
        unit = results.units[name]
        written += draw_sensitivity(study, points, values, own, name, unit, target)
    return written


def write_members(results: Results, path: Path) -> Path:
    """Write a table of the members: values of the parameters, state, quantities."""
    names = [one.name for one in results.study.parameter]
    units = results.units
    with_unit = {name: unit for name, unit in units.items() if unit not in ("", "-")}
    head = [
        *HEAD,
        *(" ".join(shown(f"{name}: {unit}").split()) for name, unit in with_unit.items()),
    ]
    columns = ["number", "folder", *names, "state", "seconds", *units]
    write_table(path, columns, head, _rows(results, names))
    return path


def _rows(results: Results, names: list[str]) -> Iterator[Row]:
    triples = zip(results.members, results.outcomes, results.figures, strict=True)
    for member, outcome, figures in triples:
        yield [
            str(member.number),
            member.folder.name,
            *(_plain(member.values[name]) for name in names),
            outcome.state,
            outcome.seconds,
            *(figures[name].value if name in figures else "" for name in results.units),
        ]


def _plain(value: Value) -> Value:
    """Return a value of a parameter, fit for a terminal that shows the table."""
    return shown(value) if isinstance(value, str) else value
