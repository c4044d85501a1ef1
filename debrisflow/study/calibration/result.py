"""What a calibration found, and the runs that it rests on."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.study.calibration.emulator import LeaveOneOut
from debrisflow.study.calibration.identifiability import Coupled, Marginal
from debrisflow.study.calibration.observations import Evaluated, misfits
from debrisflow.study.calibration.parameter_space import ParameterSpace
from debrisflow.study.calibration.posterior import Posterior
from debrisflow.study.calibration.predictive import Score
from debrisflow.study.distributions import Values

Floats = NDArray[np.float64]
DESIGN, IMPROVEMENT, PREDICTIVE = "design", "improvement", "predictive"


class Run(NamedTuple):
    """A run of a calibration.

    Attributes
    ----------
    kind : str
        ``design``, ``improvement`` or ``predictive``.
    values : dict
        Of the parameters, by name.
    evaluated : Evaluated
    """

    kind: str
    values: Values
    evaluated: Evaluated


class CalibrationResult(NamedTuple):
    """What a calibration found.

    Attributes
    ----------
    space : ParameterSpace
    runs : list of Run
        In the order in which they were computed.
    residuals : (runs, residuals) float64 array
        nan of failed runs.
    residual_names : list of str
    left_out : LeaveOneOut
        Error of the emulator.
    at_posterior : (residuals,) float64 array
        Root mean square of its error at the predictive runs, in errors of the observation; nan if
        there are none.
    posterior : Posterior
    marginals : list of Marginal
    coupled : list of Coupled
    scores : list of Score
        Of the observed extents.
    notes : list of str
        Sentences for people: what is known, how well it is founded, what to doubt.
    files : list of Path
    """

    space: ParameterSpace
    runs: list[Run]
    residuals: Floats
    residual_names: list[str]
    left_out: LeaveOneOut
    at_posterior: Floats
    posterior: Posterior
    marginals: list[Marginal]
    coupled: list[Coupled]
    scores: list[Score]
    notes: list[str]
    files: list[Path]

    @property
    def misfits(self) -> Floats:
        """Sum of the squares of the residuals of each run, (runs,); nan of failed ones."""
        return misfits(self.residuals)

    @property
    def best(self) -> int:
        """Number of the run of least misfit, among those computed to find it."""
        is_chosen = np.array([run.kind != PREDICTIVE for run in self.runs])
        return int(np.nanargmin(np.where(is_chosen, self.misfits, np.nan)))

    def folders(self, kind: str) -> list[Path]:
        """Return the folders of the finished runs of a kind."""
        return [
            run.evaluated.folder
            for run in self.runs
            if run.kind == kind and run.evaluated.folder is not None
        ]
