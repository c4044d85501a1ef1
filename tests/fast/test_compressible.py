"""The sums of the explicit scheme against all pairs, on the lattice, and what they conserve."""

import numpy as np
import pytest

from debrisflow.neighbors import lattice
from debrisflow.neighbors.boundary import LEAST_HEIGHT, wall_sums_at
from debrisflow.neighbors.half_space import PULLED_BACK, STRETCH, lever_beyond, push_beyond
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.pairs import weight
from debrisflow.physics import compressible, wall_push
from tests.building import (
    NOWHERE,
    RADII,
    Plane,
    acceleration_at,
    fluid_of,
    lattice_block,
    no_walls,
    numbers_of,
    planes,
    random_patch,
    separations,
    two_lists,
)

SPACING = 0.5
LATTICE = reference(3, 2.4, SPACING)
LENGTH = 9.0 * SPACING  # a little more than three radii of the list, the least for a period
PERIODS = [NOWHERE, np.array([0.0, LENGTH, 0.0])]
NO_WALLS = no_walls(729)
GRADIENT = 3.0 / LATTICE.number_density
LAPLACIAN = 2.0 * GRADIENT / LATTICE.laplacian_lambda

# One rounding of each of some 50 terms, relative to the greatest.
EXACT = 1e-12


@pytest.fixture
def rng():
    return np.random.default_rng(17)


@pytest.fixture(params=PERIODS, ids=["open", "periodic"])
def period(request):
    return request.param


@pytest.fixture
def position(rng):
    """Return the places of 300 particles anywhere."""
    return random_patch(3, 300, rng, LENGTH)


@pytest.fixture(params=[False, True], ids=["one-density", "own-densities"])
def fluid(rng, request):
    """Return 300 particles, of which each value is random."""
    scalar = {
        "density": rng.uniform(500.0, 1000.0, 300) if request.param else None,
        "compression": rng.uniform(-0.01, 0.05, 300),
        "pressure": rng.uniform(0.0, 5e3, 300),
        "grain_pressure": rng.uniform(0.0, 1e3, 300),
        "viscosity": rng.uniform(0.0, 100.0, 300),
    }
    return fluid_of(300, velocity=rng.normal(0.0, 0.5, (300, 3)), **scalar)


@pytest.fixture
def solid(position):
    """Return what the particles feel of a free-slip and two no-slip walls, not at right angles."""
    return planes(
        position,
        LATTICE,
        Plane((0.0, 0.0, 0.2), (0.36, -0.48, 0.8)),
        Plane((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), slip=1.0),
        Plane((0.0, LENGTH, 0.0), (0.0, -0.8, 0.6)),
    )


@pytest.fixture
def block():
    """Return the points of a lattice around the origin, of which the middle one has all near it."""
    position = lattice_block(3, 9, SPACING)
    return position - position[len(position) // 2]


def rows(function, position, fluid, solid, period=NOWHERE, **changes):
    """Return what a function of one particle returns for each, (n, k) float64 array."""
    near, numbers = two_lists(position, LATTICE, period), numbers_of(LATTICE, **changes)
    return np.array([function(i, fluid, near, solid, numbers) for i in range(len(position))])


def middle_row(function, position, fluid, solid=NO_WALLS, **changes):
    """Return what a function of one particle returns for the one nearest to the origin."""
    near, numbers = two_lists(position, LATTICE), numbers_of(LATTICE, **changes)
    i = int(np.argmin(np.linalg.norm(position, axis=1)))
    return np.array(function(i, fluid, near, solid, numbers))


def all_pairs(position, period):
    """Return separation, distance and weight of all pairs."""
    r = separations(position, period)
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf  # itself
    return r, distance, np.maximum(LATTICE.effective_radius / distance - 1.0, 0.0)


def wall_sums(solid):
    """Return n, m, G and the matrices T of every particle over the walls."""
    sums = np.array([wall_sums_at(i, solid) for i in range(solid.row.size)])
    xx, yy, zz, xy, xz, yz = sums[:, 5:].T
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
    return sums[:, 0], sums[:, 1], sums[:, 2:5], tensor


def densities(fluid):
    """Return the density of every particle, (n,) float64 array, kg/m3."""
    return np.full(len(fluid.velocity), 1000.0) if fluid.density is None else fluid.density


def assert_alike(found, expected):
    """Assert that values are equal but for rounding relative to the greatest of them."""
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=EXACT * np.abs(expected).max())


