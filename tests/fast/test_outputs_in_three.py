"""Deposit, flow, maxima, energies and files in three dimensions: on particles placed by hand."""

import csv

import numpy as np
import pytest
import pyvista

from debrisflow.case import Case, tables
from debrisflow.case.defaults import complete
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.matter import set_material
from debrisflow.particles.maxima import no_maxima
from debrisflow.particles.record import Kind, blank
from debrisflow.particles.start import initial_state
from debrisflow.results import open_run
from debrisflow.results.postprocess import postprocess
from debrisflow.results.survey import survey
from debrisflow.run import folder
from debrisflow.run.folder import RunFolder
from debrisflow.run.history import history_row
from debrisflow.run.measures import deposit_profile, elastic_energy, energies, flow, fronts
from debrisflow.space.plan_grid import cell_level, plan

D0 = 0.1
LATTICE = reference(3, 2.4, D0)
N0 = LATTICE.number_density
SOUND = 22.0


def tank(fill=((0.0, 0.4), (0.0, 0.4), (0.0, 0.3)), periodic=False, obstacles=()):
    """Return a tank of 10 by 6 by 8 spacings, 5 by 3 cells, with a block of mixture in it."""
    x, y, z = fill
    return complete(
        Case(
            title="tank",
            particles={"spacing": D0},
            gravity={"acceleration": 10.0},
            geometry={
                "type": "tank3d",
                "length": 1.0,
                "width": 0.6,
                "height": 0.8,
                "periodic": periodic,
            },
            obstacle=[{"type": "box"} | obstacle for obstacle in obstacles],
            fill=[{"type": "block", "x": x, "y": y, "z": z, "material": "mixture"}],
            mixture={"concentration": 0.4},
            scheme={"type": "explicit", "sound_speed": SOUND},
            time={"end": 1.0},
            output={"interval": 0.1},
        )
    )


BOX = {"name": "house", "x": (0.4, 0.8), "y": (0.2, 0.4), "z": (0.0, 0.3)}
BEAM = {"name": "bridge", "x": (0.8, 1.0), "y": (0.0, 0.6), "z": (0.4, 0.5)}


def lattice(case, columns, rows, layers, kind=Kind.MIXTURE):
    """Return fluid particles at rest on the lattice of some cells, of full number density."""
    i, j, k = (c.ravel() for c in np.meshgrid(columns, rows, layers, indexing="ij"))
    particles = blank(i.size)
    particles.position[:] = (np.column_stack([i, j, k]) + 0.5) * D0
    set_material(particles, slice(None), kind, case)
    particles.number_density[:] = N0
    particles.fluid_count = i.size
    return particles


def deposit(case, p):
    """Return the deposit of particles, its columns as arrays over (along, across)."""
    profile = deposit_profile(
        case,
        p.position,
        p.velocity,
        p.kind,
        p.concentration,
        p.sediment_fraction,
        p.number_density,
        N0,
    )
    return {name: value.reshape(5, 3) for name, value in profile._asdict().items()}


def table(file):
    """Return the columns of a table as arrays of numbers."""
    with file.open() as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def test_the_cells_cover_the_plan_in_steps_of_two_spacings():
    grid = plan(tank())
    np.testing.assert_allclose(grid.x.reshape(5, 3)[:, 0], np.arange(0.1, 1.0, 0.2))
    np.testing.assert_allclose(grid.y.reshape(5, 3)[0], [0.1, 0.3, 0.5])
    np.testing.assert_allclose(grid.area, 0.04)


def test_a_pile_is_as_high_as_its_layers_and_other_cells_are_empty():
    case = tank()
    found = deposit(case, lattice(case, [2, 3], [4, 5], range(3)))
    here = np.zeros((5, 3), dtype=bool)
    here[1, 2] = True
    np.testing.assert_allclose(found["deposit_height"], np.where(here, 0.3, 0.0))
    np.testing.assert_allclose(found["flow_height"], np.where(here, 0.3, 0.0))
    np.testing.assert_allclose(found["concentration"], np.where(here, 0.4, np.nan))


def test_a_layer_that_flows_ends_the_deposit_of_its_cell_alone():
    case = tank()
    p = lattice(case, range(10), range(6), range(5))
    moves = (p.position[:, 2] > 0.2) & (p.position[:, 2] < 0.3)
    p.velocity[moves & (p.position[:, 0] < 0.2) & (p.position[:, 1] < 0.2), 1] = 1.0
    expected = np.full((5, 3), 0.5)
    expected[0, 0] = 0.2
    np.testing.assert_allclose(deposit(case, p)["deposit_height"], expected)


