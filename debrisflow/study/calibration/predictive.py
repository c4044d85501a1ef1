"""What the fitted parameters predict, and whether it holds where nothing was fitted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.results.score import contingency
from debrisflow.study.calibration.observations import (
    extents,
    missed_and_false,
    used_and_held_out,
)
from debrisflow.study.calibration.parameter_space import ParameterSpace, shares_of
from debrisflow.study.distributions import Values
from debrisflow.study.tables import Extent, Study

Floats = NDArray[np.float64]
LIKELY = 0.1  # probability from which a cell is one to be warned of


class Score(NamedTuple):
    """How well some runs predict a part of an observed extent.

    Attributes
    ----------
    extent, part : str
        Name of the observation; ``used`` in the fit, or ``held out``.
    runs : str
        Which.
    members : int
        How many these are.
    csi, missed, false : float
        Means over the runs: critical success index; missed and falsely reached area as shares of
        the observed one.
    brier : float
        Sum over the cells of the squares of ``p - o``, probability that the runs reach the cell
        less 1 if it was reached, over the number of observed cells.  As a mean over all cells it
        would depend on how much dry land the map shows.  Of several runs it is that of very many
        such runs (fair score), so that groups of different size can be compared.
    covered : float
        Share of the observed cells that are reached with a probability of 0.1 at least.
    """

    extent: str
    part: str
    runs: str
    members: int
    csi: float
    missed: float
    false: float
    brier: float
    covered: float


def drawn(space: ParameterSpace, scores: Floats, count: int, seed: int) -> list[Values]:
    """Return points drawn from a sample of the posterior, without repetition."""
    random = np.random.default_rng(seed)
    chosen = random.choice(len(scores), min(count, len(scores)), replace=False)
    return space.points(shares_of(scores[chosen]))


def scores(study: Study, groups: Mapping[str, Sequence[Path]]) -> list[Score]:
    """Return how well groups of runs predict the observed extents, used and held out.

    The Brier score is proper: on average nothing but the true probability has the least [1]_.  A
    share p of m runs has on average a score that is greater by ``p (1 - p) / (m - 1)`` than that of
    the probability from which the runs are drawn; this is taken off [2]_.

    Parameters
    ----------
    study : Study
    groups : mapping of sequence of Path
        Folders of finished runs by what they are, none empty.

    References
    ----------
    .. [1] T. Gneiting, A. E. Raftery, Strictly proper scoring rules, prediction, and estimation,
       Journal of the American Statistical Association 102 (2007), doi:10.1198/016214506000001437
    .. [2] C. A. T. Ferro, Fair scores for ensemble forecasts, Quarterly Journal of the Royal
       Meteorological Society 140 (2014), doi:10.1002/qj.2270
    """
    rows = []
    for observation in study.observation:
        if isinstance(observation, Extent):
            for name, folders in groups.items():
                rows += _of_group(study, observation, name, folders)
    return sorted(rows, key=lambda row: (row.extent, row.part == "held out"))


def skill(found: Sequence[Score], runs: str, reference: str) -> dict[tuple[str, str], float]:
    """Return the Brier skill of runs over others, by extent and part: 1 is perfect, 0 no better."""
    by = {(row.extent, row.part, row.runs): row.brier for row in found}
    return {
        (extent, part): 1.0 - value / by[extent, part, reference]
        for (extent, part, name), value in by.items()
        if name == runs and by.get((extent, part, reference))
    }


def _of_group(study: Study, observation: Extent, name: str, folders: Sequence[Path]) -> list[Score]:
    found = [extents(folder, observation) for folder in folders]
    reached = np.mean([one.simulated for one in found], axis=0)
    observed, rows = found[0].observed, []
    square = (reached - observed) ** 2 - reached * (1.0 - reached) / max(len(found) - 1, 1)
    for part, compared in used_and_held_out(study, found[0]):
        seen = int((observed & compared).sum())
        if not seen:
            continue
        agreements = [contingency(observed, one.simulated, compared) for one in found]
        missed, false = np.mean([missed_and_false(one) for one in agreements], axis=0).tolist()
        brier = float(square[compared].sum()) / seen
        covered = float((reached[observed & compared] >= LIKELY).mean())
        csi = float(np.mean([one.csi for one in agreements]))
        rows.append(
            Score(observation.name, part, name, len(found), csi, missed, false, brier, covered)
        )
    return rows
