"""What the observations say of each parameter, and what of combinations only."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from debrisflow.study.calibration.parameter_space import ParameterSpace, shares_of

Floats = NDArray[np.float64]
SHARES = (0.05, 0.5, 0.95)
IDENTIFIED, WEAKLY = 0.5, 0.8  # width of the posterior over that of the prior, at most
COUPLED = 0.7  # correlation, from which two parameters are known by a combination only


class Marginal(NamedTuple):
    """A parameter before and after the observations.

    Attributes
    ----------
    name : str
    prior, posterior : tuple of float
        Values below which 5, 50 and 95 % lie.
    """

    name: str
    prior: tuple[float, float, float]
    posterior: tuple[float, float, float]

    @property
    def ratio(self) -> float:
        """Width of the 90 % interval of the posterior over that of the prior."""
        return (self.posterior[2] - self.posterior[0]) / (self.prior[2] - self.prior[0])

    @property
    def verdict(self) -> str:
        """How well it is known.

        Examples
        --------
        >>> Marginal("mu", (0.1, 0.2, 0.3), (0.12, 0.2, 0.24)).verdict
        'weakly identified'
        """
        if self.ratio < IDENTIFIED:
            return "identified"
        return "weakly identified" if self.ratio < WEAKLY else "not identified"


class Coupled(NamedTuple):
    """Two parameters of which the observations tell a combination.

    Attributes
    ----------
    names : tuple of str
    correlation : float
        Of their normal scores in the posterior.
    known, unknown : tuple of float
        Directions of unit length in normal scores of the prior: along the first the posterior is
        narrowest, along the second widest.
    trade : tuple of float
        Changes of the two that make up for each other, in their own units: one standard deviation
        to both sides along the second direction, from the median.
    """

    names: tuple[str, str]
    correlation: float
    known: tuple[float, float]
    unknown: tuple[float, float]
    trade: tuple[float, float]


def marginals(space: ParameterSpace, scores: Floats) -> list[Marginal]:
    """Return each parameter before and after, from a sample of normal scores."""
    found = []
    for k, (name, law) in enumerate(zip(space.names, space.laws, strict=True)):
        low, middle, high = law.ppf(shares_of(np.quantile(scores[:, k], SHARES))).tolist()
        found.append(Marginal(name, tuple(law.ppf(SHARES).tolist()), (low, middle, high)))
    return found


def coupled(space: ParameterSpace, scores: Floats) -> list[Coupled]:
    """Return the pairs whose correlation exceeds 0.7, the strongest first.

    Parameters
    ----------
    space : ParameterSpace
    scores : (samples, parameters) float64 array
        Normal scores of the posterior.
    """
    pairs = []
    for i, j in combinations(range(len(space.names)), 2):
        both = scores[:, [i, j]]
        correlation = float(np.asarray(np.corrcoef(both.T))[0, 1])
        if abs(correlation) <= COUPLED:
            continue
        variances, directions = np.linalg.eigh(np.cov(both.T))
        # signs so that the first of the pair grows along the unknown direction
        known, unknown = (column * np.sign(column[0]) for column in directions.T)
        middle, step = np.quantile(both, 0.5, axis=0), np.sqrt(variances[1]) * unknown
        ends = [
            [law.ppf(norm.cdf(place[k])) for k, law in enumerate((space.laws[i], space.laws[j]))]
            for place in (middle - step, middle + step)
        ]
        trade = np.subtract(ends[1], ends[0]).tolist()
        names = space.names[i], space.names[j]
        pairs.append(
            Coupled(names, correlation, tuple(known), tuple(unknown), (trade[0], trade[1]))
        )
    return sorted(pairs, key=lambda pair: -abs(pair.correlation))


def sentences(found: Sequence[Marginal], pairs: Sequence[Coupled]) -> list[str]:
    """Return what is known of the parameters in plain words."""
    identified = {one.name for one in found if one.verdict == "identified"}
    of_pairs = [_of_two(pair, identified.issuperset(pair.names)) for pair in pairs]
    return [*map(_of_one, found), *of_pairs]


def _of_one(one: Marginal) -> str:
    low, middle, high = one.posterior
    told = f"{one.name} is {one.verdict}: {middle:.3g}, with 90 % from {low:.3g} to {high:.3g}"
    width = f"the interval is {one.ratio:.0%} as wide as before"
    if one.verdict == "not identified":
        return f"{told}; {width}, so that the observations say next to nothing of it by itself."
    return f"{told}; {width}."


def _of_two(pair: Coupled, are_identified: bool) -> str:
    (first, second), (one, other) = pair.names, pair.trade
    change = "more" if other > 0.0 else "less"
    told = (
        f"The errors of {first} and {second} go together"
        if are_identified
        else f"Of {first} and {second} only a combination is known"
    )
    return (
        f"{told} (correlation {pair.correlation:.2f}): {abs(one):.2g} more of {first} with "
        f"{abs(other):.2g} {change} of {second} fits as well."
    )
