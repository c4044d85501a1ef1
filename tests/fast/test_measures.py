"""Fronts, deposit and flow height, energy: on particles placed by hand."""

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.particles.maxima import is_reached
from debrisflow.particles.record import Kind
from debrisflow.run.measures import deposit_profile, energies, flow_height, fronts, whole_depth
from debrisflow.space.gravity import gravity_vector

D0 = 0.01
N0 = 19.0


def channel(slope=0.0, vector=None, **shape):
    """Return a channel 1 m long with a recess 0.1 m deep between 0.2 and 0.8 m."""
    shape = {"bed_start": 0.2, "bed_end": 0.8, "bed_thickness": 0.1} | shape
    gravity = {"acceleration": 10.0, "slope": slope, "vector": vector}
    return complete(
        Case(
            title="channel",
            particles={"spacing": D0},
            gravity=gravity,
            geometry={"type": "channel", "length": 1.0, "height": 0.5, **shape},
            fill=[{"type": "block", "x": [0, 0.1], "y": [0, 0.1], "material": "water"}],
            mixture={"concentration": 0.4},
            time={"end": 1.0},
            output={"interval": 0.1},
        )
    )


class Pile:
    """Particles at rest on the lattice of some columns of cells, all of one kind."""

    def __init__(self, columns, rows, kind=Kind.SEDIMENT, concentration=0.5):
        i, j = (c.ravel() for c in np.meshgrid(columns, rows, indexing="ij"))
        self.position = np.column_stack([(i + 0.5) * D0, (j + 0.5) * D0, 0.0 * i])
        self.velocity = np.zeros_like(self.position)
        self.kind = np.full(i.size, kind, dtype=np.int8)
        self.concentration = np.full(i.size, concentration)
        self.number_density = np.full(i.size, N0)

    def row(self, j):
        """Return which particles stand in a row."""
        return np.isclose(self.position[:, 1], (j + 0.5) * D0)

    def column(self, i):
        """Return which particles stand in a column."""
        return np.isclose(self.position[:, 0], (i + 0.5) * D0)

    def profile(self, case=None, at=0):
        """Return deposit height, flow height and concentration of one bin."""
        profile = deposit_profile(
            case or channel(),
            self.position,
            self.velocity,
            self.kind,
            self.concentration,
            np.array([0.0, 1.0, 0.4, 0.0, 0.0, 0.0])[self.kind],
            self.number_density,
            N0,
        )
        return tuple(float(column[at]) for column in profile[2:])


def test_bins_cover_the_length_in_steps_of_two_spacings():
    x = deposit_profile(channel(), *[np.zeros((0, 3))] * 2, *[np.zeros(0, dtype=int)] * 4, N0).x
    np.testing.assert_allclose(x, np.arange(0.01, 1.0, 0.02))


def test_an_odd_number_of_spacings_leaves_a_last_bin_of_one():
    case = channel(length=0.11, bed_start=0.0, bed_end=0.11, bed_thickness=0.0)
    assert Pile([10], range(3)).profile(case, at=5)[:2] == pytest.approx((0.03, 0.03))


def test_a_heap_is_as_high_as_its_rows():
    assert Pile([0, 1], range(5)).profile() == pytest.approx((0.05, 0.05, 1.0))


def test_an_empty_bin_has_no_height_and_no_concentration():
    assert Pile([0, 1], range(5)).profile(at=1) == pytest.approx((0.0, 0.0, np.nan), nan_ok=True)


def test_heights_stand_on_the_bottom_of_the_recess():
    assert Pile([30, 31], range(-10, 3)).profile(at=15)[:2] == pytest.approx((0.13, 0.13))


def test_water_over_a_deposit_is_flow_but_no_deposit():
    pile = Pile([0, 1], range(6))
    pile.concentration[pile.position[:, 1] > 0.03] = 0.29
    pile.kind[pile.position[:, 1] > 0.03] = Kind.LIQUID
    assert pile.profile() == pytest.approx((0.03, 0.06, 0.5))


def test_what_moves_at_the_rest_speed_is_no_deposit():
    pile = Pile([0, 1], range(6))
    pile.velocity[pile.position[:, 1] > 0.03, 0] = 0.05
    pile.velocity[pile.position[:, 1] < 0.03, 0] = 0.049
    assert pile.profile()[0] == pytest.approx(0.03)


def test_a_mixture_is_deposited_at_any_concentration():
    mixture = Pile([0, 1], range(4), Kind.MIXTURE, concentration=0.1)
    assert mixture.profile() == pytest.approx((0.04, 0.04, 0.4))


def test_a_layer_that_flows_ends_the_deposit():
    pile = Pile([0, 1], range(6))
    pile.velocity[pile.row(3), 0] = 1.0
    assert pile.profile()[0] == pytest.approx(0.03)


def test_one_particle_that_flows_does_not_end_the_deposit():
    pile = Pile([0, 1], range(6))
    pile.velocity[pile.row(3) & pile.column(1), 0] = 1.0
    assert pile.profile()[0] == pytest.approx(0.06)


def test_what_hangs_above_a_gap_is_no_deposit():
    assert Pile([0, 1], [2, 3]).profile()[:2] == pytest.approx((0.0, 0.02))


def test_disorder_within_half_a_spacing_does_not_break_a_heap():
    pile = Pile([0, 1], range(8))
    pile.position[:, 1] += np.random.default_rng(1).uniform(-0.2, 0.2, pile.kind.size) * D0
    assert pile.profile()[0] == pytest.approx(pile.position[:, 1].max() + D0 / 2)


