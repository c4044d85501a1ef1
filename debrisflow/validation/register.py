"""All comparisons, in the order in which they are listed."""

from __future__ import annotations

from debrisflow.validation.at_rest import still_water, tilted_tank
from debrisflow.validation.comparison import Comparison, Group
from debrisflow.validation.viscous import start_up

_MODULES = (still_water, tilted_tank, start_up)


def _by_name() -> dict[str, Comparison]:
    found = [comparison for module in _MODULES for comparison in module.COMPARISONS]
    order = list(Group)
    found.sort(key=lambda comparison: order.index(comparison.group))  # stable within a group
    return {comparison.name: comparison for comparison in found}


COMPARISONS = _by_name()
"""By name."""
