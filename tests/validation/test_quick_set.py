"""Is the physics right: the quick set of ``debrisflow validate``, level by level."""

from __future__ import annotations

import pytest

from debrisflow.validation.register import COMPARISONS
from debrisflow.validation.row import Verdict
from debrisflow.validation.runner import Task, computed, tasks_of

QUICK = tasks_of(list(COMPARISONS.values()), is_quick=True)


@pytest.mark.parametrize("task", QUICK, ids=lambda task: f"{task.name}, {task.label}")
def test_a_flow_is_within_its_limits_or_missed_for_a_known_reason(task: Task) -> None:
    found = computed(task)
    assert not found.failure
    assert found.rows
    unexplained = [row for row in found.rows if row.verdict is Verdict.MISSED]
    assert not unexplained
    # a miss that is none any more is to be struck from the list
    mended = [row for row in found.rows if row.miss and row.is_certain and row.is_within]
    assert not mended
