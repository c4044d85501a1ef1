"""Every wrong case file gives exactly its message; each stands for one rule, told by its title."""

import tomllib
from collections.abc import Callable, Iterator
from copy import deepcopy
from functools import wraps
from pathlib import Path

import pytest

from debrisflow.case import build_case, checks, load_case
from debrisflow.case.problems import Problem
from debrisflow.errors import CaseError

FOLDER = Path(__file__).parent / "bad_cases"


@pytest.fixture(autouse=True)
def _memory_of_8_gigabytes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "available_memory", lambda: 8e9)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_message(path: Path) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(path)

    message = str(caught.value).replace(str(path), path.name)
    assert message + "\n" == path.with_suffix(".txt").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_a_case_built_in_python_gets_the_same_words(path: Path) -> None:
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    before = deepcopy(tables)

    with pytest.raises(CaseError) as caught:
        build_case(tables, folder=FOLDER)

    message = str(caught.value).replace("the case: ", f"{path.name}: ", 1)
    assert message + "\n" == path.with_suffix(".txt").read_text(encoding="utf-8")
    assert tables == before


def test_every_check_has_a_wrong_case(monkeypatch: pytest.MonkeyPatch) -> None:
    told: set[str] = set()

    def recorded(check: Callable[..., Iterator[Problem]]) -> Callable[..., Iterator[Problem]]:
        @wraps(check)
        def run(**tables: object) -> Iterator[Problem]:
            for problem in check(**tables):
                told.add(check.__name__)
                yield problem

        return run

    names: set[str] = set()
    for kind in ("AS_ASKED", "CHECKS"):
        own = getattr(checks, kind)
        names |= {check.__name__ for check in own}
        monkeypatch.setattr(checks, kind, tuple(map(recorded, own)))
    for path in FOLDER.glob("*.toml"):
        with pytest.raises(CaseError):
            load_case(path)

    assert told == names
