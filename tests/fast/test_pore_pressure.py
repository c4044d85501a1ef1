"""Pore pressure that belongs to the matter: given by fills, decaying, leaving less to friction."""

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.particles.matter import set_pore_pressure
from debrisflow.particles.record import blank
from debrisflow.particles.start import initial_state
from debrisflow.physics.contact import hold_off_walls
from debrisflow.results.frames import read_frame
from debrisflow.run import checkpoint
from debrisflow.run.vtu import write_particles
from debrisflow.schemes.terms.pore_pressure import borne_by_grains
from debrisflow.validation.marching import advance
from tests.building import Plane, lattice_block, planes, started
from tests.fast.test_base_friction import LATTICE
from tests.fast.test_checkpoint import identical

D0 = 0.05
COULOMB = {"law": "coulomb", "angle": 35.0}


def slab(fill=None, wall=None, others=(), **tables):
    """Return a case: two rows of mixture that slide down a plane between free-slip sides."""
    block = {"type": "block", "x": (0.0, 0.6), "y": (0.0, 0.2), "z": (0.0, 0.1)}
    friction = COULOMB | wall if wall and "law" not in wall else wall or COULOMB
    free = {"friction": {"law": "none"}}
    return complete(
        Case(
            title="slab",
            particles={"spacing": D0},
            gravity={"slope": 25.0},
            geometry={"type": "channel3d", "length": 3.0, "width": 0.2, "height": 0.4},
            walls={"floor": {"friction": friction}, "front": free, "back": free, "left": free},
            fill=[block | {"material": "mixture"} | (fill or {}), *others],
            scheme={"type": "explicit", "sound_speed": 15.0},
            time={"end": 0.2},
            output={"interval": 0.1},
            **tables,
        )
    )


def after(case, until=0.1):
    """Return the particles after some time."""
    return advance(*started(case), until=until).particles


def test_matter_without_it_has_no_rows():
    p = initial_state(slab()).particles
    assert p.pore_pressure.shape == p.pore_pressure_rate.shape == (0,)
    assert p.relative_velocity.shape == p.owed_displacement.shape == (0, 3)
    assert borne_by_grains(p) is None


def test_each_fill_gives_its_own():
    other = {"type": "block", "x": (0.6, 1.0), "y": (0.0, 0.2), "z": (0.0, 0.1)}
    case = slab(
        {"pore_pressure": 0.5, "pore_pressure_time": 4.0}, None, [other | {"material": "water"}]
    )
    p = initial_state(case).particles
    is_first = p.position[p.fluid, 0] < 0.6
    np.testing.assert_array_equal(p.pore_pressure[p.fluid], np.where(is_first, 0.5, 0.0))
    np.testing.assert_array_equal(p.pore_pressure_rate[p.fluid], np.where(is_first, 0.25, 0.0))
    np.testing.assert_array_equal(borne_by_grains(p), np.where(is_first, 0.5, 1.0))


def test_a_group_is_given_its_share_and_its_rate():
    p = blank(3)
    set_pore_pressure(p, slice(1, 3), 0.7, None)
    set_pore_pressure(p, np.array([2]), 0.4, 10.0)
    assert p.pore_pressure.tolist() == [0.0, 0.7, 0.4]
    assert p.pore_pressure_rate.tolist() == [0.0, 0.0, 0.1]


def test_it_takes_from_friction_what_the_same_share_at_the_wall_takes():
    mine, walls = after(slab({"pore_pressure": 0.5})), after(slab(wall={"pore_pressure": 0.5}))
    assert mine.velocity.tobytes() == walls.velocity.tobytes()
    # and both shares multiply
    both = after(slab({"pore_pressure": 0.5}, {"pore_pressure": 0.5}))
    assert both.velocity.tobytes() == after(slab(wall={"pore_pressure": 0.75})).velocity.tobytes()
    assert both.velocity[both.fluid, 0].mean() > 1.3 * mine.velocity[mine.fluid, 0].mean()


def test_of_voellmys_law_it_takes_the_sliding_part_alone():
    law = {"law": "voellmy", "coefficient": 0.8, "turbulence": 200.0}
    free, drag = after(slab({"pore_pressure": 1.0}, law)), law | {"coefficient": 0.0}
    assert free.velocity.tobytes() == after(slab(wall=drag)).velocity.tobytes()


def test_it_decays_by_its_time_from_the_start_on():
    case = slab({"pore_pressure": 0.8, "pore_pressure_time": 0.25})
    scheme, state = started(case)
    state.time = -0.05  # while the fills settle it stays
    advance(scheme, state, until=0.0)
    assert np.all(state.particles.pore_pressure == 0.8)
    advance(scheme, state, until=0.1)
    expected = 0.8 * np.exp(-0.1 / 0.25)
    np.testing.assert_allclose(state.particles.pore_pressure, expected, rtol=1e-12)
    assert np.all(after(slab({"pore_pressure": 0.8})).pore_pressure == 0.8)


def test_a_state_that_was_kept_goes_on_to_the_same_bits(tmp_path):
    scheme, state = started(slab({"pore_pressure": 0.8, "pore_pressure_time": 0.25}))
    advance(scheme, state, steps=scheme.REFRESH)
    origin = checkpoint.Origin("", "", "{}")
    checkpoint.save(tmp_path / "c.h5", state, origin)
    advance(scheme, state, steps=7)
    other, _ = started(slab({"pore_pressure": 0.8, "pore_pressure_time": 0.25}))
    loaded = advance(other, checkpoint.load(tmp_path / "c.h5").state, steps=7)
    loaded.wall_force, loaded.patches = state.wall_force, state.patches
    assert identical(loaded.particles, state.particles)


def test_what_touches_a_wall_is_slowed_by_what_its_grains_bear():
    solid = planes(np.array([[0.0, 0.0, 0.05], [0.0, 0.0, 0.05]]), LATTICE, Plane())
    velocity = np.tile([2.0, 0.0, -1.0], (2, 1))
    hold_off_walls(0.15, np.array([0.5]), np.array([1.0, 0.2]), solid, velocity)
    np.testing.assert_allclose(velocity, [[1.5, 0.0, 0.0], [1.9, 0.0, 0.0]], atol=1e-14)


def test_grains_press_on_each_other_by_no_more_than_it_leaves():
    law = {"type": "coulomb"}
    dry, wet = (after(slab(fill, rheology=law), 0.05) for fill in ({}, {"pore_pressure": 0.9}))
    rows, least = wet.fluid, 0.5 * D0 * 9.81 * wet.density[wet.fluid]
    limit = 0.1 * np.maximum(wet.pressure[rows], least)
    # pressures of the particle files are those after the step, which grains have not seen
    assert wet.grain_pressure[rows].max() == pytest.approx(limit.max(), rel=0.2)
    assert wet.grain_pressure[rows].mean() < 0.3 * dry.grain_pressure[dry.fluid].mean()
    assert wet.velocity[rows, 0].mean() > 1.2 * dry.velocity[dry.fluid, 0].mean()


def test_particle_files_hold_it_where_particles_have_it(tmp_path):
    particles = blank(4)
    particles.position[:] = lattice_block(3, (4, 1, 1))
    set_pore_pressure(particles, slice(None), 0.25, None)
    write_particles(tmp_path / "with.vtu", particles)
    assert read_frame(0.0, tmp_path / "with.vtu").pore_pressure.tolist() == [0.25] * 4
    particles.pore_pressure = np.zeros(0)
    write_particles(tmp_path / "without.vtu", particles)
    assert "pore_pressure" not in read_frame(0.0, tmp_path / "without.vtu").arrays
