"""Designs: at which values of the parameters the case is computed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from debrisflow.study.correlations import correlated, correlation_matrix, in_order_of
from debrisflow.study.distributions import AnyParameter, Choice, Value, Values
from debrisflow.study.scenarios import read_scenarios
from debrisflow.study.tables import (
    AnyDesign,
    Grid,
    LatinHypercube,
    Morris,
    OneAtATime,
    RandomDesign,
    Saltelli,
    Scenarios,
    SobolSequence,
    Study,
)

Floats = NDArray[np.float64]
MIDDLE = 0.5


def points_of(study: Study) -> list[Values]:
    """Return the values of the parameters of each member of the design, in its order.

    Parameters
    ----------
    study : Study
        Checked.

    Raises
    ------
    CaseError
        If the file of scenarios is wrong.

    Examples
    --------
    >>> friction = dict(name="mu", key="x", distribution="uniform", low=0.1, high=0.3)
    >>> design = dict(type="grid", levels=3)
    >>> points_of(Study(title="t", case="c.toml", parameter=[friction], design=design))
    [{'mu': 0.1}, {'mu': 0.2}, {'mu': 0.3}]
    """
    parameters, design = study.parameter, study.design
    match design:
        case Scenarios():
            return read_scenarios(Path(design.file), parameters)
        case Grid():
            return _grid(parameters, design.levels)
        case OneAtATime():
            return _one_at_a_time(parameters, design.shares)
        case LatinHypercube():
            shares = _latin_hypercube(study, design)
        case SobolSequence():
            shares = _sobol_sequence(study, design)
        case Morris():
            shares = _morris(problem_of(parameters), design)
        case Saltelli():
            shares = _saltelli(problem_of(parameters), design)
    columns = [_at(one, shares[:, k]) for k, one in enumerate(parameters)]
    names = [parameter.name for parameter in parameters]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def is_sample(design: AnyDesign) -> bool:
    """Return whether members are drawn from the distributions: shares of them are probabilities.

    Examples
    --------
    >>> is_sample(Morris(type="morris", paths=4)), is_sample(Saltelli(type="saltelli", samples=4))
    (False, True)
    """
    return isinstance(design, RandomDesign | Saltelli)


def problem_of(parameters: Sequence[AnyParameter]) -> dict[str, Any]:
    """Return the parameters as SALib describes them, by their shares."""
    names = [parameter.name for parameter in parameters]
    return {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}


def numbers_of(parameter: AnyParameter, points: Sequence[Values]) -> Floats:
    """Return the values of a parameter as numbers; of a choice the places in its list.

    Parameters
    ----------
    parameter : AnyParameter
    points : sequence of dict

    Returns
    -------
    (members,) float64 array
    """
    values = [point[parameter.name] for point in points]
    if isinstance(parameter, Choice):
        return np.array([parameter.values.index(value) for value in values], dtype=np.float64)
    return np.array(values, dtype=np.float64)


def _at(parameter: AnyParameter, shares: Floats) -> list[Value]:
    """Return the values at some shares; at 0 and 1 the ends of the range, which are finite."""
    if isinstance(parameter, Choice):
        return [parameter.at(share) for share in shares]
    low, high = parameter.range
    inside = parameter.law.ppf(shares)
    values: list[Value] = np.select([shares <= 0.0, shares >= 1.0], [low, high], inside).tolist()
    return values


def _grid(parameters: Sequence[AnyParameter], levels: int) -> list[Values]:
    evenly = np.linspace(0.0, 1.0, levels)
    values: list[list[Value]] = [
        list(one.values) if isinstance(one, Choice) else _at(one, evenly) for one in parameters
    ]
    names = [parameter.name for parameter in parameters]
    return [dict(zip(names, row, strict=True)) for row in product(*values)]


def _one_at_a_time(parameters: Sequence[AnyParameter], shares: tuple[float, float]) -> list[Values]:
    middle = {parameter.name: parameter.at(MIDDLE) for parameter in parameters}
    points = [middle]
    for one in parameters:
        if isinstance(one, Choice):
            others = [value for value in one.values if value != middle[one.name]]
        else:
            others = _at(one, np.array(shares))
        points += [middle | {one.name: value} for value in others]
    return points


def _latin_hypercube(study: Study, design: LatinHypercube) -> Floats:
    sampler = qmc.LatinHypercube(len(study.parameter), rng=design.seed)
    shares: Floats = sampler.random(design.members)
    if not study.correlation:
        return shares
    return in_order_of(shares, correlated(shares, correlation_matrix(study)))


def _sobol_sequence(study: Study, design: SobolSequence) -> Floats:
    sampler = qmc.Sobol(len(study.parameter), rng=design.seed)
    # a whole power of two is drawn, so that a longer sequence with this seed begins alike
    shares: Floats = sampler.random_base2((design.members - 1).bit_length())[: design.members]
    return correlated(shares, correlation_matrix(study)) if study.correlation else shares


def _morris(problem: dict[str, Any], design: Morris) -> Floats:
    from SALib.sample.morris import sample

    shares: Floats = sample(problem, design.paths, num_levels=design.levels, seed=design.seed)
    steps = design.levels - 1
    return np.round(shares * steps) / steps  # exactly at the levels, also beside a choice's edge


def _saltelli(problem: dict[str, Any], design: Saltelli) -> Floats:
    from SALib.sample.sobol import sample

    shares: Floats = sample(problem, design.samples, calc_second_order=False, seed=design.seed)
    return shares
