"""Sensitivity: indices of functions that are known in closed form, and values that are missing."""

import csv

import numpy as np
import pytest

from debrisflow.study.designs import points_of
from debrisflow.study.sensitivity import sensitivity, sensitivity_table, write_sensitivity
from debrisflow.study.tables import Study

A, B = 7.0, 0.1  # of the Ishigami function
SALTELLI = {"type": "saltelli", "samples": 1024}
LATIN = {"type": "latin-hypercube", "members": 1024}
SOBOL = {"type": "sobol", "members": 1024}
MORRIS = {"type": "morris", "paths": 8}
ONE = {"type": "one-at-a-time", "shares": [0.1, 0.9]}
WIDTHS = (1.0, 2.0, 4.0)  # of the ranges of x, y and z
SLOPES = (3.0, -2.0, 0.5)


def study(design, ranges, **tables):
    parameters = [
        {"name": name, "key": f"k.{name}", "distribution": "uniform", "low": low, "high": high}
        for name, (low, high) in zip("xyz", ranges, strict=True)
    ]
    return Study(title="t", case="case.toml", parameter=parameters, design=design, **tables)


def ishigami_study(design):
    return study(design, [(-np.pi, np.pi)] * 3)


def linear_study(design):
    return study(design, [(0.0, width) for width in WIDTHS])


def columns(points):
    return (np.array([point[name] for point in points]) for name in "xyz")


def ishigami(points):
    x, y, z = columns(points)
    return np.sin(x) + A * np.sin(y) ** 2 + B * z**4 * np.sin(x)


def linear(points):
    return 1.0 + sum(k * values for k, values in zip(SLOPES, columns(points), strict=True))


def shares_in_closed_form():
    """Return S1 and ST of the Ishigami function: means of powers of its terms, integrated."""
    of_x = 0.5 * (1.0 + B * np.pi**4 / 5.0) ** 2  # the mean of z^4 is pi^4 / 5
    of_y = A**2 / 8.0
    of_xz = 0.5 * B**2 * np.pi**8 * (1.0 / 9.0 - 1.0 / 25.0)  # half the variance of B z^4
    alone = np.array([of_x, of_y, 0.0])
    total = alone + np.array([of_xz, 0.0, of_xz])
    variance = of_x + of_y + of_xz
    return {"S1": alone / variance, "ST": total / variance}


def values_of(effects, measure):
    return [effect.value for effect in effects if effect.measure == measure]


def test_the_closed_form_is_that_of_the_literature():
    exact = shares_in_closed_form()

    assert exact["S1"] == pytest.approx([0.3139, 0.4424, 0.0], abs=1e-4)
    assert exact["ST"] == pytest.approx([0.5576, 0.4424, 0.2437], abs=1e-4)


@pytest.mark.parametrize("seed", range(4))
def test_indices_of_the_ishigami_function_by_saltelli(seed):
    one = ishigami_study(SALTELLI | {"seed": seed})
    points = points_of(one)
    effects = sensitivity(one, points, ishigami(points), "f")

    assert {effect.members for effect in effects} == {len(points)} == {1024 * 5}
    for measure, exact in shares_in_closed_form().items():
        assert values_of(effects, measure) == pytest.approx(exact, abs=0.05)
    assert all(0.0 < effect.confidence < 0.15 for effect in effects)
    assert sensitivity(one, points, ishigami(points), "f") == effects  # bootstrap included


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("design", [LATIN, SOBOL], ids=lambda design: design["type"])
def test_first_indices_of_the_ishigami_function_from_given_data(design, seed):
    one = ishigami_study(design | {"seed": seed})
    points = points_of(one)
    effects = sensitivity(one, points, ishigami(points), "f")

    assert values_of(effects, "S1") == pytest.approx(shares_in_closed_form()["S1"], abs=0.05)
    assert {effect.method for effect in effects} == {"RBD-FAST, 4 harmonics"}
    assert sensitivity(one, points, ishigami(points), "f") == effects


def test_first_indices_of_a_linear_function_with_words():
    """A word that adds 0, 1 or 2 has the variance of these three, 2 / 3.

    The first four harmonics of a stair of three equal steps hold 9 / pi^2 of its variance.
    """
    word = {"name": "law", "key": "k", "distribution": "values", "values": ["b", "c", "a"]}
    found = []
    for seed in range(8):
        one = linear_study(LATIN | {"seed": seed})
        one = Study.model_validate(one.model_dump() | {"parameter": [*one.parameter, word]})
        points = points_of(one)
        added = np.array([["b", "c", "a"].index(point["law"]) for point in points])
        found.append(values_of(sensitivity(one, points, linear(points) + added, "f"), "S1"))
    variances = np.array([*(np.multiply(WIDTHS, SLOPES) ** 2 / 12.0), 2.0 / 3.0])
    exact = variances / variances.sum() * [1.0, 1.0, 1.0, 9.0 / np.pi**2]

    assert np.mean(found, axis=0) == pytest.approx(exact, abs=0.02)


