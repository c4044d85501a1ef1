"""Which comparisons are asked for, and what there is to ask for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from debrisflow.case.words import did_you_mean
from debrisflow.errors import CaseError
from debrisflow.run.duration import duration
from debrisflow.validation.comparison import Comparison, Group
from debrisflow.validation.register import COMPARISONS


def key_of(group: Group) -> str:
    """Return the name of a group on the command line.

    Examples
    --------
    >>> key_of(Group.VISCOUS)
    'viscous_flows'
    """
    return group.value.lower().replace(" ", "_")


def chosen(names: Sequence[str]) -> list[Comparison]:
    """Return the comparisons of some names, of themselves or of groups; all of none.

    Raises
    ------
    CaseError
        If a name is not known.
    """
    groups = {key_of(group): group for group in Group}
    wanted = []
    for name in names:
        if name not in COMPARISONS and name not in groups:
            hint = did_you_mean(name, [*COMPARISONS, *groups])
            raise CaseError(
                f"no comparison '{name}'{hint}; debrisflow validate --list says what there is"
            )
        wanted += [
            one.name
            for one in COMPARISONS.values()
            if one.name == name or one.group is groups.get(name)
        ]
    return [one for one in COMPARISONS.values() if one.name in wanted or not names]


def seconds_of(comparison: Comparison, is_quick: bool) -> float:
    """Return about how long the levels of a comparison take on one core, s."""
    return sum(level.seconds for level in comparison.levels if level.is_quick or not is_quick)


def listed_lines(comparisons: Sequence[Comparison]) -> Iterator[str]:
    """Yield the comparisons by groups, with their times on one core."""
    wide = max(len(one.name) for one in comparisons)
    yield f"{'':{wide}}    quick      all  time on one core, without compilation"
    for group, members in groupby(comparisons, lambda one: one.group):
        yield f"{group.value} ({key_of(group)})"
        for one in members:
            quick, whole = (seconds_of(one, is_quick) for is_quick in (True, False))
            times = f"{duration(quick) if quick else '-':>8} {duration(whole):>8}"
            yield f"  {one.name:{wide}} {times}  {one.title}"
    quick, whole = (sum(seconds_of(o, is_q) for o in comparisons) for is_q in (True, False))
    yield f"  {'all':{wide}} {duration(quick) if quick else '-':>8} {duration(whole):>8}"


def listed_values(comparisons: Sequence[Comparison]) -> list[dict[str, Any]]:
    """Return the same as values for another program."""
    return [
        {
            "name": one.name,
            "title": one.title,
            "group": key_of(one.group),
            "reference": one.reference,
            "seconds": seconds_of(one, is_quick=False),
            "quick_seconds": seconds_of(one, is_quick=True),
        }
        for one in comparisons
    ]
