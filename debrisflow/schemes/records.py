"""Records of a case, as the kernels take them."""

from __future__ import annotations

from importlib import import_module
from inspect import signature

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.lattice import Reference
from debrisflow.particles.matter import concentrations, reference_density
from debrisflow.physics.compressible import Numbers
from debrisflow.physics.drag import DragLaw
from debrisflow.physics.kinetic_theory import Grains
from debrisflow.physics.rheology import Law
from debrisflow.space.gravity import gravity_vector

ERGUN_FROM = {"gidaspow": 0.2, "wen-yu": np.inf}


def law_of(case: ResolvedCase) -> Law:
    """Return the record of a checked case's rheological law.

    It is made by what the file in ``physics/rheology`` with the name of the law's ``type`` calls
    ``law``: the record itself, or a function of what a user states.  It is given by name what it
    asks for of the fields of the table, ``ramp_start`` and ``ramp_end`` of the concentration,
    ``grain_diameter`` and ``grain_density``.
    """
    name = case.rheology.type.replace("-", "_")
    make = import_module(f"debrisflow.physics.rheology.{name}").law
    sediment = case.sediment
    known = dict(case.rheology) | {
        "grain_diameter": sediment.grain_diameter,
        "grain_density": sediment.density,
    }
    if "concentration_ramp" in known:
        known["ramp_start"], known["ramp_end"] = known["concentration_ramp"]
    record: Law = make(**{wanted: known[wanted] for wanted in signature(make).parameters})
    return record


def grains_of(case: ResolvedCase) -> Grains:
    """Return what the stress of colliding grains needs to know of the sediment."""
    return Grains(
        density=case.sediment.density,
        diameter=case.sediment.grain_diameter,
        restitution=case.sediment.restitution,
        packing_limit=case.sediment.packing_limit,
        largest_concentration=case.collision_stress.largest_concentration,
    )


def drag_of(case: ResolvedCase) -> DragLaw:
    """Return the drag of a case that has one."""
    return DragLaw(
        ergun_from=ERGUN_FROM[case.drag.law],
        diameter=case.sediment.grain_diameter,
        density=case.water.density,
        viscosity=case.water.viscosity,
        grain_density=case.sediment.density,
        packing_limit=case.sediment.packing_limit,
    )


def _viscosities(case: ResolvedCase) -> set[float]:
    """Return the Newtonian viscosities of what a case is filled with and supplied by, Pa s."""
    return {
        case.mixture.viscosity if c > 0.0 else case.water.viscosity for c in concentrations(case)
    }


def numbers_of(case: ResolvedCase, lattice: Reference) -> Numbers:
    """Return the constants of the explicit scheme of a case."""
    scheme = case.explicit_scheme
    return Numbers(
        smooth_density=lattice.smooth_density,
        smooth_steepness=lattice.smooth_steepness,
        density=reference_density(case),
        sound_speed=scheme.sound_speed,
        viscosity=max(_viscosities(case)),
        gravity=gravity_vector(case),
        diffusion=scheme.density_diffusion,
        relaxation=scheme.density_relaxation,
        artificial_viscosity=scheme.artificial_viscosity,
        collision_distance=scheme.collision_distance * lattice.spacing or None,
        restitution=scheme.collision_restitution,
    )
