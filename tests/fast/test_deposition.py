"""Deposits: heaps and beds of known volume, area, slope and erosion."""

import numpy as np
import pytest

from debrisflow.particles.arrays import ARRAYS
from debrisflow.particles.record import Kind
from debrisflow.results.deposition import deposit_columns, deposit_table, deposition
from debrisflow.results.frames import Frame
from tests.recording import cells, channel3d_case, channel_case, placed

D0 = 0.02
ROWS = 40  # of a heap
SLOPE = 0.25  # of its flanks


def frame_of(particles, time=0.0):
    """Return the frame that holds some particles."""
    arrays = {array.name: getattr(particles, array.name) for array in ARRAYS}
    return Frame(time, particles.position, arrays)


def measured(case, particles, before=None):
    """Return the deposition of some particles, since others were there if these are given."""
    first = None if before is None else deposition(case, frame_of(before))
    return deposition(case, frame_of(particles), first)


def below(position, height, up=1):
    """Return the positions whose cells lie under a height over x."""
    return position[position[:, up] < height(position[:, 0])]


def wedge(x, start, end):
    """Return a height that rises along x by SLOPE from a start to an end, 0 elsewhere."""
    return np.where((x > start) & (x < end), SLOPE * (x - start), 0.0)


def heap_height(x, middle=4.0):
    """Return the height of a symmetric heap ROWS spacings high."""
    return np.maximum(ROWS * D0 - SLOPE * np.abs(x - middle), 0.0)


@pytest.fixture(scope="module")
def heap():
    """Return deposition and number of particles of a heap on a horizontal floor."""
    case = channel_case(length=8.0)
    position = below(cells(case, range(400), range(ROWS)), heap_height)
    return measured(case, placed(case, position)), len(position)


def test_the_volume_of_a_heap_is_that_of_its_particles(heap):
    found, count = heap
    assert found.volume == pytest.approx(count * D0**2, rel=1e-12)
    assert found.volume == pytest.approx((ROWS * D0) ** 2 / SLOPE, rel=0.002)


def test_the_integral_of_the_height_of_a_heap_is_its_volume(heap):
    found, count = heap
    integral = found.table["deposit_height"] @ found.grid.area
    assert integral == pytest.approx(count * D0**2, rel=0.02)


def test_the_height_of_a_heap_is_its_outline_to_half_a_spacing_and_a_cells_rise(heap):
    found, _ = heap
    exact = heap_height(found.grid.x)
    # the higher of the two columns of a cell, cut to whole rows
    assert np.abs(found.table["deposit_height"] - exact).max() <= 0.5 * D0 + SLOPE * D0 / 2 + 1e-9


def test_the_area_of_a_heap_is_the_length_of_its_foot(heap):
    found, _ = heap
    # where it is thinner than half a spacing there is no particle, at either end
    foot = 2.0 * (ROWS - 0.5) * D0 / SLOPE
    assert found.area == pytest.approx(foot, abs=2 * 2 * D0)


def test_the_depths_of_grains_and_water_are_their_shares_of_the_matter(heap):
    found, _ = heap
    np.testing.assert_allclose(found.table["sediment_depth"], 0.4 * found.table["deposit_depth"])
    np.testing.assert_allclose(found.table["water_depth"], 0.6 * found.table["deposit_depth"])


def test_a_symmetric_heap_has_no_gradient_of_its_own(heap):
    found, _ = heap
    assert found.gradient(0.0) == pytest.approx(0.0, abs=0.01)
    assert found.gradient(np.radians(15.0)) == pytest.approx(15.0, abs=0.01)


@pytest.mark.parametrize("slope", [0.0, 3.0, 15.0])
@pytest.mark.parametrize("is_falling", [False, True])
def test_the_gradient_of_a_wedge_is_against_the_true_horizontal(slope, is_falling):
    case = channel_case(length=4.0, slope=slope)
    side = 1.0 if is_falling else -1.0

    def height(x):
        return 0.4 + 0.2 * side * (2.0 - x)

    position = below(cells(case, range(25, 175), range(50)), height)
    found = measured(case, placed(case, position))
    expected = slope + side * np.degrees(np.arctan(0.2))
    # steps of a spacing over 150 columns
    assert found.gradient(case.gravity.fall) == pytest.approx(expected, abs=0.1)


