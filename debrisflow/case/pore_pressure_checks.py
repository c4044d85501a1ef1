"""Checks of the pore pressure of fills."""

from __future__ import annotations

from collections.abc import Callable

from debrisflow.case.friction import CoulombFriction, VoellmyFriction
from debrisflow.case.problems import Problem, Problems, was_set
from debrisflow.case.rheology import FrictionalStrength, Rheology
from debrisflow.case.shapes import Geometry, is_three_dimensional
from debrisflow.case.tables import AnyFill, Walls

Fill = tuple[AnyFill, ...]


def pore_pressure_of_fills(
    fill: Fill, geometry: Geometry, walls: Walls, rheology: Rheology
) -> Problems:
    """Check that a fill with a pore pressure has grains, and friction that it reduces."""
    has_friction = isinstance(rheology, FrictionalStrength) or any(
        isinstance(wall.friction, CoulombFriction | VoellmyFriction) for _, wall in walls
    )
    for k, part in enumerate(fill):
        key = f"fill.{k}.pore_pressure"
        if part.pore_pressure == 0.0:
            if was_set(part, "pore_pressure_time"):
                message = f"has no effect without a share to begin with; give {key} as well"
                yield Problem(f"{key}_time", message, part.pore_pressure_time)
            continue
        if not is_three_dimensional(geometry):
            message = "exists only in three dimensions; leave it out"
        elif part.material == "water":
            message = "has no effect on water, which has no grains; fill with 'mixture'"
        elif not has_friction:
            message = (
                "has no effect: there is no friction; give a wall the friction 'coulomb' or "
                "'voellmy', or rheology.type = 'coulomb' or 'mu-i'"
            )
        else:
            continue
        yield Problem(key, message, part.pore_pressure)


CHECKS: tuple[Callable[..., Problems], ...] = (pore_pressure_of_fills,)
