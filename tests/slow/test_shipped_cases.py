"""Does every shipped case run: ten steps, every writer, no warning, no NaN."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import pyvista

from debrisflow.case import case_schema, load_case
from debrisflow.results import open_run
from debrisflow.results.postprocess import postprocess
from debrisflow.results.survey import survey_of
from debrisflow.run.names import CASE, DEPOSIT, HISTORY, MAXIMA, SUMMARY
from debrisflow.run.simulation import simulate

CASES = Path(__file__).parents[2] / "cases"
NAMES = sorted(path.stem for path in CASES.glob("*.toml"))
ARRAYS = {
    "velocity",
    "pressure",
    "kind",
    "density",
    "number_density",
    "concentration",
    "granular_temperature",
    "sediment_fraction",
    "on_free_surface",
    "id",
}


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_case_runs_and_writes_everything(name, tmp_path):
    step = load_case(CASES / f"{name}.toml").time.largest_step
    short = (f"time.end={10 * step}", f"output.interval={5 * step}", "time.settling=0.0")
    case = load_case(CASES / f"{name}.toml", short)
    folder = tmp_path / name
    summary = simulate(case, folder, threads=1)
    assert summary["steps"] >= 10
    assert summary["time"] == case.time.end
    assert sum(summary["through_wall"].values()) == 0
    reader = pyvista.PVDReader(folder / "particles.pvd")
    assert reader.time_values[-1] == case.time.end
    frame = reader.read()[0]
    assert set(frame.point_data) - {"pore_pressure"} == ARRAYS
    assert all(np.isfinite(frame[array]).all() for array in ARRAYS)
    assert load_case(folder / CASE) == case
    assert json.loads((folder / SUMMARY).read_text())["end_reason"] == "end of the simulated time"
    last = "layers/extent.geojson" if case.is_terrain else MAXIMA
    for table in (DEPOSIT, HISTORY, last):
        assert (folder / table).stat().st_size > 0
    files, _ = postprocess(survey_of(open_run(folder)))
    assert all(path.stat().st_size > 0 for path in files)


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_case_says_what_it_is(name):
    head = (CASES / f"{name}.toml").read_text().split("title")[0]
    assert head.startswith("#:schema ./case.schema.json\n")
    for word in ("Source", "Calibrated", "Expect", "Takes"):
        assert f"# {word}:" in head


def test_the_schema_beside_the_cases_is_that_of_the_tables():
    assert (CASES / "case.schema.json").read_text() == case_schema()
