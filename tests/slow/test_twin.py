"""A twin experiment: parameters of a run are recovered from what was observed of it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from debrisflow.run.loop import program
from debrisflow.study.calibration.observations import Evaluated
from debrisflow.study.calibration.procedure import calibrate
from debrisflow.study.computing import compute
from debrisflow.study.designs import points_of
from debrisflow.study.distributions import Values
from debrisflow.study.loading import load_study
from debrisflow.study.member import Cases, members_of
from debrisflow.study.outcome import FINISHED
from debrisflow.study.quantities import quantities_of

STUDY = Path(__file__).parents[2] / "cases" / "studies" / "fan_twin.toml"
TRUTH = {"friction": 0.17, "pore_pressure": 0.45}  # of scripts/fan_twin.py
RUNS = 20


def test_friction_and_pore_pressure_of_a_twin_are_within_their_intervals(tmp_path: Path) -> None:
    study = load_study(STUDY)
    assert study.calibration is not None
    fewer = study.calibration.model_copy(update={"runs": RUNS, "predictive": 0})
    study = study.model_copy(update={"calibration": fewer})
    cases = Cases(study)
    count = 0

    def evaluate(points: Sequence[Values]) -> list[Evaluated]:
        nonlocal count
        count += len(points)
        results = []
        for one in members_of(cases, tmp_path / "members", points, program()):
            outcome = compute(one.case, one.folder, one.digest, program())
            assert outcome.state == FINISHED, outcome.message
            figures = quantities_of(study, one.folder, outcome)
            values = {name: figure.value for name, figure in figures.items()}
            results.append(Evaluated(one.folder, values))
        return results

    found = calibrate(study, points_of(study), evaluate, tmp_path / "calibration")
    assert count <= RUNS
    for one in found.marginals:
        low, _, high = one.posterior
        assert low <= TRUTH[one.name] <= high
    assert found.marginals[0].verdict == "identified"
    assert found.posterior.doubts == []
