"""Probes on particles whose water level, pressure and flow are known."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.errors import CaseError
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.record import Kind
from debrisflow.particles.seeding import wall_particles
from debrisflow.particles.start import initial_state
from debrisflow.run.probes import samplers
from debrisflow.run.wall_pressure import force, pressure_on, wall_faces
from debrisflow.schemes.explicit import Explicit
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.space.domain import FLOOR, wall_names
from debrisflow.space.gravity import gravity_vector

D0 = 0.05
OF_STEPS = ("_mean", "_least", "_greatest")


def still_water(dimension, probes, depth=0.5, obstacle=(), closed=False, **tables):
    """Return case and state: a tank 1 m long and 0.6 m wide, filled, under the exact pressure.

    In two dimensions it may be closed by a ceiling, and then repeats.
    """
    block = {"type": "block", "x": [0.0, 1.0], "y": [0.0, depth], "material": "water"}
    geometry = {"type": "tank", "length": 1.0, "height": 1.0}
    geometry |= {"ceiling": closed, "periodic": closed}
    if dimension == 3:
        geometry = {"type": "tank3d", "length": 1.0, "width": 0.6, "height": 1.0}
        block |= {"y": [0.0, 0.6], "z": [0.0, depth]}
    case = complete(
        Case(
            title="still water",
            particles={"spacing": D0},
            geometry=geometry,
            fill=[block],
            obstacle=obstacle,
            probe=[{"name": f"p{k}", "interval": 0.1} | probe for k, probe in enumerate(probes)],
            time={"end": 1.0},
            output={"interval": 1.0},
            **tables,
        )
    )
    state = initial_state(case.model_copy(update={"scheme": Case.model_fields["scheme"].default}))
    p, up = state.particles, dimension - 1
    inside = np.zeros(p.count, dtype=bool)
    for box in obstacle:
        extents = np.array([box["x"], box["y"], box["z"]])
        inside |= np.all((p.position > extents[:, 0]) & (p.position < extents[:, 1]), axis=1)
    kept = np.flatnonzero(~inside | (np.arange(p.count) >= p.fluid_count))
    p.fluid_count -= p.count - kept.size
    p.keep(kept, p.count)
    p.pressure[p.fluid] = p.density[p.fluid] * 9.81 * (depth - p.position[p.fluid, up])
    p.number_density[:] = reference(dimension, case.particles.effective_radius, D0).number_density
    return case, state


def samples(case, state):
    """Return the sample of every probe of a case, without what only the steps before it tell."""
    found = []
    for measure in samplers(case, state).values():
        names = [column.name for column in measure.columns(case.dimension)]
        row = zip(names, measure.sample(state), strict=True)
        found.append(np.array([value for name, value in row if not name.endswith(OF_STEPS)]))
    return found


def forces_at_rest(case, state):
    """Return the sample of every probe of a force in three dimensions, of particles at rest."""
    p = state.particles
    p.compression[p.moving] = p.pressure[p.moving] / (1000.0 * case.scheme.sound_speed**2)
    Explicit(case).fill_number_density(state)
    return samples(case, state)


@pytest.mark.parametrize("x", [0.0, 0.51, 0.537, 0.98])
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_height_of_water_on_a_lattice_is_exact_anywhere(dimension, x):
    place = {"x": x} | ({"y": 0.31} if dimension == 3 else {})
    (height,) = samples(*still_water(dimension, [{"type": "height"} | place]))
    np.testing.assert_allclose(height, [0.5, 0.5], rtol=1e-12)


def test_the_contiguous_height_ends_below_spray_and_the_filled_one_counts_it():
    case, state = still_water(2, [{"type": "height", "x": 0.5}])
    p = state.particles
    spray = np.flatnonzero(np.all(np.abs(p.position - [0.475, 0.475, 0.0]) < 1e-9, axis=1))
    p.position[spray, 1] = 0.9
    (height,) = samples(case, state)
    np.testing.assert_allclose(height, [0.5, 0.5])  # the neighbor column still stands
    p.position[p.fluid, 1] += np.where(p.position[p.fluid, 1] > 0.3, 0.2, 0.0)
    (height,) = samples(case, state)
    np.testing.assert_allclose(height, [0.3, 0.5])


def test_the_height_over_an_obstacle_is_that_above_its_top():
    box = {"type": "box", "name": "block", "x": [0.4, 0.6], "y": [0.2, 0.4], "z": [0.0, 0.2]}
    case, state = still_water(3, [{"type": "height", "x": 0.5, "y": 0.3}], obstacle=[box])
    np.testing.assert_allclose(samples(case, state)[0], [0.3, 0.3], rtol=1e-12)


def test_a_dry_place_has_no_height_and_no_pressure():
    probes = [
        {"type": "height", "x": 0.5},
        {"type": "pressure", "wall": "floor", "x": 0.5, "y": 0.0},
        {"type": "force", "wall": "right"},
        {"type": "section", "x": 0.5},
    ]
    case, state = still_water(2, probes)
    state.particles.keep(np.arange(0), state.particles.fluid_count)
    state.particles.fluid_count = 0
    height, pressure, force, section = samples(case, state)
    assert not np.any(np.concatenate([height, pressure, force]))
    np.testing.assert_array_equal(section, [0, 0, np.nan, np.nan, 0, 0, 0])


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("depth", [0.0, 0.13, 0.31, 0.5])
def test_the_pressure_of_still_water_is_hydrostatic_on_a_patch(dimension, depth):
    level = 0.5 - depth
    place = {"x": 1.0, "y": level} if dimension == 2 else {"x": 1.0, "y": 0.3, "z": level}
    probe = {"type": "pressure", "wall": "right"} | place
    ((pressure, _),) = samples(*still_water(dimension, [probe]))
    # a patch that ends at the floor has its middle half a spacing above it; one at the level of
    # the water is wet by half, half a spacing below it
    mean_depth = {0.0: 0.25 * D0, 0.5: 0.5 - 0.5 * D0}.get(depth, depth)
    expected = 1000.0 * 9.81 * mean_depth
    assert pressure == pytest.approx(expected, rel=1e-9)


def test_the_pressure_of_water_in_disorder_is_hydrostatic():
    probe = {"type": "pressure", "wall": "left", "x": 0.0, "y": 0.2, "z": 0.2}
    case, state = still_water(3, [probe])
    p = state.particles
    p.position[p.fluid] += np.random.default_rng(1).uniform(-0.3, 0.3, (p.fluid_count, 3)) * D0
    p.pressure[p.fluid] = 1000.0 * 9.81 * (0.5 - p.position[p.fluid, 2])
    ((pressure, _),) = samples(case, state)
    assert pressure == pytest.approx(1000.0 * 9.81 * 0.3, rel=1e-3)


def test_the_force_of_still_water_on_its_walls_in_two_dimensions():
    # about the foot of the right wall, along which a hundredth of the weight is carried
    about = {"type": "force", "about": [1.0, 0.0]}
    case, state = still_water(2, [about | {"wall": wall} for wall in ("right", "left", "floor")])
    scheme, p = SemiImplicit(case), state.particles
    assert not np.any(samples(case, state))  # before the first step
    mass, forces = 1000.0 * D0**2, []
    weight = mass * p.fluid_count * gravity_vector(case)
    for _ in range(100):
        before, dt = p.velocity[p.fluid].sum(axis=0), scheme.stable_dt(state)
        scheme.step(state, dt)
        state.step += 1
        change = mass * (p.velocity[p.fluid].sum(axis=0) - before) / dt
        balance = state.wall_force[:, :3].sum(axis=0) + change
        np.testing.assert_allclose(balance, weight, atol=1e-6 * np.abs(weight).max())
        forces.append(np.array(samples(case, state))[:, :3])
    right, left, floor = np.mean(forces[50:], axis=0)
    push = 0.5 * 1000.0 * 9.81 * 0.5**2
    np.testing.assert_allclose([right[0], -left[0]], push, rtol=0.03)
    np.testing.assert_allclose(floor[:2], [0.0, weight[1]], atol=0.02 * np.abs(weight).max())
    np.testing.assert_allclose(right[2], -push * 0.5 / 3, rtol=0.05)  # at a third of the depth


@pytest.mark.parametrize("rheology", ["none", "bingham"])
def test_the_force_of_a_shear_on_the_walls_beside_it_in_two_dimensions(rheology):
    law = {"type": "bingham", "yield_stress": 1e-6} if rheology == "bingham" else {"type": "none"}
    case, state = still_water(
        2,
        [{"type": "force", "wall": wall} for wall in ("floor", "ceiling")],
        depth=1.0,
        water={"viscosity": 2.0},
        walls={"ceiling": {"velocity": [0.3, 0.0]}},
        gravity={"acceleration": 0.0},
        rheology=law,
        closed=True,
    )
    scheme, p, measures = SemiImplicit(case), state.particles, samplers(case, state)
    p.velocity[p.fluid, 0] = 0.3 * p.position[p.fluid, 1]
    for _ in range(3):
        scheme.step(state, 1e-4)
        state.step += 1
    floor, ceiling = (wall.sample(state)[0] for wall in measures.values())
    np.testing.assert_allclose([floor, -ceiling], 2.0 * 0.3, rtol=0.02)


@pytest.mark.parametrize("depth", [0.12, 0.25, 0.31])
@pytest.mark.parametrize("size", [0.05, 0.2])
def test_the_reaction_of_a_wall_to_still_water_on_a_lattice_is_hydrostatic(size, depth):
    probe = {"type": "pressure", "wall": "right", "x": 1.0, "y": 0.3, "z": 0.5 - depth}
    case, state = still_water(3, [probe | {"size": size}])
    samplers(case, state)
    ((pressure, reaction),) = forces_at_rest(case, state)
    assert pressure == pytest.approx(1000.0 * 9.81 * depth, rel=1e-9)
    assert reaction == pytest.approx(pressure, rel=0.003)


def test_the_reaction_at_the_edge_of_a_box_is_that_of_its_side():
    box = {"type": "box", "name": "block", "x": [0.4, 0.6], "y": [0.0, 0.6], "z": [0.0, 0.2]}
    place = {"x": 0.4, "y": 0.3, "z": 0.175, "size": 0.05}
    probe = {"type": "pressure", "wall": "block"} | place
    case, state = still_water(3, [probe], obstacle=[box])
    samplers(case, state)
    ((pressure, reaction),) = forces_at_rest(case, state)
    assert pressure == pytest.approx(1000.0 * 9.81 * 0.325, rel=1e-9)
    assert 0.8 < reaction / pressure < 1.0  # a rim a fifth of a spacing wide carries nothing


def test_a_patch_that_covers_nothing_of_a_wall_is_refused():
    box = {"type": "box", "name": "block", "x": [0.4, 0.6], "y": [0.2, 0.4], "z": [0.0, 0.2]}
    place = {"x": 0.37, "y": 0.165, "z": 0.1, "size": 0.02}
    case, state = still_water(3, [{"type": "pressure", "wall": "block"} | place], obstacle=[box])
    with pytest.raises(CaseError, match=r"a patch of 0\.02 m there covers nothing of block"):
        samplers(case, state)


def test_the_force_of_still_water_on_its_walls_in_three_dimensions():
    probes = [{"type": "force", "wall": wall} for wall in ("right", "floor")]
    case, state = still_water(3, probes)
    right, floor = forces_at_rest(case, state)
    push, weight = 0.5 * 1000.0 * 9.81 * 0.5**2 * 0.6, 1000.0 * 9.81 * 0.5 * 0.6
    np.testing.assert_allclose(right[0], push, rtol=0.005)
    np.testing.assert_allclose(floor[2], -weight, rtol=0.03)
    np.testing.assert_allclose([right[1], *floor[:2]], 0.0, atol=1e-12 * weight)
    np.testing.assert_allclose(right[2], 0.0, atol=1e-3 * weight)  # what the wall carries
    # at a third of the depth, in the middle of the width
    np.testing.assert_allclose(right[4:6], [push * 0.5 / 3, -push * 0.3], rtol=0.03)


@pytest.mark.parametrize("bottom", [0.0, 0.1])
def test_the_force_on_a_submerged_box_is_its_buoyancy_unless_it_stands_on_the_floor(bottom):
    box = {"type": "box", "name": "box", "x": [0.4, 0.6], "y": [0.2, 0.4], "z": [bottom, 0.35]}
    middle = [0.5, 0.3, 0.0]
    probe = {"type": "force", "wall": "box", "about": middle}
    case, state = still_water(3, [probe], obstacle=[box])
    (force,) = forces_at_rest(case, state)
    buoyancy = 1000.0 * 9.81 * 0.2 * 0.2 * (0.35 - bottom)
    on_top = 1000.0 * 9.81 * 0.2 * 0.2 * 0.15
    expected = buoyancy if bottom else -on_top
    # a box presses and is pressed on as if its edges were a fifth of a spacing inside
    rim = 0.2 * D0 * 4.0 * 0.2 * 1000.0 * 9.81 * 0.15
    np.testing.assert_allclose(force[2], expected, atol=rim)
    np.testing.assert_allclose(np.delete(force, 2), 0.0, atol=1e-9 * on_top)


def test_the_impulse_is_the_sum_of_the_force_over_the_steps_since_the_start():
    probes = [{"type": "section", "x": 0.5}, {"type": "force", "wall": "floor"}]
    case, state = still_water(2, probes)
    (wall,) = list(samplers(case, state).values())[1:]
    state.wall_force = np.zeros((len(wall_names(case)), 6))
    push = np.array([3.0, -5.0, 0.0, 0.0, 0.0, 2.0])
    for time, dt, share in [(0.0, 0.5, 1.0), (0.1, 0.1, 1.0), (0.15, 0.05, 3.0)]:
        state.time, state.dt = time, dt
        state.wall_force[FLOOR] = share * push
        wall.add_step(state)
    sample = np.array(wall.sample(state))
    np.testing.assert_allclose(sample[3:5], push[:2] * (0.1 + 3.0 * 0.05), rtol=1e-12)
    np.testing.assert_allclose(sample[:3], push[[0, 1, 5]] * 0.25 / 0.15, rtol=1e-12)
    extremes = np.sort(np.outer(push[[0, 1, 5]], [1.0, 3.0]), axis=1)
    np.testing.assert_allclose(sample[5:].reshape(3, 2), extremes, rtol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_filled_height_has_its_mean_least_and_greatest_between_two_rows(dimension):
    place = {"x": 0.5} | ({"y": 0.3} if dimension == 3 else {})
    case, state = still_water(dimension, [{"type": "height"} | place])
    p, (gauge,) = state.particles, samplers(case, state).values()
    gauge.sample(state)
    high = p.position[p.fluid, dimension - 1] > 0.4
    for time, dt, shift in [(0.1, 0.1, -1.0), (0.15, 0.05, 1.0), (0.2, 0.05, 0.0)]:
        state.time, state.dt = time, dt
        p.position[p.fluid, 0] += np.where(high, shift, 0.0)  # aside, and back
        gauge.add_step(state)
    _, filled, *found = gauge.sample(state)
    assert filled == pytest.approx(0.5)
    np.testing.assert_allclose(found, [0.45, 0.4, 0.5], rtol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_volume_in_a_box_is_that_of_its_particles(dimension):
    whole = {"x": [0.0, 1.0], "y": [0.0, 1.0]}
    part = {"x": [0.3, 0.6], "y": [0.1, 0.4]}
    if dimension == 3:
        whole["z"], part["z"] = [0.0, 1.0], [0.2, 0.9]
    case, state = still_water(dimension, [{"type": "volume"} | box for box in (whole, part)])
    p = state.particles
    p.sediment_fraction[p.fluid] = np.where(p.position[p.fluid, 0] < 0.4, 0.5, 0.125)
    everything, inside = samples(case, state)
    volume = 0.5 if dimension == 2 else 0.3
    np.testing.assert_allclose(everything, [volume, volume * (0.4 * 0.5 + 0.6 * 0.125)])
    box = 0.3 * 0.3 * (1.0 if dimension == 2 else 0.3)
    np.testing.assert_allclose(inside, [box, box * (0.5 + 2 * 0.125) / 3])


def test_a_plate_one_cell_thick_shows_both_its_faces():
    box = {"type": "box", "name": "plate", "x": [0.5, 0.55], "y": [0.0, 0.6], "z": [0.0, 0.7]}
    case, state = still_water(3, [], obstacle=[box])
    p = state.particles
    p.pressure[p.fluid] *= p.position[p.fluid, 0] < 0.5
    p.density[p.fluid] *= p.position[p.fluid, 0] < 0.5
    faces = wall_faces(case, wall_particles(case), "plate")
    push, _ = force(faces, pressure_on(faces, case, state), D0**2, np.zeros(3))
    np.testing.assert_allclose(push[0], 0.5 * 1000.0 * 9.81 * 0.25 * 0.6, rtol=1e-9)


def test_the_floor_of_a_bent_channel_carries_the_weight_across_it():
    case = complete(
        Case(
            title="run-out",
            particles={"spacing": 0.02},
            gravity={"slope": 10.0},
            geometry={
                "type": "channel",
                "length": 1.0,
                "height": 0.5,
                "runout_start": 0.5,
                "runout_slope": 0.0,
            },
            inflow={"depth": 0.04, "velocity": 1.0},
            fill=[{"type": "block", "x": [0.0, 0.5], "y": [0.0, 0.1], "material": "water"}],
            probe=[
                {"name": "p", "interval": 0.1, "type": "pressure", "wall": "floor"}
                | {"x": 0.75, "y": 0.25 * np.tan(np.radians(10.0))},
            ],
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )
    state = initial_state(case)
    p, gravity = state.particles, gravity_vector(case)
    p.pressure[p.fluid] = 1000.0 * (0.1 - p.position[p.fluid, 1]) * -gravity[1]
    ((pressure, reaction),) = samples(case, state)
    assert pressure == reaction == 0.0
    faces = wall_faces(case, wall_particles(case), "floor")
    push, _ = force(faces, pressure_on(faces, case, state), 0.02, np.zeros(3))
    weight = 1000.0 * -gravity[1] * 0.1 * 0.5
    np.testing.assert_allclose(push[1], -weight, rtol=0.02)  # a face beyond the end is half wet


@pytest.mark.parametrize("x", [0.4, 0.523])
@pytest.mark.parametrize("dimension", [2, 3])
def test_what_flows_through_a_section(dimension, x):
    case, state = still_water(dimension, [{"type": "section", "x": x}])
    p = state.particles
    p.velocity[p.fluid, 0] = 2.0
    p.kind[p.fluid] = np.where(p.position[p.fluid, dimension - 1] < 0.1, Kind.SEDIMENT, 0)
    p.sediment_fraction[p.fluid] = p.kind[p.fluid] == Kind.SEDIMENT
    (sample,) = samples(case, state)
    width = [] if dimension == 2 else [0.6]
    discharge = 2.0 * 0.5 * np.prod(width)
    expected = [discharge, 0.2 * discharge, 0.2, 2.0, 0.5, *width, 0.0, 0.0]
    np.testing.assert_allclose(sample, expected, rtol=1e-12)


def test_crossings_are_counted_both_ways_by_the_number_of_the_particle():
    case, state = still_water(2, [{"type": "section", "x": 0.5}])
    p, section = state.particles, samplers(case, state)["p0"]
    state.time = 0.1
    p.kind[p.fluid][:] = Kind.LIQUID
    p.position[p.fluid, 0] += D0  # the column before the section passes it
    p.reorder(p.fluid, np.arange(p.fluid_count)[::-1])
    section.add_step(state)
    np.testing.assert_array_equal(state.sums["p0"][0], [10, 0, 0])
    p.kind[p.fluid] = Kind.MIXTURE
    p.sediment_fraction[p.fluid] = np.where(p.position[p.fluid, 0] > 0.5, 0.25, 0.5)
    p.position[p.fluid, 0] -= 3 * D0
    section.add_step(state)
    np.testing.assert_array_equal(state.sums["p0"][0], [10, 0, -30])
    volumes = samples(case, state)[0][-2:]
    np.testing.assert_allclose(volumes, [-20 * D0**2, -30 * 0.25 * D0**2])


def test_nobody_is_counted_before_the_start_nor_by_leaving():
    case, state = still_water(2, [{"type": "section", "x": 0.5}])
    p, section = state.particles, samplers(case, state)["p0"]
    state.time = 0.0
    p.position[p.fluid, 0] += D0
    section.add_step(state)
    state.time = 0.1
    p.keep(np.arange(10, p.fluid_count), p.fluid_count)
    p.fluid_count -= 10
    section.add_step(state)
    assert not state.sums["p0"].any()


def test_what_returns_through_the_end_of_a_period_is_counted_where_it_passes():
    case, state = still_water(2, [{"type": "section", "x": 0.02}])
    shape = case.geometry.model_copy(update={"periodic": True})
    case = case.model_copy(update={"geometry": shape})
    p, section = state.particles, samplers(case, state)["p0"]
    state.time = 0.1
    p.position[p.fluid, 0] = (p.position[p.fluid, 0] + D0) % 1.0
    section.add_step(state)
    assert state.sums["p0"][0, 0] == 10


# a bound that is missed and stays, see docs/theory/walls.md: on a lattice whose surface had p = 0
# what the rows beside the wall are carried by cancelled, and no longer does
@pytest.mark.xfail(strict=True, reason="8e-4 of the weight since surface rows carry pressure")
def test_a_frictionless_wall_carries_nothing_of_still_water_on_a_lattice():
    case, state = still_water(3, [{"type": "force", "wall": "right"}])
    (right,) = forces_at_rest(case, state)
    np.testing.assert_allclose(right[2], 0.0, atol=1e-4 * 1000.0 * 9.81 * 0.5 * 0.6)
