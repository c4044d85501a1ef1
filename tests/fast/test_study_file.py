"""The file of a study: what is said of a wrong one."""

import pytest

from debrisflow.errors import CaseError
from debrisflow.study.loading import load_study
from debrisflow.study.places import expect_apart
from debrisflow.study.tables import Study

HEAD = """\
title = "a study"
case = "case.toml"
design = { type = "grid" }

[[parameter]]
name = "friction"
"""
UNIFORM = 'distribution = "uniform"\nlow = 0.1\nhigh = 0.2\n'


def refused(tmp_path, text, head=HEAD):
    """Return the lines that are said of a study, without the head."""
    (tmp_path / "case.toml").touch()
    path = tmp_path / "study.toml"
    path.write_text(head + text)
    with pytest.raises(CaseError) as caught:
        load_study(path)
    return [line.strip() for line in str(caught.value).splitlines()[1:]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('values = [0.1, "a"]', 'values.1 = "a": must be a number, or all must be text'),
        ('values = ["a", 1]', 'values.0 = "a": must be a number, or all must be text'),
        ("values = [0.1, nan]", "values.1 = nan: must be a finite number"),
        ("values = 3", "values = 3: must be a list of numbers, or a list of texts"),
        ("values = []", "values = []: must have at least 1 entries"),
    ],
)
def test_a_wrong_list_of_values_is_one_fault_with_its_key(tmp_path, text, message):
    known = 'key = "a"\ndistribution = "values"\n'
    assert refused(tmp_path, known + text) == [f"parameter.friction.{message}"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("key = 3", "key = 3: must be text in quotes, or a list of texts"),
        ('key = ["a", 2]', "key.1 = 2: must be text in quotes"),
    ],
)
def test_a_wrong_key_is_one_fault(tmp_path, text, message):
    assert refused(tmp_path, f"{text}\n{UNIFORM}") == [f"parameter.friction.{message}"]


def test_levels_of_morris_must_be_even(tmp_path):
    text = f'key = "a"\n{UNIFORM}'
    head = HEAD.replace('{ type = "grid" }', '{ type = "morris", paths = 4, levels = 5 }')
    assert refused(tmp_path, text, head) == ["design.levels = 5: must be a multiple of 2"]


def test_bounds_that_are_not_in_order_are_named_with_their_value(tmp_path):
    law = 'key = "a"\ndistribution = "triangular"\nlow = 0.2\nlikely = 0.4\nhigh = 0.3\n'
    assert refused(tmp_path, law) == [
        "parameter.friction.likely = 0.4: must lie from low to high, 0.2 to 0.3"
    ]


COMPLETE = {
    "geometry": {"type": "tank"},
    "release": [
        {"name": "torrent", "hydrograph": {"time": [0.0, 9.0], "discharge": [1.0, 2.0]}},
        {"name": "gully", "volume": 5.0},
    ],
    "rheology": {"type": "bingham", "yield_stress": 9.0},
}


def study_of(first, second, changes=None, is_factor=False):
    """Return a study of two parameters with the given keys."""
    law = {"distribution": "uniform", "low": 0.1, "high": 0.2, "is_factor": is_factor}
    return Study(
        title="a study",
        case="case.toml",
        parameter=[law | {"name": "one", "key": first}, law | {"name": "two", "key": second}],
        design={"type": "grid"},
        set=changes or {},
    )


@pytest.mark.parametrize(
    ("first", "second", "message"),
    [
        (
            "release.gully.volume",
            "release.1.volume",
            "\"release.1.volume\": 'one' sets it too, as release.gully.volume; leave one out",
        ),
        (
            "release.0.hydrograph.discharge",
            "release.torrent.hydrograph",
            "\"release.torrent.hydrograph\": holds release.0.hydrograph.discharge, which 'one' "
            "sets; leave one out",
        ),
        (
            ["rheology.type", "release.0"],
            "release.torrent.hydrograph",
            "\"release.torrent.hydrograph\": is a part of release.0, which 'one' sets; leave one "
            "out",
        ),
        (
            "rheology.yield_stress",
            "strength.yield_stress",
            "\"strength.yield_stress\": 'one' sets it too, as rheology.yield_stress; leave one out",
        ),
    ],
)
def test_a_place_of_the_case_has_one_parameter(first, second, message):
    with pytest.raises(CaseError) as caught:
        expect_apart(study_of(first, second), COMPLETE)
    assert str(caught.value) == f"parameter.two.key = {message}"


def test_places_beside_each_other_are_apart():
    first, second = "release.torrent.hydrograph.time", "release.0.hydrograph.discharge"
    assert expect_apart(study_of(first, second), COMPLETE) is None
    assert expect_apart(study_of("release.0.volume", "release.1.volume"), COMPLETE) is None
    assert expect_apart(study_of("rheology.yield_stress", "rheology.yield"), COMPLETE) is None


def test_a_change_is_a_start_but_not_within_what_a_parameter_sets():
    keys = "release.torrent.hydrograph", "rheology.yield_stress"
    start = {"rheology": {"yield_stress": 4.0}, "release.torrent.hydrograph": "a.csv"}
    assert expect_apart(study_of(*keys, start), COMPLETE) is None
    within = {"release": {"0": {"hydrograph": {"discharge": [1.0, 3.0]}}}}
    with pytest.raises(CaseError) as caught:
        expect_apart(study_of(*keys, within), COMPLETE)
    assert str(caught.value) == (
        'parameter.one.key = "release.torrent.hydrograph": holds release.0.hydrograph.discharge, '
        "which [set] changes; leave one out"
    )
    entry = {"release.torrent.hydrograph.discharge.1": 3.0}
    keys = "release.0.hydrograph.discharge", "rheology.yield_stress"
    assert expect_apart(study_of(*keys, entry, is_factor=True), COMPLETE) is None