def balance(parts):
    """Return the sum of vectors relative to the sum of their magnitudes."""
    return np.abs(parts.sum(axis=0)).max() / np.abs(parts).sum()


def test_densities_and_continuity_are_the_sums_over_all_pairs(position, fluid, solid, period):
    found = rows(compressible.density_rate_at, position, fluid, solid, period)
    numbers = numbers_of(LATTICE)
    (r, d, w), (wall_n, wall_m, push, _) = all_pairs(position, period), wall_sums(solid)
    q = np.minimum(d / LATTICE.effective_radius, 1.0)
    n, m = w.sum(axis=1) + wall_n, 1.0 + lattice.smooth_weight(q).sum(axis=1) + wall_m
    u, s = fluid.velocity, fluid.compression
    u_ij = u[None] - u[:, None]
    flow = (np.sum(u_ij * r, axis=2) * w / d**2).sum(axis=1)
    flow -= 2.0 * np.sum(u * push, axis=1)
    rho = densities(fluid)
    heavy = 0.5 * (rho[None] + rho[:, None]) / 1000.0
    buoyant = s[None] - s[:, None] - heavy * (r @ numbers.gravity) / 20.0**2
    diffusion = 0.1 * 20.0 * SPACING * LAPLACIAN * (buoyant * w).sum(axis=1)
    assert_alike(found[:, 0], n / LATTICE.number_density)
    assert_alike(found[:, 1], (m / LATTICE.smooth_density - 1.0) / LATTICE.smooth_steepness)
    assert_alike(found[:, 2], -(1.0 + s) * 3.0 / LATTICE.number_density * flow + diffusion)
    around = (r * (w / d**2)[:, :, None]).sum(axis=1) + push
    expected = SPACING * np.linalg.norm(around, axis=1) / LATTICE.number_density
    assert_alike(found[:, 3], expected)


def test_the_density_of_the_lattice_is_its_reference(block):
    n, summed, rate, asymmetry = middle_row(
        compressible.density_rate_at, block, fluid_of(len(block))
    )
    assert n == pytest.approx(1.0, rel=EXACT)
    np.testing.assert_allclose([summed, rate, asymmetry], 0.0, atol=EXACT)


@pytest.mark.parametrize("s", [0.0, 0.03])
def test_a_uniform_expansion_thins_the_fluid_by_its_divergence(block, s):
    # sum of u_ij . r_ij w / r^2 = a n0 for u = a r
    fluid = fluid_of(len(block), velocity=0.7 * block, compression=np.full(len(block), s))
    _, _, rate, _ = middle_row(compressible.density_rate_at, block, fluid)
    assert rate == pytest.approx(-(1.0 + s) * 3.0 * 0.7, rel=EXACT)


def test_a_rigid_rotation_does_not_change_the_density(position, fluid):
    turning = fluid._replace(velocity=np.cross([0.3, -2.0, 1.0], position))
    found = rows(compressible.density_rate_at, position, turning, NO_WALLS, diffusion=0.0)[:, 2]
    # u_ij . r_ij w / r^2 of one pair is of order |u_ij| / d0
    np.testing.assert_allclose(found, 0.0, atol=1e-11)


@pytest.mark.parametrize("density", [None, 700.0])
def test_a_hydrostatic_compression_does_not_diffuse(position, fluid, density):
    gravity = numbers_of(LATTICE).gravity
    per_height = (1.0 if density is None else 0.7) / 20.0**2
    still = fluid_of(
        300,
        compression=0.02 + per_height * (position @ gravity),
        density=None if density is None else np.full(300, density),
    )
    np.testing.assert_allclose(
        rows(compressible.density_rate_at, position, still, NO_WALLS)[:, 2],
        0.0,
        atol=EXACT
        * np.abs(rows(compressible.density_rate_at, position, fluid, NO_WALLS)[:, 2]).max(),
    )


def test_diffusion_conserves_the_mean_compression(position, fluid, period):
    still = fluid_of(300, compression=fluid.compression, density=fluid.density)
    rate = rows(compressible.density_rate_at, position, still, NO_WALLS, period)[:, 2]
    assert np.abs(rate).max() > 0.01
    assert balance(rate[:, None]) < EXACT
    # and brings it to one value
    relative = fluid.compression - fluid.compression.mean()
    calm = rows(
        compressible.density_rate_at, position, still, NO_WALLS, period, gravity=np.zeros(3)
    )[:, 2]
    assert relative @ calm < 0.0


