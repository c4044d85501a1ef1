"""Published experiments: set up as printed, at two spacings, compared from the command line."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from click.testing import CliRunner

from debrisflow.case import load_case
from debrisflow.cli import main
from debrisflow.results.references import read_reference
from debrisflow.run.probes import columns_of

FOLDER = Path(__file__).parents[2] / "cases" / "experiments"
SPACINGS = {
    "koshizuka_oka": (0.008, 0.005),
    "martin_moyce": (0.003, 0.002),
    "spheric2": (0.05, 0.04),
    "wedge": (0.05, 0.03),
    "wet_bed": (0.005, 0.004),
    "zhou": (0.02, 0.0125),
}
MOST_LINES = 40
FRONTS = ("front_all", "outer_front_all")


def case_of(name: str) -> Path:
    """Return the case file of an experiment."""
    return FOLDER / f"{name}.toml"


def succeeds(*words: object) -> str:
    """Return the output of a command that ends well."""
    result = CliRunner().invoke(main, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.output


def test_every_experiment_has_its_spacings():
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(SPACINGS)
    assert {path.stem for path in FOLDER.glob("*.csv")} == set(SPACINGS)


@pytest.mark.parametrize("name", SPACINGS)
def test_an_experiment_is_short_and_says_what_it_is(name):
    lines = case_of(name).read_text().splitlines()
    assert len(lines) < MOST_LINES
    head = "\n".join(lines).split("title = ")[0]
    for word in ("Source:", "Calibrated:", "Expect:", "# Takes:", f"--reference {name}.csv"):
        assert word in head


@pytest.mark.parametrize(
    ("name", "spacing"), [(name, one) for name, both in SPACINGS.items() for one in both]
)
def test_the_spacing_alone_is_changed(name, spacing):
    said = succeeds("check", case_of(name), "--set", f"particles.spacing={spacing}")
    assert "warning" not in said
    assert load_case(case_of(name)).particles.spacing == SPACINGS[name][0]


@pytest.mark.parametrize("name", SPACINGS)
def test_the_reference_has_columns_of_the_case(name):
    case = load_case(case_of(name))
    probes = {f"{p.name}.{c.name}" for p in case.probe for c in columns_of(p, case.dimension)}
    given = read_reference(case_of(name).with_suffix(".csv"))
    assert given.abscissa == "time"
    assert set(given.curves) <= probes | set(FRONTS)


# Without a gate the front leads by 10 to 20 ms, in which it moves a tenth of its way: the limit of
# the validation rung, 10 %.  Moved in time it is read to within a spacing, 2 % of the range.  The
# front of Koshizuka & Oka is slower than that of Martin & Moyce by 8 %, which adds to both.
@pytest.mark.parametrize(
    ("name", "share", "shifted"), [("martin_moyce", 0.10, 0.03), ("koshizuka_oka", 0.15, 0.08)]
)
def test_a_front_is_compared_from_the_command_line(name, share, shifted, tmp_path):
    mine = tmp_path / "mine.toml"
    succeeds("init", mine, "--template", f"experiments/{name}")
    run = tmp_path / "run"
    succeeds("run", mine, "-o", run, "--threads", 1)
    said = succeeds("postprocess", run, "--reference", tmp_path / f"{name}.csv")
    assert f"distance to {name}, outer_front_all, run: rms" in said
    with (run / "postprocess" / "distances.csv").open() as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    front = next(row for row in rows if row["curve"] == "outer_front_all")
    assert len(rows) == len(read_reference(tmp_path / f"{name}.csv").curves)
    assert float(front["share"]) < share
    assert float(front["shifted_rms"]) < shifted * float(front["rms"]) / float(front["share"])
