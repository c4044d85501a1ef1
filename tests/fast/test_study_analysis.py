"""What is made of the members of a study when something is missing, wrong or left over."""

import json
import shutil
from contextlib import nullcontext

import pytest
import tomli_w
from click.testing import CliRunner

from debrisflow.case import dump_case
from debrisflow.cli import main
from debrisflow.errors import CaseError, OutputError
from debrisflow.study import analysis, fit
from debrisflow.study.analysis import UNFITTED, analyze
from debrisflow.study.lacking import damage, lacking_quantities, without_damaged
from debrisflow.study.names import WRITTEN
from debrisflow.study.outcome import DAMAGED, FAILED, FINISHED, Figure, Outcome, write_outcome
from debrisflow.study.results import Results
from debrisflow.study.sweep import Sweep
from debrisflow.study.written import remove_former
from tests.fan import GRID, fan_case, write_layers

PLACE = [GRID.west + 225.0, GRID.south + 240.0]
DEPTH = {"layer": "peak_depth", "at": PLACE, "name": "depth"}
RUNOUT = {"answer": "runout_length"}
FRICTION = {"name": "friction", "key": "walls.floor.friction.coefficient"}
FRICTION |= {"distribution": "uniform", "low": 0.1, "high": 0.2}
OBSERVED = {"type": "figure", "quantity": "runout_length", "value": 1.0, "error": 1.0}
FITTED = {"observation": [OBSERVED], "calibration": {"runs": 4}}
ANSWERS = {"runout_length": Figure(100.0, "m"), "road_arrival": Figure(float("nan"), "s")}


@pytest.fixture
def made(tmp_path):
    """Return what makes a sweep of three members whose runs are there, and its results."""
    case = fan_case(tmp_path)
    (tmp_path / "fan.toml").write_text(dump_case(case))

    def make(**tables):
        known = {
            "title": "a study",
            "case": "fan.toml",
            "parameter": [FRICTION],
            "design": {"type": "latin-hypercube", "members": 3},
            "quantity": [RUNOUT, DEPTH],
        }
        path = tmp_path / "study.toml"
        path.write_text(tomli_w.dumps(known | tables))
        sweep = Sweep.from_file(path, tmp_path / "sweep")
        for member in sweep.members:
            write_layers(member.folder)
            (member.folder / "case.toml").write_text(dump_case(case))
            write_outcome(member.folder, Outcome(FINISHED, "", ANSWERS, 1.0))
        return sweep, results_of(sweep)

    return make


def results_of(sweep, outcomes=None):
    found = outcomes or [Outcome(FINISHED, "", ANSWERS, 1.0) for _ in sweep.members]
    return Results(sweep.study, sweep.cases.base, sweep.members, found)


def page_of(sweep):
    return (sweep.folder / "report.html").read_text("utf-8")


def test_a_misspelled_answer_is_told_with_the_name_that_was_meant(made):
    sweep, results = made(quantity=[{"answer": "runout_lenght"}])
    found = analyze(sweep, results, None)
    assert found.warnings == [
        "no run gives the answer 'runout_lenght' that a quantity asks for"
        "; did you mean 'runout_length'?"
    ]
    assert "did you mean &#39;runout_length&#39;?" in page_of(sweep)
    assert not found.errors


def test_a_quantity_that_no_member_has_is_told_and_one_that_is_there_is_not(made):
    asked = [{"answer": "road_arrival"}, RUNOUT, {"answer": "zzz"}]
    sweep, results = made(quantity=asked)
    assert list(lacking_quantities(results)) == [
        "no finished member has a value of the quantity 'road_arrival'",
        "no run gives the answer 'zzz' that a quantity asks for; they give runout_length, "
        "road_arrival",
    ]
    failed = results_of(sweep, [Outcome(FAILED, "it diverges", {}, 1.0)] * 3)
    assert list(lacking_quantities(failed)) == []


