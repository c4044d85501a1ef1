"""What must be so of water at rest, though no reference says how much."""

from __future__ import annotations

from debrisflow.validation.at_rest import still_water, terrain_pool


def test_the_pressure_of_still_water_converges():
    coarse, fine = (
        still_water.run("hydrostatic2d", (f"particles.spacing={d0}",)) for d0 in (0.02, 0.01)
    )
    assert fine.pressure_error < coarse.pressure_error


def test_the_operators_of_the_study_are_worse():
    # measured: 40 times the pressure error, and one particle in six lost; 10 leaves room for the
    # chaos of a column that falls apart
    stable = still_water.run("hydrostatic2d")
    study = still_water.run("hydrostatic2d", ('scheme.form="study"',))
    assert study.pressure_error > 10.0 * stable.pressure_error


def test_what_flows_over_a_dam_is_counted(tmp_path):
    found = terrain_pool.run_pool(tmp_path, 1.0, terrain_pool.TURNED, crest=terrain_pool.LOW_CREST)
    assert found.passed > 0
    assert found.left > 0
    assert found.missing == found.through == 0
