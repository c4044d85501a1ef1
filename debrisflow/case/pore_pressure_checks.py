"""Checks of the pore pressure of fills."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from debrisflow.case.friction import CoulombFriction, VoellmyFriction
from debrisflow.case.problems import Problem, Problems
from debrisflow.case.releases import AnyRelease, HydrographRelease, Zone
from debrisflow.case.rheology import FrictionalStrength, Rheology
from debrisflow.case.shapes import Geometry, is_three_dimensional
from debrisflow.case.tables import AnyFill, Walls

Fill = tuple[AnyFill, ...]
Releases = tuple[AnyRelease, ...]
Zones = tuple[Zone, ...]


def pore_pressure_of_fills(
    fill: Fill, geometry: Geometry, walls: Walls, rheology: Rheology
) -> Problems:
    """Check that a fill with a pore pressure is in three dimensions, and what any must have."""
    laws = [wall.friction for _, wall in walls]
    for k, part in enumerate(fill):
        key = f"fill.{k}.pore_pressure"
        if part.pore_pressure != 0.0 and not is_three_dimensional(geometry):
            message = "exists only in three dimensions; leave it out"
            yield Problem(key, message, part.pore_pressure)
            continue
        yield from _not_felt(key, part, laws, rheology, "a wall")


def pore_pressure_of_releases(
    release: Releases, zone: Zones, walls: Walls, rheology: Rheology
) -> Problems:
    """Check that a release with a pore pressure has grains, and friction that it reduces."""
    laws = [walls.floor.friction, *(part.friction for part in zone)]
    for k, part in enumerate(release):
        yield from _not_felt(f"release.{k}.pore_pressure", part, laws, rheology, "walls.floor")


def _not_felt(
    key: str, part: AnyFill | AnyRelease, laws: Sequence[object], rheology: Rheology, where: str
) -> Problems:
    """Check that matter with a pore pressure has grains, and friction that it reduces."""
    has_friction = isinstance(rheology, FrictionalStrength) or any(
        isinstance(law, CoulombFriction | VoellmyFriction) for law in laws
    )
    if part.pore_pressure == 0.0:
        if part.pore_pressure_time is not None:
            message = f"has no effect without a share to begin with; give {key} as well"
            yield Problem(f"{key}_time", message, part.pore_pressure_time)
    elif not isinstance(part, HydrographRelease) and part.material == "water":
        message = "has no effect on water, which has no grains; give material = 'mixture'"
        yield Problem(key, message, part.pore_pressure)
    elif not has_friction:
        message = (
            f"has no effect: there is no friction; give {where} the friction 'coulomb' or "
            "'voellmy', or rheology.type = 'coulomb' or 'mu-i'"
        )
        yield Problem(key, message, part.pore_pressure)


CHECKS: tuple[Callable[..., Problems], ...] = (pore_pressure_of_fills, pore_pressure_of_releases)
