"""What the terms of a scheme need to know of the walls of a case."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.wall_access import Solid
from debrisflow.particles.record import Kind, Particles
from debrisflow.space.domain import WALL_NAMES

Floats = NDArray[np.float64]


def slips(case: ResolvedCase) -> Floats:
    """Return 1 for walls, obstacles and zones, in their order, that are free-slip, 0 for no-slip.

    Along a wall with a law of friction other than 'no-slip' the fluid slips.
    """
    named = [getattr(case.walls, name) for name in WALL_NAMES]
    how = [wall.slip if wall.friction is None else wall.friction.law for wall in named]
    how += [part.slip for part in case.obstacle]
    how += [zone.friction.law for zone in case.zone]
    return np.array([float(condition != "no-slip") for condition in how])


def roughnesses(case: ResolvedCase) -> Floats:
    """Return the equivalent sand roughness of walls, obstacles and zones, in their order, m."""
    named = [getattr(case.walls, name).roughness for name in WALL_NAMES]
    return np.array([*named, *np.zeros(len(case.obstacle) + len(case.zone))])


def solid_of(particles: Particles, case: ResolvedCase) -> Solid:
    """Return what is known of the wall particles, which do not change their places."""
    p, walls = particles, slice(particles.inflow.stop, particles.count)
    normal, depth = p.wall_normal[walls], p.wall_depth[walls]
    reach = (case.scheme.collision_distance - 0.5) * case.particles.spacing
    contact = _contact_height(normal, depth, reach, case.particles.spacing)
    return Solid(
        position=p.position[walls].copy(),
        normal=normal.copy(),
        depth=depth.copy(),
        slip=slips(case)[p.wall[walls]],
        roughness=roughnesses(case)[p.wall[walls]],
        velocity=p.velocity[walls].copy(),
        contact_height=np.where(p.kind[walls] == Kind.WALL, contact, -np.inf),
    )


def _contact_height(normal: Floats, depth: Floats, reach: float, spacing: float) -> Floats:
    """Return the height over a cell of wall, along its normal, at which contact begins, m.

    It is the reach over a face; at an edge or corner, whose normal halves the angle, that of the
    point over the rim of the cell, in reach of one of its faces, that is highest.
    """
    slanted = np.abs(normal)
    rim = 0.501 * spacing * slanted.sum(axis=1) - depth
    highest: Floats = rim + reach * slanted.max(axis=1)
    return highest
