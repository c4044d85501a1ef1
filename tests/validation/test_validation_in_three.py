"""Is the physics of the explicit scheme right: still water, experiments, a cube of mixture, a heap.

The coarse runs only; finer ones: scripts/validate.py still3d dam_break3d marin cube heap.
"""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.validation.at_rest import still_ground as ground3d
from debrisflow.validation.at_rest import still_tank as still3d
from debrisflow.validation.dam_breaks import dam_break, dam_break3d, plate_jet, spheric
from debrisflow.validation.debris_flows import mixture_cube
from debrisflow.validation.field import st_helens
from debrisflow.validation.granular import heap3d
from debrisflow.validation.viscous import rough_film


@pytest.mark.parametrize(
    ("changes", "depth"),
    [((), 1.0), (("scheme.sound_speed=44.0",), 1.0), (still3d.shallow(), 0.2)],
    ids=["shipped", "stiffer", "shallow"],
)
def test_still_water_in_a_tank_keeps_height_and_pressure(changes, depth):
    found = still3d.run(changes, depth)
    assert found.lost == 0
    assert abs(found.drift) < 0.01
    assert found.pressure_error < 0.03
    assert found.raw_pressure_error < 0.05
    assert found.speed < 0.03


@pytest.mark.parametrize("name", ["30 degrees", "valley"])
def test_still_water_over_a_ground_stays_where_it_is(name):
    found = ground3d.run(name)
    assert found.lost == found.inside == 0
    assert found.current < 0.010
    assert found.speed < 0.030
    assert found.pressure_error < 0.03
    assert abs(found.drift) < 0.01


@pytest.fixture(scope="module")
def landslide() -> st_helens.Runout:
    return st_helens.run()


def test_a_landslide_on_terrain_stays_over_the_ground_and_comes_to_rest(landslide):
    assert landslide.ledger["volume_released"][-1] == pytest.approx(st_helens.VOLUME, rel=0.01)
    assert landslide.is_balanced
    assert landslide.nearest > 0.0
    assert landslide.history["maximal_speed"].max() > 5.0
    assert landslide.summary["end_reason"] == "at rest"


def test_a_landslide_runs_out_as_far_as_observed(landslide):
    assert abs(landslide.score["runout_error"]) < 10.0
    assert abs(landslide.score["reach_error"]) < 10.0


@pytest.mark.xfail(
    strict=True, reason="0.48: it spreads beside the gully, half of it by less than 1 m"
)
def test_a_landslide_reaches_what_was_observed(landslide):
    assert landslide.score["csi"] > 0.5


@pytest.mark.xfail(
    strict=True, reason="on slopes steeper than its sliding friction a flow thins and never stops"
)
def test_a_landslide_lies_still_at_the_end(landslide):
    assert landslide.score["deposit_volume_error"] > -20.0


def test_a_landslide_leaves_the_volume_that_was_observed(landslide):
    assert landslide.thick == pytest.approx(landslide.score["deposit_volume_observed"], rel=0.2)


@pytest.fixture(scope="module")
def high() -> dam_break.DamBreak:
    return dam_break3d.run(10)


def test_the_front_in_a_slab_agrees_with_the_experiment(high):
    for found in (high, high.by_last_column()):
        assert found.front_error() < 0.10
        assert found.best_shift(0.5)[1] < 0.04
    assert high.slope() == pytest.approx(1.32, rel=0.08)
    assert high.height_error() < 0.05


def test_a_slab_keeps_its_energy_and_particles(high):
    assert high.energy.max() < 1.005
    assert high.state.through_wall.sum() == 0
    assert high.state.left.sum() == 0


def test_the_front_of_a_square_column_agrees_with_the_experiment():
    # its late slope is too steep, at half the spacing too: without a gate it starts at once
    found = dam_break3d.run(16, dam_break.SQUARE)
    assert found.front_error() < 0.10
    assert found.best_shift(0.5)[1] < 0.04
    assert found.slope() == pytest.approx(1.40, rel=0.12)
    assert found.height_error() < 0.05
    assert found.energy.max() < 1.005


@pytest.fixture(scope="module")
def cubes() -> dict[float | None, mixture_cube.Cube]:
    ends = {None: 0.85, 0.4: 0.85, 0.5: 2.0}
    return {
        concentration: mixture_cube.run(concentration, end) for concentration, end in ends.items()
    }


def test_grains_hold_the_front_of_a_cube_back(cubes):
    assert cubes[0.5].front < cubes[0.4].front - 0.2
    assert cubes[0.4].front < cubes[None].front


@pytest.mark.parametrize("concentration", [0.4, 0.5])
def test_grains_throw_out_no_spray(cubes, concentration):
    found, free = cubes[concentration], cubes[None]
    assert found.thin < free.thin + 0.01
    assert found.spray < free.spray + 0.001
    assert found.energy < 1.005
    assert found.through_wall == 0


@pytest.mark.parametrize(
    "concentration",
    [
        0.4,
        # a bound that is missed and stays: what stands of the cube is held back by its grains, and
        # none of it is in the air, see the test above
        pytest.param(0.5, marks=pytest.mark.xfail(strict=True, reason="5.4 %, half a spacing")),
    ],
)
def test_grains_leave_a_cube_no_higher_than_water(cubes, concentration):
    assert cubes[concentration].height < 1.05 * cubes[None].height


@pytest.fixture(scope="module")
def marin() -> spheric.Marin:
    return spheric.run(0.05, 2.0)


@pytest.mark.parametrize("gauge", ["h2", "h3", "h4"])
def test_water_levels_before_and_in_front_of_a_box_are_those_measured(marin, gauge):
    assert marin.level_error(gauge, 2.0) < 0.05


def test_a_dam_break_against_a_box_loses_nothing(marin):
    assert marin.through_wall == 0
    assert marin.energy < 1.005


@pytest.fixture(scope="module")
def heap() -> heap3d.Heap:
    return heap3d.run(across=10)


def test_a_column_of_dry_grains_comes_to_rest(heap):
    assert heap.stopped() < 0.5
    assert heap.moved().mean() < 0.1


def test_a_column_of_dry_grains_spreads_as_far_as_measured(heap):
    assert heap.run_out() == pytest.approx(heap3d.lube(1.0), rel=0.15)


def test_a_heap_keeps_volume_particles_and_energy(heap):
    assert heap.volume() == pytest.approx(1.0, abs=0.03)
    assert heap.loose() < 0.01
    assert heap.energy.max() < 1.005
    assert heap.through_wall == 0


def test_a_jet_presses_on_a_plate_as_potential_flow_does():
    found = plate_jet.run(3)
    assert found.thrust == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(found.pressure, found.expected, atol=0.05)
    assert found.by_fluid == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    "rows",
    [
        # a bound that is missed and stays: one row moves as the law of the wall says for half the
        # depth under the stress on the floor, 3.06 m/s, and the mean of the profile is 2.76 m/s
        pytest.param(1, marks=pytest.mark.xfail(strict=True, reason="+10 %, as by the law")),
        2,
        4,
        8,
    ],
)
def test_a_turbulent_film_has_the_speed_of_its_profile(rows):
    film = (0.026, 0.003, 0.004)
    found = rough_film.run(rows, *film, dimension=3)
    assert found.speed == pytest.approx(rough_film.mean_speed(*film), rel=0.06)
    assert found.across < 0.03
