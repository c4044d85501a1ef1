"""Checks of the law of strength: numbers that contradict each other, and a dry mass."""

from __future__ import annotations

from collections.abc import Callable

from debrisflow.case.problems import Problem, Problems
from debrisflow.case.rheology import FrictionalStrength, Strength
from debrisflow.case.tables import AnyFill, Inflow

Fill = tuple[AnyFill, ...]


def law_agrees(strength: Strength) -> Problems:
    """Check that the numbers of a law do not contradict each other."""
    for name, message in strength.contradictions():
        yield Problem(f"strength.{name}", message, getattr(strength, name))


def dry_mass(strength: Strength, fill: Fill, inflow: Inflow | None) -> Problems:
    """Check that no water is filled or supplied beside a dry mass."""
    if not isinstance(strength, FrictionalStrength) or strength.saturated:
        return
    if any(part.material != "mixture" for part in fill) or inflow is not None:
        message = "a dry mass has no water in it; fill with 'mixture' only, without an inflow"
        yield Problem("strength.saturated", message, strength.saturated)


CHECKS: tuple[Callable[..., Problems], ...] = (law_agrees, dry_mass)