def pushes(position, fluid, solid, period, numbers):
    """Return the force of the walls by their pressure, from sums over all pairs, N/m3."""
    (r, d, w), (_, _, push, spread) = all_pairs(position, period), wall_sums(solid)
    p, rho, third = fluid.total_pressure, densities(fluid), LATTICE.number_density / 3.0
    found = np.zeros_like(position)
    for i in np.flatnonzero(push.any(axis=1)):
        f = w[i] / d[i] ** 2
        matrix = np.einsum("j,jk,jl->kl", f, r[i], r[i])
        matrix += wall_push.LEAST_MOMENT * third * np.eye(3)
        right = (f * (p - p[i])) @ r[i]
        for normal in solid.normal[solid.row[i], : solid.faces[solid.row[i]]]:
            across = wall_push.STIFF_ACROSS * third * normal
            matrix += np.outer(across, normal)
            right += across * rho[i] * (numbers.gravity @ normal)
        toward = 2.0 * p[i] * push[i] + spread[i] @ np.linalg.solve(matrix, right)
        out = push[i] / np.linalg.norm(push[i])
        found[i] = -GRADIENT * (toward + max(p[i] * (push[i] @ out) - toward @ out, 0.0) * out)
    return found


def drags(velocity, viscosity, solid):
    """Return the force of no-slip walls by viscosity, N/m3."""
    found = np.zeros_like(velocity)
    for i in np.flatnonzero(solid.row >= 0):
        row, r_e = solid.row[i], LATTICE.effective_radius / SPACING
        for f in range(solid.faces[row]):
            normal, slip = solid.normal[row, f], solid.slip[solid.number[row, f]]
            height = max(solid.distance[row, f], LEAST_HEIGHT * SPACING)
            q = STRETCH * (height / SPACING + PULLED_BACK)
            if q >= r_e:
                continue
            share = solid.push[row, f] * SPACING / push_beyond(q, r_e)
            lever = share * lever_beyond(q, r_e) * SPACING
            along = velocity[i] - (velocity[i] @ normal) * normal
            found[i] -= LAPLACIAN * viscosity[i] * (1.0 - slip) * lever / height * along
    return found


def test_the_acceleration_is_the_sum_over_all_pairs(position, fluid, solid, period):
    found = rows(acceleration_at, position, fluid, solid, period)
    numbers = numbers_of(LATTICE)
    r, d, w = all_pairs(position, period)
    u, mu, p, rho = fluid.velocity, fluid.viscosity, fluid.total_pressure, densities(fluid)
    u_ij = u[None] - u[:, None]
    approach, mean = np.sum(u_ij * r, axis=2), 0.5 * (rho[None] + rho[:, None])
    artificial = LAPLACIAN * mean * 0.05 * 20.0 * SPACING * approach
    along = (artificial - GRADIENT * (p[None] + p[:, None])) * w / d**2
    harmonic = 2.0 * mu[None] * mu[:, None] / (mu[None] + mu[:, None])
    drag = LAPLACIAN * harmonic * w
    force = np.einsum("ij,ijk->ik", along, r) + np.einsum("ij,ijk->ik", drag, u_ij)
    force += pushes(position, fluid, solid, period, numbers) + drags(u, mu, solid)
    assert_alike(found[:, :3], numbers.gravity + force / rho[:, None])
    hits = np.where((d < 0.8 * SPACING) & (approach < 0.0), approach / d**2, 0.0)
    assert np.any(hits)
    shared = hits * rho[None] / mean  # twice the reduced mass over the own
    assert_alike(found[:, 3:6], 0.5 * 1.2 * np.einsum("ij,ijk->ik", shared, r))


def test_without_a_distance_nothing_collides(position, fluid, period):
    free = rows(acceleration_at, position, fluid, NO_WALLS, period, collision_distance=None)
    found = rows(acceleration_at, position, fluid, NO_WALLS, period)
    np.testing.assert_array_equal(free[:, 3:6], 0.0)
    np.testing.assert_allclose(free[:, :3], found[:, :3], rtol=1e-9, atol=1e-9)


def test_forces_between_particles_conserve_momentum(position, fluid, period):
    found = rows(acceleration_at, position, fluid, NO_WALLS, period, gravity=np.zeros(3))
    assert np.abs(found[:, :3]).max() > 1.0
    assert np.abs(found[:, 3:6]).max() > 0.1
    mass = densities(fluid)[:, None]
    assert balance(mass * found[:, :3]) < EXACT
    assert balance(mass * found[:, 3:6]) < EXACT


