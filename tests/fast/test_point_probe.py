"""The probe at a point: exact for linear fields, dry where there is no fluid, mean of its row."""

import numpy as np
import pytest

from debrisflow.run.probes import samplers
from tests.building import started, tank3d_case, tank_case

SLOPES = np.array([[2.0, -1.0, 0.5], [0.3, 4.0, -2.0], [1.0, 0.0, 3.0]])


def moving(dimension, **place):
    """Return a case with a probe at a point, and a state whose velocity varies linearly."""
    probe = {"name": "gauge", "type": "point", "interval": 0.1} | place
    build = {2: lambda **t: tank_case(10, 10, "water", **t), 3: tank3d_case}[dimension]
    case = build(probe=[probe])
    _, state = started(case)
    p = state.particles
    d0 = case.particles.spacing
    p.position[p.fluid, :dimension] += (
        0.2 * d0 * np.random.default_rng(2).uniform(-1.0, 1.0, (p.fluid_count, dimension))
    )
    p.velocity[p.fluid, :dimension] = (
        1.0 + p.position[p.fluid, :dimension] @ (SLOPES[:dimension, :dimension])
    )
    p.pressure[p.fluid] = 500.0 - 700.0 * p.position[p.fluid, dimension - 1]
    return case, state


@pytest.mark.parametrize(
    ("dimension", "place"),
    [
        (2, (0.05, 0.05)),
        (2, (0.0, 0.031)),  # on a wall
        (2, (0.05, 0.099)),  # under the surface
        (3, (0.3, 0.3, 0.25)),
        (3, (0.0, 0.0, 0.0)),  # in a corner
    ],
)
def test_a_linear_field_is_exact_anywhere(dimension, place):
    case, state = moving(dimension, **dict(zip("xyz", place, strict=False)))
    *velocity, pressure, concentration, wet = samplers(case, state)["gauge"].sample(state)
    expected = 1.0 + np.array(place) @ SLOPES[:dimension, :dimension]
    np.testing.assert_allclose(velocity, expected, rtol=1e-9)
    assert pressure == pytest.approx(500.0 - 700.0 * place[-1], rel=1e-9)
    assert (concentration, wet) == (0.0, 1.0)


def test_a_dry_point_has_no_flow():
    case, state = moving(2, x=0.05, y=0.15)
    *values, wet = samplers(case, state)["gauge"].sample(state)
    assert np.isnan(values).all()
    assert wet == 0.0


def test_a_row_is_the_mean_over_the_time_that_the_point_was_wet():
    case, state = moving(2, x=0.05, y=0.05)
    p, state.dt = state.particles, 0.01
    sampler = samplers(case, state)["gauge"]
    sampler.sample(state)
    for step, speed in enumerate((1.0, 3.0, None, None), start=1):
        state.time = 0.01 * step
        p.velocity[p.fluid, 0] = speed or 0.0
        p.position[p.fluid, 1] += 1.0 * (step == 3)  # away, and dry from now on
        sampler.add_step(state)
    velocity, _, _, _, wet = sampler.sample(state)
    assert velocity == pytest.approx(2.0)
    assert wet == pytest.approx(0.5)


def test_a_lone_particle_is_the_flow_where_it_is():
    case, state = moving(2, x=0.05, y=0.05)
    p = state.particles
    p.position[p.fluid, 1] += 1.0
    p.position[0, :2], p.velocity[0, :2] = (0.052, 0.049), (7.0, -2.0)
    velocity = samplers(case, state)["gauge"].sample(state)[:2]
    assert velocity == pytest.approx((7.0, -2.0))
