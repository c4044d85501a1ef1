"""The calibration of a study on the workers of its sweep, with its maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from debrisflow.errors import OutputError
from debrisflow.run.atomic import replaced
from debrisflow.study.calibration.observations import Evaluate, Evaluated
from debrisflow.study.calibration.procedure import calibrate
from debrisflow.study.calibration.result import PREDICTIVE, CalibrationResult
from debrisflow.study.distributions import Values
from debrisflow.study.maps.files import write_maps
from debrisflow.study.maps.grid import grid_of
from debrisflow.study.member import Member
from debrisflow.study.names import FINDINGS, MAPS
from debrisflow.study.outcome import FINISHED, STOPPED, Outcome
from debrisflow.study.results import Results
from debrisflow.study.sweep import Sweep, Told

if TYPE_CHECKING:
    from distributed import Client


def fit(sweep: Sweep, client: Client, threads: int, told: Told | None, target: Path) -> list[Path]:
    """Calibrate the parameters of a study, and return the files that are written.

    Parameters
    ----------
    sweep : Sweep
        Open, of a study with a calibration.
    client : distributed.Client
        Of the workers.
    threads : int
        Of each member.
    told : callable, optional
        Called with each further member and its outcome.
    target : Path
        Folder of the files; maps of the posterior in its folder ``maps``.

    Raises
    ------
    CaseError
        If the runs give too little for a fit.
    OutputError
        If the folder cannot be written.
    """
    design = [one.values for one in sweep.members]
    evaluate = evaluation(sweep, client, threads, told)
    found = calibrate(sweep.study, design, evaluate, target)
    findings = target / FINDINGS
    with replaced(findings) as unfinished:
        unfinished.write_text("".join(f"{line}\n" for line in found.notes), encoding="utf-8")
    return [findings, *found.files, *_maps(sweep, found, target)]


def evaluation(
    sweep: Sweep, client: Client, threads: int = 1, told: Told | None = None
) -> Evaluate:
    """Return the function that computes a study at some points, on the workers of its sweep."""
    design = {one.digest for one in sweep.members}

    def tell(member: Member, outcome: Outcome) -> None:
        if told and member.digest not in design:
            told(member, outcome)

    def evaluate(points: Sequence[Values]) -> list[Evaluated]:
        members = sweep.at(points)
        outcomes = sweep.compute(client, members, threads, tell)
        for member, outcome in zip(members, outcomes, strict=True):
            if outcome.state == STOPPED:  # it may not be told from one that cannot be computed
                raise OutputError(
                    f"the calibration lacks member {member.number}, which was stopped: "
                    f"{outcome.message}; once the cause is removed, the same command goes on"
                )
        figures = Results(sweep.study, sweep.cases.base, members, outcomes).figures
        return [
            Evaluated(
                member.folder if outcome.state == FINISHED else None,
                {name: one.value for name, one in row.items()},
            )
            for member, outcome, row in zip(members, outcomes, figures, strict=True)
        ]

    return evaluate


def _maps(sweep: Sweep, found: CalibrationResult, target: Path) -> list[Path]:
    """Write the maps of the runs that were drawn from the posterior, if there are any."""
    folders = found.folders(PREDICTIVE)
    if not folders:
        return []
    grid = grid_of(sweep.cases.base, sweep.study.area)
    return write_maps(sweep.study, folders, grid, target / MAPS, is_sample=True)