def test_a_member_whose_layers_are_gone_is_left_out_and_named(made):
    sweep, results = made()
    damaged = results.members[1]
    shutil.rmtree(damaged.folder / "layers")
    found = analyze(sweep, results, None)
    assert [one.state for one in found.results.outcomes] == [FINISHED, DAMAGED, FINISHED]
    (error,) = found.errors
    assert error.exit_code == OutputError.exit_code
    remedy = f"delete the folder {damaged.folder} and start the sweep again"
    assert f"member 1 (friction = {damaged.values['friction']:.4g})" in str(error)
    assert remedy in str(error)
    assert remedy in page_of(sweep)
    rows = (sweep.folder / "members.csv").read_text().splitlines()
    assert [row.split(",")[3] for row in rows if row[0].isdigit()] == [
        FINISHED,
        DAMAGED,
        FINISHED,
    ]


@pytest.mark.parametrize("file", ["layers/terrain.asc", "layers/peak_speed.asc", "case.toml"])
def test_maps_need_the_terrain_their_layers_and_the_case(made, file):
    _, results = made(map=[{"layer": "peak_speed", "exceeds": [1.0]}])
    assert damage(without_damaged(results)) is None
    (results.members[0].folder / file).unlink()
    assert "member 0" in str(damage(without_damaged(results)))


def test_a_damaged_layer_is_told_as_one_that_is_gone(made):
    _, results = made()
    (results.members[2].folder / "layers/peak_depth.asc").write_text("no raster")
    found = without_damaged(results)
    assert found.outcomes[2].state == DAMAGED
    assert "peak_depth.asc" in found.outcomes[2].message


def test_a_fit_that_fails_leaves_a_new_page_that_says_so(made, monkeypatch):
    sweep, results = made(design={"type": "latin-hypercube", "members": 3}, **FITTED)
    sweep.folder.joinpath("report.html").write_text("an old page")
    seen = []

    def fails(*_):
        seen.append(page_of(sweep))
        raise CaseError("the runs give too little for a fit")

    monkeypatch.setattr(fit, "fit", fails)
    found = analyze(sweep, results, None)
    assert UNFITTED in seen[0]
    assert UNFITTED not in page_of(sweep)
    assert "the runs give too little for a fit" in page_of(sweep)
    assert [type(error) for error in found.errors] == [CaseError]
    assert "<title>a study</title>" in page_of(sweep)


def test_no_fit_is_made_without_a_damaged_member(made, monkeypatch):
    sweep, results = made(**FITTED)
    (results.members[0].folder / "layers/peak_depth.asc").unlink()
    monkeypatch.setattr(fit, "fit", lambda *_: pytest.fail("it must not begin"))
    (error,) = analyze(sweep, results, None).errors
    assert "no calibration is made" in str(error)


def test_maps_that_cannot_be_written_stop_neither_tables_nor_page(made, monkeypatch):
    def fails(*_):
        raise OutputError("the maps cannot be written")

    monkeypatch.setattr(analysis, "write_study_maps", fails)
    sweep, results = made()
    found = analyze(sweep, results, None)
    assert "the maps cannot be written" in page_of(sweep)
    assert [str(error) for error in found.errors] == ["the maps cannot be written"]
    assert (sweep.folder / "sensitivity/effects.csv").is_file()


def test_the_command_tells_what_is_wrong_and_has_its_exit_code(made, monkeypatch, tmp_path):
    sweep, results = made(quantity=[{"answer": "runout_lenght"}, DEPTH])
    shutil.rmtree(results.members[1].folder / "layers")
    monkeypatch.setattr(Sweep, "workers", lambda *_: nullcontext())
    monkeypatch.setattr(Sweep, "results", lambda self, *_: results_of(self))
    command = ["sweep", str(tmp_path / "study.toml"), "-o", str(sweep.folder)]
    done = CliRunner().invoke(main, command)
    assert done.exit_code == OutputError.exit_code
    assert "warning: no run gives the answer 'runout_lenght'" in done.stderr
    assert "3 members: 2 finished, 1 damaged" in done.stdout
    assert "delete the folder" in done.stderr

    done = CliRunner().invoke(main, [*command, "--json"])
    result = next(
        line for line in map(json.loads, done.stdout.splitlines()) if line["event"] == "result"
    )
    assert result["damaged"] == 1
    assert "did you mean" in result["warnings"][0]