def test_a_drop_is_no_flow():
    pile = Pile([0, 1], [0, 1, 7])
    pile.number_density[pile.row(7)] = 0.49 * N0
    pile.kind[pile.row(7)] = Kind.LIQUID
    assert pile.profile() == pytest.approx((0.02, 0.02, 1.0))


@pytest.mark.parametrize("row", [4, 7, 40])
def test_spray_does_not_make_a_flow_deeper(row):
    pile = Pile([0, 1], [0, 1, row])
    pile.kind[:] = Kind.LIQUID
    pile.kind[pile.row(row)] = Kind.MIXTURE
    assert pile.profile()[1:] == pytest.approx((0.02, 0.0))


def test_what_flies_over_a_dry_floor_is_as_deep_as_it_is_thick():
    pile = Pile([0, 1], [10, 11, 12, 30])
    assert pile.profile()[1:] == pytest.approx((0.03, 1.0))


def test_walls_and_waiting_supply_are_no_deposit():
    for kind in (Kind.WALL, Kind.DUMMY, Kind.INFLOW):
        assert Pile([0, 1], range(3), kind).profile()[:2] == (0.0, 0.0)


def test_a_periodic_channel_takes_in_what_left_its_length():
    case = channel(periodic=True, bed_start=0.0, bed_end=1.0, bed_thickness=0.0)
    pile = Pile([100, 101], range(3))
    assert pile.profile(case)[0] == pytest.approx(0.03)


def test_front_leaves_half_a_percent_of_the_flow_ahead():
    x = np.arange(1000) * 1e-3
    velocity = np.tile([1.0, 0.0, 0.0], (1000, 1))
    position = np.column_stack([x[::-1], 0.0 * x, 0.0 * x])
    front = fronts(channel(), position, velocity, np.full(1000, Kind.LIQUID))
    assert front["all"] == front["liquid"] == x[994]


def test_fronts_are_those_of_what_flows_by_phase():
    position = np.array([[0.1, 0, 0], [0.2, 0, 0], [0.3, 0, 0], [0.4, 0, 0], [0.5, 0, 0]])
    velocity = np.zeros((5, 3))
    velocity[[0, 1], 1] = -1.0
    velocity[4, 0] = 1.0
    kind = np.array([Kind.LIQUID, Kind.SEDIMENT, Kind.SEDIMENT, Kind.MIXTURE, Kind.INFLOW])
    front = fronts(channel(), position, velocity, kind)
    expected = {"liquid": 0.1, "sediment": 0.2, "mixture": np.nan, "all": 0.2}
    assert front == pytest.approx(expected, nan_ok=True)


def bed_with_a_wave(columns):
    """Return a wet bed that moves everywhere, on which a wave has come up to some columns."""
    bed, wave = Pile(range(100), range(5), Kind.LIQUID), Pile(columns, range(5, 8), Kind.LIQUID)
    position = np.vstack([bed.position, wave.position])
    return position, np.tile([0.2, 0.0, 0.0], (len(position), 1)), np.full(len(position), 0)


def test_water_that_was_there_is_behind_the_front_until_it_rises():
    case = channel(bed_start=0.0, bed_end=1.0, bed_thickness=0.0)
    first = Pile(range(100), range(5), Kind.LIQUID)
    start, rested = whole_depth(case, first.position, first.velocity, first.kind)
    assert rested.all()
    for columns, front in ((range(0), np.nan), (range(30), 0.295)):
        position, velocity, kind = bed_with_a_wave(columns)
        depth = flow_height(case, position, kind, np.full(kind.size, N0), N0)
        reached = is_reached(depth, start, rested, D0)
        found = fronts(case, position, velocity, kind, reached, share=1.0)
        assert found["all"] == pytest.approx(front, nan_ok=True)
        assert fronts(case, position, velocity, kind)["all"] > 0.9


def test_a_front_over_a_dry_floor_is_the_same_wherever_its_source_stood():
    case = channel(bed_start=0.0, bed_end=1.0, bed_thickness=0.0)
    pile = Pile(range(60), range(10), Kind.LIQUID)
    velocity = np.tile([1.0, 0.0, 0.0], (600, 1))
    reached = np.arange(50) >= 20  # half of the flow is still where it stood
    for given in (None, reached):
        found = fronts(case, pile.position, velocity, pile.kind, given)
        assert found["all"] == pytest.approx(0.595)


def test_gravity_of_a_slope_keeps_its_magnitude_and_runs_down_the_channel():
    g = gravity_vector(channel(slope=15.0))
    assert np.linalg.norm(g) == pytest.approx(10.0)
    assert g[0] / -g[1] == pytest.approx(np.tan(np.radians(15.0)))
    assert g[0] > 0.0


def test_a_gravity_vector_stands_for_itself():
    np.testing.assert_array_equal(gravity_vector(channel(vector=(1.0, -2.0))), [1.0, -2.0, 0.0])


def test_energy_of_a_falling_particle_is_conserved():
    case, t = channel(slope=15.0), 0.3
    g, u0 = gravity_vector(case), np.array([[1.0, 2.0, 0.0]])
    kind, density = np.array([Kind.SEDIMENT]), np.array([2650.0])
    start = energies(case, np.zeros((1, 3)), u0, density, kind)
    end = energies(case, u0 * t + 0.5 * g * t**2, u0 + g * t, density, kind)
    assert start == pytest.approx((0.5 * 2650.0 * D0**2 * 5.0, 0.0))
    assert sum(end) == pytest.approx(sum(start))
