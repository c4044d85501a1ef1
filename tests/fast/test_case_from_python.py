"""A case built in Python without a file: checked as one, resolved as one, run as one."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from debrisflow import build_case, load_case, open_run, simulate
from debrisflow.errors import CaseError
from tests.conftest import CHANNEL, TANK


def tank_tables() -> dict:
    return tomllib.loads(TANK)


def test_it_is_the_case_of_a_file_with_the_same_content(tank: Path) -> None:
    changes = ["time.end=0.5", "scheme.form=study"]
    assert build_case(tank_tables(), changes) == load_case(tank, changes)


@pytest.mark.parametrize("path", sorted(Path("cases").glob("*.toml")), ids=lambda path: path.stem)
def test_every_shipped_case_can_be_built(path: Path) -> None:
    built = build_case(tomllib.loads(path.read_text(encoding="utf-8")), folder=path.parent)
    read = load_case(path)
    assert built == read.model_copy(update={"notes": ""})  # a dict has no comment at its head


def test_tuples_arrays_and_none_stand_for_what_a_file_can_hold() -> None:
    tables = tank_tables()
    tables["fill"] = ({**tables["fill"][0], "x": np.array([0.0, 0.2]), "z": None},)
    tables["particles"] = {"spacing": np.float64(0.01), "seed": np.int64(1)}
    tables["inflow"] = None
    assert build_case(tables) == build_case(tank_tables())


def test_files_are_looked_up_in_the_given_folder(tmp_path: Path) -> None:
    (tmp_path / "supply.csv").write_text("time,discharge,concentration\n0,0.01,0\n9,0.02,0.1\n")
    tables = tomllib.loads(CHANNEL)
    tables["inflow"] = {"depth": 0.04, "hydrograph": Path("supply.csv")}

    assert build_case(tables, folder=tmp_path).inflow.hydrograph.discharge == (0.01, 0.02)
    with pytest.raises(CaseError, match=r'inflow\.hydrograph = "supply\.csv": cannot be read'):
        build_case(tables, folder=str(tmp_path / "elsewhere"))


def test_every_mistake_is_told_at_once() -> None:
    tables = tank_tables()
    tables["time"] = {"ende": 1.0}
    tables["particles"]["spacing"] = "fine"

    with pytest.raises(CaseError) as caught:
        build_case(tables, ["no equals sign"])

    told = str(caught.value).splitlines()
    assert told[0] == "the case: 4 errors"
    assert any("time.ende = 1.0: unknown key; did you mean 'end'?" in line for line in told)
    assert any('particles.spacing = "fine" m: must be a number' in line for line in told)
    assert any("--set no equals sign: must be KEY=VALUE" in line for line in told)


@pytest.mark.parametrize("key", ["spacing", "fill", "title"])
def test_what_no_file_could_hold_is_told_as_well(key: str) -> None:
    tables = tank_tables()
    (tables["particles"] if key == "spacing" else tables)[key] = object()
    with pytest.raises(CaseError, match=rf"{key} = <object .*: must be"):
        build_case(tables)


@pytest.mark.parametrize("given", ["tank.toml", None, [1]])
def test_what_is_no_dict_is_told(given: object) -> None:
    with pytest.raises(CaseError, match="a case is built of a dict of tables, not of"):
        build_case(given)


def test_it_is_run_and_read_again(tmp_path: Path) -> None:
    case = build_case(tank_tables(), ["time.end=0.002", "output.interval=0.001"])
    simulate(case, tmp_path / "run")
    assert open_run(tmp_path / "run").case == case