def test_a_surface_that_is_level_in_truth_has_no_gradient():
    case = channel_case(length=4.0, slope=10.0)
    level = np.tan(np.radians(10.0))
    position = below(cells(case, range(200), range(60)), lambda x: 0.3 + level * x)
    found = measured(case, placed(case, position))
    assert found.gradient(case.gravity.fall) == pytest.approx(0.0, abs=0.1)


RUN_OUT = {"runout_start": 1.0, "runout_slope": 4.0}  # which 16 degrees bend by 12


def on_the_run_out(position):
    """Return positions over a horizontal floor turned about the origin onto the run-out."""
    bend, along, up = np.radians(12.0), position[:, 0], position[:, 1]
    turned = np.zeros_like(position)
    turned[:, 0] = 1.0 + along * np.cos(bend) - up * np.sin(bend)
    turned[:, 1] = along * np.sin(bend) + up * np.cos(bend)
    return turned


def test_an_even_layer_on_a_run_out_falls_as_the_run_out_does():
    case = channel_case(length=4.0, slope=16.0, shape=RUN_OUT)
    found = measured(case, placed(case, on_the_run_out(cells(case, range(10, 200), range(5)))))
    inside = found.grid.x > 1.3
    assert found.table["deposit_height"][inside] == pytest.approx(5 * D0, abs=0.5 * D0)
    assert found.gradient(case.gravity.fall) == pytest.approx(4.0, abs=0.05)


def test_a_wedge_on_a_run_out_is_measured_in_full():
    case = channel_case(length=4.0, slope=16.0, shape=RUN_OUT)
    flat = below(cells(case, range(150), range(50)), lambda x: 0.9 - 0.3 * x)
    position = on_the_run_out(flat)
    position = position[position[:, 0] > 1.0]  # its upper end would lean back over the channel
    found = measured(case, placed(case, position))
    assert found.volume == pytest.approx(len(position) * D0**2)
    assert found.gradient(case.gravity.fall) == pytest.approx(4.0 + 16.70, abs=0.2)


def test_two_cells_with_a_deposit_have_no_gradient():
    case = channel_case()
    found = measured(case, placed(case, cells(case, range(4), range(3))))
    assert found.area == pytest.approx(4 * D0)
    assert np.isnan(found.gradient(0.0))


def test_no_deposit_is_nothing():
    case = channel_case()
    found = measured(case, placed(case, np.zeros((0, 3))))
    assert (found.area, found.volume, found.deposition, found.erosion) == (0.0, 0.0, 0.0, 0.0)
    assert np.isnan(found.gradient(0.0))


def test_a_ridge_in_three_dimensions_has_volume_area_and_gradient():
    case = channel3d_case(length=6.0, slope=12.0)
    d0 = case.particles.spacing

    def height(x):
        return np.where((x > 1.0) & (x < 5.0), 1.0 - 0.2 * (x - 1.0), 0.0)

    position = below(cells(case, range(120), range(8), range(20)), height, up=2)
    found = measured(case, placed(case, position))
    assert found.volume == pytest.approx(len(position) * d0**3, rel=1e-12)
    assert found.volume == pytest.approx(0.6 * 4.0 * 0.4, rel=0.01)
    integral = found.table["deposit_height"] @ found.grid.area
    assert integral == pytest.approx(found.volume, rel=0.02)
    assert found.area == pytest.approx(4.0 * 0.4)
    expected = 12.0 + np.degrees(np.arctan(0.2))
    assert found.gradient(case.gravity.fall) == pytest.approx(expected, abs=0.2)


def test_a_slope_across_is_no_gradient_along():
    case = channel3d_case(length=2.0, width=2.0)
    position = cells(case, range(40), range(40), range(24))
    position = position[position[:, 2] < 0.2 + 0.4 * position[:, 1]]
    found = measured(case, placed(case, position))
    assert found.gradient(0.0) == pytest.approx(0.0, abs=1e-9)
    assert found.volume == pytest.approx(2.0 * 2.0 * 0.6, rel=0.01)


