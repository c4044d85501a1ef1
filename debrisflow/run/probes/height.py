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
from debrisflow.run import row_statistics
from debrisflow.run.measures import LEAST_DENSITY_RATIO, piled
from debrisflow.run.probe import Column, Sampler, extreme_columns
from debrisflow.space.domain import WALL_NAMES, domain
from debrisflow.space.floor import is_over_floor
from debrisflow.space.ground import Surface, ground_of
from debrisflow.space.mesh_pieces import top_of_structures
from debrisflow.space.plan_grid import floor_ends
from debrisflow.space.scene import trajectories

Floats = NDArray[np.float64]
MEAN = "filled_height_mean"
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

    Of the filled height mean, least and greatest of the steps since the row before are kept too.

    On a terrain they are above the ground under each particle, or the top of a structure under the
    middle.  The base ends at the ends of the space; keep it a spacing away from the sides of an
    obstacle.
    """

    sum_shape = row_statistics.sum_shape(1)
    averaged = (MEAN,)

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
        self._ground: Surface | None = None
        if case.is_terrain:
            surface = ground_of(case).surface
            level = float(surface.level(self._place[:1], self._place[1:])[0])
            self.base = max(level, top_of_structures(case, *self._place))
            if self.base == level:
                self._ground = surface
        else:
            self.base = self._base(particles, case)

    @staticmethod
    def reads_walls(case: ResolvedCase) -> bool:
        """See :meth:`Sampler.reads_walls`."""
        return not case.is_terrain

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return both heights."""
        top = "top of the particles that follow each other upward"
        filled = "volume of all particles in the column over the area of its base"
        wetted = Column("filled_height", "m", filled)
        return (
            Column("height", "m", top, "above the wall below"),
            wetted,
            Column(MEAN, "m", "of filled_height over the steps since the row before"),
            *extreme_columns([wetted]),
        )

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return ("filled_height",)

    def sample(self, state: State) -> tuple[float, ...]:
        """Return height and filled height, and mean, least and greatest of the latter, m."""
        p, d0 = state.particles, self._d0
        row, offset, level = self._column(state)
        inside = np.all((offset >= self._lower) & (offset < self._upper), axis=1)
        inside &= p.number_density[row] >= self._least_density
        column = np.zeros(int(np.count_nonzero(inside)), dtype=np.int64)
        pile = level[inside][piled(column, level[inside], d0)]
        height = pile.max() + 0.5 * d0 if pile.size else 0.0
        filled = self._filled(offset)
        found = row_statistics.since_row(state.sums[self._name], state, filled)
        return tuple(float(value) for value in (height, *filled, *np.concatenate(found)))

    def add_step(self, state: State) -> None:
        """Add the filled height of the last step."""
        _, offset, _ = self._column(state)
        row_statistics.add_step(state.sums[self._name], state, self._filled(offset))

    def _column(self, state: State) -> tuple[NDArray[np.int64], Floats, Floats]:
        """Return the fluid whose squares the base covers: rows, offsets, heights over its level."""
        position = state.particles.position[state.particles.fluid]
        row, offset = np.arange(len(position)), np.zeros((len(position), 0))
        for axis in range(self._up):  # along x first: most are far away
            away = self._offset(position[row, axis], axis)
            near = (away > self._lower[axis] - 0.5 * self._d0) & (
                away < self._upper[axis] + 0.5 * self._d0
            )
            row, offset = row[near], np.column_stack([offset[near], away[near]])
        base: float | Floats = self.base
        if self._ground is not None:
            base = self._ground.level(position[row, 0], position[row, 1])
        level = position[row, self._up] - base
        return row[level > 0.0], offset[level > 0.0], level[level > 0.0]

    def _filled(self, offset: Floats) -> Floats:
        """Return the volume of the particles in the column over its area, (1,) array, m."""
        half = 0.5 * self._d0
        covered = np.minimum(offset + half, self._upper) - np.maximum(offset - half, self._lower)
        share = np.prod(np.clip(covered, 0.0, None), axis=1)
        return np.array([self._d0 * share.sum() / np.prod(self._upper - self._lower)])

    def _offset(self, coordinate: Floats, axis: int) -> Floats:
        """Return the distance along an axis from the place, through the nearest image, m."""
        offset, period = coordinate - self._place[axis], self._period[axis]
        return np.asarray(offset - period * np.rint(offset / period) if period > 0.0 else offset)

    def _base(self, walls: Particles, case: ResolvedCase) -> float:
        """Return the level of the highest wall under the place that faces upward, m."""
        under = np.ones(walls.count, dtype=bool)
        for axis in range(self._up):
            away = np.abs(self._offset(walls.position[:, axis], axis))
            under &= away <= (0.5 + 1e-6) * self._d0
        x, y, _ = walls.position.T
        under &= is_over_floor(case, x, y)  # not a rim
        for number in trajectories(case):
            under &= walls.wall != number
        under &= (walls.kind == Kind.WALL) & (walls.wall_normal[:, self._up] > UPWARD)
        if not under.any():
            raise CaseError(f"probe '{self._name}': no floor under it looks up; move it aside")
        top = walls.position[:, self._up] + 0.5 * self._d0
        for number, body in enumerate(case.obstacle, start=len(WALL_NAMES)):
            if isinstance(body, BoxObstacle):  # which need not end on the lattice
                top[walls.wall == number] = getattr(body, "xyz"[self._up])[1]
        return float(top[under].max())
