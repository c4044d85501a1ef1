"""The strength of a case, as the kernels take it."""

from __future__ import annotations

from importlib import import_module
from inspect import signature

from debrisflow.case import ResolvedCase
from debrisflow.physics.rheology import Law


def law_of(case: ResolvedCase) -> Law:
    """Return the record of a checked case's law of strength.

    It is made by the function ``law`` of the file in ``physics/rheology`` that has the name of the
    law's ``type``, which is given the fields of the table that it asks for by their names, and
    ``grain_diameter`` and ``grain_density``.
    """
    name = case.strength.type.replace("-", "_")
    make = import_module(f"debrisflow.physics.rheology.{name}").law
    sediment = case.sediment
    known = dict(case.strength) | {
        "grain_diameter": sediment.grain_diameter,
        "grain_density": sediment.density,
    }
    record: Law = make(**{wanted: known[wanted] for wanted in signature(make).parameters})
    return record
