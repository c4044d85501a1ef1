"""The run folder: what is in it, when it is written, and how it is continued."""

import csv
import json
import logging
import math
from itertools import pairwise

import numpy as np
import pytest
import pyvista

from debrisflow.case import Case, load_case
from debrisflow.case.defaults import complete
from debrisflow.errors import OutputError
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.arrays import ARRAYS as TABLE
from debrisflow.particles.record import Kind
from debrisflow.particles.start import initial_state
from debrisflow.run.folder import RunFolder
from debrisflow.run.history import COLUMNS, history_row
from debrisflow.run.listeners import Listeners
from debrisflow.run.measures import DepositProfile
from debrisflow.run.progress import Progress
from debrisflow.run.schedule import Schedule
from debrisflow.run.summary import summary
from debrisflow.run.vtu import write_particles
from debrisflow.schemes.clock import Clock

ARRAYS = {
    "velocity": np.float32,
    "pressure": np.float32,
    "kind": np.int8,
    "density": np.float32,
    "number_density": np.float32,
    "concentration": np.float32,
    "granular_temperature": np.float32,
    "sediment_fraction": np.float64,
    "on_free_surface": np.uint8,
    "id": np.int64,
}


@pytest.fixture
def case():
    """Return a small tank half filled with water and half with a mixture."""
    return complete(
        Case(
            title="tank",
            particles={"spacing": 0.1},
            geometry={"type": "tank", "length": 1.0, "height": 1.0},
            fill=[
                {"type": "block", "x": [0, 0.5], "y": [0, 0.4], "material": "water"},
                {"type": "block", "x": [0.5, 1.0], "y": [0, 0.4], "material": "mixture"},
            ],
            time={"end": 1.0},
            output={"interval": 0.1},
        )
    )


@pytest.fixture
def state(case):
    """Return the state of the tank with numbers of its own in every array."""
    state = initial_state(case)
    rng = np.random.default_rng(2)
    for name in ("velocity", "pressure", "number_density", "concentration"):
        array = getattr(state.particles, name)
        array[:] = rng.uniform(-10, 10, array.shape)
    state.particles.granular_temperature[:] = rng.uniform(size=state.particles.count)
    state.particles.on_free_surface[::3] = True
    return state


@pytest.fixture
def row(case, state):
    """Return the row of the history of the tank."""
    return history_row(case, state, 12, reference(2, 3.1, 0.1))


def rows_of(file):
    """Return the rows of a table by column name."""
    with file.open() as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def written(folder, state, row, times):
    """Write a frame, a deposit profile of two bins and a row of history at each time."""
    profile = DepositProfile(*np.array([[0.1, 0.3], [0, 0], [0.2, 0.1], [0.3, 0.3], [0.5, np.nan]]))
    for time in times:
        state.time = time
        folder.write_frame(state)
        folder.write_deposit(time, profile)
        folder.write_history(row | {"time": time})


def test_a_particle_file_holds_every_array_and_every_particle(tmp_path, state):
    write_particles(tmp_path / "p.vtu", state.particles)
    mesh = pyvista.read(tmp_path / "p.vtu")
    stored = {name: mesh.point_data[name].dtype for name in mesh.point_data}
    assert stored == {array.name: array.storage for array in TABLE if not array.optional}
    assert ARRAYS.items() <= stored.items()
    np.testing.assert_array_equal(mesh.points, state.particles.position)
    for name, dtype in ARRAYS.items():
        expected = getattr(state.particles, name).astype(dtype)
        np.testing.assert_array_equal(mesh.point_data[name], expected)
    assert set(mesh.celltypes) == {pyvista.CellType.VERTEX}
    assert mesh.n_cells == state.particles.count


def test_the_collection_is_valid_after_every_frame(tmp_path, case, state, row):
    times = [-0.1, 0.1 + 0.2, 1 / 3]
    with RunFolder.create(tmp_path / "run", case) as folder:
        for n, time in enumerate(times, start=1):
            written(folder, state, row, [time])
            reader = pyvista.PVDReader(tmp_path / "run/particles.pvd")
            assert reader.time_values == times[:n]
            reader.set_active_time_value(time)
            assert reader.read()[0].n_points == state.particles.count


def test_the_folder_repeats_the_case(tmp_path, case):
    RunFolder.create(tmp_path / "run", case).close()
    assert load_case(tmp_path / "run/case.toml") == case


def test_a_folder_with_results_is_refused_and_stays_as_it_is(tmp_path, case, state, row):
    with RunFolder.create(tmp_path, case) as folder:
        written(folder, state, row, [0.0])
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    with pytest.raises(OutputError, match="--overwrite"):
        RunFolder.create(tmp_path, case)
    assert {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()} == before


