"""What the package offers to Python."""

import numpy as np
import pytest

import debrisflow
from debrisflow import load_case, open_run, simulate
from debrisflow.case.loading import dump_case
from debrisflow.results.answers import answers
from debrisflow.results.survey import survey


def test_a_case_is_run_and_its_results_are_read(tmp_path):
    overrides = ["time.end=0.002", "output.interval=0.001"]
    case = load_case("cases/hydrostatic2d.toml", overrides)
    summary = simulate(case, str(tmp_path / "run"))
    run = open_run(str(tmp_path / "run"))
    assert run.case == case
    assert run.summary == summary
    assert summary["bounced_share"] == 0.0
    assert "bounced_share" in [answer.quantity for answer in answers(survey(run))]
    np.testing.assert_allclose(run.times, [0.0, 0.001, 0.002])
    assert [frame.time for frame in run.frames()] == list(run.times)
    assert run.frame(0.0009).time == 0.001
    assert run.history["time"][-1] == run.frame().time == 0.002
    assert set(run.deposit) >= {"time", "x", "deposit_height"}


def test_what_is_not_there_is_an_attribute_error():
    name = "solve"
    with pytest.raises(AttributeError, match="no attribute solve"):
        getattr(debrisflow, name)


def test_the_comment_at_the_head_of_a_case_goes_with_it(tmp_path):
    case = load_case("cases/flume2d.toml")
    assert "\nCalibrated: walls.floor.roughness" in case.notes
    (tmp_path / "case.toml").write_text(dump_case(case))
    assert load_case(tmp_path / "case.toml") == case
