"""What the terms of a scheme need to know of the walls of a case."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.wall_access import Solid
from debrisflow.particles.record import Kind, Particles
from debrisflow.space.domain import WALL_NAMES
from debrisflow.space.floor import driving_gravity

Floats = NDArray[np.float64]


def solid_of(particles: Particles, case: ResolvedCase) -> Solid:
    """Return what is known of the wall particles, which do not change their places."""
    p, walls = particles, slice(particles.inflow.stop, particles.count)
    named = [getattr(case.walls, name) for name in WALL_NAMES]
    slip = np.array([float(wall.slip == "free-slip") for wall in (*named, *case.obstacle)])
    roughness = np.array([wall.roughness for wall in named] + [0.0] * len(case.obstacle))
    is_mesh = [False] * len(WALL_NAMES) + [part.type == "mesh" for part in case.obstacle]
    on_mesh, normal, depth = np.array(is_mesh)[p.wall[walls]], p.wall_normal[walls], p.wall_depth
    reach = (case.scheme.collision_distance - 0.5) * case.particles.spacing
    contact = _contact_height(normal, depth[walls], reach, case.particles.spacing)
    contact = np.where(on_mesh, reach, contact)
    velocity = p.velocity[walls].copy()
    is_three_dimensional = case.dimension == 3
    return Solid(
        position=p.position[walls].copy(),
        normal=normal.copy(),
        depth=depth[walls].copy(),
        slip=slip[p.wall[walls]],
        roughness=roughness[p.wall[walls]],
        velocity=None if is_three_dimensional else velocity,
        contact_height=np.where(p.kind[walls] == Kind.WALL, contact, -np.inf),
        on_mesh=on_mesh,
        driving=(
            driving_gravity(case, p.position[walls, 0], normal)
            if is_three_dimensional
            else np.zeros_like(normal)
        ),
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