def test_overwriting_removes_our_files_and_no_others(tmp_path, case, state, row):
    foreign = [tmp_path / "notes.txt", tmp_path / "vtu/mine.vtu", tmp_path / "postprocess/fig.png"]
    with RunFolder.create(tmp_path, case) as folder:
        written(folder, state, row, [0.0, 0.1])
        folder.write_summary({"end_reason": "end"})
    (tmp_path / "postprocess").mkdir()
    (tmp_path / "vtu/000002.vtu.unfinished").touch()
    (tmp_path / "postprocess/class_swiss.tif").touch()
    for file in foreign:
        file.write_text("keep")
    RunFolder.create(tmp_path, case, overwrite=True).close()
    assert all(file.read_text() == "keep" for file in foreign)
    assert [file.name for file in (tmp_path / "vtu").iterdir()] == ["mine.vtu"]
    assert [file.name for file in (tmp_path / "postprocess").iterdir()] == ["fig.png"]
    assert not (tmp_path / "summary.json").exists()
    assert rows_of(tmp_path / "deposit.csv") == rows_of(tmp_path / "history.csv") == []


def test_a_case_file_that_no_run_wrote_is_never_replaced(tmp_path, case):
    (tmp_path / "case.toml").write_text("# my comments")
    with pytest.raises(OutputError, match="no run wrote"):
        RunFolder.create(tmp_path, case, overwrite=True)
    assert (tmp_path / "case.toml").read_text() == "# my comments"


def test_a_folder_that_cannot_be_made_is_told(tmp_path, case):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot write"):
        RunFolder.create(tmp_path / "file/run", case)


def test_a_continued_run_leaves_what_an_uninterrupted_one_leaves(tmp_path, case, state, row):
    times = [k * 0.1 for k in range(6)]
    with RunFolder.create(tmp_path / "whole", case) as folder:
        written(folder, state, row, times)
    with RunFolder.create(tmp_path / "broken", case) as folder:
        written(folder, state, row, times[:5])
        folder.write_summary({"end_reason": "interrupted"})
    with (tmp_path / "broken/history.csv").open("a") as file:
        file.write("0.45,17")
    with RunFolder.open(tmp_path / "broken", case) as folder:
        folder.rewind(times[3])
        written(folder, state, row, times[4:])
    for file in (tmp_path / "whole").rglob("*"):
        if file.is_file() and file.name != "run.log":
            other = tmp_path / "broken" / file.relative_to(tmp_path / "whole")
            assert other.read_bytes() == file.read_bytes()
    assert not (tmp_path / "broken/summary.json").exists()


def test_rewinding_removes_the_files_of_dropped_frames(tmp_path, case, state, row):
    with RunFolder.create(tmp_path, case) as folder:
        written(folder, state, row, [0.0, 0.1, 0.2])
        folder.rewind(0.1)
    assert sorted(f.name for f in (tmp_path / "vtu").iterdir()) == ["000000.vtu", "000001.vtu"]


def test_rows_are_on_disk_while_the_run_goes_on(tmp_path, case, state, row):
    with RunFolder.create(tmp_path, case) as folder:
        written(folder, state, row, [0.1 + 0.2])
        assert [r["time"] for r in rows_of(tmp_path / "history.csv")] == [repr(0.1 + 0.2)]
        deposit = rows_of(tmp_path / "deposit.csv")
    assert [float(r["deposit_height"]) for r in deposit] == [0.2, 0.1]
    assert deposit[1]["concentration"] == "nan"


def test_a_series_with_other_columns_is_not_continued(tmp_path, case):
    RunFolder.create(tmp_path, case).close()
    (tmp_path / "deposit.csv").write_text("time,height\n0,1\n")
    with (
        RunFolder.open(tmp_path, case) as folder,
        pytest.raises(OutputError, match="other columns"),
    ):
        folder.rewind(0.0)


def test_the_log_takes_what_the_package_says_until_it_is_closed(tmp_path, case):
    with RunFolder.create(tmp_path, case) as folder:
        folder.log.info("a step")
        logging.getLogger("debrisflow.physics.pressure").warning("shortened")
    folder.log.warning("too late")
    log = (tmp_path / "run.log").read_text().splitlines()
    assert [line.split(" ", 2)[2] for line in log] == ["INFO a step", "WARNING shortened"]


@pytest.mark.parametrize(("form", "is_there"), [("stable", True), ("study", False)])
def test_only_walls_that_are_surfaces_have_a_share_of_bounces(form, is_there):
    case = load_case("cases/hydrostatic2d.toml", [f"scheme.form='{form}'"])
    state = initial_state(case)
    state.bounces, state.particle_steps = 3, 12
    with Progress(case, state, Clock(), Listeners([])) as shown:
        figures = summary(case, state, "end", 1, shown)
    assert figures.get("bounced_share") == (0.25 if is_there else None)


