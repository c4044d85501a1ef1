"""The files of the probes of a run: when they are written, continued and removed."""

from __future__ import annotations

import csv
import shutil

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.case import load_case
from debrisflow.case.probes import TABLES
from debrisflow.cli import main
from debrisflow.errors import CaseError, OutputError
from debrisflow.particles.start import initial_state
from debrisflow.results import open_run
from debrisflow.results.answers import answers
from debrisflow.results.survey import survey
from debrisflow.run import simulation
from debrisflow.run.folder import RunFolder
from debrisflow.run.probes import sampler_of, samplers
from debrisflow.run.vtu import FOLDER
from tests.building import bed_case, tank3d_case

PROBES = (
    {"name": "level", "type": "height", "interval": 0.004, "x": 0.5},
    {"name": "outlet", "type": "section", "interval": 0.007, "x": 0.7},
    {"name": "inlet", "type": "section", "interval": 0.01, "x": 0.1},
    {"name": "bed", "type": "pressure", "interval": 0.01, "wall": "bed", "x": 0.5, "y": -0.1},
    {"name": "thrust", "type": "force", "interval": 0.03, "wall": "floor"},
    {"name": "inside", "type": "point", "interval": 0.011, "x": 0.3, "y": 0.01},
    {"name": "bed_load", "type": "volume", "interval": 0.02, "x": (0.2, 0.9), "y": (-0.1, 0.0)},
)


def probed(probes=PROBES):
    """Return a short case in which everything acts, with probes."""
    return bed_case(time={"end": 0.15}, output={"interval": 0.05}, probe=probes)


