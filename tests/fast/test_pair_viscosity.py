"""Shear rate and viscosity between two particles."""

import numpy as np
import pytest

from debrisflow.physics.momentum_exchange import pair_shear_rate, pair_viscosity
from tests.fast.test_exchange import LAW, flow_of


def pair(rate=0.0, law=LAW, **known):
    """Return the viscosity between two particles at a shear rate."""
    flow = flow_of(2, **{k: v if np.isscalar(v) else np.array(v) for k, v in known.items()})
    found = pair_viscosity(0, 1, rate, flow, law)
    assert pair_viscosity(1, 0, rate, flow, law) == found
    return found


def test_two_particles_below_yield_are_as_viscous_as_the_law_allows():
    held = {"strength": (300.0, 500.0), "ramp": (1.0, 1.0)}
    # the mean strength, 400 Pa, over the least rate, 0.001 1/s, below the greatest viscosity
    for rate in (0.0, 3e-4, 1e-3):
        assert pair(rate, **held) == pytest.approx(4e5, rel=1e-13)
    assert pair(2.0, **held) == pytest.approx(200.0, rel=1e-13)
    strong = {"strength": (1e9, 1e9), "ramp": (1.0, 1.0)}
    assert pair(**strong) == LAW.largest_viscosity
    viscous = {"viscosity": (10.0, 30.0)}
    assert pair(**viscous) == pytest.approx(15.0, rel=1e-15)
    assert pair(**strong, **viscous) == pytest.approx(LAW.largest_viscosity + 15.0, rel=1e-15)


def test_the_lesser_ramp_of_two_particles_counts():
    strength = {"strength": (300.0, 500.0)}
    assert pair(2.0, ramp=(1.0, 0.25), **strength) == pytest.approx(0.25 * 200.0, rel=1e-13)
    assert pair(2.0, ramp=(1.0, 0.0), **strength) == 0.0  # water does not stick to a bed


def test_the_consistency_between_two_particles_is_their_mean():
    law = LAW._replace(exponent=0.5)
    found = pair(4.0, law, ramp=(1.0, 0.5), consistency=(4.0, 6.0), viscosity=(1.0, 3.0))
    assert found == pytest.approx(1.5 + 0.5 * 5.0 / 2.0, rel=1e-13)


def test_the_least_viscosity_adds_nothing_to_what_is_more_viscous():
    assert pair(viscosity=(10.0, 30.0), least_viscosity=25.0) == 25.0
    assert pair(viscosity=(10.0, 30.0), least_viscosity=12.0) == pytest.approx(15.0, rel=1e-15)
    held = {"strength": (400.0, 400.0), "ramp": (1.0, 1.0)}
    assert pair(2.0, least_viscosity=150.0, **held) == pytest.approx(200.0, rel=1e-13)


def shear_rate_between(gradient, a, difference):
    """Return the shear rate between two particles with gradients, (2, 3, 3) array."""
    one, other = (tuple(g.ravel()) for g in gradient)
    return pair_shear_rate(one, other, *(2.0 * a), 0.5, *(2.0 * np.array(difference)))


def plane_shear(*rates):
    """Return gradients of a velocity along x that grows with z."""
    found = np.zeros((len(rates), 3, 3))
    found[:, 0, 2] = rates
    return found


@pytest.mark.parametrize("angle", [20.0, 45.0, 90.0, -60.0])
def test_the_shear_rate_between_two_particles_is_that_of_their_layers(angle):
    up = np.sin(np.radians(angle))
    a = np.array([np.cos(np.radians(angle)), 0.0, up])

    def between(rate):
        return shear_rate_between(plane_shear(1.0, 5.0), a, [rate * up, 0.0, 0.0])

    # the mean of their gradients is 3 1/s; the profile between them is steeper or flatter
    assert between(3.0) == pytest.approx(3.0, rel=1e-14)
    floor = 0.1 / np.sqrt(up**2 + 0.01)  # what is left where layers move as one
    assert between(0.0) == pytest.approx(3.0 * floor, rel=1e-14)
    for rate in (1.0, 9.0):
        assert between(rate) == pytest.approx(rate, abs=abs(rate - 3.0) * floor)


def test_motion_as_of_a_rigid_body_is_no_shear():
    spin = np.array([[0.0, -2.0, 1.0], [2.0, 0.0, -3.0], [-1.0, 3.0, 0.0]])
    a = np.array([2.0, 1.0, -2.0]) / 3.0
    assert shear_rate_between([spin, spin], a, spin @ a) == 0.0


def test_strays_have_the_shear_rate_of_their_difference():
    a = np.array([2.0, 1.0, -2.0]) / 3.0
    for difference in ([0.0, 0.0, 0.0], [2.0, -2.0, 1.0]):
        found = shear_rate_between(np.zeros((2, 3, 3)), a, difference)
        assert found == pytest.approx(np.linalg.norm(difference), rel=1e-14)


def test_two_particles_side_by_side_in_a_shear_have_its_rate():
    aside = np.array([0.0, 1.0, 0.0])
    for scatter in (0.0, 0.015, 0.1):  # of the shear rate
        found = shear_rate_between(plane_shear(2.0, 2.0), aside, [0.0, 0.0, 2.0 * scatter])
        assert found == pytest.approx(2.0 * np.sqrt(1.0 + 100.0 * scatter**2), rel=1e-14)
