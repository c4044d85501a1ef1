"""The sampler of the height of the fluid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import BoxObstacle
from debrisflow.case.probes.height import HeightProbe
from debrisflow.errors import CaseError
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.record import Kind, Particles
from debrisflow.particles.state import State
from debrisflow.run.measures import LEAST_DENSITY_RATIO, piled
from debrisflow.run.probe import Column, Sampler
from debrisflow.space.domain import WALL_NAMES, domain
from debrisflow.space.floor import is_over_floor
from debrisflow.space.plan_grid import floor_ends

Floats = NDArray[np.float64]
UPWARD = 0.5  # upward part of the normal above which a wall carries what stands on it


class Height(Sampler):
    """Height of the fluid in a column with a square base (a strip, in two dimensions).

    Two heights above what the column stands on, the wall under its middle:

    - ``height``, the top of the particles with n >= 0.5 n0 and their centers in the column that
      follow each other upward without a gap of more than 1.5 d0.  It ends below spray and below
      a jet over air, and changes in steps as the top particle changes.
    - ``filled_height``, the volume of all particles above the wall in the column over the area of
      its base.  Each particle counts by the part of its own square, d0 wide, that the base
      covers, so that the height does not jump when a particle enters, and is exact for particles
      on a lattice wherever the column stands.  Air in the column lowers it, spray raises it.

    The base ends at the ends of the space; keep it a spacing away from the sides of an obstacle.
    """

    def __init__(self, probe: HeightProbe, case: ResolvedCase, particles: Particles) -> None:
        size = probe.side(case.particles.spacing)
        self._name = probe.name
        self._d0, self._axes, self._up = case.particles.spacing, case.dimension, case.dimension - 1
        lattice = reference(case.dimension, case.particles.effective_radius, self._d0)
        self._least_density = LEAST_DENSITY_RATIO * lattice.number_density
        self._place = np.array([probe.x, probe.y or 0.0])[: self._up]
        self._period = domain(case).period[: self._up]
        first, last = floor_ends(case, probe.x, probe.y or 0.0)
        half = np.full(self._up, 0.5 * size)
        repeats = self._period > 0.0
        # a place at a wall as it is asked may lie behind the wall as it is built
        self._place = np.where(repeats, self._place, np.clip(self._place, first, last))
        self._lower = -np.where(repeats, half, np.minimum(half, self._place - first))
        self._upper = np.where(repeats, half, np.minimum(half, last - self._place))
        self.base = self._base(particles, case)

    @staticmethod
    def reads_walls(case: ResolvedCase) -> bool:
        """See :meth:`Sampler.reads_walls`."""
        return True

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return both heights."""
        return (
            Column(
                "height",
                "m",
                "top of the particles that follow each other upward",
                "above the wall below",
            ),
            Column(
                "filled_height",
                "m",
                "volume of all particles in the column over the area of its base",
            ),
        )

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return ("filled_height",)

    def sample(self, state: State) -> tuple[float, ...]:
        """Return height and filled height, m."""
        p, d0 = state.particles, self._d0
        level = p.position[p.fluid, self._up] - self.base
        offset = self._offset(p.position[p.fluid])
        covered = np.minimum(offset + 0.5 * d0, self._upper) - np.maximum(
            offset - 0.5 * d0, self._lower
        )
        share = np.prod(np.clip(covered, 0.0, None), axis=1)
        filled = d0 * share[level > 0.0].sum() / np.prod(self._upper - self._lower)
        inside = np.all((offset >= self._lower) & (offset < self._upper), axis=1) & (level > 0.0)
        inside &= p.number_density[p.fluid] >= self._least_density
        column = np.zeros(int(np.count_nonzero(inside)), dtype=np.int64)
        pile = level[inside][piled(column, level[inside], d0)]
        height = pile.max() + 0.5 * d0 if pile.size else 0.0
        return float(height), float(filled)

    def _offset(self, position: Floats) -> Floats:
        """Return the horizontal distance from the place, through the nearest image, m."""
        offset = position[:, : self._up] - self._place
        repeat = np.where(self._period > 0.0, self._period, np.inf)
        return np.asarray(
            offset - np.where(self._period > 0.0, self._period, 0.0) * np.rint(offset / repeat)
        )

    def _base(self, walls: Particles, case: ResolvedCase) -> float:
        """Return the level of the highest wall under the place that faces upward, m."""
        under = np.all(np.abs(self._offset(walls.position)) <= (0.5 + 1e-6) * self._d0, axis=1)
        x, y, _ = walls.position.T
        under &= is_over_floor(case, x, y)  # not a rim
        under &= (walls.kind == Kind.WALL) & (walls.wall_normal[:, self._up] > UPWARD)
        if not under.any():
            raise CaseError(f"probe '{self._name}': no floor under it looks up; move it aside")
        top = walls.position[:, self._up] + 0.5 * self._d0
        for number, body in enumerate(case.obstacle, start=len(WALL_NAMES)):
            if isinstance(body, BoxObstacle):  # which need not end on the lattice
                top[walls.wall == number] = getattr(body, "xyz"[self._up])[1]
        return float(top[under].max())
