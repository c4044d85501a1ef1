"""Records of a case, as the kernels take them."""

from __future__ import annotations

from math import radians, tan

import numpy as np

from debrisflow.case import tables
from debrisflow.neighbors.lattice import Reference
from debrisflow.particles.matter import reference_density
from debrisflow.physics.compressible import Numbers
from debrisflow.physics.drag import DragLaw
from debrisflow.physics.kinetic_theory import Grains
from debrisflow.physics.rheology import Law
from debrisflow.space.gravity import gravity_vector

ANY_CONCENTRATION = 0.0, 1.0e-9
FRICTIONAL = "coulomb", "mu-i"
ERGUN_FROM = {"gidaspow": 0.2, "wen-yu": np.inf}


def law_of(case: tables.Case) -> Law:
    """Return the law of a checked case; one that resists nothing where the case has none."""
    strength, sediment = case.strength, case.sediment
    static = tan(radians(strength.friction_angle)) if strength.law in FRICTIONAL else 0.0
    dynamic = static
    if strength.law == "mu-i":
        assert strength.dynamic_friction_angle is not None  # the checks see to it
        dynamic = tan(radians(strength.dynamic_friction_angle))
    grows_with_any = strength.law == "obrien-julien"
    start, end = ANY_CONCENTRATION if grows_with_any else strength.concentration_ramp
    is_slurry = strength.law not in ("none", *FRICTIONAL)
    return Law(
        friction=static,
        friction_span=dynamic - static,
        inertia=strength.inertia_number,
        grain_diameter=sediment.grain_diameter,
        grain_density=sediment.density,
        yield_stress=(strength.yield_stress or 0.0) if is_slurry else 0.0,
        yield_growth=(strength.yield_growth or 0.0) if is_slurry else 0.0,
        consistency=(strength.consistency or 0.0) if is_slurry else 0.0,
        exponent=strength.exponent or 1.0,
        viscosity_growth=(strength.viscosity_growth or 0.0) if is_slurry else 0.0,
        ramp_start=start,
        ramp_end=end,
        smallest_shear_rate=strength.smallest_shear_rate,
        largest_viscosity=strength.largest_viscosity,
    )


def grains_of(case: tables.Case) -> Grains:
    """Return what the stress of colliding grains needs to know of the sediment."""
    return Grains(
        density=case.sediment.density,
        diameter=case.sediment.grain_diameter,
        restitution=case.sediment.restitution,
        packing_limit=case.sediment.packing_limit,
        largest_concentration=case.collision_stress.largest_concentration,
    )


def drag_of(case: tables.Case) -> DragLaw:
    """Return the drag of a case that has one."""
    return DragLaw(
        ergun_from=ERGUN_FROM[case.drag.law],
        diameter=case.sediment.grain_diameter,
        density=case.water.density,
        viscosity=case.water.viscosity,
        packing_limit=case.sediment.packing_limit,
    )


def numbers_of(case: tables.Case, lattice: Reference) -> Numbers:
    """Return the constants of the explicit scheme of a case."""
    scheme = case.scheme
    assert isinstance(scheme, tables.ExplicitScheme)
    assert scheme.sound_speed is not None
    assert scheme.density_relaxation is not None
    return Numbers(
        smooth_density=lattice.smooth_density,
        smooth_steepness=lattice.smooth_steepness,
        density=reference_density(case),
        sound_speed=scheme.sound_speed,
        gravity=gravity_vector(case),
        diffusion=scheme.density_diffusion,
        relaxation=scheme.density_relaxation,
        artificial_viscosity=scheme.artificial_viscosity,
        collision_distance=scheme.collision_distance * lattice.spacing,
        restitution=scheme.collision_restitution,
    )
