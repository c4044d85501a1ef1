"""Calibration by models whose answers are known in closed form."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import qmc

from debrisflow.errors import CaseError
from debrisflow.study.calibration.emulator import Emulator
from debrisflow.study.calibration.identifiability import Coupled, coupled, marginals, sentences
from debrisflow.study.calibration.improvement import proposed
from debrisflow.study.calibration.observations import Evaluated, misfits, residuals_of
from debrisflow.study.calibration.parameter_space import ParameterSpace, scores_of, shares_of
from debrisflow.study.calibration.posterior import Posterior, sampled
from debrisflow.study.calibration.predictive import drawn
from debrisflow.study.calibration.procedure import calibrate
from debrisflow.study.calibration.result import CalibrationResult
from debrisflow.study.designs import points_of
from debrisflow.study.distributions import Values
from debrisflow.study.loading import load_study
from debrisflow.study.member import Cases
from debrisflow.study.tables import Study

Floats = NDArray[np.float64]
STUDIES = Path(__file__).parents[2] / "cases" / "studies"
NORMAL: dict[str, Any] = {"distribution": "normal", "mean": 0.0, "deviation": 1.0}


def study_of(observed: dict[str, tuple[float, float]], runs: int = 12, **tables: Any) -> Study:
    """Return a study of two normal parameters with figures observed, values and errors."""
    parameters = [{"name": name, "key": name, **NORMAL} for name in ("first", "second")]
    return Study.model_validate(
        {
            "title": "a model in closed form",
            "case": "none.toml",
            "parameter": parameters,
            "design": {"type": "latin-hypercube", "members": 8},
            "quantity": [{"answer": name} for name in observed],
            "observation": [
                {"type": "figure", "quantity": name, "value": value, "error": error}
                for name, (value, error) in observed.items()
            ],
            "calibration": {"runs": runs},
        }
        | tables
    )


def model(
    **quantities: Callable[[Any, Any], float],
) -> Callable[[Sequence[Values]], list[Evaluated]]:
    """Return what evaluates quantities as functions of both parameters."""

    def evaluate(points: Sequence[Values]) -> list[Evaluated]:
        return [
            Evaluated(
                Path("run"),
                {name: f(at["first"], at["second"]) for name, f in quantities.items()},
            )
            for at in points
        ]

    return evaluate


def design_of(study: Study, count: int = 8, seed: int = 0) -> list[Values]:
    return ParameterSpace.of(study).points(qmc.LatinHypercube(2, rng=seed).random(count))


def smooth(shares: Floats) -> Floats:
    """Return two residuals at shares."""
    x, y = shares.T
    return np.column_stack([10.0 * np.sin(3.0 * x) + 4.0 * y, 8.0 * (x - 0.4) * (y + 0.5)])


def test_emulator_interpolates_and_its_errors_are_those_it_states() -> None:
    shares = qmc.LatinHypercube(2, rng=3).random(30)
    emulator = Emulator(shares, smooth(shares), seed=0)
    np.testing.assert_allclose(emulator.at(shares).mean, smooth(shares), atol=0.02)
    elsewhere = np.random.default_rng(1).random((400, 2))
    expected, found = smooth(elsewhere), emulator.at(elsewhere)
    assert np.sqrt(np.mean((found.mean - expected) ** 2)) < 0.02 * expected.std()
    within = np.abs(found.mean - expected) < 1.645 * np.sqrt(found.variance + found.noise)
    assert within.mean() > 0.85
    assert emulator.left_out().explained.min() > 0.99


def test_left_out_runs_are_as_by_an_emulator_without_them() -> None:
    shares = qmc.LatinHypercube(2, rng=3).random(12)
    noisy = smooth(shares) + np.random.default_rng(0).normal(0.0, 0.5, (12, 2))
    emulator = Emulator(shares, noisy, seed=0)
    found = emulator.left_out()
    process = emulator._processes[0]
    covariance = process.kernel_(shares)
    standard = (noisy[:, 0] - noisy[:, 0].mean()) / noisy[:, 0].std()
    for k in range(12):
        others = np.arange(12) != k
        weights = np.linalg.solve(covariance[np.ix_(others, others)], covariance[others, k])
        mean = noisy[:, 0].mean() + noisy[:, 0].std() * weights @ standard[others]
        variance = covariance[k, k] - weights @ covariance[others, k]
        assert found.predicted[k, 0] == pytest.approx(mean, rel=1e-6)
        assert found.deviation[k, 0] == pytest.approx(noisy[:, 0].std() * variance**0.5, rel=1e-5)


def test_errors_of_left_out_runs_of_a_rough_model_are_about_as_stated() -> None:
    shares = qmc.LatinHypercube(2, rng=3).random(40)
    noisy = smooth(shares) + np.random.default_rng(0).normal(0.0, 1.0, (40, 2))
    found = Emulator(shares, noisy, seed=0).left_out()
    spread = np.sqrt((found.standardized**2).mean(axis=0))
    assert np.all((spread > 0.7) & (spread < 1.4))  # of 40: sampling error 0.11
    assert np.all((found.rms > 0.7) & (found.rms < 1.6))  # the noise is 1


def test_residual_that_depends_on_nothing_is_emulated_without_a_warning() -> None:
    shares = qmc.LatinHypercube(2, rng=3).random(10)
    emulator = Emulator(shares, np.column_stack([np.full(10, 3.0), shares[:, 0]]), seed=0)
    assert emulator.at(np.array([[0.5, 0.5]])).mean[0, 0] == pytest.approx(3.0)
    assert np.isfinite(emulator.left_out().explained).all()


FLAT = study_of(
    {},
    parameter=[
        {"name": name, "key": name, "distribution": "uniform", "low": 0.0, "high": 1.0}
        for name in ("first", "second")
    ],
)
SQUARE = ParameterSpace.of(FLAT)
NONE = np.empty((0, 2))


def least_by_improvement(seed: int, count: int) -> float:
    """Return the least misfit of Rosenbrock's valley after some runs, 8 of them a design."""
    shares = qmc.LatinHypercube(2, rng=seed).random(8)
    residuals = valley(shares)
    while len(shares) < count:
        emulator = Emulator(SQUARE.coordinates(shares), residuals, 0)
        point = proposed(emulator, SQUARE, shares, NONE, 1, seed).shares
        shares = np.vstack([shares, point])
        residuals = np.vstack([residuals, valley(point)])
    return float(misfits(residuals).min())


