"""The law that a case makes, and the density and buoyancy of its mixture."""

from importlib import import_module
from inspect import signature
from math import radians, tan
from typing import get_args

import pytest

from debrisflow.case.materials import Sediment, Water, bulk_density
from debrisflow.case.rheology import LAWS, Coulomb
from debrisflow.physics.rheology import (
    ramp,
    yield_strength,
    yielding_viscosity,
)
from debrisflow.schemes.records import law_of
from tests.building import consistency_viscosity, tank_case

WATER, ROCK = Water(density=1000.0), Sediment(density=2500.0)
WET, DRY = Coulomb(type="coulomb"), Coulomb(type="coulomb", saturated=False)


def law_from(**rheology):
    """Return the law of a case with a table of rheology."""
    return law_of(tank_case(4, 4, "mixture", rheology=rheology))


def test_the_density_of_a_mixture_is_that_of_its_parts():
    assert bulk_density(0.0, WATER, ROCK, WET) == 1000.0
    assert bulk_density(0.6, WATER, ROCK, WET) == pytest.approx(0.6 * 2500.0 + 0.4 * 1000.0)
    assert bulk_density(1.0, WATER, ROCK, WET) == 2500.0
    assert bulk_density(0.6, WATER, ROCK, DRY) == pytest.approx(0.6 * 2500.0)


def test_no_law_resists_nothing():
    law = law_from(type="none")
    assert ramp(0.5, law) * yield_strength(1e4, 0.5, 1.0, law) == 0.0
    assert consistency_viscosity(0.5, 1.0, law) == 0.0
    assert yielding_viscosity(1e4, 0.0, law) == 0.0


def test_friction_is_that_of_the_angles():
    caps = {"smallest_shear_rate": 0.001, "largest_viscosity": 1e6}
    ramp_of = {"ramp_start": 0.20, "ramp_end": 0.35}
    law = law_from(type="coulomb", friction_angle=30.0)
    assert law._asdict() == {"friction": tan(radians(30.0))} | ramp_of | caps
    law = law_from(type="mu-i", friction_angle=20.9, dynamic_friction_angle=32.76)
    assert law.friction == tan(radians(20.9))
    assert law.friction + law.friction_span == pytest.approx(tan(radians(32.76)))
    assert (law.inertia, law.grain_diameter, law.grain_density) == (0.279, 0.003, 2650.0)


def test_slurries_have_no_friction():
    law = law_from(type="bingham", yield_stress=20.0)
    assert yield_strength(1e4, 0.5, 1.0, law) == 20.0
    law = law_from(type="herschel-bulkley", yield_stress=20.0, consistency=5.0, exponent=0.4)
    assert (law.yield_stress, law.consistency, law.exponent) == (20.0, 5.0, 0.4)
    assert yield_strength(1e4, 0.5, 1.0, law) == 20.0


def test_a_mud_of_o_brien_and_julien_has_its_law_at_any_concentration():
    numbers = {"yield_stress": 0.0181, "yield_growth": 25.7, "consistency": 0.0036}
    law = law_from(type="obrien-julien", viscosity_growth=22.1, **numbers)
    assert (law.yield_growth, law.viscosity_growth) == (25.7, 22.1)
    assert ramp(0.0, law) == 0.0
    assert ramp(1e-6, law) == 1.0


def test_every_law_of_the_case_has_a_file_of_its_formulas():
    for table in LAWS:
        (name,) = get_args(table.model_fields["type"].annotation)
        module = import_module(f"debrisflow.physics.rheology.{name.replace('-', '_')}")
        known = {"grain_diameter", "grain_density", *table.model_fields}
        if "concentration_ramp" in known:
            known |= {"ramp_start", "ramp_end"}
        assert set(signature(module.law).parameters) <= known
