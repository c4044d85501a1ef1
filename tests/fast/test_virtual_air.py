"""Virtual air, and the pressure equation of still water before walls that are surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.particles.start import initial_state
from debrisflow.physics.virtual_air import density_error, gate, missing, virtual_air
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import endless_channel
from tests.building import tank_case

GRAVITY = 9.81


def air_of(radius):
    """Return lattice, air, and rows of a half space of fluid: n/n0, sum of A, what it lacks."""
    lattice, rows = reference(2, radius, 1.0), []
    reach = int(radius)
    for k in range(4):
        above, below = np.zeros(2), 0.0
        for x in range(-reach, reach + 1):
            for y in range(-reach, reach + 1):
                r = np.hypot(x, y)
                if 0.0 < r < radius and y > k:
                    a = 3.0 * radius / r**3
                    above += [a * (1.0 + (y - k - 0.5) / (k + 0.5)), 0.0]
                elif 0.0 < r < radius:
                    below += radius / r - 1.0
        rows.append((below / lattice.number_density, above[0]))
    return virtual_air(lattice, 3.0), rows


@pytest.mark.parametrize(("radius", "exact"), [(3.1, 2), (2.6, 2), (2.1, 1)])
def test_air_is_exact_in_the_first_rows_under_a_flat_surface(radius, exact):
    air, rows = air_of(radius)
    for ratio, expected in rows[:exact]:
        assert missing(ratio, 0.2, air) == pytest.approx(expected, rel=1e-9)
    whole = rows[0][1]
    for ratio, expected in rows[exact:]:
        assert missing(ratio, 0.2, air) == pytest.approx(expected, abs=0.03 * whole)


def test_air_counts_only_where_neighbors_are_missing():
    air, _ = air_of(3.1)
    assert missing(0.9, 0.04, air) == 0.0  # looser than the lattice, but on all sides
    assert missing(1.02, 0.2, air) == 0.0
    assert missing(0.5, 0.0, air) > 0.0  # spray
    assert gate(0.86, 0.075) == pytest.approx(0.5)


def test_what_air_makes_too_thin_is_no_error_of_density():
    air, _ = air_of(3.1)
    assert density_error(0.7, 0.2, air) == 0.0
    assert density_error(0.98, 0.0, air) == pytest.approx(-0.02)
    assert density_error(1.03, 0.2, air) == pytest.approx(0.03)


@pytest.mark.parametrize("columns", [20, 40])
def test_the_first_step_of_still_water_is_at_rest_up_to_its_corners(columns):
    case = tank_case(columns, 20, "water", tank=(columns, 40))
    scheme, state = SemiImplicit(case), initial_state(case)
    p, dt = state.particles, 1e-3
    scheme.step(state, dt)
    depth = 0.2 - p.position[p.fluid, 1]
    error = p.pressure[p.fluid] / (1000.0 * GRAVITY * 0.2) - depth / 0.2
    # the row under the surface is looser than the lattice and is not yet seen as such
    assert np.abs(error - error.mean()).max() < 0.03
    assert np.abs(error).max() < 0.05
    # what gravity adds to the velocity in the step is taken back, but for a fifth at the surface
    speed = np.linalg.norm(p.velocity[p.fluid], axis=1) / (GRAVITY * dt)
    assert np.sqrt(np.mean(speed**2)) < 0.2


def test_a_sheet_of_one_row_is_carried_by_the_pressure_of_the_floor():
    case = endless_channel(0.01, 0.0, [{"y": [0.0, 0.01], "material": "water"}])
    scheme, state = SemiImplicit(case), initial_state(case)
    p = state.particles
    for _ in range(50):
        scheme.step(state, 1e-3)
        state.step += 1
    assert np.abs(p.velocity[p.fluid]).max() < 1e-3
    assert p.position[p.fluid, 1] == pytest.approx(0.005, abs=0.0005)
    # a single row has half of its support from its pressure, which so is 12 % too great
    assert p.pressure[p.fluid] == pytest.approx(1000.0 * GRAVITY * 0.005, rel=0.15)