def test_the_loop_over_particles_conserves_momentum(position, fluid, period):
    near, numbers = two_lists(position, LATTICE, period), numbers_of(LATTICE)
    velocity, dt, mass = np.empty((300, 3)), 0.002, densities(fluid)[:, None]
    push, reaction = np.empty((2, 300, 3))
    bounced = np.empty(300, dtype=np.bool_)
    compressible.advance_velocity(
        dt, fluid, near, NO_WALLS, numbers, velocity, push, reaction, bounced
    )
    assert not bounced.any()
    assert not push.any()
    assert not reaction.any()
    gained = velocity - fluid.velocity - dt * numbers.gravity
    assert np.abs(gained).max() > 0.1
    assert balance(mass * gained) < EXACT


def test_pressure_damping_and_collisions_conserve_angular_momentum(position, fluid):
    inviscid = fluid._replace(viscosity=np.zeros(300))
    found = rows(acceleration_at, position, inviscid, NO_WALLS, gravity=np.zeros(3))
    for parts in (found[:, :3], found[:, 3:6]):
        assert np.any(parts)
        force = densities(fluid)[:, None] * parts
        assert balance(np.cross(position, force)) < EXACT


@pytest.mark.parametrize("part", ["artificial_viscosity", "viscosity", "collisions"])
def test_dissipation_takes_energy_of_any_motion(position, fluid, part):
    calm = fluid_of(300, velocity=fluid.velocity, density=fluid.density)
    calm = calm._replace(viscosity=fluid.viscosity * (part == "viscosity"))
    changes = {"artificial_viscosity": 0.05 * (part == "artificial_viscosity")}
    found = rows(acceleration_at, position, calm, NO_WALLS, gravity=np.zeros(3), **changes)
    given = found[:, 3:6] if part == "collisions" else found[:, :3]
    # relative to rho0
    assert densities(fluid) @ np.sum(given * fluid.velocity, axis=1) / 1000.0 < -1e-3


def test_what_pressure_takes_from_motion_is_stored_by_compression(position, fluid):
    s = np.abs(fluid.compression)
    calm = fluid_of(300, velocity=fluid.velocity, compression=s, density=fluid.density)
    still = {"gravity": np.zeros(3), "artificial_viscosity": 0.0, "diffusion": 0.0}
    numbers = numbers_of(LATTICE, **still)
    pressed = calm._replace(pressure=numbers.density * numbers.sound_speed**2 * s)
    pressed = pressed._replace(total_pressure=pressed.pressure)
    given = rows(acceleration_at, position, pressed, NO_WALLS, **still)[:, :3]
    rate = rows(compressible.density_rate_at, position, pressed, NO_WALLS, **still)[:, 2]
    # in a volume without compression, over rho0
    stored = numbers.sound_speed**2 * s / (1.0 + s) * rate
    taken = densities(fluid) @ np.sum(given * fluid.velocity, axis=1) / numbers.density
    assert np.abs(stored).max() > 1.0
    assert abs(taken + stored.sum()) < EXACT * np.abs(stored).sum()


def test_a_linear_pressure_is_exact_on_the_lattice(block, rng):
    slope, grains = 1e3 * rng.normal(size=(2, 3))
    pressure, between = 5e3 + block @ slope, 3e3 + block @ grains
    fluid = fluid_of(len(block), pressure=pressure, grain_pressure=between)
    for light in (1.0, 0.5):
        if light < 1.0:
            fluid = fluid._replace(density=np.full(len(block), light * 1000.0))
        found = middle_row(acceleration_at, block, fluid)
        # the sum of the magnitudes of 57 pairs is p / (rho d0), 20 m/s2, times some ten
        expected = [1.0, 2.0, -9.0] - (slope + grains) / (light * 1000.0)
        np.testing.assert_allclose(found[:3], expected, atol=200.0 / light * EXACT)
        assert not np.any(found[3:6])


def viscous(position, velocity, solid=NO_WALLS):
    """Return the acceleration of the middle particle by viscosity alone."""
    viscosity = np.full(len(position), 300.0)
    changes = {"gravity": np.zeros(3), "artificial_viscosity": 0.0}
    fluid = fluid_of(len(position), velocity=velocity, viscosity=viscosity)
    return middle_row(acceleration_at, position, fluid, solid, **changes)[:3]