def test_what_hangs_above_a_gap_is_no_deposit_in_any_cell():
    case = tank()
    p = lattice(case, range(10), range(6), [0, 1, 4, 5])
    gone = (p.position[:, 0] > 0.8) & (p.position[:, 2] < 0.3)
    found = deposit(case, lattice_without(p, gone))
    np.testing.assert_allclose(found["deposit_height"][:4], 0.2)
    np.testing.assert_allclose(found["deposit_height"][4], 0.0)
    np.testing.assert_allclose(found["flow_height"], 0.2)


def lattice_without(particles, gone):
    """Return the particles without some."""
    particles.keep(np.flatnonzero(~gone), particles.count)
    particles.fluid_count = particles.count
    return particles


def test_piles_are_what_a_loop_over_cells_finds(rng):
    case = tank()
    p = lattice(case, range(10), range(6), range(8))
    p.position += rng.uniform(-1.0, 1.0, p.position.shape) * D0
    p = lattice_without(p, rng.random(p.count) < 0.7)
    p.velocity[rng.random(p.count) < 0.2] = 1.0
    found = deposit(case, p)["deposit_height"]
    for i, j in np.ndindex(5, 3):
        inside = (p.position[:, :2] >= 0.2 * np.array([i, j])).all(axis=1)
        inside &= (p.position[:, :2] < 0.2 * np.array([i + 1, j + 1])).all(axis=1)
        top = -0.5 * D0
        still = inside & (p.velocity[:, 0] == 0.0) & (p.position[:, 2] > 0.0)
        for z in np.sort(p.position[still, 2]):
            if z > top + 1.5 * D0:
                break
            top = max(top, z)
        assert found[i, j] == pytest.approx(top + 0.5 * D0)


def test_the_top_of_an_obstacle_is_the_floor_and_a_beam_is_not():
    case = tank(obstacles=(BOX, BEAM))
    raised = cell_level(case, plan(case)).reshape(5, 3)
    expected = np.zeros((5, 3))
    expected[2:4, 1] = 0.3
    np.testing.assert_allclose(raised, expected)
    found = deposit(case, lattice(case, range(4, 6), range(6), [3, 4]))
    np.testing.assert_allclose(found["deposit_height"][2], [0.0, 0.2, 0.0])
    np.testing.assert_allclose(found["flow_height"][2], 0.2)  # beside the box it flies


def test_obstacles_stand_on_each_other():
    tower = {"name": "tower", "x": (0.4, 0.6), "y": (0.2, 0.4), "z": (0.3, 0.5)}
    case = tank(obstacles=(tower, BOX))
    raised = cell_level(case, plan(case)).reshape(5, 3)
    np.testing.assert_allclose(raised[2:4, 1], [0.5, 0.3])


def test_a_tank_that_repeats_across_takes_in_what_left_its_width():
    case = tank(periodic=True)
    found = deposit(case, lattice(case, [0, 1], [6, 7], range(2)))
    np.testing.assert_allclose(found["deposit_height"][0], [0.2, 0.0, 0.0])


def test_the_front_is_the_foremost_of_the_whole_width():
    case = tank()
    p = lattice(case, range(4), [0, 5], [0])
    p.velocity[:, 1] = -1.0
    p.position[-1, 0] = 0.87
    found = fronts(case, p.position, p.velocity, p.kind)
    assert found["mixture"] == found["all"] == 0.87


def test_flow_is_depth_mean_speed_and_momentum_flux():
    case = tank()
    p = lattice(case, [0, 1], [0, 1], range(3))
    p.velocity[:, 0] = np.where(p.position[:, 2] < 0.1, 0.0, 3.0)
    depth, speed, flux, *_ = flow(case, p, N0)
    assert (depth[0], speed[0]) == pytest.approx((0.3, 2.0))
    assert flux[0] == pytest.approx(p.density[0] * 3.0**2 * 0.2)  # rho u^2 h of two layers
    assert not np.any([depth[1:], speed[1:], flux[1:]])


def test_drops_are_no_flow():
    case = tank()
    p = lattice(case, [0, 1], [0, 1], range(3))
    p.velocity[:, 0] = 1.0
    high = p.position[:, 2] > 0.2
    p.number_density[high] = 0.49 * N0
    p.velocity[high] = 9.0
    depth, speed, *_ = flow(case, p, N0)
    assert (depth[0], speed[0]) == pytest.approx((0.2, 1.0))