def test_morris_finds_the_slopes_of_a_linear_function():
    one = linear_study(MORRIS)
    points = points_of(one)
    effects = sensitivity(one, points, linear(points), "f")

    assert values_of(effects, "mu_star") == pytest.approx(np.abs(np.multiply(WIDTHS, SLOPES)))
    assert values_of(effects, "sigma") == pytest.approx([0.0] * 3, abs=1e-12)
    assert [effect.parameter for effect in effects] == [*"xyzxyz"]


def test_one_at_a_time_gives_the_ranges_of_a_linear_function():
    one = linear_study(ONE)
    points = points_of(one)
    effects = sensitivity(one, points, linear(points), "f")

    assert values_of(effects, "range") == pytest.approx(0.8 * np.abs(np.multiply(WIDTHS, SLOPES)))
    assert {effect.members for effect in effects} == {3}


@pytest.mark.parametrize(
    ("design", "size"), [(SALTELLI | {"samples": 64}, 5), (MORRIS, 4)], ids=["saltelli", "morris"]
)
def test_a_block_with_a_missing_value_counts_as_if_it_were_not_there(design, size):
    one = ishigami_study(design)
    points = points_of(one)
    values = ishigami(points)
    values[[1, size * 3, size * 3 + 2]] = np.nan, np.nan, np.inf
    kept = np.delete(np.arange(len(points)), [*range(size), *range(size * 3, size * 4)])
    found = sensitivity(one, points, values, "f")

    assert {effect.members for effect in found} == {len(points) - 2 * size}
    without = sensitivity(one, [points[k] for k in kept], values[kept], "f")
    assert repr(found) == repr(without)  # nan, where there is no confidence, is not equal to itself
    assert np.isfinite([effect.value for effect in found]).all()


def test_members_without_a_value_are_left_out_of_given_data():
    one = ishigami_study(LATIN)
    points = points_of(one)
    values = ishigami(points)
    values[::5] = np.nan
    effects = sensitivity(one, points, values, "f")

    assert {effect.members for effect in effects} == {1024 - 205}
    assert values_of(effects, "S1") == pytest.approx(shares_in_closed_form()["S1"], abs=0.06)


def test_a_range_with_a_missing_end_is_not_given():
    one = linear_study(ONE)
    points = points_of(one)
    values = linear(points)
    values[2] = np.nan  # x at its high end
    effects = sensitivity(one, points, values, "f")

    assert np.isnan(values_of(effects, "range")).tolist() == [True, False, False]
    assert [effect.members for effect in effects] == [2, 3, 3]


@pytest.mark.parametrize("design", [SALTELLI, LATIN, SOBOL, MORRIS, ONE], ids=lambda d: d["type"])
@pytest.mark.parametrize("fill", [np.nan, 2.5])
def test_what_is_constant_or_missing_has_no_shares_and_raises_no_warning(design, fill):
    one = ishigami_study(design)
    points = points_of(one)
    effects = sensitivity(one, points, np.full(len(points), fill), "f")

    changes = np.array([e.value for e in effects if e.measure in ("range", "mu_star", "sigma")])
    shares = np.array([e.value for e in effects if e.measure in ("S1", "ST")])
    assert len(changes) + len(shares) == len(effects) > 0
    assert np.isnan(shares).all()  # of no variance
    assert np.isnan(changes).all() if np.isnan(fill) else (changes == 0.0).all()


@pytest.mark.parametrize(
    "design", [SALTELLI | {"samples": 2}, LATIN | {"members": 8}, MORRIS | {"paths": 2}]
)
def test_few_members_give_numbers_or_none_but_no_warning(design):
    one = ishigami_study(design)
    points = points_of(one)
    values = ishigami(points)
    first = {"saltelli": 5, "latin-hypercube": 1, "morris": 4}[design["type"]]
    for there in (values, np.where(np.arange(len(values)) < first, np.nan, values)):
        effects = sensitivity(one, points, there, "f")
        assert {effect.parameter for effect in effects} == {*"xyz"}
    assert np.isnan([effect.value for effect in effects]).all()


def test_a_grid_has_no_indices():
    one = ishigami_study({"type": "grid", "levels": 3})
    points = points_of(one)

    assert sensitivity(one, points, ishigami(points), "f") == []


def test_the_table_is_written_with_its_explanations(tmp_path):
    one = linear_study(MORRIS)
    points = points_of(one)
    effects = sensitivity_table(
        one, points, {"f": linear(points), "g": np.full(len(points), np.nan)}
    )
    write_sensitivity(tmp_path / "sensitivity.csv", effects)

    lines = (tmp_path / "sensitivity.csv").read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [row["quantity"] for row in rows] == ["f"] * 6 + ["g"] * 6
    assert [float(row["value"]) for row in rows[:3]] == pytest.approx([3.0, 4.0, 2.0])
    assert {row["members"] for row in rows} == {"32", "0"}
    assert any("mu_star" in line for line in lines if line.startswith("#"))
