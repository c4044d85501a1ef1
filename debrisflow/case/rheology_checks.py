"""Checks of the rheological law: numbers that contradict each other, and a dry mass."""

from __future__ import annotations

from collections.abc import Callable

from debrisflow.case.problems import Problem, Problems
from debrisflow.case.rheology import FrictionalStrength, Rheology
from debrisflow.case.tables import AnyFill, Inflow

Fill = tuple[AnyFill, ...]


def law_agrees(rheology: Rheology) -> Problems:
    """Check that the numbers of a law do not contradict each other."""
    for name, message in rheology.contradictions():
        yield Problem(f"rheology.{name}", message, getattr(rheology, name))


def dry_mass(rheology: Rheology, fill: Fill, inflow: Inflow | None) -> Problems:
    """Check that no water is filled or supplied beside a dry mass."""
    if not isinstance(rheology, FrictionalStrength) or rheology.saturated:
        return
    if any(part.material != "mixture" for part in fill) or inflow is not None:
        message = "a dry mass has no water in it; fill with 'mixture' only, without an inflow"
        yield Problem("rheology.saturated", message, rheology.saturated)


CHECKS: tuple[Callable[..., Problems], ...] = (law_agrees, dry_mass)
