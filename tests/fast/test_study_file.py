"""The file of a study: what is said of a wrong one."""

import pytest

from debrisflow.errors import CaseError
from debrisflow.study.loading import load_study

HEAD = """\
title = "a study"
case = "case.toml"
design = { type = "grid" }

[[parameter]]
name = "friction"
"""
UNIFORM = 'distribution = "uniform"\nlow = 0.1\nhigh = 0.2\n'


def refused(tmp_path, text):
    """Return the lines that are said of a study, without the head."""
    (tmp_path / "case.toml").touch()
    path = tmp_path / "study.toml"
    path.write_text(HEAD + text)
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


def test_bounds_that_are_not_in_order_are_named_with_their_value(tmp_path):
    law = 'key = "a"\ndistribution = "triangular"\nlow = 0.2\nlikely = 0.4\nhigh = 0.3\n'
    assert refused(tmp_path, law) == [
        "parameter.friction.likely = 0.4: must lie from low to high, 0.2 to 0.3"
    ]
