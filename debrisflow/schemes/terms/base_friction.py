"""Friction along walls that are surfaces."""

from __future__ import annotations

from math import radians, tan

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.friction import (
    CoulombFriction,
    LogFriction,
    ManningFriction,
    VoellmyFriction,
)
from debrisflow.neighbors.boundary import Boundary
from debrisflow.physics.base_friction import (
    STEEPEST,
    BaseFriction,
    Columns,
    Grid,
    hold_along_walls,
    slow_along_walls,
    survey_columns,
)
from debrisflow.schemes.terms.pore_pressure import borne_by_grains
from debrisflow.schemes.terms.term import Scene, Step, Term
from debrisflow.space.domain import WALL_NAMES, domain, first_zone, wall_names
from debrisflow.space.floor import roughness_of
from debrisflow.space.plan_grid import floor_extent

Floats = NDArray[np.float64]
COLUMN = 2.0  # spacings


class BaseFrictions(Term):
    """The friction of the walls that have a law of it.

    Where momentum is exchanged implicitly it acts within that, else by itself.

    Parameters
    ----------
    case : ResolvedCase
    is_implicit : bool
    """

    name = "base friction"

    def __init__(self, case: ResolvedCase, *, is_implicit: bool) -> None:
        self._is_implicit, self.friction = is_implicit, friction_of(case)
        by_depth = np.any(self.friction.manning) or np.any(self.friction.turbulent)
        self._case, self._grid = case, _grid_of(case) if by_depth else None

    def act(self, step: Step) -> None:
        """Slow the fluid particles next to walls, unless the exchange of momentum does."""
        if not self._is_implicit:
            p, scene = step.particles, step.scene
            velocity = step.velocity[p.fluid]
            before = velocity.copy()
            slow_along_walls(
                step.dt,
                _effective(step),
                self.friction,
                self._columns(step, velocity),
                scene.near.spacing,
                scene.solid,
                velocity,
            )
            step.reaction += (velocity - before) / step.dt

    def hold(self, step: Step, velocity: Floats) -> tuple[Floats, Floats]:
        """Return what holds the particles along walls, (n, 6) array, and carries them, (n, 3).

        See :func:`debrisflow.physics.base_friction.hold_along_walls`.  ``velocity`` is that at
        which the friction is asked for.
        """
        p, scene, rows = step.particles, step.scene, step.particles.moving.stop
        hold, carried = np.zeros((rows, 6)), np.zeros((rows, 3))
        fluid = velocity[p.fluid]
        hold_along_walls(
            step.dt,
            fluid,
            _effective(step),
            self.friction,
            self._columns(step, fluid),
            scene.near.spacing,
            scene.solid,
            hold[p.fluid],
            carried[p.fluid],
        )
        return hold, carried

    def _columns(self, step: Step, velocity: Floats) -> Columns:
        p, scene = step.particles, step.scene
        columns = Columns(*np.ones((3, p.fluid_count)))
        if self._grid is None or p.fluid_count == 0:
            return columns
        position, grid = p.position[p.fluid], self._grid
        if self._case.is_terrain:  # of which a flow covers a small part
            grid = _around(position, grid)
        survey_columns(
            position,
            velocity,
            _next_to_wall(scene, p.fluid_count, self.friction),
            grid,
            scene.near.spacing,
            np.zeros((*grid.shape, 5)),
            columns,
        )
        return columns


def _effective(step: Step) -> Floats:
    """Return what walls do to the fluid particles less what their pore water bears, m/s2."""
    share = borne_by_grains(step.particles)
    return step.reaction if share is None else step.reaction * share[:, None]


def _next_to_wall(scene: Scene, count: int, friction: BaseFriction) -> NDArray[np.bool_]:
    """Return which fluid particles stand next to a wall whose friction follows the column."""
    solid = scene.solid
    if not isinstance(solid, Boundary):
        raise TypeError("walls of particles have no law of friction")
    by_column = (friction.manning > 0.0) | (friction.turbulent > 0.0)
    there = np.arange(solid.distance.shape[1]) < solid.faces[:, None]
    there &= (solid.distance < scene.near.spacing) & by_column[solid.number]
    there &= np.abs(solid.normal[:, :, 2]) >= STEEPEST
    has_row = solid.row[:count] >= 0
    beside = np.zeros(count, dtype=np.bool_)
    beside[has_row] = np.any(there, axis=1)[solid.row[:count][has_row]]
    return beside


def _grid_of(case: ResolvedCase) -> Grid:
    space, d0 = domain(case), case.particles.spacing
    plan = floor_extent(case)
    lower, upper = plan[:, 0], plan[:, 1]
    shape = np.maximum(1, np.rint((upper - lower) / (COLUMN * d0))).astype(np.int64)
    return Grid(
        lower=lower, width=(upper - lower) / shape, shape=shape, repeats=space.period[:2] > 0.0
    )


def _around(position: Floats, grid: Grid) -> Grid:
    """Return the columns of a grid among which particles stand, with one more on each side."""
    place = (position[:, :2] - grid.lower) / grid.width
    first = np.clip(np.floor(place.min(axis=0)) - 1.0, 0.0, grid.shape - 1.0)
    last = np.clip(np.floor(place.max(axis=0)) + 2.0, first + 1.0, grid.shape)
    return grid._replace(
        lower=grid.lower + first * grid.width, shape=(last - first).astype(np.int64)
    )


def friction_of(case: ResolvedCase) -> BaseFriction:
    """Return the friction of walls, obstacles and zones, in the order of their numbers."""
    found = BaseFriction(*np.zeros((4, len(wall_names(case)))))
    g = float(np.hypot(*case.gravity.components))
    walls = [getattr(case.walls, name) for name in WALL_NAMES]
    tables = {number: wall.friction for number, wall in enumerate(walls)}
    tables |= {number: zone.friction for number, zone in enumerate(case.zone, first_zone(case))}
    for number, wall in enumerate(walls):
        found.roughness[number] = roughness_of(wall)
    for number, table in tables.items():
        if isinstance(table, LogFriction):
            found.roughness[number] = table.roughness
        elif isinstance(table, ManningFriction):
            found.manning[number] = g * table.coefficient**2
        elif isinstance(table, CoulombFriction):
            found.sliding[number] = (1.0 - table.pore_pressure) * tan(radians(table.angle))
        elif isinstance(table, VoellmyFriction):
            found.sliding[number] = (1.0 - table.pore_pressure) * table.coefficient
            found.turbulent[number] = g / table.turbulence
    return found
