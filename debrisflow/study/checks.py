"""Checks of a study that involve several fields."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from typing import get_args

import numpy as np

from debrisflow.case.fields import Interval
from debrisflow.case.problems import Problem, Problems
from debrisflow.case.words import did_you_mean, either
from debrisflow.study.correlations import correlation_matrix
from debrisflow.study.distributions import AnyParameter, Choice
from debrisflow.study.maps.checks import layer_problems, map_problems
from debrisflow.study.places import overlaps
from debrisflow.study.quantities import USUAL
from debrisflow.study.tables import (
    Calibration,
    Figure,
    Grid,
    Morris,
    OneAtATime,
    Quantity,
    RandomDesign,
    Saltelli,
    Study,
)

MOST_MEMBERS = 1_000_000  # as of the designs that state their number
RANDOM = tuple(get_args(one.model_fields["type"].annotation)[0] for one in get_args(RandomDesign))
COLUMNS = ("number", "folder", "state", "seconds", "member")
"""Of the tables of the members, beside the parameters and the quantities."""


def problems_of(study: Study) -> list[Problem]:
    """Return what is wrong with a study whose fields are right by themselves."""
    checks = (
        _parameters,
        _columns,
        _correlations,
        _design,
        _quantities,
        map_problems,
        _observations,
        _areas,
    )
    found = [problem for check in checks for problem in check(study)]
    if study.calibration is not None:
        found += _calibration(study, study.calibration)
    return found


def _parameters(study: Study) -> Problems:
    yield from _twice("parameter", [parameter.name for parameter in study.parameter])
    yield from overlaps(study, lambda key: tuple(key.split(".")))
    for k, parameter in enumerate(study.parameter):
        yield from _bounds(f"parameter.{k}", parameter)
        yield from _choices(f"parameter.{k}", parameter)


def _columns(study: Study) -> Problems:
    """Yield the names that another column of the tables of the members has."""
    parameters = [parameter.name for parameter in study.parameter]
    quantities = [quantity.called for quantity in study.quantity]
    for table, names in (("parameter", parameters), ("quantity", quantities)):
        for k, name in enumerate(names):
            if name in COLUMNS:
                message = "is a column of the table of members; choose another"
                yield Problem(f"{table}.{k}.name", message, name)
    for k, name in enumerate(quantities):
        if name in parameters:
            first = f"parameter.{parameters.index(name)}"
            yield Problem(f"quantity.{k}.name", f"is the name of {first} too; choose another", name)
    for k, name in enumerate(() if quantities else parameters):
        if name in USUAL:
            message = "is the name of an answer of each run too; choose another"
            yield Problem(f"parameter.{k}.name", message, name)


def _bounds(key: str, parameter: AnyParameter) -> Problems:
    """Yield the bounds of a distribution that are not in order."""
    low, likely, high = (getattr(parameter, name, None) for name in ("low", "likely", "high"))
    if low is not None and high is not None and low >= high:
        yield Problem(f"{key}.low", f"must be less than high, {high:g}", low)
    elif likely is not None and not low <= likely <= high:
        yield Problem(f"{key}.likely", f"must lie from low to high, {low:g} to {high:g}", likely)


def _choices(key: str, parameter: AnyParameter) -> Problems:
    """Yield what makes a list of values no choice, or one whose values are not equally likely."""
    if not isinstance(parameter, Choice):
        return
    values = parameter.values
    if len(values) < 2:
        yield Problem(
            f"{key}.values", "must be two or more; set a single one for all under [set]", values
        )
    for k, value in enumerate(values):
        if value in values[:k]:
            yield Problem(f"{key}.values.{k}", "stands in the list before; leave one out", value)


def _twice(table: str, names: list[str]) -> Problems:
    """Yield the names that an entry before has."""
    for k, name in enumerate(names):
        if name in names[:k]:
            first = f"{table}.{names.index(name)}"
            yield Problem(f"{table}.{k}.name", f"is the name of {first} too; choose another", name)


def _correlations(study: Study) -> Problems:
    if not study.correlation:
        return
    if not isinstance(study.design, RandomDesign):
        yield Problem(
            "correlation",
            f"the design '{study.design.type}' sets parameters independently of each other; "
            f"leave correlations out, or use {either(RANDOM)}",
        )
    known = {parameter.name: parameter for parameter in study.parameter}
    faults = list(_pairs(study, known))
    yield from faults
    if not faults and np.linalg.eigvalsh(correlation_matrix(study))[0] <= np.finfo(float).eps:
        yield Problem(
            "correlation",
            "no parameters can go together like this: the coefficients contradict each other "
            "(their matrix is not positive definite); bring the largest nearer to 0",
        )


def _pairs(study: Study, known: Mapping[str, object]) -> Problems:
    seen: set[frozenset[str]] = set()
    for k, correlation in enumerate(study.correlation):
        key, pair = f"correlation.{k}.parameters", frozenset(correlation.parameters)
        for name in correlation.parameters:
            if name not in known:
                yield Problem(key, f"no parameter is named '{name}'{did_you_mean(name, known)}")
            elif isinstance(known[name], Choice):
                yield Problem(
                    key, f"'{name}' has a list of values, which are in no order; leave it out"
                )
        if len(pair) == 1:
            yield Problem(key, "must be two parameters", correlation.parameters)
        if pair in seen:
            yield Problem(key, "have a correlation already; leave one out", correlation.parameters)
        seen.add(pair)


def _design(study: Study) -> Problems:
    design = study.design
    if isinstance(design, OneAtATime):
        low, high = design.shares
        if not 0.0 <= low < high <= 1.0:
            yield Problem(
                "design.shares", "must be two shares from 0 to 1, the lower one first", (low, high)
            )
    if isinstance(design, Saltelli) and design.samples.bit_count() != 1:
        least = 1 << design.samples.bit_length()
        yield Problem(
            "design.samples", f"must be a power of two: {least // 2} or {least}", design.samples
        )
    if (members := _computed_count(study)) > MOST_MEMBERS:
        yield Problem("design", f"gives {members:,} members; at most {MOST_MEMBERS:,} are possible")


def _computed_count(study: Study) -> int:
    """Return how many members a design has that does not state their number; 0 for the others."""
    count = len(study.parameter)
    match study.design:
        case Grid(levels=levels):
            return prod(
                len(one.values) if isinstance(one, Choice) else levels for one in study.parameter
            )
        case Morris(paths=paths):
            return paths * (count + 1)
        case Saltelli(samples=samples):
            return samples * (count + 2)
    return 0


def _quantities(study: Study) -> Problems:
    for k, quantity in enumerate(study.quantity):
        yield from _quantity(f"quantity.{k}", quantity)
    yield from _twice("quantity", [quantity.called for quantity in study.quantity])


def _quantity(key: str, quantity: Quantity) -> Problems:
    if (quantity.answer is None) == (quantity.layer is None):
        yield Problem(key, "needs either an answer, or a layer and the place at which it is read")
    elif quantity.layer is not None:
        yield from layer_problems(f"{key}.layer", quantity.layer)
        if quantity.at is None:
            yield Problem(f"{key}.at", "missing: place on the map at which the layer is read")
    elif quantity.at is not None:
        yield Problem(f"{key}.at", "has no effect on an answer; leave it out", quantity.at)


def _observations(study: Study) -> Problems:
    known = [quantity.called for quantity in study.quantity]
    for k, observation in enumerate(study.observation):
        if isinstance(observation, Figure) and observation.quantity not in known:
            yield Problem(
                f"observation.{k}.quantity",
                f"no [[quantity]] has this name{did_you_mean(observation.quantity, known)}",
                observation.quantity,
            )


def _areas(study: Study) -> Problems:
    areas = [("area", study.area.x, study.area.y)]
    held_out = study.calibration and study.calibration.held_out
    if held_out:
        areas.append(("calibration.held_out", held_out.x, held_out.y))
    for table, x, y in areas:
        yield from _interval(f"{table}.x", x)
        yield from _interval(f"{table}.y", y)


def _interval(key: str, interval: Interval | None) -> Problems:
    if interval is not None and interval[0] >= interval[1]:
        yield Problem(key, "must increase", interval)


def _calibration(study: Study, wanted: Calibration) -> Problems:
    if not study.observation:
        yield Problem("calibration", "needs an [[observation]] that the runs are compared with")
    for k, parameter in enumerate(study.parameter):
        if isinstance(parameter, Choice):
            yield Problem(
                f"parameter.{k}.distribution",
                "a parameter that is calibrated must be able to have any value of a range",
                parameter.distribution,
            )
    design = study.design
    if not isinstance(design, RandomDesign):
        yield Problem("design.type", f"a calibration needs {either(RANDOM)}", design.type)
    elif wanted.runs < design.members:
        yield Problem(
            "calibration.runs", f"must be at least design.members, {design.members}", wanted.runs
        )
