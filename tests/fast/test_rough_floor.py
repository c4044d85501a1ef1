"""The roughness of a floor, and the mixing length over it, in two and three dimensions."""

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.physics.turbulence import KARMAN
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.terms.eddies import Eddies
from debrisflow.space.floor import floor_roughness
from tests.building import started

ROUGHNESS, IN_RECESS, ON_WEIR = 0.03, 0.06, 0.09


def rough(dimension, value):
    """Return the table of a wall of a roughness."""
    return (
        {"roughness": value} if dimension == 2 else {"friction": {"law": "log", "roughness": value}}
    )


def channel(dimension, mixing_length=0.01):
    """Return a case: water in a channel with a recess and a rough floor."""
    solid = dimension == 3
    shape = {"type": "channel3d", "width": 0.2} if solid else {"type": "channel"}
    block = {"type": "block", "material": "water", "x": [0.0, 0.2]}
    block |= {"y": [0.0, 0.2], "z": [0.0, 0.1]} if solid else {"y": [0.0, 0.1]}
    return complete(
        Case(
            title="rough channel",
            particles={"spacing": 0.02},
            geometry=shape
            | {
                "length": 1.0,
                "height": 0.4,
                "bed_start": 0.3,
                "bed_end": 0.6,
                "bed_thickness": 0.1,
                "weir_height": 0.04,
            },
            walls={
                "floor": rough(dimension, ROUGHNESS),
                "bed": rough(dimension, IN_RECESS),
                "right": rough(dimension, ON_WEIR),
            },
            fill=[block, {"type": "bed"}],
            scheme={"type": "explicit"} if solid else {},
            rheology={"type": "coulomb", "mixing_length": mixing_length},
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_floor_recess_and_weir_have_their_own_roughness(dimension):
    found = floor_roughness(channel(dimension), np.array([0.1, 0.4, 0.8]))
    np.testing.assert_array_equal(found, [ROUGHNESS, IN_RECESS, ON_WEIR])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("has_ground", [False, True])
def test_a_rough_floor_limits_the_mixing_length(dimension, has_ground):
    case = channel(dimension)
    scheme, state = started(case)
    scene = scheme.observe(state)
    p, rows = scene.particles, scene.particles.fluid
    scene.shear_rate = np.full(p.fluid_count, 5.0)
    scene.viscosity = np.zeros(p.moving.stop)
    Eddies(case, has_ground).observe(scene)
    upstream = p.position[rows, 0] < 0.2
    height = p.position[rows, dimension - 1][upstream]
    limit = KARMAN * (np.maximum(height, 0.01) + ROUGHNESS / 30.0)  # of the first row at least
    length = np.full(height.size, 0.01) if has_ground else np.minimum(0.01, limit)
    expected = p.density[rows][upstream] * length**2 * 5.0
    np.testing.assert_allclose(scene.eddies[rows][upstream], expected, rtol=1e-12)
    assert has_ground or length.min() < 0.01


def test_every_scheme_with_a_strength_law_has_eddies():
    for dimension in (2, 3):
        scheme = scheme_of(channel(dimension))
        assert any(isinstance(term, Eddies) for term in scheme.terms)