def rows_of(folder, name):
    """Return the rows of the file of a probe, by the names of its columns."""
    with (folder / "probes" / f"{name}.csv").open() as lines:
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        return [{key: float(value) for key, value in row.items()} for row in rows]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Return the folder of a whole run with probes."""
    folder = tmp_path_factory.mktemp("probed") / "whole"
    simulation.simulate(probed(), folder, threads=1)
    return folder


def test_probes_leave_the_solution_as_it_is(whole, tmp_path):
    simulation.simulate(probed(()), tmp_path / "plain", threads=1)
    assert not (tmp_path / "plain" / "probes").exists()
    for file in (tmp_path / "plain" / FOLDER).iterdir():
        assert file.read_bytes() == (whole / FOLDER / file.name).read_bytes()
    history = "history.csv"
    assert (tmp_path / "plain" / history).read_bytes() == (whole / history).read_bytes()


def test_each_probe_has_its_own_interval_and_samples_at_the_end_of_steps(whole):
    for probe in PROBES:
        times = [row["time"] for row in rows_of(whole, probe["name"])]
        due = np.arange(0.0, 0.15 - 1e-9, probe["interval"])
        late = np.array(times[:-1]) - due
        assert times[-1] == 0.15
        assert np.all((late > -1e-9) & (late < 0.003))
        # the history makes a step end at every multiple of 0.005 s
        assert np.any(late > 1e-6) or probe["interval"] not in (0.004, 0.007)


def test_what_goes_through_the_inlet_is_what_was_supplied_less_what_waits_before_it(whole):
    case, last = probed(), rows_of(whole, "inlet")[-1]
    assert 0.0 < last["volume"] <= case.inflow.depth * (0.15 * case.inflow.velocity - 0.1) * 1.3
    assert last["volume"] / 0.02**2 == pytest.approx(round(last["volume"] / 0.02**2))
    assert 0.0 < last["sediment_volume"] < last["volume"]


def test_the_arrival_at_a_section_is_the_first_sample_after_it(whole):
    inlet = rows_of(whole, "inlet")
    before = max(row["time"] for row in inlet if row["volume"] <= 0.0)
    rows = {row.quantity: row.value for row in answers(survey(open_run(whole)))}
    found = {name: value for name, value in rows.items() if name.endswith("_arrival")}
    assert found.keys() == {"inlet_arrival", "outlet_arrival"}
    assert 0.1 / 1.5 < before < found["inlet_arrival"] <= before + 0.013
    assert np.isnan(found["outlet_arrival"])
    told = CliRunner().invoke(main, ["postprocess", str(whole)]).stdout
    assert f"section inlet: first passed by t = {found['inlet_arrival']:g} s" in told
    assert "section outlet: nothing has passed" in told


def test_an_interrupted_run_writes_the_same_rows(whole, tmp_path, interrupt):
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulation.simulate(probed(), tmp_path / "broken", threads=1)
    shutil.copytree(tmp_path / "broken", tmp_path / "rest")
    with (tmp_path / "rest/probes/level.csv").open("a") as file:
        file.write("0.149,7,7\n")  # written after the checkpoint
    simulation.resume(tmp_path / "rest", threads=1)
    for probe in PROBES:
        name = f"probes/{probe['name']}.csv"
        assert (tmp_path / "rest" / name).read_bytes() == (whole / name).read_bytes()


def test_overwriting_removes_the_files_of_earlier_probes_and_no_others(tmp_path):
    RunFolder.create(tmp_path, probed()).close()
    (tmp_path / "probes/mine.csv").write_text("time,height\n")
    RunFolder.create(tmp_path, probed(PROBES[:1]), overwrite=True).close()
    assert sorted(f.name for f in (tmp_path / "probes").iterdir()) == ["level.csv", "mine.csv"]


def test_the_folder_repeats_the_probes_with_their_sizes(tmp_path):
    case = probed()
    RunFolder.create(tmp_path, case).close()
    assert load_case(tmp_path / "case.toml") == case
    assert case.probe[0].size == 0.04


def test_a_place_off_a_wall_that_only_the_run_knows_is_told():
    case = probed([PROBES[3] | {"y": 0.1}])
    with pytest.raises(CaseError, match=r"'bed': the place is .* m from the surface of bed"):
        samplers(case, initial_state(case))


def test_only_probes_with_a_sum_have_one_in_the_state():
    state = initial_state(probed())
    samplers(probed(), state)
    assert state.sums.keys() == {"level", "outlet", "inlet", "thrust", "bed", "inside"}


def test_a_sum_that_a_checkpoint_lacks_is_not_taken_as_zero():
    state = initial_state(probed())
    state.step = 40
    with pytest.raises(OutputError, match="no running sum of the probe 'level'"):
        samplers(probed(), state)


def test_each_table_has_a_sampler_with_names_of_its_own():
    for table in TABLES:
        for dimension in (2, 3):
            columns = sampler_of(table).columns(dimension)
            names = [column.name for column in columns]
            assert len(set(names)) == len(names) > 0
            assert all(column.meaning for column in columns)


def test_a_probe_on_a_hidden_wall_is_told_before_results_are_replaced(whole, tmp_path):
    folder = tmp_path / "kept"
    shutil.copytree(whole, folder)
    lid = {"name": "lid", "type": "box", "x": [0.0, 0.8], "y": [0.0, 0.6], "z": [0.0, 0.2]}
    probe = {"name": "p", "type": "pressure", "interval": 0.1, "wall": "floor"}
    case = tank3d_case(z=(0.2, 0.5), obstacle=[lid], probe=[probe | {"x": 0.4, "y": 0.3, "z": 0.0}])
    with pytest.raises(CaseError, match="nothing of floor is open"):
        simulation.simulate(case, folder, threads=1, overwrite=True)
    assert (folder / "summary.json").is_file()


def test_the_height_over_a_pier_as_high_as_its_tank_starts_at_its_top():
    pier = {"name": "pier", "type": "box", "x": [0.4, 0.8], "y": [0.0, 0.6], "z": [0.0, 1.0]}
    probe = {"name": "h", "type": "height", "interval": 0.1, "x": 0.6, "y": 0.3}
    block = {"type": "block", "x": [0.0, 0.4], "y": [0.0, 0.6], "z": [0.0, 0.5]}
    case = tank3d_case(obstacle=[pier], fill=[block | {"material": "water"}], probe=[probe])
    state = initial_state(case)
    assert not any(samplers(case, state)["h"].sample(state))
