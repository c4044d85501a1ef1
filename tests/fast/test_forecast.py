"""What a case will run, told before it runs."""

import pytest

from debrisflow.run.forecast import forecast
from tests.building import tank3d_case, tank_case
from tests.recording import channel_case


def test_a_slow_speed_of_sound_is_warned_of():
    told = forecast(tank3d_case(scheme={"sound_speed": 10.0}))
    speed = (2 * 9.81 * 0.5) ** 0.5
    assert told.sound.ratio == pytest.approx(10.0 / speed)
    assert told.sound.compression == pytest.approx(9.81 * 0.5 / 10.0**2)
    assert "warning        c/u = 3.19: below 10, the flow is compressible" in str(told)
    assert "scheme.sound_speed = 31.3 m/s would do" in str(told)


def test_another_influence_radius_is_warned_of():
    told = str(forecast(tank3d_case(particles={"effective_radius": 2.1})))
    assert (
        "warning        effective_radius = 2.1: water at rest keeps its height at 2.4 only" in told
    )


def test_the_speed_of_sound_follows_the_fall_to_the_floor():
    told = forecast(tank3d_case(z=(0.5, 0.8)))
    assert told.largest_speed == pytest.approx((2 * 9.81 * 0.8) ** 0.5)
    assert told.sound.ratio == pytest.approx(10.0)


def test_ten_times_the_speed_of_a_fall_is_fast_enough():
    told = forecast(tank3d_case())
    assert told.sound.ratio == pytest.approx(10.0)
    assert "warning" not in str(told)


def test_the_incompressible_scheme_has_no_speed_of_sound():
    told = forecast(tank_case(20, 10, "water"))
    assert told.sound is None
    assert "c/u            none" in str(told)


def test_sound_limits_the_step():
    told = forecast(tank3d_case(scheme={"sound_speed": 40.0, "courant": 0.8}))
    assert told.first_step == told.smallest_step == pytest.approx(0.8 * 0.1 / 40.0)


def test_a_fast_fill_shortens_the_step():
    block = {"type": "block", "x": [0, 0.8], "y": [0, 0.6], "z": [0, 0.5], "material": "water"}
    case = tank3d_case(fill=[block | {"velocity": [20.0, 0.0, 0.0]}], scheme={"sound_speed": 20.0})
    told = forecast(case)
    assert told.first_step == pytest.approx(0.2 * 0.1 / 20.0)
    assert told.smallest_step < told.first_step


def test_the_estimate_of_three_dimensions_is_near_the_count():
    from debrisflow.case.estimate import particle_estimate

    pier = {"type": "box", "name": "pier", "x": [1.0, 1.4], "y": [0.4, 0.8], "z": [0.0, 0.6]}
    block = {"type": "block", "x": [0, 0.8], "y": [0, 1.2], "z": [0, 0.5], "material": "water"}
    case = tank3d_case(size=(1.6, 1.2, 1.0), fill=[block], obstacle=[pier])
    counted = sum(forecast(case).counts.values())
    assert particle_estimate(case)["total"] == pytest.approx(counted, rel=0.05)


def test_a_patch_smaller_than_a_spacing_is_warned_of():
    gauge = {"type": "pressure", "wall": "right", "x": 0.8, "y": 0.3, "z": 0.2, "interval": 0.1}
    sizes = {"wide": 0.1, "small": 0.09, "tiny": 0.02}
    probes = [gauge | {"name": name, "size": size} for name, size in sizes.items()]
    told = str(forecast(tank3d_case(probe=probes)))
    assert "warning        small, tiny: patch smaller than a spacing" in told
    assert "warning" not in str(forecast(tank3d_case(probe=probes[:1])))


def test_the_rows_over_the_depths_are_told():
    case = channel_case(inflow={"depth": 0.04, "velocity": 1.0})
    found = forecast(case)
    assert found.rows == {"fill.0": 5, "inflow": 2}
    assert "rows           over depths, fill.0: 5, inflow: 2" in str(found)
