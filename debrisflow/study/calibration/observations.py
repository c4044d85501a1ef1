"""How far members are from what was observed, in errors of the observations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.rasters import MapGrid
from debrisflow.errors import CaseError
from debrisflow.results.flow_path import centers
from debrisflow.results.score import Contingency, Extents, contingency, extents_of
from debrisflow.study.distributions import Values
from debrisflow.study.quantities import is_early
from debrisflow.study.tables import Extent, Part, Study

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
LEAST_OF_MISSING = 5.0  # errors, by which a figure that a run lacks is wrong at least


class Evaluated(NamedTuple):
    """What a run gave.

    Attributes
    ----------
    folder : Path or None
        Of the run; None if it failed.
    answers : dict of float
        The quantities of the study by name; nan where the run gives none.
    """

    folder: Path | None
    answers: dict[str, float]


Evaluate = Callable[[Sequence[Values]], Sequence[Evaluated]]
"""Computes the study at some points."""


def residual_names(study: Study) -> list[str]:
    """Return the names of the residuals: one of a figure, two of an extent."""
    names: list[str] = []
    for one in study.observation:
        if isinstance(one, Extent):
            names += [f"{one.name}_missed", f"{one.name}_false"]
        else:
            names.append(one.quantity)
    return names


def residuals_of(study: Study, runs: Sequence[Evaluated]) -> Floats:
    """Return the residuals of runs, ``(computed - observed) / error``.

    An extent has two: the area that a run misses and the area that it reaches falsely, each as a
    share of the observed area, over the error.  The held-out part of the map is left out.

    The arrival of a flow that stopped on its way contradicts the observed one.  It counts as much
    as the worst of the runs in which the flow arrives, above the observed value, and 5 errors at
    least: a lower bound (it is censored), and no jump for an emulator.  Of other figures that a run
    lacks nothing is known, and the run is left out as a failed one.

    Parameters
    ----------
    study : Study
    runs : sequence of Evaluated

    Returns
    -------
    (runs, residuals) float64 array
        nan in the rows of failed runs, and of those that lack a figure which is no arrival.

    Raises
    ------
    CaseError
        If an observation cannot be compared with any run.
    """
    part = study.calibration.held_out if study.calibration else None
    columns: list[Floats] = []
    for one in study.observation:
        if isinstance(one, Extent):
            found = [_outside(run.folder, one, part) for run in runs]
            missed, false = np.array(found).reshape(-1, 2).T
            columns += [missed / one.error, false / (one.false_error or one.error)]
        else:
            values = np.array([run.answers.get(one.quantity, np.nan) for run in runs], dtype=float)
            has_failed = np.array([run.folder is None for run in runs], dtype=bool)
            residuals = (values - one.value) / one.error
            is_time = any(is_early(own) for own in study.quantity if own.called == one.quantity)
            columns.append(_filled(residuals, has_failed, one.quantity) if is_time else residuals)
    return np.column_stack(columns)


def is_in(part: Part | None, grid: MapGrid) -> Flags:
    """Return the cells of a grid whose middles lie in a part of the map; of no part none.

    Examples
    --------
    >>> is_in(Part(x=(0.0, 1.0)), MapGrid(0.0, 0.0, 1.0, 2, 1))
    array([[ True, False]])
    """
    if part is None:
        return np.zeros(grid.shape, dtype=bool)
    east, north = centers(grid)
    x, y = np.meshgrid(east, north)
    inside = np.ones(grid.shape, dtype=bool)
    for place, interval in ((x, part.x), (y, part.y)):
        if interval is not None:
            inside &= (place >= interval[0]) & (place <= interval[1])
    return inside


def extents(folder: Path, observation: Extent) -> Extents:
    """Return the observed extent and that of a run, on the grid of the run."""
    return extents_of(folder, Path(observation.file), observation.threshold)


def missed_and_false(agreement: Contingency) -> tuple[float, float]:
    """Return the missed and the falsely reached area, as shares of the observed area.

    Examples
    --------
    >>> missed_and_false(Contingency(6, 2, 4, 88))
    (0.25, 0.5)
    """
    observed = agreement.hits + agreement.misses
    return agreement.misses / observed, agreement.false_alarms / observed


def _outside(folder: Path | None, observation: Extent, part: Part | None) -> tuple[float, float]:
    """Return the missed and the false share outside the held-out part; nan of a failed run."""
    if folder is None:
        return np.nan, np.nan
    found = extents(folder, observation)
    used = found.compared & ~is_in(part, found.terrain.grid)
    if not (found.observed & used).any():
        raise CaseError(
            f"calibration.held_out: nothing of the observed extent '{observation.name}' is left "
            "beside the part that is held out; make the part smaller"
        )
    return missed_and_false(contingency(found.observed, found.simulated, used))


def _filled(residuals: Floats, has_failed: Flags, name: str) -> Floats:
    """Return residuals of a figure with those of finished runs that lack it."""
    missing = np.isnan(residuals) & ~has_failed
    if missing.any() and np.isnan(residuals).all():
        raise CaseError(
            f"observation '{name}': no run has this quantity, so that nothing can be fitted to it; "
            "widen the distributions of the parameters, or leave the observation out"
        )
    worst = np.abs(residuals[~np.isnan(residuals)]).max(initial=LEAST_OF_MISSING)
    return np.where(missing, worst, residuals)


def misfits(residuals: Floats) -> Floats:
    """Return the sum of the squares of the residuals of each run, (runs,)."""
    return np.asarray((residuals**2).sum(axis=1))


def used_and_held_out(study: Study, found: Extents) -> Iterator[tuple[str, Flags]]:
    """Yield the parts of a map by name with the compared cells in them; held out only if given."""
    part = study.calibration.held_out if study.calibration else None
    inside = is_in(part, found.terrain.grid)
    yield "used", found.compared & ~inside
    if part is not None:
        yield "held out", found.compared & inside
