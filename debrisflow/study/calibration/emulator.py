"""An emulator: what runs that were not computed would give, with how uncertain that is."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve, solve_triangular
from scipy.optimize import minimize
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

Floats = NDArray[np.float64]
RESTARTS = 4
WIDE = (1e-15, 1e15)  # bounds that the priors keep the hyperparameters away from
# median and deviation of the logarithm: of the variance of a residual, of its lengths as parts of
# the 90 % interval of the prior, and of the noise in that variance
VARIANCE, LENGTH, NOISE = (1.0, 1.0), (0.7, 1.0), (1e-3, 2.0)


class Prediction(NamedTuple):
    """Residuals at points that were not computed: independent and normal.

    Attributes
    ----------
    mean : (points, residuals) float64 array
    variance : (points, residuals) float64 array
        Of the smooth part: what is not known for lack of runs.
    noise : (residuals,) float64 array
        Variance of what is not smooth: particles that stop a cell farther on.
    """

    mean: Floats
    variance: Floats
    noise: Floats


class LeaveOneOut(NamedTuple):
    """Each residual of each run by an emulator of the others.

    Attributes
    ----------
    predicted, deviation, computed : (runs, residuals) float64 array
    """

    predicted: Floats
    deviation: Floats
    computed: Floats

    @property
    def rms(self) -> Floats:
        """Root mean square of the error of each residual, in errors of the observation."""
        return np.asarray(np.sqrt(np.mean((self.predicted - self.computed) ** 2, axis=0)))

    @property
    def standardized(self) -> Floats:
        """The errors over the deviations the emulator states: about 1 if these are honest."""
        return np.asarray((self.predicted - self.computed) / self.deviation)

    @property
    def explained(self) -> Floats:
        """Share of the variance of each residual that is explained, Q2; 1 is perfect."""
        spread = self.computed.var(axis=0)
        error = ((self.predicted - self.computed) ** 2).mean(axis=0)
        return np.asarray(1.0 - np.divide(error, spread, where=spread > 0.0, out=0.0 * spread))


class Emulator:
    """Gaussian processes, one for each residual.

    Of residuals, since they are smoother than their squares: the misfit follows from them exactly.
    The covariance is that of Matern with nu = 5/2 and one length for each parameter, and a noise.
    These are the most likely ones under wide lognormal priors, which keep them finite where a
    residual does not depend on a parameter, or runs are few.

    Parameters
    ----------
    places : (runs, parameters) float64 array
        Of the runs, see :meth:`ParameterSpace.coordinates`.
    residuals : (runs, residuals) float64 array
    seed : int

    References
    ----------
    Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, MIT Press, sections 2.2,
    4.2 and 5.4.2.
    """

    def __init__(self, places: Floats, residuals: Floats, seed: int) -> None:
        self.places, self.residuals = places, residuals
        self._processes = [_fitted(places, column, seed) for column in residuals.T]

    def at(self, places: Floats) -> Prediction:
        """Return the residuals at places, (points, parameters)."""
        found = [_predicted(process, places) for process in self._processes]
        mean, variance = (np.column_stack(parts) for parts in zip(*found, strict=True))
        return Prediction(mean, variance, np.array([_noise(one) for one in self._processes]))

    def believing(self, places: Floats) -> Emulator:
        """Return the emulator as if runs at some places had given what it expects there."""
        other = copy.copy(self)
        other.places = np.vstack([self.places, places])
        other.residuals = np.vstack([self.residuals, self.at(places).mean])
        other._processes = [
            _conditioned(process, other.places, column)
            for process, column in zip(self._processes, other.residuals.T, strict=True)
        ]
        return other

    def left_out(self) -> LeaveOneOut:
        """Return each residual of each run by the others, with the same covariance."""
        found = [_left_out(process) for process in self._processes]
        predicted, deviation = (np.column_stack(parts) for parts in zip(*found, strict=True))
        return LeaveOneOut(predicted, deviation, self.residuals)


def _fitted(places: Floats, values: Floats, seed: int) -> GaussianProcessRegressor:
    count = places.shape[1]
    kernel = ConstantKernel(VARIANCE[0], WIDE) * Matern(
        [LENGTH[0]] * count, [WIDE] * count, nu=2.5
    ) + WhiteKernel(NOISE[0], WIDE)
    process = GaussianProcessRegressor(
        kernel, optimizer=_most_likely(count, seed), normalize_y=True, random_state=seed
    )
    return process.fit(places, values)


def _conditioned(
    process: GaussianProcessRegressor, places: Floats, values: Floats
) -> GaussianProcessRegressor:
    """Return a process with the covariance of another, through other values."""
    other = GaussianProcessRegressor(process.kernel_, optimizer=None, normalize_y=True)
    return other.fit(places, values)


def _most_likely(count: int, seed: int) -> Callable[..., tuple[Floats, float]]:
    """Return the search for the hyperparameters of greatest posterior density."""
    priors = [VARIANCE, *[LENGTH] * count, NOISE]
    middle = np.log([median for median, _ in priors])
    deviation = np.array([spread for _, spread in priors])

    def search(
        negative: Callable[[Floats], tuple[float, Floats]], initial: Floats, bounds: Floats
    ) -> tuple[Floats, float]:
        def cost(theta: Floats) -> tuple[float, Floats]:
            value, slope = negative(theta)
            off = (theta - middle) / deviation
            return value + 0.5 * float(off @ off), slope + off / deviation

        random = np.random.default_rng(seed)
        starts = [initial, *(middle + deviation * random.standard_normal((RESTARTS, len(middle))))]
        found = [
            minimize(cost, start, jac=True, method="L-BFGS-B", bounds=bounds) for start in starts
        ]
        best = min(found, key=lambda one: one.fun)
        return best.x, best.fun

    return search


def _scale(process: GaussianProcessRegressor) -> tuple[float, float]:
    """Return the mean and the deviation by which the values were standardized."""
    return float(process._y_train_mean), float(process._y_train_std)


def _noise(process: GaussianProcessRegressor) -> float:
    return float(process.kernel_.k2.noise_level) * _scale(process)[1] ** 2


def _predicted(process: GaussianProcessRegressor, places: Floats) -> tuple[Floats, Floats]:
    """Return mean and variance without noise; as of scikit-learn, ten times as fast for a few."""
    smooth = process.kernel_.k1
    middle, deviation = _scale(process)
    across = smooth(places, process.X_train_)
    explained = solve_triangular(process.L_, across.T, lower=True, check_finite=False)
    variance = smooth.diag(places) - (explained**2).sum(axis=0)
    return middle + deviation * (across @ process.alpha_), deviation**2 * np.maximum(variance, 0.0)


def _left_out(process: GaussianProcessRegressor) -> tuple[Floats, Floats]:
    """Return mean and deviation of each value by the others, from the inverse covariance."""
    inverse = cho_solve((process.L_, True), np.eye(len(process.X_train_)))
    weight = np.diag(inverse)
    middle, deviation = _scale(process)
    mean = process.y_train_ - process.alpha_ / weight
    return middle + deviation * mean, deviation / np.sqrt(weight)