def test_maxima_remember_the_greatest_and_the_first():
    case = tank()
    maxima = no_maxima(15)
    cells = {0: ([0, 1], [2, 3]), 1: ([2, 3], [2, 3])}
    for time, cell, layers, speed in ((0.0, 0, 3, 1.0), (0.1, 1, 1, 4.0), (0.2, 1, 2, 2.0)):
        p = lattice(case, *cells[cell], range(layers))
        p.velocity[:, 0] = speed
        maxima.include(time, *flow(case, p, N0), spacing=D0)
    rho = case.water.density + 0.4 * (case.sediment.density - case.water.density)
    at = {0: 1, 1: 4}  # numbers of the cells, three across
    assert maxima.depth[[at[0], at[1]]] == pytest.approx([0.3, 0.2])
    assert maxima.speed[[at[0], at[1]]] == pytest.approx([1.0, 4.0])
    expected = [rho * 0.3 * 1.0, rho * 0.1 * 16.0]
    assert maxima.momentum_flux[[at[0], at[1]]] == pytest.approx(expected)
    assert maxima.arrival_time[at[1]] == 0.1
    assert np.isnan(np.delete(maxima.arrival_time, at[1])).all()


def test_a_flow_arrives_over_a_bed_where_it_is_deeper_than_at_the_start():
    maxima = no_maxima(3)
    still = np.zeros(3)
    for time, depth in ((0.0, [0.5, 0.5, 0.0]), (0.1, [0.54, 0.56, 0.1]), (0.2, [0.6, 0.4, 0.3])):
        depth = np.array(depth)
        maxima.include(time, depth, still, still, depth, depth > 0.0, spacing=D0)
    np.testing.assert_array_equal(maxima.arrival_time, [0.2, 0.1, 0.1])


def test_a_flow_has_come_where_nothing_rested_or_it_has_risen():
    maxima, depth = no_maxima(4), np.array([0.5, 0.5, 0.5, 0.0])
    assert maxima.reached(depth, D0).all()  # before the first sample
    rests = np.array([True, True, False, False])
    maxima.include(0.0, depth, 0.0 * depth, 0.0 * depth, depth, rests, spacing=D0)
    now = np.array([0.54, 0.56, 0.3, 0.01])
    np.testing.assert_array_equal(maxima.reached(now, D0), [False, True, True, True])


def test_a_film_that_rested_is_not_a_flow():
    case = tank()
    p = lattice(case, range(10), range(6), [0])
    p.number_density[:] = 0.3 * N0
    found = flow(case, p, N0)
    assert not found.depth.any()
    np.testing.assert_allclose(found.whole_depth, D0)
    assert found.rests.all()


def test_energies_are_those_of_cubes():
    case = tank()
    p = lattice(case, [0], [0], [4])
    p.velocity[:] = [1.0, 2.0, 2.0]
    energy = energies(case, p.position, p.velocity, p.density, p.kind)
    mass = p.density[0] * D0**3
    assert energy == pytest.approx((4.5 * mass, mass * 10.0 * 0.45))


def test_the_elastic_energy_of_a_hydrostatic_column_is_that_of_the_integral():
    case = tank(fill=((0.0, 1.0), (0.0, 0.6), (0.0, 0.7)))
    p = lattice(case, range(10), range(6), np.arange(0, 7, 0.01))  # a hundred slices a layer
    p.density[:] /= 100.0
    height = 0.7
    p.compression[:] = 10.0 * (height - p.position[:, 2] + 0.495 * D0) / SOUND**2
    found = elastic_energy(case, p.density, p.kind, p.compression)
    rho = case.water.density + 0.4 * (case.sediment.density - case.water.density)
    expected = rho * 10.0**2 * height**3 / (6.0 * SOUND**2) * 0.6
    at_the_floor = 10.0 * height / SOUND**2  # the next order in s takes half this share off
    assert found == pytest.approx(expected * (1.0 - 0.5 * at_the_floor), rel=1e-3)


def test_tension_and_incompressible_fluids_store_nothing():
    case = tank()
    p = lattice(case, [0], [0], range(4))
    assert elastic_energy(case, p.density, p.kind, np.full(4, -0.01)) == 0.0
    incompressible = case.model_copy(update={"scheme": tables.Scheme()})
    assert elastic_energy(incompressible, p.density, p.kind, np.full(4, 0.01)) == 0.0


@pytest.fixture
def rng():
    return np.random.default_rng(7)


@pytest.fixture
def case():
    """Return a tank with an obstacle and a beam."""
    return tank(obstacles=(BOX, BEAM))


