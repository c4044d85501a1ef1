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


def sampled(case, sampler, state):
    """Return a sample by the names of its columns."""
    names = [column.name for column in sampler.columns(case.dimension)]
    return dict(zip(names, sampler.sample(state), strict=True))


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
    found = sampled(case, samplers(case, state)["gauge"], state)
    velocity = [found[f"velocity_{axis}"] for axis in "xyz"[:dimension]]
    pressure, concentration, wet = (found[name] for name in ("pressure", "concentration", "wet"))
    expected = 1.0 + np.array(place) @ SLOPES[:dimension, :dimension]
    np.testing.assert_allclose(velocity, expected, rtol=1e-9)
    assert pressure == pytest.approx(500.0 - 700.0 * place[-1], rel=1e-9)
    assert (concentration, wet) == (0.0, 1.0)
    assert found["pressure_least"] == found["pressure_greatest"] == pressure


@pytest.mark.parametrize("y", [0.15, 0.112])  # no particle near, and one within two spacings
def test_a_dry_point_has_no_flow(y):
    case, state = moving(2, x=0.05, y=y)
    found = sampled(case, samplers(case, state)["gauge"], state)
    assert found.pop("wet") == 0.0
    assert np.isnan(list(found.values())).all()


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
    found = sampled(case, sampler, state)
    assert found["velocity_x"] == pytest.approx(2.0)
    assert found["velocity_x_least"] == pytest.approx(1.0)  # not the zeros of dry steps
    assert found["velocity_x_greatest"] == pytest.approx(3.0)
    assert found["wet"] == pytest.approx(0.5)


def test_a_lone_particle_is_the_flow_where_it_is():
    case, state = moving(2, x=0.05, y=0.05)
    p = state.particles
    p.position[p.fluid, 1] += 1.0
    p.position[0, :2], p.velocity[0, :2] = (0.052, 0.049), (7.0, -2.0)
    velocity = samplers(case, state)["gauge"].sample(state)[:2]
    assert velocity == pytest.approx((7.0, -2.0))
