"""Observed extents in a calibration, by cells that can be counted by hand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.errors import CaseError
from debrisflow.study.calibration.extent_map import write_extent_maps
from debrisflow.study.calibration.observations import Evaluated, residuals_of
from debrisflow.study.calibration.predictive import scores, skill
from debrisflow.study.calibration.procedure import calibrate
from debrisflow.study.designs import points_of
from debrisflow.study.distributions import Values
from debrisflow.study.tables import Calibration, Study

GRID = MapGrid(0.0, 0.0, 10.0, 4, 2)
OBSERVED = [[1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 0.0]]
RUNS = {
    "short": [[1.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]],
    "long": [[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0]],
}


@pytest.fixture
def folders(tmp_path: Path) -> dict[str, Path]:
    """Return the folders of runs that reach some cells of a map of two rows."""
    write_raster(tmp_path / "change.asc", Raster(GRID, np.array(OBSERVED)))
    for name, depth in RUNS.items():
        layers = tmp_path / name / "layers"
        layers.mkdir(parents=True)
        write_raster(layers / "terrain.asc", Raster(GRID, np.ones(GRID.shape)))
        write_raster(layers / "peak_depth.asc", Raster(GRID, np.array(depth)))
    return {name: tmp_path / name for name in RUNS}


def study_of(folder: Path, held_out: dict[str, list[float]] | None = None) -> Study:
    """Return a study of the extent, with errors of 0.5 of what is missed and 0.25 of the rest."""
    law = {"distribution": "uniform", "low": 0.0, "high": 1.0}
    observation = {
        "type": "extent",
        "file": str(folder / "change.asc"),
        "error": 0.5,
        "false_error": 0.25,
    }
    return Study.model_validate(
        {
            "title": "an extent",
            "case": "none.toml",
            "parameter": [{"name": "mu", "key": "mu", **law}],
            "design": {"type": "latin-hypercube", "members": 8},
            "observation": [observation],
            "calibration": {"runs": 12, "held_out": held_out},
        }
    )


def test_residuals_are_missed_and_false_shares_over_their_errors(
    folders: dict[str, Path], tmp_path: Path
) -> None:
    runs = [Evaluated(folders["short"], {}), Evaluated(folders["long"], {}), Evaluated(None, {})]
    found = residuals_of(study_of(tmp_path), runs)
    # of 4 observed cells: 2 missed and 1 false; none and 2
    expected = [[0.5 / 0.5, 0.25 / 0.25], [0.0, 0.5 / 0.25], [np.nan, np.nan]]
    np.testing.assert_allclose(found, expected)


def test_held_out_part_is_not_fitted(folders: dict[str, Path], tmp_path: Path) -> None:
    study = study_of(tmp_path, {"x": [20.0, 40.0]})
    found = residuals_of(study, [Evaluated(folder, {}) for folder in folders.values()])
    # the two columns to the left: of 2 observed cells none is missed, 1 is false; none
    np.testing.assert_allclose(found, [[0.0, 0.5 / 0.25], [0.0, 0.0]])
    everything = study_of(tmp_path, {"x": [0.0, 40.0]})
    with pytest.raises(CaseError, match="make the part smaller"):
        residuals_of(everything, [Evaluated(folders["long"], {})])


def test_scores_are_those_counted_by_hand(folders: dict[str, Path], tmp_path: Path) -> None:
    study = study_of(tmp_path, {"x": [20.0, 40.0]})
    short, long = folders.values()
    groups = {"best fit": [long], "design": [short, long, long], "predictive": [long, long]}
    found = {(row.part, row.runs): row for row in scores(study, groups)}
    assert [row.part for row in found.values()] == ["used"] * 3 + ["held out"] * 3
    best, design = found["held out", "best fit"], found["held out", "design"]
    # to the right 2 cells are observed, both of them reached with 2 more; by the short run none
    assert (best.csi, best.missed, best.false, best.brier) == (0.5, 0.0, 1.0, 1.0)
    assert design.members == 3
    third = pytest.approx(1 / 3)
    assert (design.csi, design.missed, design.false) == (third, third, pytest.approx(2 / 3))
    # p = 2/3 in four cells, two of them observed; less what three runs make of it by chance
    squares = 2 * (1 / 3) ** 2 + 2 * (2 / 3) ** 2
    assert design.brier == pytest.approx((squares - 4 * (2 / 3) * (1 / 3) / 2) / 2)
    assert (design.covered, best.covered) == (1.0, 1.0)
    gain = skill(list(found.values()), "predictive", "design")
    assert gain["extent", "held out"] == pytest.approx(1.0 - 1.0 / (1 / 3))


def test_without_a_held_out_part_all_is_used(folders: dict[str, Path], tmp_path: Path) -> None:
    (row,) = scores(study_of(tmp_path), {"best fit": [folders["long"]]})
    assert (row.part, row.csi) == ("used", 4 / 6)


def test_map_is_drawn_for_each_observed_extent(folders: dict[str, Path], tmp_path: Path) -> None:
    study = study_of(tmp_path, {"x": [20.0, 40.0]})
    groups = {"best fit": [folders["long"]], "design": list(folders.values())}
    (picture,) = write_extent_maps(study, groups, tmp_path / "calibration")
    assert picture.name == "extent.png"
    with Image.open(picture) as drawn:
        assert len(np.unique(np.asarray(drawn.convert("RGB")).reshape(-1, 3), axis=0)) > 100


def test_score_of_a_few_runs_is_on_average_that_of_many(tmp_path: Path) -> None:
    """Cells that are reached with a probability of 0.3, by 4 runs: not 0.21 / 4 more than it is."""
    random = np.random.default_rng(0)
    grid = MapGrid(0.0, 0.0, 1.0, 200, 100)
    observed = (random.random(grid.shape) < 0.3).astype(float)
    write_raster(tmp_path / "change.asc", Raster(grid, observed))
    folders = []
    for number in range(4):
        layers = tmp_path / f"{number}" / "layers"
        layers.mkdir(parents=True)
        depth = (random.random(grid.shape) < 0.3).astype(float)
        write_raster(layers / "terrain.asc", Raster(grid, np.ones(grid.shape)))
        write_raster(layers / "peak_depth.asc", Raster(grid, depth))
        folders.append(tmp_path / f"{number}")
    (row,) = scores(study_of(tmp_path), {"design": folders})
    # of 20,000 cells: standard error 0.002 a cell, 0.007 over the observed share
    assert row.brier * observed.mean() == pytest.approx(0.3 * 0.7, abs=0.006)


def test_reach_is_fitted_to_an_extent_and_predicts_what_was_held_out(tmp_path: Path) -> None:
    grid = MapGrid(0.0, 0.0, 1.0, 100, 2)
    column = np.arange(100) + 0.5 + np.zeros((2, 1))
    observed = (column < 60.0).astype(float)
    observed[1, :50] = 0.0  # two arms, the lower one seen only in its last part
    write_raster(tmp_path / "change.asc", Raster(grid, observed))

    def evaluate(points: Sequence[Values]) -> list[Evaluated]:
        runs = []
        for point in points:
            folder = tmp_path / f"{point['mu']:.12f}"
            (folder / "layers").mkdir(parents=True, exist_ok=True)
            depth = (column < 100.0 * (1.0 - float(point["mu"]))).astype(float)
            for name, values in (("terrain", np.ones(grid.shape)), ("peak_depth", depth)):
                write_raster(folder / "layers" / f"{name}.asc", Raster(grid, values))
            runs.append(Evaluated(folder, {}))
        return runs

    study = study_of(tmp_path, {"y": [0.0, 1.0]})
    wanted = {"runs": 14, "predictive": 4, "held_out": {"y": (0.0, 1.0)}}
    study = study.model_copy(update={"calibration": Calibration.model_validate(wanted)})
    found = calibrate(study, points_of(study), evaluate, tmp_path / "calibration")
    low, _, high = found.marginals[0].posterior
    assert low < 0.4 < high
    assert found.marginals[0].verdict != "not identified"
    assert {"extents.csv", "extent.png"} < {file.name for file in found.files}
    assert any("Brier skill of the 4 fitted runs over the 8" in note for note in found.notes)
