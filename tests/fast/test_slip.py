"""The slip between the phases: drag, relative velocity, exchange of places."""

from dataclasses import replace

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from debrisflow.particles.record import MATTER, blank
from debrisflow.physics.concentration import concentrations
from debrisflow.physics.drag import drag_coefficient
from debrisflow.physics.slip import (
    concentration_ahead,
    pair_up,
    room_at,
    surroundings_at,
    survey_surroundings,
)
from debrisflow.schemes.terms.slip import Slip
from debrisflow.schemes.terms.term import Step
from tests.building import (
    GIDASPOW,
    NOWHERE,
    RADII,
    WEN_YU,
    lattice_block,
    one_list,
    random_patch,
    scene_of,
)

ROCK, WATER = 2650.0, 1000.0
GRAVITY = np.array([0.0, -9.81, 0.0])
SIDE = 12


@pytest.fixture
def rng():
    return np.random.default_rng(53)


def checkerboard():
    """Return water and sediment that alternate on a periodic lattice, and who is near whom."""
    position = lattice_block(2, SIDE)
    near = one_list(
        position, reference(2, 3.1, 1.0), period=np.array([SIDE, SIDE, 0.0], dtype=float)
    )
    particles = blank(len(position))
    particles.fluid_count = len(position)
    particles.position[:] = position
    particles.sediment_fraction[:] = np.floor(position.sum(axis=1)) % 2.0
    particles.density[:] = np.where(particles.sediment_fraction > 0, ROCK, WATER)
    smooth(particles, near)
    return particles, near


def smooth(particles, near):
    raw, level = np.empty((2, particles.fluid_count))
    fraction, smoothed = particles.sediment_fraction, particles.concentration
    concentrations(fraction, fraction, NOWHERE, near, raw, level)
    concentrations(raw, raw, NOWHERE, near, smoothed, level)


def observed(phases, particles, near):
    """Return a scene that the slip has observed."""
    scene = scene_of(particles, near)
    phases.observe(scene)
    return scene


def acted(phases, scene, dt, velocity=None, collisions=None):
    """Return a step in which the slip has acted on the velocity of the phases, by default rest.

    ``collisions`` is the acceleration of the grains by collisions, where there are some.
    """
    p = scene.particles
    if collisions is not None:
        scene.collision_acceleration = collisions
    start = np.zeros_like(p.velocity) if velocity is None else velocity.copy()
    step = Step(scene, dt, start, p.pressure)
    phases.act(step)
    return step


def of_phases(phases, step):
    """Return the velocity of the phases in a step: that of the mixture, and the slip."""
    return step.velocity + phases.velocity


def carry_over(phases, step, time=0.0):
    """Give the particles what the slip owes them after a time; by default only the velocity."""
    phases.move(replace(step, dt=time))


def random_mix(dimension, radius, rng, count=300):
    """Return random water and sediment particles with relative velocities, and who is near whom."""
    spacing = count ** (-1.0 / dimension)
    near = one_list(random_patch(dimension, count, rng), reference(dimension, radius, spacing))
    particles = blank(count)
    particles.fluid_count = count
    particles.sediment_fraction[:] = rng.choice([0.0, 1.0], count, p=(0.6, 0.4))
    particles.density[:] = np.where(particles.sediment_fraction > 0, ROCK, WATER)
    particles.relative_velocity[:, :dimension] = rng.normal(0.0, 0.2, (count, dimension))
    smooth(particles, near)
    return particles, near


