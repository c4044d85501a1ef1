"""The fit as a whole: design, improvement, posterior, prediction, check."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from debrisflow.errors import CaseError
from debrisflow.study.calibration.emulator import Emulator
from debrisflow.study.calibration.identifiability import (
    coupled,
    marginals,
    sentences,
)
from debrisflow.study.calibration.improvement import NEGLIGIBLE, proposed
from debrisflow.study.calibration.observations import (
    Evaluate,
    residual_names,
    residuals_of,
)
from debrisflow.study.calibration.parameter_space import ParameterSpace
from debrisflow.study.calibration.plots import write_plots
from debrisflow.study.calibration.posterior import sampled
from debrisflow.study.calibration.predictive import drawn, scores, skill
from debrisflow.study.calibration.result import (
    DESIGN,
    IMPROVEMENT,
    PREDICTIVE,
    CalibrationResult,
    Run,
)
from debrisflow.study.calibration.result_tables import write_tables
from debrisflow.study.distributions import Values
from debrisflow.study.tables import Calibration, Study

Floats = NDArray[np.float64]
MANY = 30  # runs, from which a Brier score is known well enough
RELIABLE = 0.5  # Q2, below which an emulator tells little


def calibrate(
    study: Study,
    design: Sequence[Values],
    evaluate: Evaluate,
    target: Path,
) -> CalibrationResult:
    """Fit the parameters of a study to its observations, and write tables and plots.

    Parameters
    ----------
    study : Study
        With a calibration, checked.
    design : sequence of dict
        Values of the parameters in the runs of its design.
    evaluate : callable
        Computes the study at some points.
    target : Path
        Folder of the files.

    Raises
    ------
    CaseError
        If the runs give too little for a fit.
    OutputError
        If the folder cannot be written.
    """
    from debrisflow.study.calibration.extent_map import write_extent_maps

    wanted = study.calibration
    assert wanted is not None, "the check of a study sees to it"
    space = ParameterSpace.of(study)
    runs = _computed(DESIGN, design, evaluate)
    notes = _improve(study, wanted, space, runs, evaluate)
    emulator, residuals = _emulator(study, space, runs, wanted.seed)
    posterior = sampled(emulator, space, wanted.seed)
    if wanted.predictive:
        points = drawn(space, posterior.scores, wanted.predictive, wanted.seed)
        runs += _computed(PREDICTIVE, points, evaluate)
        residuals = residuals_of(study, [run.evaluated for run in runs])
    left_out = emulator.left_out()
    known, pairs = marginals(space, posterior.scores), coupled(space, posterior.scores)
    found = CalibrationResult(
        space,
        runs,
        residuals,
        residual_names(study),
        left_out,
        _error_at_posterior(emulator, space, runs, residuals),
        posterior,
        known,
        pairs,
        scores=[],
        notes=[],
        files=[],
    )
    groups = _groups(found)
    found = found._replace(scores=scores(study, groups))
    notes = [
        *_of_runs(found),
        *notes,
        *sentences(known, pairs),
        *_of_emulator(found),
        *posterior.doubts,
        *_of_prediction(found),
    ]
    found = found._replace(notes=notes)
    written = [*write_tables(found, target), *write_plots(found, target)]
    maps = write_extent_maps(study, groups, target)
    return found._replace(files=[*written, *maps])


def _computed(kind: str, points: Sequence[Values], evaluate: Evaluate) -> list[Run]:
    results = evaluate(points)
    return [Run(kind, values, one) for values, one in zip(points, results, strict=True)]


def _improve(
    study: Study,
    wanted: Calibration,
    space: ParameterSpace,
    runs: list[Run],
    evaluate: Evaluate,
) -> list[str]:
    """Add runs where the misfit may be less, and say why no more are added."""
    while (left := wanted.runs - len(runs)) > 0:
        emulator, residuals = _emulator(study, space, runs, wanted.seed)
        shares = space.shares([run.values for run in runs])
        has_failed = np.isnan(residuals).any(axis=1)
        proposal = proposed(
            emulator,
            space,
            shares[~has_failed],
            shares[has_failed],
            min(wanted.at_once, left),
            wanted.seed + len(runs),
        )
        if proposal.improvement < NEGLIGIBLE:
            return [
                f"No more than {len(runs)} of {wanted.runs} runs were needed: another one would "
                f"lower the misfit by {proposal.improvement:.2g} on average."
            ]
        runs += _computed(IMPROVEMENT, space.points(proposal.shares), evaluate)
    return []


def _emulator(
    study: Study, space: ParameterSpace, runs: Sequence[Run], seed: int
) -> tuple[Emulator, Floats]:
    """Return the emulator of the finished runs, and the residuals of all."""
    residuals = residuals_of(study, [run.evaluated for run in runs])
    is_finished = ~np.isnan(residuals).any(axis=1)
    least = len(space.names) + 2
    if is_finished.sum() < least:
        raise CaseError(
            f"calibration: {is_finished.sum()} of {len(runs)} runs have finished, and a fit of "
            f"{len(space.names)} parameters needs {least}; see why the others failed, or enlarge "
            "the design"
        )
    places = space.coordinates(space.shares([run.values for run in runs]))
    return Emulator(places[is_finished], residuals[is_finished], seed), residuals


def _error_at_posterior(
    emulator: Emulator, space: ParameterSpace, runs: Sequence[Run], residuals: Floats
) -> Floats:
    """Return how far the emulator was off at the predictive runs, which it does not know."""
    chosen = np.array([run.kind == PREDICTIVE for run in runs]) & np.isfinite(residuals).all(axis=1)
    if not chosen.any():
        return np.full(residuals.shape[1], np.nan)
    drawn_at = [run.values for run, is_chosen in zip(runs, chosen, strict=True) if is_chosen]
    expected = emulator.at(space.coordinates(space.shares(drawn_at))).mean
    return np.asarray(np.sqrt(((expected - residuals[chosen]) ** 2).mean(axis=0)))


def _groups(found: CalibrationResult) -> dict[str, list[Path]]:
    """Return the folders of finished runs by what they are, none empty."""
    best = found.runs[found.best].evaluated.folder
    groups = {
        "best fit": [best] if best is not None else [],
        DESIGN: found.folders(DESIGN),
        PREDICTIVE: found.folders(PREDICTIVE),
    }
    return {name: folders for name, folders in groups.items() if folders}


def _of_runs(found: CalibrationResult) -> list[str]:
    failed = int(np.isnan(found.misfits).sum())
    best = found.runs[found.best]
    values = ", ".join(f"{name} = {best.values[name]:.4g}" for name in found.space.names)
    told = [
        f"The best of the computed runs has {values}; the sum of its squared residuals is "
        f"{found.misfits[found.best]:.3g} of {len(found.residual_names)} residuals."
    ]
    if failed:
        told.append(f"{failed} of {len(found.runs)} runs failed and are left out.")
    return told


def _of_emulator(found: CalibrationResult) -> list[str]:
    rows = zip(found.residual_names, found.left_out.explained, found.left_out.rms, strict=True)
    told = [
        f"The emulator tells little of {name}: it explains {share:.0%} of its variance between "
        f"runs, and errs by {error:.2g} errors of the observation; the posterior allows for this, "
        "and more runs would narrow it."
        for name, share, error in rows
        if share < RELIABLE and error > 1.0
    ]
    if np.isfinite(found.at_posterior).all():
        worst = int(np.argmax(found.at_posterior))
        told.append(
            f"At the {len(found.folders(PREDICTIVE))} runs drawn from the posterior, which it does "
            f"not know, the emulator errs by {found.at_posterior[worst]:.2g} errors of the "
            f"observation at most, root mean square, of {found.residual_names[worst]}."
        )
    return told


def _of_prediction(found: CalibrationResult) -> list[str]:
    count, before = len(found.folders(PREDICTIVE)), len(found.folders(DESIGN))
    doubt = "" if min(count, before) >= MANY else "; of so few runs it is uncertain"
    told = []
    for (extent, part), value in skill(found.scores, PREDICTIVE, DESIGN).items():
        where = "that was held out" if part == "held out" else "that was used"
        told.append(
            f"In the part of {extent} {where} the Brier skill of the {count} fitted runs over the "
            f"{before} of the design is {value:.2f}, where 1 is perfect and 0 no better{doubt}."
        )
    return told
