"""Documentation: its commands and programs run, its cases are valid, its links lead somewhere.

An HTML comment before a block says how it is run here:

- ``<!-- test: time.end=1 -->`` gives the block's cases these values (``--set``), so that they end
  soon.  Times in the options of later commands are scaled to the shorter run.
- ``<!-- test: tables of check_dam3d -->`` checks tables in a shipped case, in place of its own, and
  ``tables of studies/fan`` in a shipped study.
- ``<!-- test: slurm -->`` is a program for a cluster, see ``test_docs_slurm.py``.

Of ``debrisflow sweep`` the values are those of the study's own keys.

The blocks of a page run one after the other in a folder of their own, which holds a copy of
``cases``.
"""

import json
import re
import runpy
import shlex
import shutil
import tomllib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
import pytest
import shapely
from click.testing import CliRunner

import debrisflow
from debrisflow.case import load_case
from debrisflow.case.overrides import apply_overrides
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.case.vectors import write_polygons
from debrisflow.cli import main
from debrisflow.study.loading import load_study
from debrisflow.study.sweep import Sweep

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((ROOT / "docs").rglob("*.md")),  # those in Japanese after those that they translate
    ROOT / "README.ja.md",
]
STUDIES = sorted((ROOT / "cases/studies").glob("*.toml"))
NOTEBOOKS = sorted((ROOT / "docs").rglob("*.ipynb"))
BLOCK = re.compile(r"(?:<!-- test: ([^\n]*?) -->\n)?^```(\w*)\n(.*?)^```$", re.M | re.S)
LINK = re.compile(r"\]\(([^)\s]+)\)")
INSTALL = "python3 -m venv .venv && .venv/bin/pip install "
OPEN = "python3 -m webbrowser "
TESTS = 'pytest -m "not validation" -n 2 --dist loadfile'
PROMPT = "source .venv/bin/activate"
TIMES = ("--times", "--window")
SLURM = "slurm"


class Block(NamedTuple):
    """A fenced block, its language and the comment before it."""

    note: str
    language: str
    text: str


@cache
def blocks(page: Path) -> list[Block]:
    return [Block(*found) for found in BLOCK.findall(page.read_text(encoding="utf-8"))]


def pages_with(*languages: str) -> list:
    """Return the pages with blocks that no page before them has."""
    found, seen = [], set()
    for page in PAGES:
        new = {block for block in blocks(page) if block.language in languages} - seen
        if new:
            found.append(page)
            seen |= new
    return [pytest.param(p, id=str(p.relative_to(ROOT))) for p in found]