def analytic_rate(c, speed, law):
    """Return ``K [(1 - C) / rho_s + C / rho_l]``, 1/s: beta acts on the share of each phase."""
    coefficient = np.vectorize(lambda value: drag_coefficient(value, speed, law))(c)
    return coefficient * ((1 - c) / ROCK + c / WATER)


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 0.1])
@pytest.mark.parametrize("law", [GIDASPOW, WEN_YU])
def test_drag_brings_the_phases_to_a_common_velocity_at_the_analytic_rate(dt, law):
    # no pressure, so that only the drag acts; below the packing limit the grains are free
    p, near = checkerboard()
    law = law._replace(packing_limit=0.6)
    is_rock = p.sediment_fraction > 0
    start = np.array([0.3, -0.1, 0.0]), np.array([-0.5, 0.2, 0.0])
    velocity = np.where(is_rock[:, None], *start)
    p.relative_velocity[:] = start[0] - start[1]
    before = p.density @ velocity
    phases = Slip(law, GRAVITY)
    step = acted(phases, observed(phases, p, near), dt, velocity)
    carry_over(phases, step)
    rate = analytic_rate(phases.surroundings.concentration, np.hypot(0.8, 0.3), law)
    expected = np.outer(1 / (1 + dt * rate), [0.8, -0.3])
    np.testing.assert_allclose(p.relative_velocity[:, :2], expected, rtol=1e-12)
    after = of_phases(phases, step)
    # on each phase the drag of its share of the weights with the other
    c, share = phases.surroundings.concentration, phases.surroundings.share
    drag = rate / ((1 - c) / ROCK + c / WATER) * p.relative_velocity[:, 0]
    drag = 0.5 * (drag[is_rock].mean() + drag[~is_rock].mean())
    for phase, sign, other in ((is_rock, -1.0, 1 - share), (~is_rock, 1.0, share)):
        change = sign * dt * other[phase] * drag / p.density[phase]
        start_x = start[0][0] if sign < 0 else start[1][0]
        np.testing.assert_allclose(after[phase, 0] - start_x, change, rtol=1e-10)
    np.testing.assert_allclose(p.density @ after, before, rtol=1e-12)


def test_drag_at_rest_decays_exponentially_as_the_step_vanishes():
    # so slow that the drag is Stokes': K does not change
    p, near = checkerboard()
    law = WEN_YU._replace(packing_limit=0.6)
    is_rock = p.sediment_fraction > 0
    velocity = np.where(is_rock[:, None], [1e-9, 0.0, 0.0], 0.0)
    p.relative_velocity[:, 0] = 1e-9
    phases = Slip(law, GRAVITY)
    scene = observed(phases, p, near)
    rate = analytic_rate(phases.surroundings.concentration, 0.0, law)
    end, steps = 2.0 / rate.max(), 2000
    for _ in range(steps):
        step = acted(phases, scene, end / steps, velocity)
        carry_over(phases, step)
        velocity = of_phases(phases, step)
    # implicit Euler with a step of 1/1000 of the time of decay
    np.testing.assert_allclose(p.relative_velocity[:, 0], 1e-9 * np.exp(-rate * end), rtol=2e-3)


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_drag_gives_the_water_what_it_takes_from_the_grains(dimension, radius, rng):
    p, near = random_mix(dimension, radius, rng)
    phases = Slip(WEN_YU, GRAVITY)
    velocity = of_phases(phases, acted(phases, observed(phases, p, near), 1e-3))
    given = p.density @ np.abs(velocity)
    assert given[:dimension].min() > 0.0
    assert np.abs(p.density @ velocity).max() < 1e-13 * given.max()


def test_without_slip_there_is_no_drag_and_without_two_phases_no_slip(rng):
    p, near = random_mix(2, 3.1, rng)
    phases = Slip(WEN_YU, GRAVITY)
    p.relative_velocity[:] = 0.0
    step = acted(phases, observed(phases, p, near), 1e-3)
    assert not step.velocity.any()
    p.sediment_fraction[:] = 1.0
    p.relative_velocity[:] = 1.0
    step = acted(phases, observed(phases, p, near), 1e-3)
    carry_over(phases, step, 1e-3)
    assert not step.velocity.any()
    assert not phases.velocity.any()
    assert not p.owed_displacement.any()


def test_the_slip_carries_no_volume():
    p, near = checkerboard()
    p.relative_velocity[:, 1] = -0.3
    phases = Slip(WEN_YU, GRAVITY)
    scene = observed(phases, p, near)
    is_rock = p.sediment_fraction > 0
    assert np.all(phases.velocity[is_rock, 1] < -0.14)
    assert np.all(phases.velocity[~is_rock, 1] > 0.14)
    assert abs(phases.velocity[:, 1].sum()) < 1e-12
    np.testing.assert_array_equal(scene.velocity, p.velocity - phases.velocity)


