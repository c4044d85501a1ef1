"""Expected improvement: where the next run is most likely to reduce the misfit."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import norm, qmc

from debrisflow.study.calibration.emulator import Emulator
from debrisflow.study.calibration.observations import misfits
from debrisflow.study.calibration.parameter_space import ParameterSpace

Floats = NDArray[np.float64]
NEGLIGIBLE = 0.01  # of a misfit, in which a difference of 1 is one error of one observation
CANDIDATES, DRAWS = 10, 8  # powers of two
BEST_RUNS, AROUND, NEAR = 3, 64, 0.05  # candidates near runs, and how near, as shares
EDGES = (0.005, 0.995)  # shares between which runs are chosen: a prior may have no bounds
SEARCHES = 3
LEAST_DISTANCE = 0.01  # share, between two runs
FROM_FAILURES = 0.1  # share, since what lies beside a run that failed is likely to fail too


class Proposal(NamedTuple):
    """Where to compute next.

    Attributes
    ----------
    shares : (points, parameters) float64 array
    improvement : float
        Expected of the first of them: by how much the least misfit would fall.
    """

    shares: Floats
    improvement: float


def proposed(
    emulator: Emulator, space: ParameterSpace, runs: Floats, failed: Floats, count: int, seed: int
) -> Proposal:
    """Return the points of greatest expected improvement.

    The improvement of a point is the mean of ``max(J_min - J, 0)`` where J is the sum of squares of
    normal residuals, over draws of these; all points share the draws.  After each point of several
    the emulator takes for granted what it expects there, so that they keep apart [1]_; they are
    fewer than wanted if nothing more can be expected.

    Parameters
    ----------
    emulator : Emulator
    space : ParameterSpace
    runs, failed : (runs, parameters) float64 array
        Shares of the runs of the emulator, and of those that failed.
    count : int
        Of points that are computed at the same time, at most.
    seed : int

    References
    ----------
    .. [1] D. Ginsbourger, R. Le Riche, L. Carraro, Kriging is well-suited to parallelize
       optimization, in Computational Intelligence in Expensive Optimization Problems (2010),
       doi:10.1007/978-3-642-10701-6_6
    """
    least = float(misfits(emulator.residuals).min())
    draws = _draws(emulator.residuals.shape[1], seed)
    points: list[Floats] = []
    improvements: list[float] = []
    best = runs[np.argsort(misfits(emulator.residuals))[:BEST_RUNS]]
    candidates = _candidates(best, seed)
    for _ in range(count):
        taken = np.vstack([runs, *points])

        def gains(shares: Floats, emulator: Emulator = emulator, taken: Floats = taken) -> Floats:
            is_free = _is_apart(shares, taken, LEAST_DISTANCE)
            is_free &= _is_apart(shares, failed, FROM_FAILURES)
            places = space.coordinates(shares)
            return np.where(is_free, expected_improvement(emulator, places, draws, least), 0.0)

        point, gain = _greatest(gains, candidates)
        if points and gain <= 0.0:
            break
        points.append(point)
        improvements.append(gain)
        emulator = emulator.believing(space.coordinates(point[None, :]))
    return Proposal(np.array(points), improvements[0])


def expected_improvement(emulator: Emulator, places: Floats, draws: Floats, least: float) -> Floats:
    """Return by how much runs at some places would reduce the least misfit on average, (points,).

    Parameters
    ----------
    emulator : Emulator
    places : (points, parameters) float64 array
    draws : (draws, residuals) float64 array
        Of standard normal numbers.
    least : float
        Misfit so far.
    """
    mean, variance, _ = emulator.at(places)
    misfit = np.zeros((len(places), len(draws)))
    for k in range(mean.shape[1]):
        misfit += (mean[:, k, None] + np.sqrt(variance[:, k, None]) * draws[:, k]) ** 2
    return np.asarray(np.maximum(least - misfit, 0.0).mean(axis=1))


def _is_apart(shares: Floats, taken: Floats, least: float) -> NDArray[np.bool_]:
    """Return whether points are farther than a distance from all that are taken."""
    distance = np.abs(shares[:, None, :] - taken).max(axis=2)
    return np.asarray((distance >= least).all(axis=1))


def _draws(residuals: int, seed: int) -> Floats:
    shares = qmc.Sobol(residuals, rng=seed).random_base2(DRAWS)
    return np.asarray(norm.ppf(np.clip(shares, 1e-9, 1.0 - 1e-9)))


def _greatest(gains: Callable[[Floats], Floats], candidates: Floats) -> tuple[Floats, float]:
    """Return the point of greatest gain, by searches from the best of the candidates."""
    found = gains(candidates)
    best = (candidates[int(np.argmax(found))], float(found.max()))
    count = candidates.shape[1]
    for k in np.argsort(found)[-SEARCHES:]:
        search = minimize(
            lambda place: -gains(place[None, :])[0],
            candidates[k],
            method="Nelder-Mead",
            bounds=[EDGES] * count,
            options={"maxfev": 60 * count, "xatol": 1e-3, "fatol": 1e-4},
        )
        if -search.fun > best[1]:
            best = (search.x, float(-search.fun))
    return best


def _candidates(best: Floats, seed: int) -> Floats:
    """Return points over all shares, and around the best runs."""
    count = best.shape[1]
    evenly = qmc.scale(
        qmc.Sobol(count, rng=seed).random_base2(CANDIDATES), [EDGES[0]] * count, [EDGES[1]] * count
    )
    random = np.random.default_rng(seed)
    off = NEAR * random.standard_normal((AROUND * len(best), count))
    return np.vstack([evenly, np.clip(np.repeat(best, AROUND, axis=0) + off, *EDGES)])
