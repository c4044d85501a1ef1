"""Sensitivity: how much of a quantity each parameter makes, by SALib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.run.tables import write_table
from debrisflow.study.designs import numbers_of, problem_of
from debrisflow.study.distributions import Values
from debrisflow.study.tables import (
    LatinHypercube,
    Morris,
    OneAtATime,
    Saltelli,
    SobolSequence,
    Study,
)

Floats = NDArray[np.float64]
HARMONICS = 4  # of RBD-FAST: with 6 or 10 the Ishigami function is met no better, see the notes
LEAST_MEMBERS = 32  # of RBD-FAST
OF_HALVES = 0.5**0.5  # its bootstrap draws half as many members as there are, which scatter more
LEAST_BLOCKS = 2  # from which there is a scatter
HEAD = (
    "S1: share of the variance that the parameter makes alone, or with those that are correlated "
    "with it; ST: with all its interactions",
    "mu_star: mean size of the change of the quantity per change of the parameter, as a share of "
    "all its values below, by 1; sigma: standard deviation of these changes",
    "range: greatest less least value with the others at their medians",
    "confidence: half the width of the 95 % interval, by bootstrap; nan where there is none",
    "members: those used; of a block, or a path, with a missing value none is used",
)


class Effect(NamedTuple):
    """What one parameter does to one quantity.

    Attributes
    ----------
    quantity, parameter : str
    measure : str
        ``S1``, ``ST``, ``mu_star``, ``sigma`` or ``range``.
    value : float
        nan where the members do not give it.
    confidence : float
        Half the width of the 95 % interval; nan where there is none.
    method : str
    members : int
        Used for it.
    """

    quantity: str
    parameter: str
    measure: str
    value: float
    confidence: float
    method: str
    members: int


def sensitivity(study: Study, points: Sequence[Values], values: Floats, name: str) -> list[Effect]:
    """Return what each parameter does to a quantity, by the method that fits the design.

    Members that failed or give no value are left out: of a Morris or Saltelli design with the
    whole path or block, as a path needs each of its steps, and of a range of one at a time with the
    whole range, which would be too small otherwise.

    Parameters
    ----------
    study : Study
    points : sequence of dict
        Of the members of the design, in its order.
    values : (members,) float64 array
        Of the quantity; nan where there is none.
    name : str
        Of the quantity.

    Returns
    -------
    list of Effect
        None for a grid and for scenarios, which are no sample of the distributions.

    Notes
    -----
    RBD-FAST [1]_ [2]_ takes the first-order shares from any random sample, correlated ones too,
    where a share then holds what the parameter and those that go with it make together.  On the
    Ishigami function, 60 samples each, nine in ten have all three shares within 0.11 of the closed
    form with 128 members of a Latin hypercube, 0.07 with 256, 0.06 with 512 and 0.05 with 1024;
    with a Sobol sequence, whose pattern it may take for an effect, 0.21, 0.10, 0.03 and 0.01.
    With 10 harmonics a Latin hypercube gives 0.13, 0.08, 0.06 and 0.04.  Of a stair, as the values
    of a list make one, four harmonics hold nine tenths of the variance.  SALib's bootstrap of
    halves is brought to all members; 94 to 99 in 100 of these intervals then hold the closed form,
    of this function and of a linear one, with 64 to 1024 members.

    References
    ----------
    .. [1] S. Tarantola, D. Gatelli, T. A. Mara, Random balance designs for the estimation of first
       order global sensitivity indices, Reliability Engineering & System Safety 91 (2006),
       doi:10.1016/j.ress.2005.06.003
    .. [2] J.-Y. Tissot, C. Prieur, Bias correction for the estimation of sensitivity indices based
       on random balance designs, Reliability Engineering & System Safety 107 (2012),
       doi:10.1016/j.ress.2012.06.010
    """
    numbers = np.column_stack([numbers_of(one, points) for one in study.parameter])
    values = np.where(np.isfinite(values), values, np.nan)
    match study.design:
        case Morris():
            return _elementary_effects(study, study.design, numbers, values, name)
        case Saltelli():
            return _variance_shares(study, study.design, values, name)
        case LatinHypercube() | SobolSequence():
            return _given_data(study, study.design.seed, numbers, values, name)
        case OneAtATime():
            return _ranges(study, numbers, values, name)
    return []


def sensitivity_table(
    study: Study, points: Sequence[Values], quantities: Mapping[str, Floats]
) -> list[Effect]:
    """Return what each parameter does to each quantity, see :func:`sensitivity`."""
    return [
        effect
        for name, values in quantities.items()
        for effect in sensitivity(study, points, values, name)
    ]


def write_sensitivity(path: Path, effects: Sequence[Effect]) -> None:
    """Write a table of effects.

    Raises
    ------
    OutputError
        If the operating system refuses.
    """
    write_table(path, Effect._fields, HEAD, effects)


def _elementary_effects(
    study: Study, design: Morris, numbers: Floats, values: Floats, name: str
) -> list[Effect]:
    """Return the mean size and the scatter of the elementary effects."""
    from SALib.analyze.morris import analyze

    size = len(study.parameter) + 1
    whole = _whole(values, size)
    rows = np.repeat(whole, size)
    used, nothing = int(rows.sum()), np.full(size - 1, np.nan)
    mu_star = sigma = confidence = nothing
    if whole.sum() >= LEAST_BLOCKS:
        found = analyze(
            problem_of(study.parameter),
            numbers[rows],
            values[rows],
            num_levels=design.levels,
            seed=design.seed,
        )
        mu_star, sigma = np.asarray(found["mu_star"]), np.asarray(found["sigma"])
        confidence = np.asarray(found["mu_star_conf"])
    method = "Morris, elementary effects"
    return [
        *_effects(study, name, "mu_star", mu_star, confidence, method, used),
        *_effects(study, name, "sigma", sigma, nothing, method, used),
    ]


def _variance_shares(study: Study, design: Saltelli, values: Floats, name: str) -> list[Effect]:
    """Return the shares of the variance, alone and with interactions."""
    from SALib.analyze.sobol import analyze

    size = len(study.parameter) + 2
    whole = _whole(values, size)
    blocks = values.reshape(-1, size)[whole]
    nothing = np.full(size - 2, np.nan)
    found = dict.fromkeys(("S1", "S1_conf", "ST", "ST_conf"), nothing)
    if len(blocks) >= LEAST_BLOCKS and np.ptp(blocks[:, [0, -1]]) > 0.0:
        found = analyze(
            problem_of(study.parameter),
            blocks.ravel(),
            calc_second_order=False,
            seed=design.seed + 1,  # with 0 its random numbers would differ each time
        )
    method = "Saltelli, Sobol indices"
    return [
        effect
        for key in ("S1", "ST")
        for effect in _effects(
            study, name, key, found[key], found[f"{key}_conf"], method, blocks.size
        )
    ]


def _given_data(
    study: Study, seed: int, numbers: Floats, values: Floats, name: str
) -> list[Effect]:
    """Return the first-order shares of the variance from a random sample."""
    from SALib.analyze.rbd_fast import analyze

    # In random order, since members with the same value of a parameter are taken as they come.
    order = np.random.default_rng(seed).permutation(len(values))
    order = order[~np.isnan(values[order])]
    share = confidence = np.full(len(study.parameter), np.nan)
    if len(order) >= LEAST_MEMBERS and np.ptp(values[order]) > 0.0:
        found = analyze(
            problem_of(study.parameter), numbers[order], values[order], M=HARMONICS, seed=seed + 1
        )
        share, confidence = np.array(found["S1"]), OF_HALVES * np.array(found["S1_conf"])
    method = f"RBD-FAST, {HARMONICS} harmonics"
    return _effects(study, name, "S1", share, confidence, method, len(order))


def _ranges(study: Study, numbers: Floats, values: Floats, name: str) -> list[Effect]:
    """Return the range of the quantity that each parameter makes while the others do not vary."""
    effects = []
    for k, parameter in enumerate(study.parameter):
        own = values[moved_alone(numbers, k)]
        there = int(np.isfinite(own).sum())
        effects.append(
            Effect(
                name, parameter.name, "range", float(np.ptp(own)), np.nan, "one at a time", there
            )
        )
    return effects


def moved_alone(numbers: Floats, k: int) -> NDArray[np.intp]:
    """Return the base of a design of one at a time, and the members that move one parameter.

    Parameters
    ----------
    numbers : (members, parameters) float64 array
        Values of the parameters.
    k : int
        Of the parameter.

    Returns
    -------
    (count,) int64 array
        Places among the members; the first is the base, 0.
    """
    moved = np.flatnonzero(numbers[:, k] != numbers[0, k])
    return np.concatenate([[0], moved])


def _whole(values: Floats, size: int) -> NDArray[np.bool_]:
    """Return which blocks of so many members have all their values."""
    return np.asarray(np.isfinite(values.reshape(-1, size)).all(axis=1))


def _effects(
    study: Study,
    quantity: str,
    measure: str,
    values: Floats,
    confidences: Floats,
    method: str,
    members: int,
) -> list[Effect]:
    return [
        Effect(quantity, one.name, measure, float(value), float(confidence), method, members)
        for one, value, confidence in zip(study.parameter, values, confidences, strict=True)
    ]