def test_the_concentration_of_the_drag_has_no_bias_of_the_particle_itself(rng):
    position = lattice_block(2, 40)
    lattice = reference(2, 3.1, 1.0)
    near = one_list(position, lattice, period=np.array([40.0, 40.0, 0.0]))
    p = blank(len(position))
    p.fluid_count = len(position)
    p.sediment_fraction[:] = rng.choice([0.0, 1.0], len(position), p=(0.7, 0.3))
    smooth(p, near)
    c, share, weight = np.empty((3, len(position)))
    survey_surroundings(p.sediment_fraction, p.concentration, near, share, weight, c)
    is_rock = p.sediment_fraction > 0
    bias = p.concentration[is_rock].mean() - p.concentration[~is_rock].mean()
    assert bias > 0.05
    # a standard error of the mean of 480 correlated values is about 0.005
    for values in (c, share):
        assert values[is_rock].mean() - values[~is_rock].mean() == pytest.approx(0.0, abs=0.02)
        assert values.mean() == pytest.approx(p.sediment_fraction.mean(), abs=0.002)
    assert c.std() < share.std()
    np.testing.assert_allclose(weight, lattice.number_density, rtol=1e-12)


def test_rest_is_the_balance_of_drag_and_buoyant_weight():
    # a given pressure gradient rho_m g on the periodic lattice, up to the jump at its seam
    p, near = checkerboard()
    law = WEN_YU._replace(packing_limit=0.6)
    phases = Slip(law, GRAVITY)
    p.pressure[:] = 0.5 * (ROCK + WATER) * 9.81 * (SIDE - p.position[:, 1])
    middle = np.abs(p.position[:, 1] - 0.5 * SIDE) < 1.0
    for _ in range(3000):
        carry_over(phases, acted(phases, observed(phases, p, near), 1e-3))
    u_r = p.relative_velocity[middle, 1]
    assert np.all(u_r < 0.0)
    c = phases.surroundings.concentration[middle]
    slowing = [analytic_rate(*pair, law) for pair in zip(c, -u_r, strict=True)] * -u_r
    # 3 s are many times of relaxation
    np.testing.assert_allclose(slowing, (1 / WATER - 1 / ROCK) * 1825.0 * 9.81, rtol=1e-4)


def test_packed_grains_hardly_slip():
    p, near = checkerboard()
    free, packed = WEN_YU._replace(packing_limit=0.6), WEN_YU._replace(packing_limit=0.48)
    speeds = []
    for law in (free, packed):
        p.relative_velocity[:] = 0.0
        p.pressure[:] = 1825.0 * 9.81 * (SIDE - p.position[:, 1])
        phases = Slip(law, GRAVITY)
        for _ in range(500):
            carry_over(phases, acted(phases, observed(phases, p, near), 1e-3))
        speeds.append(-np.median(p.relative_velocity[:, 1]))
    assert speeds[0] > 0.05
    assert 0.0 < speeds[1] < 1e-3


def test_collisions_of_grains_move_them_against_the_water():
    p, near = checkerboard()
    collisions = np.where(p.sediment_fraction[:, None] > 0, [50.0, 0.0, 0.0], 0.0)
    phases = Slip(WEN_YU._replace(packing_limit=0.6), GRAVITY)
    step = acted(phases, observed(phases, p, near), 1e-6, collisions=collisions)
    assert not p.relative_velocity.any()  # nothing is done before the step is
    carry_over(phases, step)
    np.testing.assert_allclose(p.relative_velocity[:, 0], 50.0 * 1e-6, rtol=1e-4)


def test_particles_change_places_when_both_come_nearer_to_their_paths():
    # sediment over water, a spacing apart; each is owed its part
    for owed, expected in ((0.4, False), (0.6, True)):
        position = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
        near = one_list(position, reference(2, 3.1, 1.0))
        wish = np.array([[0.0, -owed, 0.0], [0.0, owed, 0.0]])
        partner, fraction = np.empty(2, dtype=np.int64), np.array([1.0, 0.0])
        pair_up(wish, fraction, np.zeros(2), 1.01, near, partner)
        assert list(partner) == ([1, 0] if expected else [-1, -1])
        left = 1.0 - owed if expected else -owed
        np.testing.assert_allclose(wish, [[0.0, left, 0.0], [0.0, -left, 0.0]], atol=1e-15)


