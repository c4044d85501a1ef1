"""What a mistyped key suggests: a key that is near, in its table or in another, or nothing."""

import pytest

from debrisflow import load_case
from debrisflow.errors import CaseError

FLUME, TANK = "cases/flume2d.toml", "cases/column_collapse2d.toml"


def told(case: str, override: str) -> str:
    with pytest.raises(CaseError) as caught:
        load_case(case, [override])
    _, line = str(caught.value).splitlines()
    return line.partition("unknown key")[2]


@pytest.mark.parametrize(
    ("override", "suggested"),
    [
        ("water.viscocity=1", "'viscosity'"),
        ("gravity.slop=15", "'slope'"),
        ("time.ende=2", "'end'"),
        ("geometry.lngth=1", "'length'"),
        ("geometry.heght=1", "'height'"),
        ("inflow.dept=0.1", "'depth'"),
        ("sediment.grain_size=0.003", "'grain_diameter'"),
        ("rheology.friction=30", "'friction_angle'"),
        ("gravty.slope=3", "'gravity'"),
        ("rheology.yield_stres=30", "'rheology.yield_stress'"),
        ("viscocity=1", "'water.viscosity', 'sediment.viscosity' or 'mixture.viscosity'"),
        ("density=1000", "'water.density' or 'sediment.density'"),
        ("slop=15", "'gravity.slope'"),
        ("depth=0.3", "'inflow.depth'"),
        ("geometry.slope=15", "'gravity.slope'"),
        ("collision_stress.restitution=0.5", "'sediment.restitution'"),
    ],
)
def test_a_key_that_is_near_is_suggested(override: str, suggested: str) -> None:
    assert told(FLUME, override) == f"; did you mean {suggested}?"


@pytest.mark.parametrize(
    "override",
    [
        "foo=1",
        "x=1",
        "water.color=1",
        "time.duration=3",
        "time.bed=3",  # not end
        "inlet.depth=3",  # not title
        "outlet.x=3",  # not output
        "gravity.stop=3",  # not slope
        "walls.floor.solid=3",  # not slip
        "turbulence.model=1",  # a table, and no word of a law of friction
        "slip=free-slip",  # of seven walls
    ],
)
def test_nothing_is_suggested_where_nothing_is_near(override: str) -> None:
    assert told(FLUME, override) == ""


def test_a_table_that_the_case_does_not_have_is_not_suggested() -> None:
    assert told(TANK, "depth=0.3") == ""