def test_the_viscous_force_of_a_quadratic_profile_is_exact_on_the_lattice(block):
    velocity = np.zeros_like(block)
    velocity[:, 0] = 2.0 + 5.0 * block[:, 2] + 4.0 * block[:, 2] ** 2 + block[:, 0] * block[:, 1]
    np.testing.assert_allclose(viscous(block, velocity), [0.3 * 8.0, 0.0, 0.0], atol=10.0 * EXACT)


def test_the_equation_of_state_bears_no_tension():
    numbers = numbers_of(LATTICE)
    assert compressible.state_pressure(-0.01, numbers) == 0.0
    assert compressible.state_pressure(0.0, numbers) == 0.0
    # p = c^2 (rho - rho0)
    assert compressible.state_pressure(0.03, numbers) == pytest.approx(400.0 * 30.0, rel=1e-15)


def test_the_compression_follows_continuity_and_inside_the_fluid_the_summed_density():
    def after(s, asymmetry, rate=0.5, summed=0.02, dt=0.001):
        return compressible.new_compression(s, rate, asymmetry, summed, 0.1, dt)

    assert after(0.03, 0.3) == after(0.03, 0.101) == pytest.approx(0.0305, rel=1e-15)
    assert after(0.03, 0.0) == after(0.03, 0.049) == pytest.approx(0.0304, rel=1e-15)
    assert after(0.03, 0.075) == pytest.approx(0.03045, rel=1e-15)
    # without a rate it comes to the summed density within some relaxation times
    s = 0.03
    for _ in range(1000):
        s = after(s, 0.0, rate=0.0)
    assert s == pytest.approx(0.02 + 0.01 * np.exp(-10.0), rel=1e-3)  # dt is 1 % of the time
    # out of bounds it stays at them
    assert after(0.03, 0.2, rate=1e6) == compressible.GREATEST_COMPRESSION
    assert after(0.03, 0.2, rate=-1e6) == compressible.LEAST_COMPRESSION


def test_the_asymmetry_tells_a_flat_surface_from_the_row_beneath(block):
    """By arithmetic on the cubic lattice without the layers above, r_e = 2.4 d0."""
    found = []
    for rows_above in (0, 1, 2):
        under = block[block[:, 2] < (rows_above + 0.5) * SPACING]
        found.append(middle_row(compressible.density_rate_at, under, fluid_of(len(under)))[3])
    assert found == pytest.approx([0.1571, 0.0095, 0.0], abs=5e-5)


def test_the_loop_writes_density_compression_and_pressure_of_each_particle(
    position, fluid, solid, period
):
    near, numbers = two_lists(position, LATTICE, period), numbers_of(LATTICE)
    n, s, p = np.empty((3, 300))
    compressible.advance_density(0.002, fluid, near, solid, numbers, n, s, p)
    for i, row in enumerate(rows(compressible.density_rate_at, position, fluid, solid, period)):
        ratio, summed, rate, asymmetry = row
        expected = compressible.new_compression(
            fluid.compression[i], rate, asymmetry, summed, numbers.relaxation, 0.002
        )
        assert n[i] == pytest.approx(ratio * LATTICE.number_density, rel=EXACT)
        assert s[i] == pytest.approx(expected, rel=1e-11, abs=1e-14)
        assert p[i] == pytest.approx(compressible.state_pressure(s[i], numbers), rel=1e-15)


def test_the_smooth_weight_of_the_kernels_is_that_of_the_lattice():
    near = two_lists(np.zeros((1, 3)), LATTICE)
    q = np.linspace(0.01, 1.2, 50)
    found = []
    for r in q * LATTICE.effective_radius:
        w = weight(1.0 / r, near)
        found.append(compressible.smooth_weight(w, r * r, 1.0 / r, near))
    expected = np.where(q < 1.0, lattice.smooth_weight(q), 0.0)
    np.testing.assert_allclose(found, expected, atol=1e-15)


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_the_smooth_density_grows_with_the_density_as_its_steepness_tells(dimension, radius):
    known, step = reference(dimension, radius, 1.0), 1e-4
    r = np.linalg.norm(lattice_block(dimension, 9) - 4.5 * (np.arange(3) < dimension), axis=1)

    def summed(density):
        q = r * density ** (-1.0 / dimension) / radius
        return lattice.smooth_weight(q[q < 1.0]).sum()  # W(0) = 1 of itself

    assert summed(1.0) == pytest.approx(known.smooth_density, rel=1e-13)
    growth = (summed(1.0 + step) - summed(1.0 - step)) / (2.0 * step * known.smooth_density)
    # a central difference, whose error is of the order of the squared step
    assert growth == pytest.approx(known.smooth_steepness, rel=1e-6)