class Reader:
    """Does what a page says, in the current folder."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.monkeypatch = monkeypatch
        self.names: dict = {}

    def follow(self, block: Block) -> None:
        if block.note == SLURM:
            return
        overrides = block.note.split()
        if block.language == "python":
            self.run_python(block.text, overrides)
        elif block.language == "bash":
            for line in block.text.splitlines():
                self.run_line(line, overrides)

    def run_line(self, line: str, overrides: list[str]) -> None:
        if line == PROMPT or line.endswith(f" {TESTS}"):
            return
        if line.startswith(OPEN):
            assert Path(line.removeprefix(OPEN)).is_file()
            return
        if line.startswith(INSTALL):  # the tests run in such an installation: look at the rest
            line = line.rpartition(" && .venv/bin/")[2].replace(" run ", " check ")
        program, *arguments = shlex.split(line)
        assert program == "debrisflow", f"no test knows how to run: {line}"
        if arguments[0] == "run":
            ends = [load_case(arguments[1], given).time.end for given in (overrides, ())]
            self.scale = ends[0] / ends[1]
            arguments += [part for value in overrides for part in ("--set", value)]
        if arguments[0] == "sweep" and arguments[1].endswith(".toml"):
            shorten_study(Path(arguments[1]), overrides)
        before = ["", *arguments]
        scaled = [self.scaled(a, b) for a, b in zip(before, arguments, strict=False)]
        done = CliRunner().invoke(main, scaled)
        assert done.exit_code == 0, f"{line}\n{done.output}"

    def scaled(self, before: str, argument: str) -> str:
        if before not in TIMES:
            return argument
        return ",".join(f"{self.scale * float(part):g}" for part in argument.split(","))

    def run_python(self, text: str, overrides: list[str]) -> None:
        def shortened(path, given=()):
            return load_case(path, [*given, *overrides])

        self.monkeypatch.setattr(debrisflow, "load_case", shortened, raising=False)
        exec(compile(text, "block", "exec"), self.names)


def shorten_study(path: Path, overrides: list[str]) -> None:
    import tomli_w

    given = tomllib.loads(path.read_text(encoding="utf-8"))
    apply_overrides(given, overrides)
    path.write_text(tomli_w.dumps(given), encoding="utf-8")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(ROOT / "cases", tmp_path / "cases")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("page", pages_with("bash", "python"))
def test_commands_and_programs_run(page, folder, monkeypatch):
    reader = Reader(monkeypatch)
    for block in blocks(page):
        reader.follow(block)


def cells_of(notebook: Path) -> list[dict]:
    return json.loads(notebook.read_text(encoding="utf-8"))["cells"]


@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(notebook, folder, capsys):
    matplotlib.use("agg")
    names: dict = {}
    for cell in cells_of(notebook):
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), cell["id"], "exec"), names)
    drawn = matplotlib.pyplot.get_fignums()
    matplotlib.pyplot.close("all")
    assert len(drawn) == 2
    assert names["summary"]["end_reason"] == "end of the simulated time"
    assert 0.59 < names["history"]["front_all"].max() < 0.61  # the wall is reached
    told = capsys.readouterr().out
    assert "did you mean 'end'?" in told
    assert re.search(r"greatest \d+ Pa at 0\.\d+ s", told)


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_hold_no_outputs_and_are_linked(notebook):
    for cell in cells_of(notebook):
        assert not cell.get("outputs")
        assert cell.get("execution_count") is None
    assert f"]({notebook.name})" in (notebook.parent / f"{notebook.stem}.md").read_text("utf-8")


@pytest.mark.parametrize("page", pages_with("toml"))
def test_cases_are_valid(page, folder):
    for block in blocks(page):
        if block.language != "toml":
            continue
        given = tomllib.loads(block.text)
        if "title" not in given:
            base = folder / "cases" / f"{block.note.removeprefix('tables of ')}.toml"
            given = tomllib.loads(base.read_text(encoding="utf-8")) | given
        if "design" in given:
            load_study(write_case(folder / "cases/studies/block.toml", given))
            continue
        if given["geometry"]["type"] == "terrain":
            write_map(folder)
        load_case(write_case(folder / "block.toml", given))


def write_map(folder: Path) -> None:
    """Write the files on a map that the pages name."""
    slope = np.tile(500.0 - 0.3 * 5.0 * np.arange(100.0), (60, 1))
    write_raster(folder / "dem.tif", Raster(MapGrid(0.0, 0.0, 5.0, 100, 60), slope))
    for name, x in (("scar", 50.0), ("fan", 300.0)):
        write_polygons(folder / f"{name}.gpkg", [shapely.box(x, 100.0, x + 50.0, 150.0)])


def write_case(path: Path, given: dict) -> Path:
    import tomli_w

    path.write_text(tomli_w.dumps(given), encoding="utf-8")
    return path


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_blocks_say_what_they_are(page):
    known = {"bash", "python", "toml", "text", "bibtex"}
    assert {block.language for block in blocks(page)} <= known
    assert page.read_text(encoding="utf-8").count("```") % 2 == 0


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    for address in LINK.findall(page.read_text(encoding="utf-8")):
        if address.startswith(("https://", "http://")):
            continue
        file, _, anchor = address.partition("#")
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), address
        if anchor:
            assert anchor in anchors(target), address


@cache
def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page, as GitHub and MkDocs make them."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", title).strip().lower().replace(" ", "-") for title in titles}


def test_readme_has_two_screens():
    assert len(README.read_text(encoding="utf-8").splitlines()) <= 150


def test_readme_has_the_line_that_installs_and_tests():
    lines = README.read_text(encoding="utf-8").splitlines()
    found = [line for line in lines if re.fullmatch(r"python3 -m venv .* pytest.*", line)]

    assert found == [f"{INSTALL}-e '.[test]' && .venv/bin/python -m {TESTS}"]
    assert "s/^\\(python3 -m venv .* pytest.*\\)$/\\1/p" in (ROOT / ".ci/run").read_text()


def test_every_case_has_a_page_and_the_site_lists_every_page():
    site = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = {str(p.relative_to(ROOT / "docs")) for p in (ROOT / "docs").rglob("*.md")}

    assert {f"cases/{path.stem}.md" for path in (ROOT / "cases").glob("*.toml")} <= pages
    assert {page for page in pages if f"{page}\n" not in site} == set()


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_a_shipped_study_is_valid_and_says_what_it_is(path):
    head = path.read_text(encoding="utf-8").split("title")[0]

    assert Sweep(load_study(path), path.parent / "runs").members
    assert head.startswith("#:schema ../study.schema.json\n")
    for word in ("Source", "Chosen", "Calibrated", "Takes"):
        assert f"# {word}:" in head


def test_generated_pages_are_up_to_date(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "scripts")  # as for a script that is started there
    pages = runpy.run_path(str(ROOT / "scripts/docs.py"))["pages"]()

    stale = [path.name for path, text in pages.items() if path.read_text("utf-8") != text]
    assert stale == [], "run: python scripts/docs.py"


def test_the_version_is_one():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]

    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"## [{version}]" in (ROOT / "CHANGELOG.md").read_text()