def names_in(folder):
    return {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()}


def test_what_an_edited_study_wants_no_more_is_removed(made):
    sweep, results = made(map=[{"layer": "peak_speed", "exceeds": [1.0]}])
    analyze(sweep, results, None)
    own = sweep.folder / "maps/mine.tif"
    own.write_text("of a person")
    before = names_in(sweep.folder)
    assert "maps/peak_speed_over_1m_per_s.qml" in before

    sweep, results = made(map=[{"layer": "peak_speed", "exceeds": [2.0]}], quantity=[DEPTH])
    found = analyze(sweep, results, None)
    after = names_in(sweep.folder)
    gone = before - after
    assert gone
    assert all(
        name.startswith(("maps/peak_speed_over_1m", "sensitivity/runout_length")) for name in gone
    )
    assert not [name for name in after if "over_1m" in name or "runout_length" in name]
    assert own.read_text() == "of a person"
    written = {file.relative_to(sweep.folder).as_posix() for file in found.files}
    listed = set(json.loads((sweep.folder / WRITTEN).read_text()))
    assert written - listed == {"report.html"}


def filled(folder, names):
    """Write files into the folder of a study, and list them as those of a former analysis."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(name)
    (folder / WRITTEN).write_text(json.dumps(names))
    return folder


def test_only_files_of_analyses_are_removed(tmp_path):
    removed = ["maps/a.tif", "sensitivity/a.csv", "calibration/a.png", "calibration/maps/a.tif"]
    spared = ["members/0/a.tif", "study.json", "members.csv", "maps/0/a.tif", "other/a.csv"]
    folder = filled(tmp_path / "study", [*removed, *spared])
    assert remove_former(folder, []) == []
    assert names_in(folder) == {*spared, WRITTEN}
    assert json.loads((folder / WRITTEN).read_text()) == []


def test_a_list_cannot_lead_out_of_the_folder(tmp_path):
    outside = tmp_path / "maps/a.tif"
    outside.parent.mkdir()
    outside.write_text("of somebody")
    folder = filled(tmp_path / "study", ["members/maps/a.tif", "maps/real.tif"])
    (folder / "sensitivity").symlink_to(outside.parent)
    (folder / "calibration").symlink_to(folder / "members")
    (folder / "maps/link.tif").symlink_to(folder / "members/maps/a.tif")
    hostile = ["../maps/a.tif", str(outside), "sensitivity/a.tif", "maps/../../maps/a.tif"]
    hostile += ["calibration/maps/a.tif", "maps/link.tif", "maps/..", "maps", "", "maps/\0"]
    (folder / WRITTEN).write_text(json.dumps(hostile))
    assert remove_former(folder, []) == []
    assert outside.read_text() == "of somebody"
    assert (folder / "members/maps/a.tif").is_file()
    assert (folder / "maps/link.tif").is_symlink()
    assert (folder / "maps/real.tif").is_file()


def test_what_is_still_to_come_is_kept_and_remembered(tmp_path):
    folder = filled(tmp_path, ["maps/old.tif", "calibration/old.csv"])
    remove_former(folder, [], spared="calibration")
    assert names_in(folder) == {"calibration/old.csv", WRITTEN}
    remove_former(folder, [])
    assert names_in(folder) == {WRITTEN}


@pytest.mark.parametrize("text", ["{", "[1]", '{"a": 1}', "[" * 10_000])
def test_a_damaged_list_removes_nothing_and_is_told(tmp_path, text):
    folder = filled(tmp_path, ["maps/old.tif"])
    (folder / WRITTEN).write_text(text)
    (warning,) = remove_former(folder, [])
    assert "is damaged" in warning
    assert (folder / "maps/old.tif").is_file()