def layered():
    """Return a lattice whose lower half is sediment and water by turns: places, phases, near."""
    position = lattice_block(2, SIDE)
    near = one_list(position, reference(2, 3.1, 1.0))
    in_bed = position[:, 1] < 0.5 * SIDE
    fraction = np.where(in_bed, np.floor(position.sum(axis=1)) % 2.0, 0.0)
    return position, fraction, near


@pytest.mark.parametrize(("packing_limit", "enters"), [(0.55, False), (0.75, True)])
def test_no_sediment_enters_what_is_packed_already(packing_limit, enters):
    # a grain over a bed of C = 0.5, half as much within its whole reach
    position, fraction, near = layered()
    top = int(np.argmin(np.linalg.norm(position - [6.5, 6.5, 0.0], axis=1)))
    below = int(np.argmin(np.linalg.norm(position - [6.5, 5.5, 0.0], axis=1)))
    assert fraction[below] == 0.0  # its nearest neighbors in the bed are sediment
    fraction[top] = 1.0
    ahead = concentration_ahead(top, below, 0.0, -1.0, 0.0, fraction, near)
    around, _, _ = surroundings_at(below, fraction, near)
    assert around < 0.55 < ahead < 0.75  # around: with the clear water above
    wish = np.zeros_like(position)
    wish[top, 1] = -1.2
    partner = np.empty(len(position), dtype=np.int64)
    free = np.zeros(len(position))
    pair_up(wish, fraction, free, packing_limit, near, partner)
    assert (partner[top] == below) == enters
    assert np.count_nonzero(partner >= 0) == 2 * enters


@pytest.mark.parametrize(("c", "moves"), [(0.89, True), (0.91, False)])
def test_grains_that_touch_exchange_no_places(c, moves):
    # contact begins at 0.9 of the limit; there is room, since a limit of 1.01 is no limit
    position, fraction = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]), np.array([1.0, 0.0])
    near = one_list(position, reference(2, 3.1, 1.0))
    wish, partner = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]), np.empty(2, dtype=np.int64)
    pair_up(wish, fraction, np.full(2, 1.01 * c), 1.01, near, partner)
    assert (partner[0] == 1) == moves


def test_a_grain_that_is_owed_more_than_it_can_have_is_held():
    part, spacing = np.array([0.7]), 0.01
    down, up = np.array([[0.0, -0.02, 0.0]]), np.array([[0.0, 0.02, 0.0]])
    u_r = np.array([[0.0, -0.2, 0.0]])
    assert room_at(0, part, down, spacing, u_r) == pytest.approx(1e-4)
    assert room_at(0, part, 0.95 * down, spacing, u_r) == pytest.approx(0.5)
    assert room_at(0, part, 0.5 * down, spacing, u_r) == 1.0
    assert room_at(0, part, up, spacing, u_r) == 1.0  # it comes nearer to its path
    # the water around slips the other way
    assert room_at(0, -part, up, spacing, u_r) == pytest.approx(1e-4)


def test_an_exchange_moves_the_matter_and_keeps_sums_and_places(rng):
    p, near = random_mix(2, 3.1, rng)
    p.id[:] = rng.permutation(300)
    p.velocity[:] = rng.normal(size=(300, 3))
    p.owed_displacement[:, 1] = np.where(p.sediment_fraction > 0, -1.0, 0.3) / np.sqrt(300)
    before = {name: value.copy() for name, value in p.arrays().items()}
    phases = Slip(WEN_YU._replace(packing_limit=0.9), GRAVITY)
    scene = observed(phases, p, near)
    phases.move(Step(scene, 1e-9, p.velocity, p.pressure))
    moved = p.id != before["id"]
    assert moved.sum() > 20
    assert np.array_equal(np.sort(p.id), np.arange(300))
    back = np.argsort(p.id)[before["id"]]  # the row in which each particle now stands
    for name in set(MATTER) - {"owed_displacement"}:
        np.testing.assert_array_equal(getattr(p, name)[back], before[name], err_msg=name)
    for name in set(before) - set(MATTER):
        np.testing.assert_array_equal(getattr(p, name), before[name], err_msg=name)
    np.testing.assert_allclose(
        p.owed_displacement.sum(axis=0), before["owed_displacement"].sum(axis=0), atol=1e-7
    )
    # place + owed displacement is where a particle's own path has led
    assert np.sum(p.owed_displacement**2) < np.sum(before["owed_displacement"] ** 2)
