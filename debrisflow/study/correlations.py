"""Parameters that go together: correlated normal scores, a Gaussian copula."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from debrisflow.study.tables import Study

Floats = NDArray[np.float64]
LEAST_SHARE = 2.0**-31  # half a step of a Sobol sequence, so that no normal score is infinite


def correlation_matrix(study: Study) -> Floats:
    """Return the correlations of the normal scores of the parameters, in their order.

    Parameters
    ----------
    study : Study

    Returns
    -------
    (parameters, parameters) float64 array
    """
    place = {parameter.name: k for k, parameter in enumerate(study.parameter)}
    matrix = np.eye(len(place))
    for pair in study.correlation:
        i, j = (place[name] for name in pair.parameters)
        matrix[i, j] = matrix[j, i] = pair.coefficient
    return matrix


def correlated(shares: Floats, matrix: Floats) -> Floats:
    """Return shares whose normal scores are correlated, from independent ones.

    Parameters
    ----------
    shares : (members, parameters) float64 array
        Independent, each between 0 and 1.
    matrix : (parameters, parameters) float64 array
        Correlations, positive definite.

    Returns
    -------
    (members, parameters) float64 array

    Examples
    --------
    >>> both = correlated(np.array([[0.9, 0.5]]), np.array([[1.0, 0.6], [0.6, 1.0]]))
    >>> stats.norm.ppf(both) / stats.norm.ppf(0.9)
    array([[1. , 0.6]])
    """
    scores = stats.norm.ppf(np.clip(shares, LEAST_SHARE, 1.0 - LEAST_SHARE))
    return np.asarray(stats.norm.cdf(scores @ np.linalg.cholesky(matrix).T))


def in_order_of(shares: Floats, others: Floats) -> Floats:
    """Return the shares of each parameter in the order of others, so that they go together alike.

    A Latin hypercube stays one: each stratum still has its member [1]_.

    Parameters
    ----------
    shares, others : (members, parameters) float64 array

    Returns
    -------
    (members, parameters) float64 array

    References
    ----------
    .. [1] R. L. Iman, W. J. Conover, A distribution-free approach to inducing rank correlation
       among input variables, Communications in Statistics B 11 (1982),
       doi:10.1080/03610918208812265

    Examples
    --------
    >>> in_order_of(np.array([[0.1], [0.5], [0.9]]), np.array([[7.0], [3.0], [5.0]])).ravel()
    array([0.9, 0.1, 0.5])
    """
    ranks = np.argsort(np.argsort(others, axis=0), axis=0)
    return np.take_along_axis(np.sort(shares, axis=0), ranks, axis=0)
