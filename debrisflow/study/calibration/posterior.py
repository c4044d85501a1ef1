"""The posterior: how likely values of the parameters are after the observations."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import emcee
import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from debrisflow.study.calibration.emulator import Emulator
from debrisflow.study.calibration.parameter_space import ParameterSpace, scores_of, shares_of

Floats = NDArray[np.float64]
WALKERS, STEPS, MOST_STEPS = 32, 1000, 16_000
TIMES = 50  # autocorrelation times, that a chain must be long
BURN_IN = 5  # autocorrelation times, at the start of a chain, that are left out
ACCEPTANCE = (0.15, 0.8)
FARTHEST, ROWS = 6.0, 4001  # scores of a table, and how many: exact to 1e-6 of a prior's width
STARTS = 12  # power of two, of points of the prior among which the chains start


class Posterior(NamedTuple):
    """A sample of the posterior.

    Attributes
    ----------
    scores : (samples, parameters) float64 array
        Normal scores.
    autocorrelation : float
        The longest of the parameters, in steps.
    steps : int
        Of each chain, those left out at its start among them.
    effective : float
        Independent samples that it is worth.
    acceptance : float
        Share of the moves that were accepted.
    """

    scores: Floats
    autocorrelation: float
    steps: int
    effective: float
    acceptance: float

    @property
    def doubts(self) -> list[str]:
        """Why the sample cannot be relied on, in sentences."""
        found = []
        if not self.steps >= TIMES * self.autocorrelation:  # also if it is nan
            found.append(
                f"The chains of the posterior are too short: {self.steps} steps are less than "
                f"{TIMES} autocorrelation times of {self.autocorrelation:.0f} steps."
            )
        low, high = ACCEPTANCE
        if not low <= self.acceptance <= high:
            found.append(
                f"The chains of the posterior accept {self.acceptance:.0%} of their moves; "
                f"{low:.0%} to {high:.0%} are usual."
            )
        return found


def log_likelihood(emulator: Emulator, places: Floats) -> Floats:
    """Return the logarithm of the likelihood of places, but for a constant, (points,).

    A residual is normal with the mean and the variance v of the emulator, its noise among it, and
    the error of the observation is 1: ``-1/2 sum [m^2 / (1 + v) + ln(1 + v)]``.
    """
    mean, variance, noise = emulator.at(places)
    total = 1.0 + variance + noise
    return np.asarray(-0.5 * (mean**2 / total + np.log(total)).sum(axis=1))


def sampled(emulator: Emulator, space: ParameterSpace, seed: int) -> Posterior:
    """Return a sample of the posterior by an ensemble of chains that stretch moves lead [1]_.

    It is drawn in normal scores, in which the prior is exactly the normal distribution N(0, R) of
    the correlations R and has no bounds.  The chains begin at points of the prior, drawn by their
    likelihood, and grow until they are 50 autocorrelation times long.

    Parameters
    ----------
    emulator : Emulator
    space : ParameterSpace
    seed : int

    References
    ----------
    .. [1] D. Foreman-Mackey, D. W. Hogg, D. Lang, J. Goodman, emcee: the MCMC hammer, PASP 125
       (2013), doi:10.1086/670067
    """
    count = len(space.names)
    walkers = max(WALKERS, 4 * count)
    places = _places(space)

    def log_density(scores: Floats) -> Floats:
        return space.log_prior(scores) + log_likelihood(emulator, places(scores))

    sampler = emcee.EnsembleSampler(walkers, count, log_density, vectorize=True)
    sampler.random_state = np.random.RandomState(seed).get_state()
    state = _start(emulator, space, walkers, seed)
    while True:
        state = sampler.run_mcmc(state, STEPS)
        times = sampler.get_autocorr_time(tol=0)
        longest = float(np.max(times))
        steps = sampler.iteration
        # the steps at the start are besides those that are asked for
        if steps >= (TIMES + BURN_IN) * longest or steps >= MOST_STEPS:
            break
    begin = int(min(BURN_IN * longest, steps / 2)) if np.isfinite(longest) else steps // 2
    apart = max(int(longest / 2), 1) if np.isfinite(longest) else 1
    chain = sampler.get_chain(discard=begin, thin=apart, flat=True)
    effective = walkers * (steps - begin) / longest
    return Posterior(chain, longest, steps, effective, float(sampler.acceptance_fraction.mean()))


def _places(space: ParameterSpace) -> Callable[[Floats], Floats]:
    """Return what gives the places of scores: by a table, since distributions take their time."""
    table = np.linspace(-FARTHEST, FARTHEST, ROWS)
    columns = space.coordinates(shares_of(np.repeat(table[:, None], len(space.names), axis=1))).T

    def places(scores: Floats) -> Floats:
        pairs = zip(scores.T, columns, strict=True)
        return np.column_stack([np.interp(score, table, column) for score, column in pairs])

    return places


def _start(emulator: Emulator, space: ParameterSpace, walkers: int, seed: int) -> Floats:
    """Return points of the prior, drawn without repetition by their likelihood."""
    shares = qmc.Sobol(len(space.names), rng=seed).random_base2(STARTS)
    independent = scores_of(shares)
    scores = independent @ np.linalg.cholesky(space.correlation).T
    weight = log_likelihood(emulator, space.coordinates(shares_of(scores)))
    random = np.random.default_rng(seed)
    chosen = np.argsort(weight + random.gumbel(size=len(weight)))[-walkers:]
    return np.asarray(scores[chosen])