def test_a_pile_beside_the_middle_has_the_area_of_its_foot():
    case = channel3d_case()
    d0 = case.particles.spacing
    found = measured(case, placed(case, cells(case, range(40, 46), range(2, 6), range(5))))
    assert found.area == pytest.approx(6 * 4 * d0**2)
    assert found.volume == pytest.approx(6 * 4 * 5 * d0**3)
    assert found.sediment_volume == pytest.approx(0.4 * 6 * 4 * 5 * d0**3)
    here = found.table["deposit_height"] > 0.0
    np.testing.assert_allclose(found.grid.x[here].min(), 41 * d0)
    np.testing.assert_allclose(np.unique(found.grid.y[here]), [3 * d0, 5 * d0])


BED = {"bed_start": 1.0, "bed_end": 3.0, "bed_thickness": 0.4}


@pytest.fixture(scope="module")
def bed():
    """Return a case with a bed 20 spacings thick from x = 1 to 3 m, and its particles."""
    fill = [{"type": "bed", "material": "sediment"}]
    case = channel_case(length=4.0, shape=BED, fill=fill)
    return case, cells(case, range(50, 150), range(-20, 0))


def test_a_whole_bed_is_neither_eroded_nor_deposited(bed):
    case, position = bed
    whole = placed(case, position, Kind.SEDIMENT)
    found = measured(case, whole, before=whole)
    np.testing.assert_allclose(found.table["bed_change"], 0.0, atol=1e-12)
    assert (found.erosion, found.deposition) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert found.volume == pytest.approx(2.0 * 0.4)


def test_what_is_cut_out_of_a_bed_is_eroded_and_what_lies_elsewhere_is_deposited(bed):
    case, whole = bed
    left = whole[whole[:, 1] < -wedge(whole[:, 0], 1.0, 2.2)]
    heap = cells(case, range(160, 190), range(6))
    after = placed(case, np.vstack([left, heap]), Kind.SEDIMENT)
    found = measured(case, after, before=placed(case, whole, Kind.SEDIMENT))
    pores = 1.0 / case.sediment.packing_limit  # their grains, and the pores of a packed bed
    gone = (len(whole) - len(left)) * D0**2
    assert gone == pytest.approx(0.5 * 1.2 * SLOPE * 1.2, rel=0.02)
    assert found.erosion == pytest.approx(pores * gone, rel=0.02)
    assert found.deposition == pytest.approx(pores * 30 * 6 * D0**2)
    assert found.volume == pytest.approx((len(left) + len(heap)) * D0**2)


def test_what_moves_is_no_deposit_but_matter(bed):
    case, whole = bed
    velocity = np.where(whole[:, 1] > -0.2, 1.0, 0.0)
    moving = placed(case, whole, Kind.SEDIMENT, velocity)
    found = measured(case, moving, before=placed(case, whole, Kind.SEDIMENT))
    assert found.volume == pytest.approx(2.0 * 0.2)
    assert (found.erosion, found.deposition) == (0.0, 0.0)
    assert found.table["sediment_depth"] @ found.grid.area == pytest.approx(2.0 * 0.4)


def test_water_at_rest_is_no_deposit():
    case = channel_case()
    found = measured(case, placed(case, cells(case, range(50), range(5)), Kind.LIQUID))
    assert found.volume == 0.0
    assert found.table["water_depth"] @ found.grid.area == pytest.approx(50 * 5 * D0**2)
    assert found.table["flow_height"].max() == pytest.approx(5 * D0)


@pytest.mark.parametrize("build", [channel_case, channel3d_case])
def test_several_times_are_one_table_after_another(build):
    case = build()
    found = [deposition(case, frame_of(placed(case, np.zeros((0, 3))), t)) for t in (0.0, 0.5)]
    table = deposit_table(case, found)
    assert tuple(table) == deposit_columns(case.dimension)
    count = found[0].grid.x.size
    np.testing.assert_array_equal(table["time"], np.repeat([0.0, 0.5], count))
    np.testing.assert_array_equal(table["x"], np.tile(found[0].grid.x, 2))
