"""The end of a run at rest: what counts as rest, what is written, what resuming it does."""

import json
import shutil

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.case.rasters import read_raster
from debrisflow.particles.start import initial_state
from debrisflow.results import open_run
from debrisflow.run import simulation
from debrisflow.run.stop import StopRule, last_schedule
from debrisflow.run.tables import read_table
from tests.building import tank_case
from tests.fast.test_pore_pressure import slab
from tests.recording import channel3d_case
from tests.terrain_recording import sloping_case


def pushed(**time):
    """Return a case: a slab that friction stops in 0.2 s."""
    case = slab({"velocity": (1.0, 0.0, 0.0)}, {"angle": 45.0})
    plain = case.model_dump() | {"gravity": {"slope": 0.0}, "time": {"end": 1.0} | time}
    return complete(
        Case.model_validate(plain | {"output": {"interval": 0.5, "history_interval": 0.01}})
    )


def test_a_share_of_the_greatest_energy_so_far_is_rest():
    case = tank_case(6, 6, "water", time={"end": 1.0, "stop_energy": 0.01})
    state, rule = initial_state(case), StopRule(case)
    state.time = -0.1
    assert not rule.is_met(state, 50.0)  # while the fills settle
    state.time = 0.0
    assert not rule.is_met(state, 0.0)  # before anything has moved
    state.time = 0.5
    for energy, rests in ((1.0, False), (3.0, False), (0.031, False), (0.029, True)):
        assert rule.is_met(state, energy) == rests
    assert state.peak_energy == 3.0


def test_what_is_released_late_is_not_at_rest():
    case = tank_case(6, 6, "water", time={"end": 90.0, "stop_energy": 0.01})
    state, rule = initial_state(case), StopRule(case)
    rule._earliest = 40.0  # a second mass starts then, when the first has long been at rest
    rows = ((5.0, 5000.0), (39.5, 10.0), (40.0, 10.0), (40.5, 15.0), (41.0, 900.0), (60.0, 20.0))
    found = []
    for state.time, energy in rows:
        found.append(rule.is_met(state, energy))
    assert found == [False, False, False, False, False, True]


def test_without_the_rule_nothing_is_kept():
    case = tank_case(6, 6, "water")
    state, rule = initial_state(case), StopRule(case)
    assert not rule.is_met(state, 3.0)
    assert state.peak_energy == 0.0


def test_rest_is_not_before_supply_and_motions_have_ended():
    case = channel3d_case(time={"end": 9.0, "stop_energy": 0.01})
    assert last_schedule(case) == 0.0
    graph = {"time": [0.0, 3.0, 5.0], "discharge": [0.1, 0.1, 0.0], "concentration": [0.3] * 3}
    supplied = channel3d_case(inflow={"depth": 0.2, "hydrograph": graph})
    assert last_schedule(supplied) == 5.0
    assert last_schedule(channel3d_case(inflow={"depth": 0.2, "discharge": 0.1})) == np.inf
    gate = {"type": "box", "name": "gate", "x": (1.0, 1.1), "y": (0.0, 0.4), "z": (0.0, 1.0)}
    table = gate | {"motion": {"time": [0.0, 2.0], "z": [0.0, 1.5]}}
    assert last_schedule(channel3d_case(obstacle=[table])) == 2.0
    drawn = channel3d_case(
        obstacle=[gate | {"motion": {"velocity": (0.0, 0.0, 3.0), "start": 1.0}}]
    )
    assert 1.4 < last_schedule(drawn) < 1.8  # 1.5 m at 3 m/s, and what is drawn of the wall
    state, rule = initial_state(case), StopRule(supplied)
    rule._share, state.time, state.peak_energy = 0.01, 4.9, 1.0
    assert not rule.is_met(state, 0.0)


@pytest.fixture(scope="module")
def rested(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rest") / "run"
    return folder, simulation.simulate(pushed(stop_energy=0.05), folder)


def test_a_run_ends_at_rest_and_says_so(rested):
    folder, figures = rested
    assert figures["end_reason"] == "at rest"
    assert 0.05 < figures["time"] < 0.5
    assert 0.0 <= figures["energy_share"] < 0.05
    run = open_run(folder)
    energy = np.asarray(run.history["kinetic_energy"])
    assert energy[-1] < 0.05 * energy.max() <= energy[-2]
    assert [frame.time for frame in run.frames()] == [
        0.0,
        figures["time"],
    ]  # the deposit is on record


def test_resuming_it_changes_nothing_while_the_rule_is_the_same(rested):
    folder, _ = rested
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    assert simulation.resume(folder) is None
    assert {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()} == before


def test_with_a_lower_share_it_goes_on(rested, tmp_path):
    figures, folder = rested[1], tmp_path / "copy"
    shutil.copytree(rested[0], folder)
    case = folder / "case.toml"
    case.write_text(case.read_text().replace("stop_energy = 0.05", "stop_energy = 1e-9"))
    longer = simulation.resume(folder)
    assert longer["time"] > figures["time"]
    assert json.loads((folder / "summary.json").read_text())["energy_share"] < 0.05
    whole = simulation.simulate(pushed(stop_energy=1e-9), tmp_path / "whole")
    assert longer["time"] == whole["time"]
    # the frame and the deposit of the first end, off their schedules, are gone
    for name in ("history.csv", "deposit.csv", "particles.pvd"):
        tables = [run / name for run in (folder, tmp_path / "whole")]
        assert tables[0].read_bytes() == tables[1].read_bytes()
    frames = [
        sorted(file.name for file in run.glob("vtu/*")) for run in (folder, tmp_path / "whole")
    ]
    assert frames[0] == frames[1]


def test_on_a_terrain_the_last_depth_is_kept_too(tmp_path):
    friction = {"floor": {"friction": {"law": "coulomb", "angle": 45.0}}}
    output = {"interval": 10.0, "layer_interval": 10.0, "history_interval": 0.1}
    case = sloping_case(
        tmp_path, walls=friction, output=output, time={"end": 10.0, "stop_energy": 0.5}
    )
    figures = simulation.simulate(case, tmp_path / "run")
    assert figures["end_reason"] == "at rest"
    times = read_table(tmp_path / "run" / "layers" / "depth.csv")["time"]
    assert times.tolist() == [0.0, figures["time"]]
    layers = [
        read_raster(tmp_path / "run" / "layers" / f"{name}.tif").values
        for name in ("depth_000001", "final_depth")
    ]
    np.testing.assert_array_equal(*layers)
