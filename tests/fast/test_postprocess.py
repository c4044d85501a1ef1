"""Post-processing: what it measures in frames placed by hand, and what it says of damaged ones."""

import csv

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.errors import OutputError
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.start import initial_state
from debrisflow.results import open_run
from debrisflow.results.postprocess import postprocess
from debrisflow.results.survey import survey
from debrisflow.run.folder import RunFolder

D0 = 0.02
BED = 0.1


@pytest.fixture(scope="module")
def case():
    """Return a channel with a saturated bed and a block of water on it."""
    return complete(
        Case(
            title="channel",
            particles={"spacing": D0},
            geometry={
                "type": "channel",
                "length": 1.6,
                "height": 1.0,
                "bed_start": 0.4,
                "bed_thickness": BED,
            },
            fill=[
                {"type": "bed", "material": "sediment"},
                {"type": "block", "x": [0.4, 0.8], "y": [0.0, 0.1], "material": "water"},
            ],
            time={"end": 1.0},
            output={"interval": 0.1},
        )
    )


@pytest.fixture
def run(tmp_path, case):
    """Return a run whose water slides at 1 m/s over the bed at rest, in three frames."""
    return recorded(tmp_path / "run", case)


@pytest.fixture(scope="module")
def done(tmp_path_factory, case):
    """Return such a run whose tables and plots are written, and their files."""
    folder = recorded(tmp_path_factory.mktemp("done") / "run", case)
    return folder, written(folder)


def recorded(path, case):
    """Write a run whose water slides at 1 m/s over the bed at rest, in three frames."""
    state = initial_state(case)
    p = state.particles
    p.number_density[:] = reference(2, 3.1, D0).number_density
    p.concentration[:] = p.sediment_fraction
    water = p.position[p.fluid, 1] > 0.0
    p.velocity[p.fluid, 0] = np.where(water, 1.0, 0.0)
    with RunFolder.create(path, case) as folder:
        for k in range(3):
            state.time = 0.1 * k
            folder.write_frame(state)
            p.position[p.fluid, 0] += np.where(water, 0.1, 0.0)
    return path


def written(folder, stations=()):
    """Write the tables and plots of a run and return their files."""
    files, _ = postprocess(survey(open_run(folder), stations))
    return files


def rows_of(file):
    """Return the rows of a table as numbers by column name."""
    with file.open() as lines:
        table = csv.DictReader(line for line in lines if not line.startswith("#"))
        return [{name: float(value) for name, value in row.items()} for row in table]


TABLES = (
    "front",
    "profiles",
    "mean_profiles",
    "hydrographs",
    "stations",
    "deposit_profile",
    "budget",
    "momentum",
    "distances",
    "answers",
)


def test_it_writes_tables_that_state_what_they_hold(done):
    run, written_files = done
    files = [file for file in written_files if file.suffix == ".csv"]
    assert files == [run / "postprocess" / f"{name}.csv" for name in TABLES]
    assert all(file.read_text().startswith("# ") for file in files)


def test_the_front_moves_with_the_water(done):
    run, _ = done
    rows = rows_of(run / "postprocess/front.csv")
    assert [r["time"] for r in rows] == [0.0, 0.1, 0.2]
    expected = [0.8 - D0 / 2 + 0.1 * k for k in range(3)]
    assert [r["front_all"] for r in rows] == pytest.approx(expected)
    assert [r["speed_liquid"] for r in rows] == pytest.approx([1.0, 1.0, 1.0])
    assert all(np.isnan([r["front_sediment"] for r in rows]))


def test_the_front_of_a_single_frame_has_no_speed(run, case):
    with RunFolder.open(run, case) as folder:
        folder.rewind(0.0)
        folder.write_maxima(initial_state(case))
    written(run)
    (only,) = rows_of(run / "postprocess/front.csv")
    assert only["front_all"] == pytest.approx(0.8 - D0 / 2)
    assert np.isnan(only["speed_all"])


def test_a_profile_shows_the_water_above_the_bed(done):
    run, _ = done
    rows = rows_of(run / "postprocess/profiles.csv")
    stations = sorted({r["station"] for r in rows})
    assert stations == pytest.approx([0.2 * k for k in range(2, 8)])
    rows = [r for r in rows if r["time"] == 0.0 and r["station"] == pytest.approx(0.6)]
    y = np.array([r["y"] for r in rows])
    np.testing.assert_allclose(y, (np.arange(10) + 0.5) * D0)
    assert [r["velocity"] for r in rows] == pytest.approx(np.where(y > BED, 1.0, 0.0))
    assert [r["concentration"] for r in rows] == pytest.approx(np.where(y > BED, 0.0, 1.0))
    assert {r["samples"] for r in rows} == {2.0}


def test_stations_can_be_chosen(run):
    found = survey(open_run(run), [0.5])
    assert set(found.profiles["station"]) == set(found.hydrographs["station"]) == {0.5}


def test_the_deposit_profile_is_that_of_the_first_and_the_last_frame(done):
    run, _ = done
    rows = rows_of(run / "postprocess/deposit_profile.csv")
    assert {r["time"] for r in rows} == {0.0, 0.2}
    rows = [r for r in rows if r["time"] == 0.2]
    before, under, behind = (
        next(r for r in rows if r["x"] == pytest.approx(x)) for x in (0.3, 0.7, 1.26)
    )
    measured = ("floor_level", "deposit_height", "flow_height", "concentration")
    assert [before[m] for m in measured] == pytest.approx([0.0, 0.0, 0.0, np.nan], nan_ok=True)
    assert [under[m] for m in measured] == pytest.approx([-BED, BED, BED + 0.1, 0.5])
    assert [behind[m] for m in measured] == pytest.approx([-BED, BED, BED, 1.0])


def test_it_can_be_repeated(done):
    run, files = done
    first = [file.read_bytes() for file in files]
    assert [file.read_bytes() for file in written(run)] == first


def test_a_folder_that_cannot_be_written_is_told(run):
    (run / "postprocess").touch()
    with pytest.raises(OutputError, match="cannot write"):
        written(run)


def test_a_folder_without_a_run_is_told(tmp_path):
    with pytest.raises(OutputError, match="no run folder"):
        written(tmp_path)


def test_a_run_without_frames_is_told(tmp_path, case):
    RunFolder.create(tmp_path, case).close()
    with pytest.raises(OutputError, match="no frames yet"):
        written(tmp_path)


def test_a_missing_frame_is_told(run):
    (run / "vtu/000001.vtu").unlink()
    with pytest.raises(OutputError, match=r"000001\.vtu is missing"):
        written(run)


def test_a_frame_that_is_cut_off_is_told(run):
    file = run / "vtu/000001.vtu"
    file.write_bytes(file.read_bytes()[:-40])
    with pytest.raises(OutputError, match=r"000001\.vtu is damaged: it is cut off"):
        written(run)


def test_a_frame_with_broken_contents_is_told(run):
    file = run / "vtu/000002.vtu"
    text = file.read_bytes()
    start = text.index(b">", text.index(b'Name="velocity"')) + 60
    file.write_bytes(text[:start] + b"A" * 40 + text[start + 40 :])
    with pytest.raises(
        OutputError, match=r"000002\.vtu is damaged: its array 'velocity' cannot be unpacked"
    ):
        written(run)


def test_a_damaged_collection_is_told(run):
    file = run / "particles.pvd"
    file.write_text(file.read_text()[:80])
    with pytest.raises(OutputError, match=r"particles\.pvd is damaged"):
        written(run)
