"""Plots: every one is drawn, of full runs and of those in which there is little to show."""

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.image import imread

from debrisflow.cli import main
from debrisflow.particles.record import Kind
from debrisflow.results.plots.curves import (
    hydrograph_figure,
    normalized_figure,
    profile_figure,
)
from debrisflow.results.plots.maps import flow_figure
from debrisflow.results.postprocess import postprocess
from debrisflow.results.references import Reference
from debrisflow.run.folder import RunFolder
from tests.recording import (
    cells,
    channel3d_case,
    channel_case,
    placed,
    record,
    sliding,
    state_of,
    surveyed,
)

PLOTS = {
    "front",
    "profiles",
    "normalized_profiles",
    "hydrographs",
    "deposit",
    "maxima",
    "budget",
}
OF_WATER = PLOTS - {"deposit"} | {"flow"}
TIMES = [0.0, 0.1, 0.2]


def drawn(found, given=(), expected=PLOTS):
    """Return the plots of a survey, each checked to be whole and not blank."""
    files, _ = postprocess(found, given)
    plots = [file for file in files if file.suffix == ".png"]
    assert {file.stem for file in plots} == expected
    for file in plots:
        assert file.stat().st_size > 20_000, file
        image = imread(file)[..., :3]
        assert image.shape[1] >= 1000
        dark = np.mean(image.min(axis=2) < 0.5)
        assert 0.002 < dark < 0.7, file
    assert not list(found.run.folder.rglob("*.unfinished"))
    return plots


def layer(case, kind=Kind.MIXTURE, columns=100, rows=8):
    """Return a layer with a bed at rest under what shears."""
    across = [range(8)] if case.dimension == 3 else []
    position = cells(case, range(columns), *across, range(rows))
    height = position[:, case.dimension - 1]
    d0 = case.particles.spacing
    return placed(case, position, kind, np.where(height < 3 * d0, 0.0, 5.0 * height))


def test_a_flow_in_two_dimensions_is_drawn_with_its_references(tmp_path):
    case = channel_case(title="costs $5^$ or 50 % off_season")
    given = [
        Reference(
            "seen", "time", {"time": np.array(TIMES), "front_all": np.array([1.9, 2.0, 2.1])}
        ),
        Reference("lidar", "x", {"x": np.array([0.0, 2.0]), "deposit_height": np.full(2, 0.05)}),
        Reference("piv", "y", {"y": np.array([0.0, 0.1]), "velocity": np.array([0.0, 0.5])}),
        Reference("exact", "y_over_h", {"y_over_h": np.array([0.0, 1.0]), "u": np.array([0.0, 1])}),
    ]
    states = sliding(case, layer(case), TIMES)
    drawn(surveyed(tmp_path, case, states, (0.5, 1.0)), given)


def test_a_flow_in_three_dimensions_is_drawn(tmp_path):
    case = channel3d_case()
    drawn(surveyed(tmp_path, case, sliding(case, layer(case, columns=40), TIMES)))


def test_an_even_layer_is_a_map_of_one_color(tmp_path):
    case = channel3d_case()
    particles = placed(case, cells(case, range(80), range(8), range(5)))
    still = {"profiles", "deposit", "maxima", "budget"}
    drawn(surveyed(tmp_path, case, [state_of(case, particles)]), expected=still)


@pytest.mark.parametrize("build", [channel_case, channel3d_case])
def test_water_alone_has_no_plots_of_grains(tmp_path, build):
    case = build()
    states = sliding(case, layer(case, Kind.LIQUID, columns=40), TIMES)
    found = surveyed(tmp_path, case, states, (0.2, 0.5))
    figures = [
        profile_figure(found, ()),
        normalized_figure(found, (), ()),
        hydrograph_figure(found),
        flow_figure(found, ()),
    ]
    words = " ".join(
        text
        for figure in figures
        for axes in figure.axes
        for text in (axes.get_xlabel(), axes.get_ylabel(), *axes.get_legend_handles_labels()[1])
    )
    for word in ("concentration", "density", "granular", "grains", "dilatant", "sediment"):
        assert word not in words
    drawn(found, expected=OF_WATER)


def test_a_plot_in_which_there_is_no_longer_anything_is_removed(tmp_path):
    case = channel_case()
    states = sliding(case, layer(case), TIMES)
    found = surveyed(tmp_path, case, states)
    old = tmp_path / "postprocess/flow.png"
    old.parent.mkdir()
    old.touch()
    drawn(found)
    assert not old.exists()


@pytest.mark.parametrize("build", [channel_case, channel3d_case])
def test_a_run_with_nothing_in_it_is_drawn(tmp_path, build):
    case = build()
    found = surveyed(tmp_path, case, [state_of(case, placed(case, np.zeros((0, 3))))])
    drawn(found, expected={"budget"})


def test_a_run_whose_fills_settle_is_drawn(tmp_path):
    case = channel_case(shape={"periodic": True})
    states = sliding(case, layer(case), [-0.2, -0.1])
    found = surveyed(tmp_path, case, states, (0.5, 1.0))
    drawn(found, expected=PLOTS - {"hydrographs"})  # there are no volumes where x repeats


def test_the_command_writes_all_that_overwriting_a_run_removes(tmp_path):
    case = channel_case()
    folder = record(tmp_path / "run", case, sliding(case, layer(case), TIMES))
    options = ["--stations", "0.5,1", "--window", "0.1,0.2", "--times", "0.1"]
    result = CliRunner().invoke(main, ["postprocess", str(folder), *options])
    assert result.exit_code == 0, result.output
    files = list((folder / "postprocess").iterdir())
    assert len(files) == 10 + len(PLOTS)
    assert [file for file in files if f"wrote {file}\n" not in result.stdout] == []
    assert "front_farthest = " in result.stdout
    assert "distance to dilatant, u_over_us, x = 0.5 m: rms 0." in result.stdout
    RunFolder.create(folder, case, overwrite=True).close()
    assert not (folder / "postprocess").exists()
