"""The supply in three dimensions: its section, its discharge and the sediment that it brings."""

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.particles.inflow_outflow import advance_supply, remove_leaving
from debrisflow.particles.record import Kind
from debrisflow.particles.start import initial_state
from debrisflow.run import checkpoint
from debrisflow.run.probes import samplers
from debrisflow.space.domain import domain, wall_layers
from tests.fast.test_checkpoint import identical

D0 = 0.05
ACROSS = (0.1, 0.4)
HYDROGRAPH = {
    "time": (0.0, 0.5, 1.5, 2.0),
    "discharge": (0.02, 0.08, 0.03, 0.0),
    "concentration": (0.0, 0.4, 0.1, 0.1),
}


def flume(probe=(), **inflow):
    """Return a case: a supply 3 particles deep and 6 wide, in a flume 10 wide."""
    return complete(
        Case(
            title="supply",
            particles={"spacing": D0},
            gravity={"slope": 15.0},
            geometry={"type": "channel3d", "length": 1.0, "width": 0.5, "height": 0.5},
            inflow={"depth": 0.15, "across": ACROSS} | inflow,
            probe=probe,
            time={"end": 2.0},
            output={"interval": 1.0},
        )
    )


def supplied(case, until, dt=1e-3):
    """Return the state after a supply of some time, without forces."""
    state = initial_state(case)
    return go_on(state, case, until, dt)


def go_on(state, case, until, dt=1e-3):
    while state.time < until - 0.5 * dt:
        advance_supply(state, case, dt)
        state.time += dt
        state.step += 1
    return state


def test_the_supply_fills_its_section_and_is_compressed_by_its_weight():
    case = flume(velocity=1.0, concentration=0.3)
    p = initial_state(case).particles
    rows = p.inflow
    layers = wall_layers(case)
    cell = np.rint(p.position[rows] / D0 - 0.5).astype(int)
    assert p.fluid_count == 0
    assert p.inflow_count == 18 * layers
    assert {tuple(c) for c in cell} == {
        (-n, j, k) for n in range(1, layers + 1) for j in range(2, 8) for k in range(3)
    }
    assert set(p.kind[rows]) == {Kind.INFLOW}
    np.testing.assert_allclose(p.sediment_fraction[rows], 0.3, rtol=1e-15)
    np.testing.assert_allclose(p.density[rows], 1000.0 + 0.3 * 1650.0)
    weight = 9.81 * np.cos(np.radians(15.0)) * (0.15 - p.position[rows, 2])
    np.testing.assert_allclose(p.compression[rows], weight / case.scheme.sound_speed**2)


@pytest.mark.parametrize("given", [{"velocity": 0.8}, {"discharge": 0.036}])
def test_velocity_and_discharge_follow_from_each_other_through_the_section(given):
    inflow = flume(**given).inflow
    assert (inflow.velocity, inflow.discharge) == pytest.approx((0.8, 0.036))
    assert inflow.across == ACROSS


def test_a_supply_comes_over_the_whole_width_if_nothing_else_is_said():
    assert flume(across=None, velocity=1.0).inflow.across == (0.0, 0.5)


@pytest.mark.parametrize("until", [0.02, 0.33, 1.0, 1.97])
@pytest.mark.parametrize(
    ("inflow", "kind"),
    [({"velocity": 0.8, "concentration": 0.3}, Kind.MIXTURE), ({"discharge": 0.036}, Kind.LIQUID)],
)
def test_a_steady_supply_is_exact_to_the_last_slab(inflow, kind, until):
    case = flume(**inflow)
    state = supplied(case, until)
    slabs = np.floor(0.8 * until / D0 + 0.5 + 1e-9)  # the first stands half a spacing before x = 0
    assert state.entered[kind] == state.entered.sum() == state.particles.fluid_count == 18 * slabs
    carried = case.inflow.concentration
    np.testing.assert_allclose(state.entered_sediment.sum(), carried * 18 * slabs, rtol=1e-12)
    fluid = state.particles.fluid
    assert set(state.particles.kind[fluid]) <= {kind}
    np.testing.assert_array_equal(state.particles.sediment_fraction[fluid], carried)
    assert np.unique(state.particles.id).size == state.particles.count


@pytest.mark.parametrize("until", [0.4, 0.9, 1.6, 2.0])
def test_a_hydrograph_is_exact_to_the_last_slab(until):
    state = supplied(flume(hydrograph=HYDROGRAPH), until)
    time = np.linspace(0.0, until, 200_001)
    discharge, concentration = (
        np.interp(time, HYDROGRAPH["time"], HYDROGRAPH[name])
        for name in ("discharge", "concentration")
    )
    slab = 18 * D0**3
    volume = np.trapezoid(discharge, time)
    assert state.entered.sum() * D0**3 == pytest.approx(volume, abs=0.51 * slab)
    sediment = np.trapezoid(discharge * concentration, time)
    entered = state.entered_sediment.sum() * D0**3
    assert entered == pytest.approx(sediment, abs=0.51 * slab * concentration.max())
    p = state.particles
    np.testing.assert_allclose(p.sediment_fraction[p.fluid].sum() * D0**3, entered, rtol=1e-12)
    rest = 1000.0 + 1650.0 * p.sediment_fraction[p.fluid]
    np.testing.assert_allclose(p.density[p.fluid], rest)


def test_what_leaves_takes_its_own_sediment_along():
    case = flume(hydrograph=HYDROGRAPH)
    state = supplied(case, 1.5)
    p = state.particles
    p.position[10:300, 0] += 1.0  # beyond the end
    p.position[:5, 2] = -0.2  # through the floor
    remove_leaving(state, case, domain(case))
    assert state.through_wall.sum() == 5
    assert state.left.sum() == 290
    inside = np.bincount(p.kind[p.fluid], minlength=3)
    np.testing.assert_array_equal(state.entered, state.left + state.through_wall + inside)
    sediment = np.bincount(p.kind[p.fluid], p.sediment_fraction[p.fluid], 3)
    np.testing.assert_allclose(
        state.entered_sediment,
        state.left_sediment + state.through_wall_sediment + sediment,
        rtol=1e-12,
    )


def test_a_section_sees_what_the_supply_brings():
    case = flume(
        velocity=0.8,
        concentration=0.3,
        probe=[{"name": "s", "type": "section", "x": 0.21, "interval": 0.1}],
    )
    state = initial_state(case)
    section = samplers(case, state)["s"]
    while state.time < 0.5:
        p = state.particles
        p.position[p.fluid, 0] += 1e-3 * 0.8
        advance_supply(state, case, 1e-3)
        state.time += 1e-3
        section.add_step(state)
    *flow, volume, sediment = section.sample(state)
    np.testing.assert_allclose(flow, [0.036, 0.3 * 0.036, 0.3, 0.8, 0.15, 0.3])
    slabs = np.floor((0.8 * 0.5 - 0.21) / D0 + 0.5)
    np.testing.assert_allclose([volume, sediment], 18 * slabs * D0**3 * np.array([1.0, 0.3]))


def test_a_supply_goes_on_bit_for_bit_from_a_checkpoint(tmp_path):
    case = flume(hydrograph=HYDROGRAPH)
    whole = supplied(case, 1.2)
    part = supplied(case, 0.6)
    origin = checkpoint.Origin("", "", "{}")
    checkpoint.save(tmp_path / "c.h5", part, origin)
    assert identical(whole, go_on(checkpoint.load(tmp_path / "c.h5").state, case, 1.2))