def valley(shares: Floats) -> Floats:
    """Return the residuals whose squares are Rosenbrock's function over [-2, 2] by [-1, 3]."""
    x, y = 4.0 * shares[:, 0] - 2.0, 4.0 * shares[:, 1] - 1.0
    return np.column_stack([10.0 * (y - x**2), 1.0 - x])


def test_improvement_finds_a_minimum_in_25_runs() -> None:
    found = least_by_improvement(0, 25)
    designs = [misfits(valley(qmc.LatinHypercube(2, rng=k).random(25))).min() for k in range(100)]
    assert found < 0.01
    assert found < np.quantile(designs, 0.01)


def test_points_computed_at_once_keep_apart_from_each_other_and_from_failures() -> None:
    shares = qmc.LatinHypercube(2, rng=0).random(8)
    emulator = Emulator(SQUARE.coordinates(shares), valley(shares), 0)
    first = proposed(emulator, SQUARE, shares, NONE, 3, 0).shares
    assert len(first) == 3
    gaps = np.abs(first[:, None] - first[None, :]).max(axis=2)[np.triu_indices(3, 1)]
    assert gaps.min() >= 0.01
    beside = proposed(emulator, SQUARE, shares, first[:1], 1, 0).shares
    assert np.abs(beside - first[0]).max() >= 0.1