def test_the_summary_is_json(tmp_path, case):
    with RunFolder.create(tmp_path, case) as folder:
        folder.write_summary({"end_reason": "end", "steps": 3})
    assert json.loads((tmp_path / "summary.json").read_text()) == {"end_reason": "end", "steps": 3}


def test_history_counts_particles_and_mass_by_way_and_phase(case, state):
    state.entered[:] = 7, 1, 0
    state.entered_sediment[:] = 0, 1, 0
    state.left[:] = 0, 0, 2
    state.left_sediment[2] = 0.3 + 0.1
    state.through_wall[:] = 1, 0, 0
    row = history_row(case, state, 12, reference(2, 3.1, 0.1))
    assert set(row) == set(COLUMNS)
    assert (row["particles_in_liquid"], row["particles_in_sediment"]) == (7, 1)
    assert (row["particles_out_mixture"], row["particles_through_wall_liquid"]) == (2, 1)
    assert (row["particles_inside_liquid"], row["particles_inside_mixture"]) == (20, 20)
    assert row["mass_inside_liquid"] == pytest.approx(0.5 * 0.4 * 1000.0)
    assert row["mass_inside_mixture"] == pytest.approx(0.5 * 0.4 * 1825.0)
    assert row["mass_in_sediment"] == pytest.approx(0.1**2 * 2650.0)
    assert row["mass_out_mixture"] == pytest.approx(0.1**2 * (2000.0 + 0.4 * 1650.0))
    volumes = [row[f"sediment_volume_{way}"] for way in ("in", "out", "inside")]
    assert volumes == pytest.approx([0.01, 0.004, 0.5 * 0.4 * 0.5])
    assert row["ppe_iterations"] == 12


def test_history_looks_at_the_fluid_only(case, state):
    p, n0 = state.particles, reference(2, 3.1, 0.1).number_density
    p.velocity[p.kind > Kind.MIXTURE] = 99.0
    p.velocity[p.fluid] = 0.0
    p.velocity[3] = [3.0, 4.0, 0.0]
    p.number_density[:] = 9.0 * n0
    p.number_density[p.fluid] = np.linspace(0.5, 1.1, p.fluid_count) * n0
    row = history_row(case, state, 0, reference(2, 3.1, 0.1))
    assert row["maximal_speed"] == 5.0
    assert row["kinetic_energy"] == pytest.approx(0.5 * 1000.0 * 0.01 * 25.0)
    ratios = row["least_density_ratio"], row["greatest_density_ratio"]
    assert ratios == pytest.approx((0.5, 1.1))
    assert row["front_all"] == p.position[3, 0]


def test_history_of_an_empty_tank_has_no_numbers_to_give(case):
    empty = initial_state(case.model_copy(update={"fill": ()}))
    row = history_row(case, empty, 0, reference(2, 3.1, 0.1))
    assert row["particles_inside_liquid"] == row["maximal_speed"] == 0
    assert math.isnan(row["least_density_ratio"])
    assert math.isnan(row["front_all"])


@pytest.mark.parametrize(
    ("interval", "start", "end", "times"),
    [
        (0.1, 0.0, 0.3, [0.0, 0.1, 0.2, 0.3]),
        (0.25, -0.3, 0.6, [-0.3, -0.25, 0.0, 0.25, 0.5, 0.6]),
        (2.0, 0.0, 0.5, [0.0, 0.5]),
    ],
)
def test_a_schedule_lands_on_multiples_and_on_the_end(interval, start, end, times):
    schedule, time, due = Schedule(interval, start, end), start, []
    while time < math.inf:
        assert schedule.is_due(time)
        assert not schedule.is_due(time + 0.03 * interval)
        due.append(time)
        time = schedule.next_after(time)
    assert due == times


def test_a_schedule_does_not_drift():
    schedule, time = Schedule(0.1, 0.0, 1000.0), 0.0
    for k in range(1, 10000):
        time = schedule.next_after(time)
        assert time == k * 0.1
    assert schedule.next_after(time) == 1000.0


def test_a_due_time_passes_once():
    schedule = Schedule(0.1, 0.0, 0.35)
    times = [-math.inf, 0.0, 0.04, 0.1 - 1e-16, 0.13, 0.17, 0.31, 0.35, 0.4]
    passed = [schedule.passed_due(one, other) for one, other in pairwise(times)]
    assert passed == [True, False, True, False, False, True, True, False]


def test_rounding_does_not_make_a_time_due_twice():
    schedule = Schedule(0.1, 0.0, 1.0)
    for time in (0.3, 0.1 + 0.2, np.nextafter(0.3, 0.0)):
        assert schedule.is_due(time)
        assert schedule.next_after(time) == pytest.approx(0.4)
