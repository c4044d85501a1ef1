"""Is the physics right: closed forms and experiments, with the tolerances of the README."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.validation.at_rest import still_water as hydrostatic
from debrisflow.validation.beds import settling
from debrisflow.validation.dam_breaks import dam_break, moving_walls, plate_jet
from debrisflow.validation.dam_breaks import zhou as impact
from debrisflow.validation.debris_flows import collapse
from debrisflow.validation.granular import granular_shear
from debrisflow.validation.viscous import rough_film, slurry_film
from debrisflow.validation.viscous import start_up as viscous


@pytest.fixture(scope="module")
def still() -> hydrostatic.Still:
    return hydrostatic.run("hydrostatic2d")


@pytest.fixture(scope="module")
def breaks() -> dict[int, dam_break.DamBreak]:
    return {across: dam_break.run(across) for across in (16, 32, 64)}


def test_still_water_holds_its_pressure_and_height(still):
    # half a row is 2.5 % of the depth: the free surface of particles lies there
    assert still.pressure_error < 0.02
    assert still.floor_noise < 0.01
    assert abs(still.height - 1.0) < 0.01
    assert still.through_wall == 0


def test_still_water_converges(still):
    fine = hydrostatic.run("hydrostatic2d", ("particles.spacing=0.005",))
    assert fine.pressure_error < 0.012
    assert fine.pressure_error < still.pressure_error


def test_water_rests_on_a_heavy_layer():
    found = hydrostatic.run("hydrostatic_two_phase2d")
    assert found.pressure_error < 0.015
    assert found.floor_noise < 0.01
    assert found.interface < 1.0  # rows by which the phases have passed each other
    assert found.through_wall == 0


# a bound that is missed and stays: at 20 rows two of each layer are left to fit the slope to; with
# 40 rows the next test holds it
@pytest.mark.xfail(strict=True, reason="4.5 % in the lower layer: its lattice packs by 3 %")
def test_the_pressure_of_twenty_rows_grows_with_the_weight_of_each_layer():
    found = hydrostatic.run("hydrostatic_two_phase2d")
    assert found.slopes == pytest.approx((2650.0 * 9.81, 1000.0 * 9.81), rel=0.03)


def test_the_pressure_grows_with_the_weight_of_each_layer():
    # at 20 rows two of each layer would be all that the slope is fitted to
    found = hydrostatic.run("hydrostatic_two_phase2d", ("particles.spacing=0.005",))
    assert found.slopes == pytest.approx((2650.0 * 9.81, 1000.0 * 9.81), rel=0.03)


def test_the_operators_of_the_study_are_worse(still):
    # measured: 40 times the pressure error, and one particle in six lost; 10 leaves room for the
    # chaos of a column that falls apart
    study = hydrostatic.run("hydrostatic2d", ('scheme.form="study"',))
    assert study.pressure_error > 10.0 * still.pressure_error


def test_drag_leaves_a_heavy_layer_at_rest():
    # its rock is denser than any packing, so that nothing may slip through it
    found = hydrostatic.run("hydrostatic_two_phase2d", ("drag.law=wen-yu",))
    assert found.pressure_error < 0.015
    assert found.interface < 1.0
    assert found.through_wall == 0


def test_grains_in_plane_shear_have_temperature_and_stress_of_kinetic_theory():
    found = granular_shear.plane_shear()
    assert found.temperature_ratio == pytest.approx(1.0, abs=0.01)
    ratio = 0.4 * np.sqrt(15.0 * (1.0 - granular_shear.RESTITUTION) / np.pi)
    assert found.stress_ratio == pytest.approx(ratio, rel=0.01)


def test_the_temperature_of_the_neighborhood_shrinks_with_the_spacing_squared():
    coarse, fine = (granular_shear.plane_shear(n, temperature="neighborhood") for n in (10, 20))
    assert fine.temperature_ratio / coarse.temperature_ratio == pytest.approx(0.25, rel=0.1)


def test_the_fluctuation_temperature_sees_no_shear():
    assert 0.0 < granular_shear.plane_shear(temperature="fluctuation").temperature_ratio < 0.01


def test_a_film_of_colliding_grains_has_the_dilatant_profile():
    found = granular_shear.film()
    assert np.abs(found.speed - found.exact).max() < 0.03
    # one row from the walls' no-slip and from the free surface
    assert found.temperature_ratio[1:-3] == pytest.approx(1.0, abs=0.05)


def test_the_balance_of_temperature_holds_in_discrete_elements():
    _, temperature, rate = granular_shear.discrete_elements()
    found = granular_shear.closure(rate, granular_shear.fitted_grain_over_gap())
    assert temperature.max() > 2.5 * temperature.min()
    # DEM scatters by 5 % from point to point; the balance leaves conduction out
    np.testing.assert_allclose(found, temperature, rtol=0.30)
    assert np.sqrt(np.mean((found - temperature) ** 2)) < 0.15 * temperature.mean()


@pytest.mark.parametrize("c", [0.1, 0.2, 0.3])
def test_grains_settle_as_richardson_and_zaki_and_come_to_rest(c):
    # two seedings, since one differs from another by 10 %
    columns = [settling.run(c, seed) for seed in (1, 2)]
    speed = np.mean([column.speed for column in columns])
    assert speed == pytest.approx(settling.richardson_zaki(c), rel=0.20)
    for column in columns:
        assert column.speed == pytest.approx(settling.richardson_zaki(c), rel=0.25)
        assert column.kept
        assert column.mean_displacement < 0.1
        assert column.greatest_displacement < 1.0
        # the packing limit, but for the six rows of a thin bed that are measured
        assert column.bed == pytest.approx(0.55, abs=0.07)


@pytest.mark.parametrize("seed", [1, 2])
def test_collisions_hold_the_sediment_back_at_half_the_spacing_too(seed):
    # all four seedings, and 2 s: scripts/validate.py collapse
    stressed, free = (
        collapse.run(with_stress, seed, ("particles.spacing=0.005",), collapse.LAG_TIME)
        for with_stress in (True, False)
    )
    assert stressed.sediment < free.sediment
    assert max(stressed.energy, free.energy) < 1.01


def test_a_collapsing_column_whose_grains_slip_packs_under_clear_water():
    stressed, free = (
        collapse.run(with_stress, 1, ("drag.law=wen-yu",)) for with_stress in (True, False)
    )
    assert stressed.sediment < free.sediment
    for found in (stressed, free):
        assert found.energy < 1.01
        assert found.through_wall == 0


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_collisions_hold_the_sediment_of_a_collapsing_column_back(seed):
    stressed, free = (collapse.run(with_stress, seed) for with_stress in (True, False))
    assert stressed.sediment < free.sediment
    for found in (stressed, free):
        assert found.energy < 1.01
        assert found.layering[collapse.END] > 0.8
        assert found.through_wall == 0


@pytest.mark.parametrize("implicit", [False, True])
@pytest.mark.parametrize("flow", ["poiseuille", "couette", "film"])
def test_viscous_profiles_follow_their_series(flow, implicit):
    # slow, so that the rows of particles hardly pass each other
    assert viscous.error(flow, 20, 1.25e-5, (0.05, 0.1, 0.2, 0.5, 1.0), implicit) < 0.02


@pytest.mark.parametrize("flow", ["poiseuille", "couette", "film"])
def test_viscous_profiles_hold_when_rows_pass_each_other(flow):
    # at a hundred times the speed the fastest row has passed the wall's by 25 spacings at the end
    assert viscous.error(flow, 20, 1.25e-3, (0.05, 0.1, 0.2, 0.5, 1.0)) < 0.02


def test_the_poiseuille_profile_converges():
    coarse, fine = (viscous.error("poiseuille", rows, 1.25e-5, (0.5,)) for rows in (10, 20))
    assert fine < 0.5 * coarse


def test_the_front_of_the_dam_break_agrees_with_the_experiment(breaks):
    shipped = breaks[32]
    assert shipped.best_shift()[1] < 0.04
    assert shipped.slope() == pytest.approx(1.32, rel=0.08)


# a bound that is missed and stays, see docs/validation.md: the experiment has a gate, the run has
# none; the front shifted in time is held by the test above
@pytest.mark.xfail(strict=True, reason="11.3 %: no lattice of walls holds it back, and no gate")
def test_the_front_of_the_dam_break_agrees_without_a_shift_in_time(breaks):
    assert breaks[32].front_error() < 0.10


# a bound that is missed and stays: friction acts on the lowest row, which thins with the spacing.
# Not strict, since nothing says that it must fail on every processor; held on a smooth floor below
@pytest.mark.xfail(reason="a wall law slows the lowest row alone, a thinner one each")
def test_the_dam_break_converges(breaks):
    at = [0.05, 0.09, 0.13, 0.17]
    coarse, middle, fine = (np.interp(at, breaks[n].time, breaks[n].front) for n in (16, 32, 64))
    assert np.abs(fine - middle).mean() < np.abs(middle - coarse).mean()


@pytest.mark.parametrize("across", [16, 32, 64])
def test_the_dam_break_keeps_height_slope_and_energy(breaks, across):
    found = breaks[across]
    assert found.best_shift()[1] < 0.04
    assert found.slope() == pytest.approx(1.32, rel=0.08)
    assert found.height_error() < 0.05
    assert found.energy.max() < 1.005
    assert found.state.through_wall.sum() == 0


def test_the_dam_break_over_a_smooth_floor_converges():
    # the friction of a rough one acts on the lowest row, which thins with the spacing
    found = [dam_break.run(across, overrides=dam_break.SMOOTH) for across in (16, 32, 64)]
    at = [0.05, 0.09, 0.13, 0.17]
    coarse, middle, fine = (np.interp(at, each.time, each.front) for each in found)
    assert np.abs(fine - middle).mean() < 0.5 * np.abs(middle - coarse).mean()


def test_the_splash_of_a_dam_break_stays_in_the_tank():
    found = dam_break.run(32, end=2.0)
    assert found.state.through_wall.sum() == 0
    assert found.energy.max() < 1.005


@pytest.mark.parametrize(
    ("rows", "roughness", "mixing_length", "error"),
    [
        (1, 0.003, 0.004, 0.10),
        (2, 0.003, 0.004, 0.05),
        (4, 0.003, 0.004, 0.05),
        (8, 0.003, 0.004, 0.05),
        pytest.param(
            *(1, 0.095, 0.0095, 0.12),
            # a bound that is missed and stays, see docs/limits.md: no law of the wall holds there
            marks=pytest.mark.xfail(strict=True, reason="21 %: k_s is four times the depth"),
        ),
        (2, 0.095, 0.0095, 0.10),
        (4, 0.095, 0.0095, 0.10),
        (8, 0.095, 0.0095, 0.10),
    ],
)
def test_a_turbulent_film_has_the_speed_of_its_profile(rows, roughness, mixing_length, error):
    film = (0.026, roughness, mixing_length)
    found = rough_film.run(rows, *film)
    assert found.speed == pytest.approx(rough_film.mean_speed(*film), rel=error)
    assert found.across < 0.03


@pytest.fixture(scope="module")
def jet() -> plate_jet.Jet:
    return plate_jet.run(2)


def test_a_jet_presses_on_a_plate_as_potential_flow_does(jet):
    assert jet.thrust == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(jet.pressure, jet.expected, atol=0.1)
    finer = plate_jet.run(2, 16)
    assert finer.thrust == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(finer.pressure, finer.expected, atol=0.03)


# a bound that is missed and stays, see docs/limits.md: rows that are pressed together carry more
# stress than the pressure of their particles; 0.60, 0.74, 0.86 in 4, 8, 16 rows.  The reaction of
# the plate, which the test above holds, does not miss it
@pytest.mark.xfail(strict=True, reason="0.74: rows are pressed together")
def test_the_fluid_before_a_plate_has_the_pressure_of_stagnation(jet):
    assert jet.by_fluid == pytest.approx(1.0, abs=0.1)


def test_a_gate_drawn_ever_faster_comes_to_none():
    fronts = [moving_walls.front_after(speed) for speed in (1.0, 4.0, 64.0)]
    none = moving_walls.front_after(None)
    assert fronts[0] < fronts[1] < fronts[2] < none
    assert none - fronts[2] < 0.005  # half a spacing


def test_under_a_gate_goes_what_an_orifice_lets_through():
    # eight rows over the opening; the jet contracts to five
    assert moving_walls.sluice(8).open == pytest.approx(1.0, abs=0.10)


@pytest.mark.parametrize("rows", [10, 20])
def test_a_piston_drives_the_bore_of_shallow_water(rows):
    found = moving_walls.bore(rows)
    assert found.depth == pytest.approx(1.0, abs=0.05)
    assert found.path == pytest.approx(1.0, abs=0.05)


# a bound that is missed and stays, see docs/limits.md: 0.80, 0.55, 0.38 of the amplitude in the
# first three half periods at 15 rows, 0.84, 0.58, 0.44 at 30.  The lattice of the start resists
# shear: water that was stirred and came to rest keeps 0.87, 0.79, 0.62
@pytest.mark.xfail(strict=True, reason="0.55: the lattice of the start melts")
def test_a_standing_wave_is_not_damped():
    assert moving_walls.swing(15, halves=2)[1] > 0.9


@pytest.mark.parametrize("rows", [2, 6, 12])
def test_a_sheet_loses_nothing_to_a_smooth_floor(rows):
    found = rough_film.slide(rows)
    assert abs(found.drag) < 0.1
    assert found.across < 0.025


def test_a_dam_break_loses_less_energy_before_it_strikes_the_finer_it_is():
    coarse, fine = (dam_break.lost_before_impact(across) for across in (16, 32))
    assert fine < 0.04
    assert fine < 0.7 * coarse


@pytest.mark.parametrize("law", ["bingham", "herschel-bulkley", "mu-i"])
def test_a_film_of_slurry_or_dry_grains_has_its_profile(law):
    off = slurry_film.errors(law, 1.6)
    assert np.sqrt(np.mean(off**2)) < 0.03
    assert np.abs(off).max() < 0.04


# of at most 2.5 degrees, where the yield stress is rho g h sin(slope), and of the friction angle, 8
@pytest.mark.parametrize(
    ("law", "slope"), [("bingham", 2.0), ("herschel-bulkley", 2.0), ("mu-i", 6.0)]
)
def test_a_layer_below_its_yield_stays(law, slope):
    assert slurry_film.creep(law, slope) < 0.1


@pytest.fixture(scope="module")
def struck() -> impact.Impact:
    return impact.run(0.02)


def test_a_dam_break_reaches_a_wall_as_measured(struck):
    assert struck.lost == 0
    assert struck.energy < 1.005
    assert struck.level_error("h2") < 0.02


# a bound that is missed and stays, see docs/validation.md: 21 and 19 % at a half and a quarter of
# the spacing, so that it is not resolution that is missing
@pytest.mark.xfail(strict=True, reason="25 %: the jet up the wall presses too little")
def test_the_pressure_on_a_wall_after_an_impact_is_that_measured(struck):
    measured = impact.mean(*impact.experiment()["p2"].T, *impact.PLATEAU)
    series = struck.series
    ours = impact.mean(series["time"], series["reaction_p2"], *impact.PLATEAU)
    assert ours == pytest.approx(measured, rel=0.20)
