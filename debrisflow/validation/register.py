"""All comparisons, in the order in which they are listed."""

from __future__ import annotations

from debrisflow.validation.comparison import Comparison, Group
from debrisflow.validation.dam_breaks import (
    check_dam,
    dam_break,
    dam_break3d,
    jet_on_dam,
    koshizuka_oka,
    moving_walls,
    plate_jet,
    spheric,
    still_dam,
    wet_bed,
    zhou,
)
from debrisflow.validation.viscous import start_up

_MODULES = (
    start_up,
    dam_break,
    dam_break3d,
    koshizuka_oka,
    wet_bed,
    zhou,
    spheric,
    plate_jet,
    jet_on_dam,
    still_dam,
    check_dam,
    moving_walls,
)


def _by_name() -> dict[str, Comparison]:
    found = [comparison for module in _MODULES for comparison in module.COMPARISONS]
    order = list(Group)
    found.sort(key=lambda comparison: order.index(comparison.group))  # stable within a group
    return {comparison.name: comparison for comparison in found}


COMPARISONS = _by_name()
"""By name."""
