"""A supply that the explicit scheme carries on: budgets in a run, and a run that goes on."""

import shutil

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.run import simulation
from debrisflow.schemes.explicit import Explicit
from tests.fast.test_checkpoint import identical

D0 = 0.02
SLAB = 8 * 3 * D0**3
HYDROGRAPH = {
    "time": (0.0, 0.1, 0.2),
    "discharge": (0.005, 0.012, 0.004),
    "concentration": (0.0, 0.3, 0.1),
}


def flume(end):
    """Return a case: a supply of changing concentration runs over water in a short flume."""
    block = {"type": "block", "x": [0.0, 0.14], "y": [0.0, 0.24], "z": [0.0, 0.04]}
    box = {"x": [0.0, 0.2], "y": [0.0, 0.24], "z": [0.0, 0.3]}
    return complete(
        Case(
            title="supply",
            particles={"spacing": D0},
            gravity={"slope": 15.0},
            geometry={"type": "channel3d", "length": 0.2, "width": 0.24, "height": 0.3},
            inflow={"depth": 0.06, "across": (0.04, 0.2), "hydrograph": HYDROGRAPH},
            fill=[block | {"material": "water"}],
            probe=[
                {"name": "s", "type": "section", "interval": 0.01, "x": 0.1},
                {"name": "f", "type": "force", "interval": 0.03, "wall": "floor"},
                {"name": "v", "type": "volume", "interval": 0.01} | box,
            ],
            time={"end": end},
            output={"interval": 0.05},
        )
    )


def test_what_a_run_supplies_is_the_integral_of_the_hydrograph(tmp_path, ends):
    summary = simulation.simulate(flume(0.2), tmp_path / "run", threads=1)
    (state,) = ends
    time = np.linspace(0.0, 0.2, 100_001)
    discharge, concentration = (
        np.interp(time, HYDROGRAPH["time"], HYDROGRAPH[name])
        for name in ("discharge", "concentration")
    )
    assert state.entered.sum() * D0**3 == pytest.approx(
        np.trapezoid(discharge, time), abs=0.51 * SLAB
    )
    assert state.entered_sediment.sum() * D0**3 == pytest.approx(
        np.trapezoid(discharge * concentration, time), abs=0.51 * SLAB * 0.3
    )
    p = state.particles
    assert state.left.sum() > 0
    assert state.through_wall.sum() == 0
    start = 7 * 12 * 2
    assert p.fluid_count == start + state.entered.sum() - state.left.sum()
    np.testing.assert_allclose(
        p.sediment_fraction[p.fluid].sum(),
        state.entered_sediment.sum() - state.left_sediment.sum(),
        rtol=1e-12,
    )
    volumes = summary["sediment_volume"]
    assert volumes["entered"] == pytest.approx(state.entered_sediment.sum() * D0**3)
    lines = (tmp_path / "run/probes/v.csv").read_text().splitlines()
    inside = [float(number) for number in lines[-1].split(",")]
    expected = p.fluid_count * D0**3, p.sediment_fraction[p.fluid].sum() * D0**3
    np.testing.assert_allclose(inside[1:], expected, rtol=1e-8)


def test_a_run_with_a_supply_goes_on_bit_for_bit(tmp_path, ends, interrupt):
    case = flume(0.1)
    simulation.simulate(case, tmp_path / "whole", threads=1)
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulation.simulate(case, tmp_path / "broken", threads=1)
    shutil.copytree(tmp_path / "broken", tmp_path / "rest")
    simulation.resume(tmp_path / "rest", threads=1)
    assert ends[0].step > Explicit.REFRESH
    assert identical(ends[0], ends[-1])
    for name in ("s", "f", "v"):
        whole, rest = (tmp_path / run / f"probes/{name}.csv" for run in ("whole", "rest"))
        assert whole.read_bytes() == rest.read_bytes()
