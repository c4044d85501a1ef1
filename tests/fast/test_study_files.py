"""The files that a sweep leaves for itself, read as what others may have written."""

import json

import pytest
import tomli_w

from debrisflow.case import dump_case
from debrisflow.errors import OutputError
from debrisflow.study.analysis import write_members
from debrisflow.study.outcome import (
    FAILED,
    FILE,
    FINISHED,
    Figure,
    Outcome,
    read_outcome,
    write_outcome,
)
from debrisflow.study.progress import Bar
from debrisflow.study.results import Results
from debrisflow.study.status import DAMAGED, status_lines, sweep_status
from debrisflow.study.sweep import Sweep
from tests.fan import fan_case
from tests.fast.test_study_report import results_of, study_of

CLEAR = chr(27) + "[2J"  # what clears a terminal
KEPT = {"state": "finished", "message": "", "answers": {"a": [1.0, "m"]}, "seconds": 2.0}


@pytest.fixture
def fan_study(tmp_path):
    """Write a study of two members on the terrain of the tests."""
    case = fan_case(tmp_path)
    (tmp_path / "fan.toml").write_text(dump_case(case))
    parameter = {"name": "friction", "key": "walls.floor.friction.coefficient"}
    parameter |= {"distribution": "values", "values": [0.1, 0.2]}
    tables = {"title": "a study", "case": "fan.toml", "parameter": [parameter]}
    path = tmp_path / "study.toml"
    path.write_text(tomli_w.dumps(tables | {"design": {"type": "grid"}}))
    return path


def left(folder, **changes):
    """Write what became of a member, with changes, and return its folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / FILE).write_text(json.dumps(KEPT | changes))
    return folder


def planned(folder, names, store="members"):
    """Write the list of the members of a sweep."""
    members = [
        {"number": k, "folder": name, "values": {"dem": CLEAR}} for k, name in enumerate(names)
    ]
    folder.mkdir(exist_ok=True)
    plan = {"title": "a study", "store": store, "members": members}
    (folder / "study.json").write_text(json.dumps(plan))
    return folder


def test_what_became_of_a_member_is_read_as_it_was_written(tmp_path):
    answers = {"a": Figure(1.5, "m"), "b": Figure(float("nan"), "s")}
    outcome = Outcome(FINISHED, "", answers, 3.0)
    write_outcome(tmp_path, outcome)
    assert repr(read_outcome(tmp_path)) == repr(outcome)


@pytest.mark.parametrize(
    "changes",
    [
        {"state": "stopped"},
        {"state": CLEAR},
        {"seconds": float("inf")},
        {"answers": {"a": [float("nan"), "m"]}},
        {"answers": {"a": [float("inf"), "m"]}},
        {"more": 1},
    ],
)
def test_another_state_and_numbers_without_end_are_damage(tmp_path, changes):
    with pytest.raises(OutputError, match="is damaged; delete this file"):
        read_outcome(left(tmp_path, **changes))


def test_a_member_cannot_steer_the_terminal(tmp_path, capsys):
    results = results_of(tmp_path, study_of())
    member = results.members[0]._replace(values={"friction": CLEAR, "volume": 1.0})
    with Bar(1, is_quiet=True) as told:
        told(member, Outcome(FAILED, CLEAR, {}, 1.0))
    shown = capsys.readouterr().err
    assert shown.count("\\x1b[2J") == 2
    assert chr(27) not in shown

    outcome = Outcome(FINISHED, "", {"runout_length": Figure(1.0, f"m\n{CLEAR}")}, 1.0)
    hostile = Results(results.study, results.base, [member], [outcome])
    text = write_members(hostile, tmp_path / "members.csv").read_text()
    assert chr(27) not in text
    assert [line[0] for line in text.splitlines()] == ["#", "#", "n", "0"]


@pytest.mark.parametrize("name", ["/etc", "../../x", "0" * 15, "0" * 17, "ABCDEF" + "0" * 10])
def test_a_folder_that_is_no_digest_is_no_member(tmp_path, name):
    with pytest.raises(OutputError, match=r"study\.json is damaged"):
        sweep_status(planned(tmp_path / "sweep", [name]))


def test_a_damaged_member_is_counted_and_the_others_are_shown(tmp_path):
    names = [f"{k:016x}" for k in range(4)]
    sweep = planned(tmp_path / "sweep", names)
    left(sweep / "members" / names[0])
    left(sweep / "members" / names[1], state=CLEAR)
    left(sweep / "members" / names[2], state=FAILED, message="it diverges")
    status = sweep_status(sweep)
    assert [status[state] for state in (FINISHED, FAILED, DAMAGED, "waiting")] == [1, 1, 1, 1]
    assert [one["state"] for one in status["shown"]] == [DAMAGED, FAILED]
    lines = "\n".join(status_lines(status))
    assert "1 damaged" in lines
    assert f"{names[1]}/member.json is damaged; delete this file and start the sweep" in lines
    assert chr(27) not in lines


def test_a_run_whose_own_status_is_damaged_stops_no_status_of_the_sweep(tmp_path):
    names = [f"{k:016x}" for k in range(2)]
    sweep = planned(tmp_path / "sweep", names)
    left(sweep / "members" / names[0])
    run = sweep / "members" / names[1]
    run.mkdir()
    (run / "case.toml").write_text("")
    (run / "status.json").write_text("{")
    status = sweep_status(sweep)
    assert (status[FINISHED], status[DAMAGED]) == (1, 1)


def test_a_sweep_that_was_moved_finds_its_members(tmp_path):
    sweep = planned(tmp_path / "sweep", ["0" * 16])
    left(sweep / "members" / ("0" * 16))
    moved = sweep.rename(tmp_path / "moved")
    assert sweep_status(moved)[FINISHED] == 1


def test_the_list_of_members_names_their_store_by_its_place(tmp_path, fan_study):
    inside = Sweep.from_file(fan_study, tmp_path / "sweep")
    outside = Sweep.from_file(fan_study, tmp_path / "other", store=tmp_path / "shared")
    found = []
    for sweep in (inside, outside):
        with sweep.open():
            found.append(json.loads((sweep.folder / "study.json").read_text())["store"])
        assert sweep_status(sweep.folder)["waiting"] == 2
    assert found == ["members", str(tmp_path / "shared")]
