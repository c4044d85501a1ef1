"""Plots of sensitivity: drawn for every design, and their bars end where they must."""

import numpy as np
import pytest
from matplotlib.image import imread

from debrisflow.study.designs import points_of
from debrisflow.study.plots.drawn import draw_sensitivity
from debrisflow.study.plots.effects import morris_figure, shares_figure
from debrisflow.study.plots.labels import label_of, parameter_label
from debrisflow.study.plots.scatter import scatter_figure
from debrisflow.study.plots.tornado import ends_of, explanation, tornado_figure
from debrisflow.study.sensitivity import Effect, sensitivity
from debrisflow.study.tables import Study

PARAMETERS = [
    {
        "name": "volume",
        "key": "fill.depth",
        "is_factor": True,
        "distribution": "lognormal",
        "median": 1.0,
        "deviation": 0.3,
    },
    {"name": "mu", "key": "material.mu", "distribution": "uniform", "low": 0.0, "high": 1.0},
    {"name": "dem", "key": "d", "distribution": "values", "values": ["in/a_$1.asc", "in/b_$2.asc"]},
    {"name": "spacing", "key": "particles.spacing", "distribution": "values", "values": [1.0, 0.5]},
]
DESIGNS = {
    "latin-hypercube": ({"members": 64}, {"tornado", "scatter", "shares"}),
    "sobol": ({"members": 64}, {"tornado", "scatter", "shares"}),
    "saltelli": ({"samples": 16}, {"tornado", "scatter", "shares"}),
    "morris": ({"paths": 6}, {"tornado", "scatter", "morris"}),
    "grid": ({}, {"tornado", "scatter"}),
    "one-at-a-time": ({}, {"tornado"}),
}


def study(kind, parameters=PARAMETERS, **options):
    design = {"type": kind} | DESIGNS[kind][0] | options
    return Study(title="costs $5^ of 50 %", case="c.toml", parameter=parameters, design=design)


def runout(points):
    """Return a quantity that grows with volume, falls with mu, and is 10 longer on another DEM."""
    return np.array(
        [
            100.0 * point["volume"] - 80.0 * point["mu"] + 10.0 * ("b_" in point["dem"])
            for point in points
        ]
    )


@pytest.mark.parametrize("kind", DESIGNS)
@pytest.mark.parametrize("values", ["all", "some", "constant"])
def test_every_design_is_drawn(tmp_path, kind, values):
    one = study(kind)
    points = points_of(one)
    found = np.ones(len(points)) if values == "constant" else runout(points)
    if values == "some":
        found[[0, 4]] = np.nan
    effects = sensitivity(one, points, found, "runout")
    files = draw_sensitivity(one, points, found, effects, "runout", "m2", tmp_path)

    wanted = DESIGNS[kind][1] - ({"shares"} if values == "constant" else set())
    assert {file.name for file in files} == {f"runout_{name}.png" for name in wanted}
    for file in files:
        image = imread(file)[..., :3]
        assert image.shape[1] >= 1000
        assert 0.002 < np.mean(image.min(axis=2) < 0.5) < 0.7


def test_nothing_is_drawn_of_nothing(tmp_path):
    one = study("sobol")
    values = np.full(64, np.nan)

    assert draw_sensitivity(one, points_of(one), values, [], "runout", "m", tmp_path) == []
    assert not list(tmp_path.iterdir())


def test_the_bars_of_one_at_a_time_end_at_its_members():
    one = study("one-at-a-time", shares=[0.1, 0.9])
    points = points_of(one)
    volume, mu, dem, spacing = ends_of(one, points, runout(points))
    base = 100.0 - 40.0 + 10.0  # at the medians, on the second of two DEMs
    low, high = np.exp([-0.3 * 1.28155, 0.3 * 1.28155])

    assert [end.value for end in volume[1:]] == pytest.approx(
        [base - 100.0 * (1.0 - low), base + 100.0 * (high - 1.0)], abs=1e-3
    )
    assert (mu.low.label, mu.high.label) == ("0.1", "0.9")
    assert [mu.low.value, mu.high.value] == pytest.approx([base + 32.0, base - 32.0])
    assert (dem.low, dem.high) == (("a_$1.asc", base - 10.0), ("b_$2.asc", base))
    assert (spacing.low, spacing.high) == (("0.5", base), ("1", base))  # numbers in their order


