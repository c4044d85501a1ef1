"""The parameters of a calibration, by their shares and by their normal scores."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from debrisflow.study.correlations import LEAST_SHARE, correlation_matrix
from debrisflow.study.distributions import Continuous, LogNormal, Values
from debrisflow.study.tables import Study

Floats = NDArray[np.float64]
WIDTH = (0.05, 0.95)  # shares, between which a coordinate grows from 0 to 1


class ParameterSpace(NamedTuple):
    """The parameters and what is known of them beforehand.

    A value is known by its share u, that of the prior below it, and by its normal score
    z = Phi^-1(u).  In scores the prior is exactly the normal distribution N(0, R), whatever the
    distributions are, where R holds the correlations; nothing has a bound there.

    Attributes
    ----------
    names : tuple of str
    laws : tuple
        Distributions of :mod:`scipy.stats`.
    is_logarithmic : tuple of bool
        Whether what depends on a parameter is smoother in its logarithm.
    correlation : (parameters, parameters) float64 array
        R, of the normal scores.
    """

    names: tuple[str, ...]
    laws: tuple[Any, ...]
    is_logarithmic: tuple[bool, ...]
    correlation: Floats

    @classmethod
    def of(cls, study: Study) -> ParameterSpace:
        """Return the parameters of a study; only those that can have any value of a range."""
        continuous = [one for one in study.parameter if isinstance(one, Continuous)]
        laws = tuple(one.law for one in continuous)
        names = tuple(one.name for one in continuous)
        logarithmic = tuple(isinstance(one, LogNormal) for one in continuous)
        return cls(names, laws, logarithmic, correlation_matrix(study))

    def shares(self, points: list[Values]) -> Floats:
        """Return the shares of points, (points, parameters)."""
        rows = [
            [law.cdf(point[name]) for name, law in zip(self.names, self.laws, strict=True)]
            for point in points
        ]
        return np.array(rows, dtype=np.float64).reshape(-1, len(self.names))

    def values(self, shares: Floats) -> Floats:
        """Return the values at shares, both (points, parameters)."""
        columns = [law.ppf(shares[:, k]) for k, law in enumerate(self.laws)]
        return np.column_stack(columns)

    def points(self, shares: Floats) -> list[Values]:
        """Return the values at shares by the names of the parameters."""
        rows = self.values(shares).tolist()
        return [dict(zip(self.names, row, strict=True)) for row in rows]

    def coordinates(self, shares: Floats) -> Floats:
        """Return the places of shares for an emulator, both (points, parameters).

        The values, or the logarithms of what is distributed lognormally, from 0 to 1 between 5 and
        95 % of the prior.  Not the shares themselves, in which the tails of a prior are so narrow
        that a model linear in the value would be steep there.
        """
        inside = np.clip(shares, LEAST_SHARE, 1.0 - LEAST_SHARE)
        columns = []
        for k, (law, has_log) in enumerate(zip(self.laws, self.is_logarithmic, strict=True)):
            values = law.ppf(np.append(inside[:, k], WIDTH))
            if has_log:
                values = np.log(values)
            *places, low, high = values
            columns.append((np.array(places) - low) / (high - low))
        return np.column_stack(columns)

    def log_prior(self, scores: Floats) -> Floats:
        """Return the logarithm of the prior density of scores, but for a constant, (points,)."""
        inverse = np.linalg.inv(self.correlation)
        return np.asarray(-0.5 * np.einsum("ni,ij,nj->n", scores, inverse, scores))


def scores_of(shares: Floats) -> Floats:
    """Return the normal scores of shares; finite at 0 and 1 too."""
    return np.asarray(stats.norm.ppf(np.clip(shares, LEAST_SHARE, 1.0 - LEAST_SHARE)))


def shares_of(scores: Floats) -> Floats:
    """Return the shares of normal scores."""
    return np.asarray(stats.norm.cdf(scores))
