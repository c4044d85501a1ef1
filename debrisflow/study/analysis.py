"""What is made of the members of a study: tables, maps, sensitivity, a fit and a report."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from debrisflow.errors import shown
from debrisflow.run.atomic import made
from debrisflow.run.tables import Row, write_table
from debrisflow.study.distributions import Value
from debrisflow.study.names import CALIBRATION, EFFECTS, MAPS, SENSITIVITY, TABLE
from debrisflow.study.report import study_report
from debrisflow.study.results import Results
from debrisflow.study.sweep import Sweep, Told

if TYPE_CHECKING:
    from distributed import Client

HEAD = ("members of the study; nan where a run gives no answer, empty where there is no run",)


def analyze(
    sweep: Sweep, results: Results, client: Client, threads: int = 1, told: Told | None = None
) -> list[Path]:
    """Write what a study wants of its members into its folder, and return the files.

    Parameters
    ----------
    sweep : Sweep
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
    written = [write_members(results, sweep.folder / TABLE)]
    if results.finished:
        written += write_study_maps(results, sweep.folder / MAPS)
        written += write_sensitivities(results, sweep.folder / SENSITIVITY)
    if sweep.study.calibration:
        from debrisflow.study.fit import fit

        written += fit(sweep, client, threads, told, sweep.folder / CALIBRATION)
    return [*written, study_report(results, sweep.folder, written)]


def write_study_maps(results: Results, target: Path) -> list[Path]:
    """Write the maps that a study asks for, and return the files; none without any."""
    if not results.study.map:
        return []
    from debrisflow.study.map_files import write_maps
    from debrisflow.study.map_grid import grid_of

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
