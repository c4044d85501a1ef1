"""Whole steps over walls with friction: what slides, what rests, what laws of a column hold."""

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.validation.marching import advance
from tests.building import started

D0, SLOPE, ACROSS, G = 0.01, 10.0, 11, 9.81
ANGLE = np.radians(SLOPE)
RIGID = {"type": "bingham", "yield_stress": 1e5, "concentration_ramp": (0.1, 0.2)}


def layer(rows, friction, rheology=RIGID, slope=SLOPE):
    """Return a case: a layer of mixture that repeats along a slope, between free-slip sides."""
    side = ACROSS * D0
    block = {"x": (0.0, side), "y": (0.0, side), "z": (0.0, rows * D0)}
    channel = {"type": "channel3d", "length": side, "width": side, "height": (rows + 4) * D0}
    free = {"slip": "free-slip"}
    return complete(
        Case(
            title="layer",
            particles={"spacing": D0},
            gravity={"slope": slope},
            geometry=channel | {"periodic": True},
            walls={"floor": {"friction": friction}, "front": free, "back": free},
            fill=[{"type": "block", "material": "mixture", **block}],
            mixture={"concentration": 0.5},
            rheology=rheology,
            scheme={"type": "explicit", "sound_speed": 15.0},
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )


def speed_of(state):
    """Return the mean velocity down the slope, m/s."""
    return state.particles.velocity[state.particles.fluid, 0].mean()


def acceleration(case, start, end, velocity=0.0):
    """Return the mean acceleration down the slope, m/s2, between two times, and mean speed."""
    scheme, state = started(case)
    state.particles.velocity[state.particles.fluid, 0] = velocity
    advance(scheme, state, until=start)
    time, speed = state.time, speed_of(state)
    advance(scheme, state, until=end)
    gain = speed_of(state) - speed
    return gain / (state.time - time), speed + 0.5 * gain, state


def coulomb(tangent):
    return {"law": "coulomb", "angle": float(np.degrees(np.arctan(tangent)))}


@pytest.mark.parametrize("rows", [1, 2])
def test_a_block_slides_with_what_sliding_friction_leaves(rows):
    # once it has come to the height at which it is carried
    found, _, state = acceleration(layer(rows, coulomb(0.15)), 0.2, 0.4)
    assert found == pytest.approx(G * (np.sin(ANGLE) - 0.15 * np.cos(ANGLE)), rel=0.01)
    heights = state.particles.position[state.particles.fluid, 2]
    assert heights.min() > 0.28 * D0


@pytest.mark.parametrize("rows", [1, 4])
def test_a_block_below_its_angle_of_friction_rests(rows):
    _, _, state = acceleration(layer(rows, coulomb(0.2)), 0.05, 0.4)
    velocity = state.particles.velocity[state.particles.fluid, 0]
    assert np.abs(velocity).max() < 5e-5


@pytest.mark.parametrize("rows", [1, 4])
@pytest.mark.parametrize(
    ("friction", "law"),
    [
        ({"law": "manning", "coefficient": 0.03}, lambda u, h: G * 0.03**2 * u**2 / h ** (4 / 3)),
        (
            {"law": "voellmy", "coefficient": 0.0, "turbulence": 200.0},
            lambda u, h: G * u**2 / 200.0 / h,
        ),
    ],
    ids=["manning", "voellmy"],
)
def test_the_laws_of_a_column_slow_it_by_its_mean(rows, friction, law):
    found, speed, _ = acceleration(layer(rows, friction), 0.01, 0.03, velocity=1.0)
    slowed = G * np.sin(ANGLE) - found
    assert slowed == pytest.approx(law(speed, rows * D0), rel=0.02)


def test_a_sheet_on_a_frictionless_slope_gains_what_gravity_gives():
    case = layer(4, {"law": "none"}, rheology={"type": "none"})
    found, _, _ = acceleration(case, 0.0, 0.2)
    assert found == pytest.approx(G * np.sin(ANGLE), rel=0.002)