def test_the_bars_of_a_sample_end_at_the_means_of_fifths():
    values = [0.1 * k for k in range(10)]
    one = study("sobol", parameters=[PARAMETERS[1]])
    (mu,) = ends_of(one, [{"mu": value} for value in values], np.array(values) ** 2)

    assert mu.low.value == pytest.approx(np.mean(np.square(values[:2])))
    assert mu.high.value == pytest.approx(np.mean(np.square(values[8:])))
    assert mu.low.label == "0.05"


def test_a_tornado_has_the_longest_bars_on_top_and_names_what_is_missing():
    one = study("one-at-a-time")
    points = points_of(one)
    values = runout(points)
    values[3] = np.nan  # mu at its low end
    figure = tornado_figure(one, points, values, "runout", "m")
    (axes,) = figure.axes

    names = [label.get_text() for label in axes.get_yticklabels()]
    assert names == ["spacing, m", "dem", "mu", "volume, factor"]
    assert "0.05: no value" in [text.get_text() for text in axes.texts]
    assert axes.get_xlabel() == "runout, m"
    middle = axes.lines[0].get_xdata()[0]
    assert middle == values[0]
    ends = {round(bar.get_x() + bar.get_width(), 6) for bar in axes.patches}
    assert ends <= {round(value, 6) for value in values}


def test_the_caption_tells_what_the_line_is():
    one = study("one-at-a-time")

    assert "Line: all parameters at their medians; " in explanation(one, np.ones(7))
    assert "5 % and 95 % of all values are below" in explanation(one, np.ones(7))
    without = explanation(one, np.array([np.nan, 1.0, 1.0]))
    assert "Line: mean of all members, as there is no value with all" in without
    assert "the lowest or highest value of the parameter" in explanation(study("grid"), np.ones(9))


def test_bars_of_shares_are_sorted_and_have_their_confidence():
    effects = [
        Effect("q", name, measure, value, 0.1, "m", 9)
        for measure, values in (("S1", (0.1, 0.5)), ("ST", (0.6, 0.55)))
        for name, value in zip("xy", values, strict=True)
    ]
    (axes,) = shares_figure(effects).axes

    assert [label.get_text() for label in axes.get_yticklabels()] == ["y", "x"]  # by ST, upwards
    assert [bar.get_width() for bar in axes.patches] == [0.5, 0.1, 0.55, 0.6]
    assert len(axes.collections) == 2  # lines of confidence


def test_morris_shows_each_parameter_at_its_place():
    effects = [
        Effect("q", name, measure, value, 0.1, "m", 9)
        for measure, values in (("mu_star", (3.0, 1.0)), ("sigma", (0.5, 2.0)))
        for name, value in zip("xy", values, strict=True)
    ]
    (axes,) = morris_figure(effects, "m/s").axes

    assert {(text.get_text(), text.xy) for text in axes.texts} == {
        ("x", (3.0, 0.5)),
        ("y", (1.0, 2.0)),
    }
    assert axes.get_xlabel() == "mean size of the effect, mu*, m/s"
    assert axes.get_ylim()[1] > 2.0


def test_a_scatter_has_the_means_at_the_few_values_of_a_grid():
    one = study("grid", levels=4)
    points = points_of(one)
    figure = scatter_figure(one, points, runout(points), "runout", "m")
    of_mu = figure.axes[1].lines[1]

    assert of_mu.get_xdata() == pytest.approx([0.0, 1 / 3, 2 / 3, 1.0])
    assert np.diff(of_mu.get_ydata()) == pytest.approx([-80 / 3] * 3)
    assert [label.get_text() for label in figure.axes[2].get_xticklabels()] == [
        "a_$1.asc",
        "b_$2.asc",
    ]


def test_labels_have_the_unit_of_the_key():
    labels = [parameter_label(one) for one in study("grid").parameter]

    assert labels == ["volume, factor", "mu", "dem", "spacing, m"]
    assert label_of("manning", "s/m^(1/3)") == "manning, s/m^(1/3)"  # no exponent of 1/³
    assert label_of("discharge", "m3/s") == "discharge, m³/s"
