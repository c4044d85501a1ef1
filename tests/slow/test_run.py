"""What a run keeps to: walls with edges, the supply, broken promises and interruptions."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow._jit import set_threads
from debrisflow.case.defaults import complete
from debrisflow.cli import main
from debrisflow.errors import DivergedError
from debrisflow.particles.record import Kind
from debrisflow.particles.start import initial_state
from debrisflow.run import checkpoint, loop, simulation
from debrisflow.run.measures import energies
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.schemes.terms.term import Term
from debrisflow.validation.marching import advance
from tests.building import bed_case, started, tank_case
from tests.fast.test_checkpoint import identical


def test_a_particle_that_skims_a_step_keeps_its_velocity():
    block = {"type": "block", "x": (0.10, 0.12), "y": (0.0, 0.02), "material": "water"}
    plain = bed_case().model_dump() | {
        "gravity": {"acceleration": 0.0},
        "fill": [block | {"velocity": (1.0, 0.0)}],
        "inflow": None,
        "water": {"viscosity": 0.0},
        "rheology": {},
        "drag": {},
        "collision_stress": {},
    }
    case = complete(type(bed_case()).model_validate(plain))
    scheme, state = started(case)
    advance(scheme, state, until=0.2)
    p = state.particles
    assert p.position[0, 0] > 0.25  # past the lip of the recess at 0.2
    np.testing.assert_allclose(p.velocity[0], [1.0, 0.0, 0.0], atol=1e-12)


def test_the_supply_carries_its_sediment_from_the_first_column():
    scheme, state = started(bed_case())  # 2 rows with C = 0.2
    advance(scheme, state, until=0.4)
    entered = state.entered
    assert entered.sum() >= 30
    assert abs(entered[Kind.SEDIMENT] - 0.2 * entered.sum()) <= 1.0


class Fault(Term):
    """A term that spoils one velocity."""

    name = "fault"

    def act(self, step):
        step.velocity[3, 0] = np.nan


def test_a_velocity_that_is_no_number_ends_the_run_before_it_spoils_the_state():
    scheme, state = started(tank_case(6, 6, "water"))
    advance(scheme, state, steps=2)
    scheme.observe(state)
    before = state.particles.position.copy()

    *others, motion = scheme.terms
    scheme.terms = (*others, Fault(), motion)
    with pytest.raises(DivergedError, match=r"particle \d+ at .* got the velocity"):
        scheme.step(state, 1e-4)
    np.testing.assert_array_equal(state.particles.position, before)


def test_a_time_step_that_collapses_ends_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr(SemiImplicit, "stable_dt", lambda self, state: 1e-12)
    case = tank_case(6, 6, "water")
    with pytest.raises(
        DivergedError, match=r"(?s)the time step has fallen to 1e-12 s.*checkpoint.h5"
    ):
        simulation.simulate(case, tmp_path / "run")
    assert checkpoint.load(tmp_path / "run" / "checkpoint.h5").state.step == 0


def test_an_interrupted_run_goes_on_bit_for_bit(tmp_path, ends, interrupt):
    case = bed_case(time={"end": 0.15}, output={"interval": 0.05})
    simulation.simulate(case, tmp_path / "whole")
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulation.simulate(case, tmp_path / "broken")
    stopped = checkpoint.load(tmp_path / "broken" / "checkpoint.h5").state
    assert stopped.step == SemiImplicit.REFRESH
    summary = json.loads((tmp_path / "broken" / "summary.json").read_text())
    assert summary["end_reason"] == "interrupted"
    shutil.copytree(tmp_path / "broken", tmp_path / "rest")
    simulation.resume(tmp_path / "rest")
    assert identical(ends[0], ends[-1])
    whole, rest = (tmp_path / run / "maxima.csv" for run in ("whole", "rest"))
    assert whole.read_bytes() == rest.read_bytes()
    assert np.nanmax(ends[0].maxima.arrival_time) > stopped.time  # there was more to accumulate


def test_a_run_takes_more_threads_as_particles_come_in_and_keeps_its_bits(tmp_path, monkeypatch):
    case = bed_case(time={"end": 0.2}, output={"interval": 0.1})
    at_start = initial_state(case).particles.unknown_count
    monkeypatch.setattr(loop, "cores", lambda: 2)
    monkeypatch.setattr(loop, "FEWEST_PARTICLES_A_THREAD", (at_start + 6) // 2)
    try:
        grown = simulation.simulate(case, tmp_path / "grown")
        alone = simulation.simulate(case, tmp_path / "alone", threads=1)
    finally:
        set_threads(1)
    assert (grown["threads"], alone["threads"]) == (2, 1)
    files = [tmp_path / run / "history.csv" for run in ("grown", "alone")]
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_run_that_has_come_to_its_end_is_not_changed_by_resuming_it(tmp_path):
    run = tmp_path / "run"
    simulation.simulate(
        tank_case(6, 6, "water", time={"end": 0.02}, output={"interval": 0.01}), run
    )
    before = {file: file.read_bytes() for file in run.rglob("*") if file.is_file()}
    result = CliRunner().invoke(main, ["resume", str(run)])
    assert result.exit_code == 0, result.output
    assert "has come to its end" in result.output
    assert {file: file.read_bytes() for file in run.rglob("*") if file.is_file()} == before
    file = run / "case.toml"
    file.write_text(file.read_text().replace("end = 0.02", "end = 0.03"))
    assert simulation.resume(run)["time"] == pytest.approx(0.03)


@pytest.mark.parametrize("temperature", ["algebraic", "neighborhood"])
def test_colliding_grains_do_not_gain_energy(temperature):
    stress = {"enabled": True, "granular_temperature": temperature}
    case = tank_case(10, 10, "sediment", tank=(30, 20), collision_stress=stress)
    scheme, state = started(case)
    p = state.particles

    def energy():
        rows = p.fluid
        motion = p.position[rows], p.velocity[rows], p.density[rows], p.kind[rows]
        return sum(energies(case, *motion))

    start = energy()
    for until in np.arange(0.05, 0.31, 0.05):
        advance(scheme, state, until=until)
        assert energy() <= 1.01 * start