def linear_posterior(correlation: float) -> tuple[Posterior, Floats, Floats]:
    """Return a sample of a linear Gaussian posterior, its mean and covariance in closed form."""
    pair = [{"parameters": ["first", "second"], "coefficient": correlation}]
    study = study_of({"sum": (1.0, 0.5), "first_only": (0.4, 0.8)}, correlation=pair)
    space = ParameterSpace.of(study)
    matrix, observed = np.array([[1.0, 1.0], [1.0, 0.0]]), np.array([1.0, 0.4])
    error = np.array([0.5, 0.8])
    precision = np.linalg.inv(space.correlation) + matrix.T @ np.diag(error**-2.0) @ matrix
    covariance = np.linalg.inv(precision)
    mean = covariance @ matrix.T @ (observed / error**2)
    shares = qmc.LatinHypercube(2, rng=0).random(40)
    residuals = (scores_of(shares) @ matrix.T - observed) / error
    return sampled(Emulator(space.coordinates(shares), residuals, 0), space, 0), mean, covariance


@pytest.mark.parametrize("correlation", [0.0, 0.6])
def test_posterior_of_a_linear_model_is_the_closed_form(correlation: float) -> None:
    posterior, mean, covariance = linear_posterior(correlation)
    assert posterior.doubts == []
    assert posterior.effective > 1000.0
    deviation = np.sqrt(np.diag(covariance))
    # three standard errors of the sample, and 2 % of the deviation for the emulator
    error = 3.0 / posterior.effective**0.5 + 0.02
    assert np.all(np.abs(posterior.scores.mean(axis=0) - mean) < error * deviation)
    scale = np.outer(deviation, deviation)
    assert np.all(np.abs(np.cov(posterior.scores.T) - covariance) < 2.0 * error * scale)


@pytest.mark.usefixtures("undrawn")
def test_posterior_of_a_curved_model_is_that_by_quadrature() -> None:
    """As of a flow whose friction and decaying pore pressure an arrival and a run-out tell."""

    def arrival(friction: Any, share: Any) -> Any:
        return 12.0 + 330.0 * (friction * (1.0 - 0.8 * share)) ** 2

    def runout(friction: Any, share: Any) -> Any:
        return 350.0 * np.exp(-4.0 * friction) * (1.0 + 0.3 * share)

    bounds = {"first": (0.1, 0.3), "second": (0.0, 0.8)}
    parameters = [
        {"name": name, "key": name, "distribution": "uniform", "low": low, "high": high}
        for name, (low, high) in bounds.items()
    ]
    observed = {"arrival": (17.5, 0.5), "runout": (178.0, 8.0)}
    study = study_of(observed, runs=30, parameter=parameters)
    found = fitted(study, model(arrival=arrival, runout=runout), 14)
    x, y = np.meshgrid(*(np.linspace(*ends, 301) for ends in bounds.values()), indexing="ij")
    values = {"arrival": arrival(x, y), "runout": runout(x, y)}
    squares = [((values[name] - one) / error) ** 2 for name, (one, error) in observed.items()]
    density = np.exp(-0.5 * sum(squares))
    for axis, (one, ends) in enumerate(zip(found.marginals, bounds.values(), strict=True)):
        below = np.cumsum(density.sum(axis=1 - axis)) / density.sum()
        exact = np.interp([0.05, 0.5, 0.95], below, np.linspace(*ends, 301))
        np.testing.assert_allclose(one.posterior, exact, atol=0.05 * (exact[2] - exact[0]))


def test_chains_that_are_too_short_or_stuck_are_said_so() -> None:
    short = Posterior(np.zeros((4, 1)), 100.0, 1000, 10.0, 0.02)
    assert len(short.doubts) == 2
    assert "too short" in short.doubts[0]
    assert "2%" in short.doubts[1]
    assert len(Posterior(np.zeros((4, 1)), np.nan, 1000, np.nan, 0.3).doubts) == 1


@pytest.mark.usefixtures("undrawn")
def test_ridge_is_known_by_its_combination_only() -> None:
    study = study_of({"sum": (0.5, 0.05)})
    found = fitted(study, model(sum=lambda first, second: first + second))
    (pair,) = found.coupled
    assert pair.correlation < -0.95
    np.testing.assert_allclose(pair.known, [0.5**0.5, 0.5**0.5], atol=0.02)
    np.testing.assert_allclose(pair.unknown, [0.5**0.5, -(0.5**0.5)], atol=0.02)
    assert pair.trade[0] == pytest.approx(-pair.trade[1], rel=0.05)
    # each by itself has half of the variance of its prior left: a ratio of 0.71
    assert [one.verdict for one in found.marginals] == ["weakly identified"] * 2
    assert any("only a combination is known" in note for note in found.notes)


