"""The study's own form of the explicit scheme: what it is, and what it costs."""

from pathlib import Path

import numpy as np
import pytest

from debrisflow.case import load_case
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.record import Kind
from debrisflow.particles.seeding import seed
from debrisflow.physics import study_form
from debrisflow.physics.kinetic_theory import Grains, bulk_viscosity
from debrisflow.run.simulation import simulate
from debrisflow.schemes.study_explicit import StudyExplicit
from debrisflow.validation.marching import advance
from tests.building import lattice_block, one_list, random_patch, separations, started, tank3d_case

LATTICE = reference(3, 2.4, 1.0)
CASES = Path(__file__).parents[2] / "cases"
STUDY = {"scheme": {"type": "explicit", "form": "study", "sound_speed": 22.0}}


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def test_the_cube_has_the_number_of_particles_of_the_study():
    particles = seed(load_case(CASES / "dam_break3d.toml", ['scheme.form="study"']))
    kinds = np.bincount(particles.kind, minlength=len(Kind))
    assert particles.count == 38_456
    assert kinds[Kind.MIXTURE] == 8_000
    assert kinds[Kind.WALL] + kinds[Kind.DUMMY] == 66 * 66 * 3 + 756 * 23


def test_density_and_equation_of_state_are_those_of_a_lattice():
    block = lattice_block(3, 7)
    near = one_list(block, LATTICE)
    n, pressure = np.empty((2, len(block)))
    study_form.sum_densities(near, 1000.0, 22.0, n, pressure)
    middle = int(np.argmin(np.sum((block - 3.5) ** 2, axis=1)))
    assert n[middle] == pytest.approx(LATTICE.number_density, rel=1e-12)
    assert pressure[middle] == pytest.approx(0.0, abs=1e-6)
    assert study_form.pressure_of(1.02 * n[middle], near, 1000.0, 22.0) == pytest.approx(9680.0)
    assert not pressure[0]  # a corner does not pull


def test_the_gradient_is_that_of_equation_14(rng):
    position, pressure = random_patch(3, 60, rng, 5.0), rng.uniform(0.0, 1e3, 60)
    near, r = one_list(position, LATTICE), separations(position)
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf
    w = np.maximum(LATTICE.effective_radius / distance - 1.0, 0.0)
    for i in range(60):
        least = min(pressure[i], pressure[w[i] > 0.0].min(initial=np.inf))
        f = (pressure - least) * w[i] / distance[i] ** 2
        exact = 3.0 / LATTICE.number_density * f @ r[i]
        found = study_form.study_gradient_at(i, pressure, near)
        np.testing.assert_allclose(found, exact, rtol=1e-10, atol=1e-9)


def test_walls_hold_by_their_rest_unless_they_are_free_slip(rng):
    position = random_patch(3, 40, rng, 4.0)
    near = one_list(position, LATTICE, rows=30)
    velocity, viscosity = rng.normal(size=(40, 3)), rng.uniform(1.0, 2.0, 30)
    velocity[30:] = 0.0
    slip = np.array([0.0, 1.0] * 5)
    r = separations(position)
    distance = np.linalg.norm(r, axis=2)
    distance[distance == 0.0] = np.inf
    w = np.maximum(LATTICE.effective_radius / distance - 1.0, 0.0)
    factor = 6.0 / (LATTICE.laplacian_lambda * LATTICE.number_density)
    for i in range(30):
        mu = 2.0 * viscosity[i] * viscosity / (viscosity[i] + viscosity)
        mu = np.concatenate([mu, viscosity[i] * (1.0 - slip)])
        exact = factor * (mu * w[i]) @ (velocity - velocity[i])
        found = study_form.study_laplacian_at(i, velocity, viscosity, near, slip)
        np.testing.assert_allclose(found, exact, rtol=1e-10, atol=1e-9)


def test_the_bulk_viscosity_is_five_thirds_of_twice_that_of_shear():
    grains = Grains(2650.0, 0.003, 0.7, 0.55, 0.54)
    (found,) = bulk_viscosity(np.array([0.4]), np.array([0.02]), grains)
    g0 = 1.0 / (1.0 - (0.4 / 0.55) ** (1.0 / 3.0))
    exact = 4.0 * 0.4**2 * 0.003 * 2650.0 * g0 * 1.7 * np.sqrt(0.02) / (3.0 * np.sqrt(np.pi))
    assert found == pytest.approx(exact, rel=1e-12)


def test_it_costs_the_rest_of_still_water():
    # within a second: the stable form keeps 20 mm/s and its height
    case = tank3d_case(size=(0.8, 0.6, 1.0), **STUDY)
    scheme, state = started(case)
    assert isinstance(scheme, StudyExplicit)
    p = state.particles
    height = p.position[p.fluid, 2].mean()
    scheme.fill_number_density(state)
    advance(scheme, state, until=1.0)
    speed = np.sqrt(np.mean(np.sum(p.velocity[p.fluid] ** 2, axis=1)))
    assert speed > 0.1
    assert abs(p.position[p.fluid, 2].mean() / height - 1.0) > 0.01


def test_a_run_writes_frames_of_the_fluid_and_its_surfaces(tmp_path):
    case = tank3d_case(
        probe=[{"name": "push", "type": "force", "wall": "floor", "interval": 0.01}],
        **STUDY | {"time": {"end": 0.02}, "output": {"interval": 0.02}},
    )
    simulate(case, tmp_path / "run")
    assert (tmp_path / "run" / "walls.vtp").is_file()
    lines = (tmp_path / "run" / "probes" / "push.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines if not line.startswith("#")]
    down = [float(row[rows[0].index("force_z")]) for row in rows[1:]]
    assert len(down) == 3
    assert down[-1] < 0.0
