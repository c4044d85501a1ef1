"""Does the page of notation tell the truth: equation, function, and the docstring that names it."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "theory" / "notation.md").read_text(encoding="utf-8")
EQUATIONS = re.findall(r"^\| \((\d+)\) \| .* \| `([\w.]+):(\w+)` \|$", PAGE, re.MULTILINE)
LAWS = re.findall(r"^\| ([^|(]+) \| `([\w.]+):(\w+)` \|$", PAGE, re.MULTILINE)
NUMBERS = list(range(1, 22))


def docstring(module: str, name: str) -> str:
    """Return the docstring of a function or class; of a law also that of its file."""
    home = import_module(module)
    item = getattr(home, name)
    return f"{home.__doc__} {getattr(item, 'py_func', item).__doc__}"


def test_every_equation_of_the_study_has_one_function():
    assert [int(number) for number, _, _ in EQUATIONS] == NUMBERS


@pytest.mark.parametrize(("number", "module", "name"), EQUATIONS)
def test_the_docstring_of_a_function_names_its_equation(number, module, name):
    text = docstring(module, name)
    assert re.search(rf"equations? (\(\d+\)(,| and| or)? ?)*\({number}\)", text), text


def test_one_search_finds_all_equations_in_the_sources():
    sources = (ROOT / "debrisflow").rglob("*.py")
    found = {
        int(number)
        for source in sources
        for number in re.findall(r"equation \((\d+)\)", source.read_text(encoding="utf-8"))
    }
    assert found == set(NUMBERS)


@pytest.mark.parametrize(("law", "module", "name"), LAWS)
def test_the_docstring_of_a_law_names_it(law, module, name):
    text = docstring(module, name)
    assert all(word in text for word in re.findall(r"[A-Z]\w+", law)), text


def test_every_strength_law_is_on_the_page():
    files = (ROOT / "debrisflow" / "physics" / "rheology").glob("*.py")
    laws = {file.stem for file in files} - {"__init__", "none"}
    assert laws == {module.split(".")[-1] for _, module, _ in LAWS if ".rheology." in module}