@pytest.mark.usefixtures("undrawn")
def test_product_of_positive_parameters_is_a_ridge_too() -> None:
    law = {"distribution": "lognormal", "median": 2.0, "deviation": 0.5}
    parameters = [{"name": name, "key": name, **law} for name in ("first", "second")]
    study = study_of({"product": (4.0, 0.1)}, runs=16, parameter=parameters)
    found = fitted(study, model(product=lambda first, second: first * second), 12)
    np.testing.assert_allclose(found.coupled[0].unknown, [0.5**0.5, -(0.5**0.5)], atol=0.05)


@pytest.mark.usefixtures("undrawn")
def test_parameter_that_matters_is_identified_and_one_that_does_not_is_not() -> None:
    study = study_of({"first_only": (0.5, 0.1)})
    found = fitted(study, model(first_only=lambda first, second: first))
    assert [one.verdict for one in found.marginals] == ["identified", "not identified"]
    assert found.coupled == []
    assert found.marginals[0].posterior[1] == pytest.approx(0.5, abs=0.05)
    narrow = [one._replace(posterior=(0.0, 0.01, 0.02)) for one in found.marginals]
    pair = Coupled(("first", "second"), 0.9, (0.6, -0.8), (0.8, 0.6), (0.2, 0.1))
    assert "The errors of first and second go together" in sentences(narrow, [pair])[2]
    assert "only a combination" in sentences(found.marginals, [pair])[2]
    assert "next to nothing" in sentences(found.marginals, [])[1]


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave plots out, which take longer than a fit."""
    monkeypatch.setattr("debrisflow.study.calibration.plots.write_plots", lambda *_: [])


def fitted(
    study: Study,
    evaluate: Callable[[Sequence[Values]], list[Evaluated]],
    count: int = 8,
    target: Path | None = None,
) -> CalibrationResult:
    with tempfile.TemporaryDirectory() as folder:
        return calibrate(study, design_of(study, count), evaluate, target or Path(folder))


def test_seeds_reproduce_and_files_are_written(tmp_path: Path) -> None:
    observed = {"product": (0.3, 0.1), "first_only": (0.4, 0.2)}
    study = study_of(observed, calibration={"runs": 12, "predictive": 3, "seed": 5})
    evaluate = model(product=lambda x, y: x * y, first_only=lambda x, y: x)
    one, other = (fitted(study, evaluate, target=tmp_path / name) for name in ("a", "b"))
    assert np.all(one.at_posterior < 0.5)
    assert [run.values for run in one.runs] == [run.values for run in other.runs]
    np.testing.assert_array_equal(one.posterior.scores, other.posterior.scores)
    assert [run.kind for run in one.runs].count("predictive") == 3
    names = {"runs.csv", "posterior.csv", "summary.csv", "emulator.csv"}
    assert {file.name for file in one.files if file.suffix == ".csv"} == names
    for file in one.files:
        if file.suffix == ".csv":
            assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()
    assert all(file.stat().st_size > 0 for file in one.files)


@pytest.mark.usefixtures("undrawn")
def test_search_ends_early_when_nothing_is_to_be_gained() -> None:
    study = study_of({"first_only": (0.5, 0.1)}, runs=40)
    found = fitted(study, model(first_only=lambda first, second: first))
    assert len(found.runs) < 25
    assert any(note.startswith("No more than") for note in found.notes)


@pytest.mark.usefixtures("undrawn")
def test_runs_are_chosen_as_many_at_once_as_the_study_says(tmp_path: Path) -> None:
    observed = {"product": (0.3, 0.1), "first_only": (0.4, 0.2)}
    study = study_of(observed, calibration={"runs": 13, "at_once": 3})
    works = model(product=lambda x, y: x * y, first_only=lambda x, y: x)
    counts: list[int] = []

    def evaluate(points: Sequence[Values]) -> list[Evaluated]:
        counts.append(len(points))
        return works(points)

    found = calibrate(study, design_of(study), evaluate, tmp_path)
    assert counts[0] == 8
    assert max(counts[1:]) == 3
    assert sum(counts) == len(found.runs) <= 13


@pytest.mark.usefixtures("undrawn")
def test_failed_runs_are_left_out_and_counted() -> None:
    study = study_of({"first_only": (0.5, 0.1), "sum": (0.5, 0.2)}, runs=14)
    works = model(first_only=lambda x, y: x, sum=lambda x, y: x + y)

    def evaluate(points: Sequence[Values]) -> list[Evaluated]:
        return [
            one if float(at["second"]) < 1.0 else Evaluated(None, {})
            for at, one in zip(points, works(points), strict=True)
        ]

    found = fitted(study, evaluate)
    failed = np.isnan(found.misfits)
    assert failed.any()
    assert f"{failed.sum()} of {len(found.runs)} runs failed" in " ".join(found.notes)
    assert found.marginals[0].posterior[0] < 0.5 < found.marginals[0].posterior[2]


@pytest.mark.usefixtures("undrawn")
def test_fit_needs_more_runs_than_parameters() -> None:
    study = study_of({"sum": (0.5, 0.1)})
    with pytest.raises(CaseError, match="0 of 8 runs have finished"):
        fitted(study, lambda points: [Evaluated(None, {}) for _ in points])


def test_arrival_that_a_run_lacks_contradicts_the_observation() -> None:
    study = study_of({"road_arrival": (10.0, 2.0)})
    answers = [11.0, 30.0, np.nan]
    runs = [Evaluated(Path("run"), {"road_arrival": value}) for value in answers]
    found = residuals_of(study, [*runs, Evaluated(None, {})])
    np.testing.assert_array_equal(found[:, 0], [0.5, 10.0, 10.0, np.nan])
    near = residuals_of(study, [runs[0], runs[2]])
    np.testing.assert_array_equal(near[:, 0], [0.5, 5.0])
    with pytest.raises(CaseError, match="no run has this quantity"):
        residuals_of(study, [runs[2]])


def test_of_a_level_that_a_run_lacks_nothing_is_known() -> None:
    study = study_of({"level": (10.0, 2.0)})
    runs = [Evaluated(Path("run"), {"level": value}) for value in (11.0, np.nan)]
    np.testing.assert_array_equal(residuals_of(study, runs)[:, 0], [0.5, np.nan])


def test_prior_in_scores_is_that_in_the_parameters() -> None:
    study = study_of({"sum": (0.5, 0.1)})
    space = ParameterSpace.of(study)
    scores = np.array([[0.0, 0.0], [1.0, -2.0]])
    found = np.exp(np.diff(space.log_prior(scores)))
    assert found == pytest.approx(np.exp(-0.5 * (1.0 + 4.0)))
    np.testing.assert_allclose(scores_of(shares_of(scores)), scores)
    np.testing.assert_allclose(space.shares(space.points(shares_of(scores))), shares_of(scores))


def test_points_are_drawn_from_the_posterior_without_repetition() -> None:
    space = ParameterSpace.of(study_of({"sum": (0.5, 0.1)}))
    sample = np.random.default_rng(0).normal(1.0, 0.1, (500, 2))
    points = drawn(space, sample, 100, seed=0)
    assert len({point["first"] for point in points}) == 100
    assert np.mean([float(point["first"]) for point in points]) == pytest.approx(1.0, abs=0.04)


def test_verdicts_follow_the_widths() -> None:
    space = ParameterSpace.of(study_of({"sum": (0.5, 0.1)}))
    sample = np.random.default_rng(0).normal(0.0, [0.3, 0.7], (4000, 2))
    found = marginals(space, sample)
    assert [one.verdict for one in found] == ["identified", "weakly identified"]
    assert found[0].ratio == pytest.approx(0.3, abs=0.02)
    assert coupled(space, sample) == []


@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parents[2] / "cases/studies").glob("*.toml"))
)
def test_shipped_studies_are_right(path: Path) -> None:
    study = load_study(path)
    assert len(points_of(study)) > 0
    assert Cases(study).at(points_of(study)[0]).title