@pytest.fixture
def run(tmp_path, case):
    """Return a run of three frames in which the mixture slides at 1 m/s, and its last state."""
    state = initial_state(case)
    p = state.particles
    p.number_density[:] = N0
    p.velocity[p.fluid, 0] = 1.0
    with RunFolder.create(tmp_path / "run", case) as folder:
        for k in range(3):
            state.time = 0.1 * k
            state.maxima.include(state.time, *flow(case, p, N0), spacing=D0)
            found = deposit_profile(
                case,
                p.position,
                p.velocity,
                p.kind,
                p.concentration,
                p.sediment_fraction,
                p.number_density,
                N0,
            )
            folder.write_history(history_row(case, state, 0, LATTICE))
            folder.write_deposit(state.time, found)
            folder.write_frame(state)
            p.position[p.fluid, 0] += 0.1
    return tmp_path / "run"


def test_walls_stand_in_a_file_of_their_own(run, case):
    p = initial_state(case).particles
    walls, frame = pyvista.read(run / "walls.vtp"), pyvista.read(run / "vtu/000000.vtu")
    assert frame.n_points == p.fluid_count
    assert frame["kind"].max() == Kind.MIXTURE
    assert walls.bounds == pytest.approx((0.0, 1.0, 0.0, 0.6, 0.0, 0.8))
    number = walls.cell_data["obstacle"]
    assert set(number) == set(range(-1, len(case.obstacle)))
    for k, obstacle in enumerate(case.obstacle):
        body = walls.extract_cells(number == k)
        assert body.n_cells == 6
        assert body.bounds == pytest.approx((*obstacle.x, *obstacle.y, *obstacle.z))
    # floor and four sides
    assert np.count_nonzero(number == -1) == 5
    assert walls.extract_cells(number == -1).area == pytest.approx(0.6 + 2 * 0.8 * 1.6)


def test_the_file_of_walls_is_written_once(tmp_path, case, monkeypatch):
    written = []

    def write(path, case):
        written.append(path)
        path.touch()

    monkeypatch.setattr(folder, "write_walls", write)
    state = initial_state(case)
    with RunFolder.create(tmp_path / "run", case) as made:
        for k in range(3):
            state.time = 0.1 * k
            made.write_frame(state)
    assert written == [tmp_path / "run/walls.vtp"]


def test_overwriting_removes_walls_and_maxima(run, case):
    RunFolder.create(run, case, overwrite=True).close()
    assert not (run / "walls.vtp").exists()
    assert not (run / "maxima.csv").exists()


def test_the_tables_have_a_row_a_cell(run):
    deposit = table(run / "deposit.csv")
    assert list(deposit) == ["time", "x", "y", "deposit_height", "flow_height", "concentration"]
    assert deposit["time"].size == 3 * 15
    maxima = table(run / "maxima.csv")
    assert maxima["x"].size == maxima["y"].size == 15
    arrived = maxima["arrival_time"].reshape(5, 3)
    assert arrived[2, 0] == pytest.approx(0.1)
    np.testing.assert_array_equal(maxima["floor_level"].reshape(5, 3)[2], [0.0, 0.3, 0.0])
    assert np.isnan(arrived[[0, 1]]).all()
    assert maxima["maximal_depth"].reshape(5, 3)[2, 0] == pytest.approx(0.3, abs=0.02)


def test_history_counts_whole_masses(run):
    history = table(run / "history.csv")
    assert history["mass_inside_mixture"] == pytest.approx(0.4 * 0.4 * 0.3 * 1660.0)
    assert history["elastic_energy"][0] > 0.0
    assert "kg per meter" not in (run / "history.csv").read_text()


def test_post_processing_measures_in_three_dimensions(run):
    postprocess(survey(open_run(run), [0.5]))
    files = (run / f"postprocess/{name}.csv" for name in ("front", "profiles", "deposit_profile"))
    front, profiles, deposit = (table(file) for file in files)
    assert np.diff(front["front_all"]) == pytest.approx(0.1)
    assert front["speed_mixture"] == pytest.approx(1.0)
    assert list(profiles)[:5] == ["time", "station", "z", "velocity", "concentration"]
    last = profiles["time"] == 0.2
    np.testing.assert_allclose(profiles["z"][last], [0.05, 0.15, 0.25])
    np.testing.assert_array_equal(profiles["samples"][last], 2 * 4)
    names = ["x", "y", "floor_level", "deposit_height", "flow_height", "concentration"]
    assert list(deposit)[:7] == ["time", *names]
    assert np.count_nonzero(deposit["time"] == 0.2) == 15
