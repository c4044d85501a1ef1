"""Case files of before still load, and what is called otherwise now is told."""

import json
import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from debrisflow import build_case, load_case, open_run, simulate
from debrisflow.case import case_schema, dump_case
from debrisflow.case.doubts import doubts
from debrisflow.cli import main
from debrisflow.errors import CaseError
from debrisflow.run.simulation import resume

PRESENT = """
title = "a case of words"
particles = { spacing = 0.01 }
geometry = { type = "tank", length = 0.2, height = 0.2 }
rheology = { type = "coulomb", friction_angle = 30.0 }
time = { end = 0.002, settling = 0.001 }
output = { interval = 0.001 }

[[fill]]
type = "block"
x = [0.0, 0.1]
y = [0.0, 0.1]
material = "two-phase"
"""
FORMER = PRESENT
for present, former in (
    ("length", "width"),
    ("rheology = { type", "strength = { law"),
    ("settling", "relaxation"),
    ("two-phase", "mix"),
):
    FORMER = FORMER.replace(present, former)
NOTES = [
    "strength.law: now called rheology.type",
    "strength: now called rheology",
    "geometry.width: now called geometry.length",
    "time.relaxation: now called time.settling",
    'fill.0.material = "mix": now called "two-phase"',
]


@pytest.fixture
def former(tmp_path: Path) -> Path:
    path = tmp_path / "former.toml"
    path.write_text(FORMER)
    return path


@pytest.fixture
def present(tmp_path: Path) -> Path:
    path = tmp_path / "present.toml"
    path.write_text(PRESENT)
    return path


def test_a_former_file_is_the_same_case_and_its_names_are_told(former: Path, present: Path) -> None:
    case, same = load_case(former), load_case(present)
    assert case.model_dump() == same.model_dump()
    assert dump_case(case) == dump_case(same)
    assert doubts(case) == NOTES
    assert doubts(same) == []


def test_a_former_case_is_built_in_python_and_stays_as_it_is() -> None:
    tables = tomllib.loads(FORMER)
    case = build_case(tables)
    assert case.model_dump() == build_case(tomllib.loads(PRESENT)).model_dump()
    assert doubts(case) == NOTES
    assert tables == tomllib.loads(FORMER)


def test_check_prints_them(former: Path) -> None:
    printed = CliRunner().invoke(main, ["check", str(former)])
    assert printed.exit_code == 0
    for note in NOTES:
        assert f"warning        {note}\n" in printed.output


@pytest.mark.parametrize("text", [FORMER, PRESENT], ids=["former", "present"])
@pytest.mark.parametrize(
    ("override", "note", "value"),
    [
        ("strength.law=bingham", "strength.law: now called rheology.type", "bingham"),
        ("strength.type=bingham", "strength.type: now called rheology.type", "bingham"),
        ("time.relaxation=0.004", "time.relaxation: now called time.settling", 0.004),
        ("geometry.width=0.3", "geometry.width: now called geometry.length", 0.3),
        ("geometry={type='tank', width=0.3, height=0.2}", NOTES[2], 0.3),
    ],
)
def test_overrides_take_them_and_tell(
    tmp_path: Path, text: str, override: str, note: str, value: object
) -> None:
    path = tmp_path / "case.toml"
    path.write_text(text.replace("friction_angle = 30.0", "yield_stress = 30.0"))
    case = load_case(path, ["rheology.type=bingham", override])
    table, field = note.split()[-1].split(".")
    assert getattr(getattr(case, table), field) == value
    assert note in doubts(case)


def test_an_override_of_the_material_takes_the_former_word(present: Path) -> None:
    case = load_case(present, ["fill.0.material=mix"])
    assert case.fill[0].material == "two-phase"
    assert doubts(case) == [NOTES[-1]]


def test_a_width_across_keeps_its_name(former: Path) -> None:
    box = [
        "geometry.width=0.1",
        "geometry.type=tank3d",
        "geometry.length=0.3",
        "fill.0.material=mixture",
        "fill.0.z=[0, 0.1]",
        "time.relaxation=0",
    ]
    case = load_case(former, box)
    assert (case.geometry.length, case.geometry.width) == (0.3, 0.1)


def test_a_former_override_beside_the_present_one_is_the_later_of_both(present: Path) -> None:
    case = load_case(present, ["time.settling=0.1", "time.relaxation=0.2"])
    assert case.time.settling == 0.2


def test_a_run_folder_of_before_is_read_and_resumed(tmp_path: Path, present: Path) -> None:
    folder = tmp_path / "run"
    simulate(load_case(present), folder, threads=1)
    resolved = folder / "case.toml"
    text = resolved.read_text()
    for now, before in (
        ("[rheology]", "[strength]"),
        ("settling =", "relaxation ="),
        ("\nlength =", "\nwidth ="),
        ('"two-phase"', '"mix"'),
    ):
        assert now in text
        text = text.replace(now, before)
    resolved.write_text(text)

    assert open_run(folder).case.model_dump() == load_case(present).model_dump()
    assert resume(folder, threads=1) is None


def test_a_run_keeps_them_in_its_log(tmp_path: Path, former: Path) -> None:
    simulate(load_case(former), tmp_path / "run", threads=1)
    log = (tmp_path / "run" / "run.log").read_text()
    for note in NOTES:
        assert f"WARNING {note}" in log


def test_the_schema_knows_the_present_names_only() -> None:
    schema = json.loads(case_schema())
    tables = schema["$defs"]
    assert {"rheology", "strength"} & set(schema["properties"]) == {"rheology"}
    assert {"settling", "relaxation"} & set(tables["Time"]["properties"]) == {"settling"}
    assert {"length", "width"} & set(tables["Tank"]["properties"]) == {"length"}
    assert {"two-phase", "mix"} & set(tables["Bed"]["properties"]["material"]["enum"]) == {
        "two-phase"
    }


def test_a_wrong_value_is_told_by_the_present_name(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(FORMER.replace('strength = { law = "coulomb"', "strength = { law = 3"))
    with pytest.raises(CaseError, match=r"rheology\.type = 3: must be 'none', 'coulomb'"):
        load_case(path)
