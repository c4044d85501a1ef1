"""Who is near whom at a step, and when the lists are built anew."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.boundary import Boundary
from debrisflow.neighbors.height_field import HeightField
from debrisflow.neighbors.lattice import Reference
from debrisflow.neighbors.lists import SKIN, Neighbors, group
from debrisflow.neighbors.pairs import Near, repeats_of
from debrisflow.neighbors.wall_access import Solid
from debrisflow.neighbors.wall_shares import share_drag
from debrisflow.particles.record import Particles
from debrisflow.schemes.surfaces import walls_of
from debrisflow.schemes.wall_particles import solid_of
from debrisflow.space.domain import Domain

Floats = NDArray[np.float64]
LEAST_SKIN, GREATEST_SKIN = 0.15, 0.6  # spacings


class Vicinity(Protocol):
    """Neighbors of the particles of a run, and what they feel of the walls."""

    @property
    def near(self) -> Near:
        """Who is near whom."""

    @property
    def solid(self) -> Solid | Boundary:
        """The walls, of particles or as surfaces."""

    @property
    def wall_speed(self) -> float:
        """The greatest speed of an obstacle that moves, m/s."""

    def update(self, particles: Particles, time: float, is_fresh: bool) -> None:
        """Bring the lists up to the particles at a time, s; build them anew if ``is_fresh``."""


class OneList:
    """Fluid, supply and walls in one list: walls carry a pressure and see their neighbors too."""

    near: Near
    solid: Solid
    wall_speed = 0.0

    def __init__(self, case: ResolvedCase, lattice: Reference, domain: Domain) -> None:
        self._case, self._lattice, self._period = case, lattice, domain.period
        self._lists = Neighbors(lattice.effective_radius, lattice.spacing, domain.period)
        self._has_walls = False

    def update(self, particles: Particles, time: float, is_fresh: bool) -> None:
        """See :class:`Vicinity`."""
        p, rows = particles, particles.unknown_count
        if not self._has_walls:
            self.solid, self._has_walls = solid_of(p, self._case), True
        if is_fresh or self._lists.is_stale(p.position, rows):
            self._lists.build(p.position, rows)
            self._moving, self._pressed = np.empty((2, rows), dtype=np.int32)
            group(
                self._lists.index,
                self._lists.count,
                p.moving.stop,
                rows,
                self._moving,
                self._pressed,
            )
        self.near = _near(
            self._lattice,
            self._period,
            p,
            position=p.position,
            neighbors=self._lists.index,
            fluid_count=self._moving,
            wall=self._lists.index,
            wall_row=np.arange(rows, dtype=np.int32),
            wall_start=self._moving,
            wall_count=self._lists.count - self._moving,
            pressed_count=self._pressed,
            wall_from=p.moving.stop,
        )


class ListAndSurfaces:
    """Fluid and supply in one list; walls are surfaces.

    Parameters
    ----------
    case : ResolvedCase
    lattice : Reference
    domain : Domain
    ground : HeightField, optional
        Over the floor.
    shares_drag : bool
        Whether the drag of no-slip walls counts, see :mod:`debrisflow.neighbors.wall_shares`.
    """

    near: Near
    solid: Boundary

    def __init__(
        self,
        case: ResolvedCase,
        lattice: Reference,
        domain: Domain,
        ground: HeightField | None = None,
        *,
        shares_drag: bool = False,
    ) -> None:
        self._shares_drag = shares_drag
        self._lattice, self._period = lattice, domain.period
        self._lists = Neighbors(lattice.effective_radius, lattice.spacing, domain.period)
        self._surfaces, self._moving = walls_of(case, GREATEST_SKIN, ground)
        self._skin = SKIN

    @property
    def wall_speed(self) -> float:
        """See :class:`Vicinity`."""
        return self._moving.speed

    def choose_skin(self, path: float) -> None:
        """Weigh building lists often against passing over many neighbors out of reach.

        A wide skin costs the sums some (r_e + skin)^2 a spacing, a list lasts for skin / (2 m)
        steps where the fastest particle moves by m spacings in one: the least of both lies at
        1.4 sqrt(m).

        Parameters
        ----------
        path : float
            m.
        """
        self._skin = min(max(1.4 * np.sqrt(path), LEAST_SKIN), GREATEST_SKIN)

    def update(self, particles: Particles, time: float, is_fresh: bool) -> None:
        """See :class:`Vicinity`."""
        p, position = particles, particles.position[particles.moving]
        self._moving.place(time)
        is_stale = is_fresh or self._moving.path > 0.5 * self._lists.skin
        if is_stale or self._lists.is_stale(position, p.moving.stop):
            self._lists.set_skin(self._skin)
            self._lists.build(position, p.moving.stop)
            self._moving.remember()
            if self._moving.moves_elements:
                self._surfaces.sort_elements()
            self._surfaces.build(position, self._lists.skin)
            self._surfaces.cut(position, self._lists)
        self.solid = self._surfaces.survey(position)
        self.near = _near(
            self._lattice,
            self._period,
            p,
            position=position,
            neighbors=self._lists.index,
            fluid_count=self._lists.count,
            wall=None,
            wall_row=None,
            wall_start=None,
            wall_count=None,
            pressed_count=None,
            wall_from=0,
        )
        if self._shares_drag and np.any(self.solid.slip == 0.0):
            share_drag(self.near, self.solid)


def _near(lattice: Reference, period: Floats, particles: Particles, **lists: Any) -> Near:
    return Near(
        supply_from=particles.fluid_count,
        period=repeats_of(period),
        spacing=lattice.spacing,
        effective_radius=lattice.effective_radius,
        dimension=float(lattice.dimension),
        number_density=lattice.number_density,
        laplacian_lambda=lattice.laplacian_lambda,
        **lists,
    )
