"""Records the layers of a map while a case runs: each step, and the depth at a time."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import threads
from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import SPREAD
from debrisflow.case.rasters import MapGrid
from debrisflow.particles.layers import Layers
from debrisflow.particles.record import Particles
from debrisflow.physics import map_cells
from debrisflow.run.measures import DepositProfile
from debrisflow.space.ground import ground_of

Floats = NDArray[np.float64]


class LayerRecorder:
    """Spreads particles over the cells of a map, see :mod:`debrisflow.physics.map_cells`.

    Parameters
    ----------
    grid : MapGrid
        Its south-west corner is the origin of the particles.
    spacing : float
        d0, m.
    threshold : float, m
        Depth from which a cell counts as reached.
    """

    def __init__(self, grid: MapGrid, spacing: float, threshold: float) -> None:
        self.grid, self.threshold = grid, threshold
        self.half = 0.5 * SPREAD * spacing / grid.cell
        self.height = spacing**3 / grid.cell**2
        self._sums = np.zeros((grid.columns, grid.rows, map_cells.SUMS))  # between steps too

    def add_step(self, layers: Layers, particles: Particles, time: float, dt: float) -> None:
        """Take the fluid at the end of a step into the layers, in place.

        Parameters
        ----------
        layers : Layers
            Of the cells of the grid.
        particles : Particles
        time, dt : float, s
            The end of the step and its length.
        """
        fluid = particles.fluid
        touched = self._spread(
            particles.position[fluid], particles.velocity[fluid], particles.density[fluid]
        )
        arrays = tuple(getattr(layers, field.name) for field in fields(layers))
        map_cells.record(self._sums, touched, self.height, self.threshold, time, dt, arrays)

    def depth(self, particles: Particles, slower_than: float = np.inf) -> Floats:
        """Return the depth of the fluid now, (columns, rows) array, m; 0 where there is none.

        Parameters
        ----------
        particles : Particles
        slower_than : float, m/s
            Only that of particles slower than this, as of a deposit.
        """
        fluid = particles.fluid
        chosen = np.linalg.norm(particles.velocity[fluid], axis=1) < slower_than
        columns = (particles.position, particles.velocity, particles.density)
        self._spread(*(np.ascontiguousarray(column[fluid][chosen]) for column in columns))
        depth: Floats = self.height * self._sums[..., 0]
        self._sums[:] = 0.0
        return depth

    def profile(self, particles: Particles, rest_speed: float) -> DepositProfile:
        """Return deposit, depth and concentration in the cells where there is fluid.

        Their concentration is the mean of the particles in the cell itself.

        Parameters
        ----------
        particles : Particles
        rest_speed : float, m/s
            Particles slower than this are deposited.
        """
        deposit, depth = self.depth(particles, rest_speed), self.depth(particles)
        fluid, cell = particles.fluid, self.grid.cell
        shape = depth.shape
        place = [np.floor(particles.position[fluid, axis] / cell).astype(int) for axis in (0, 1)]
        index = np.ravel_multi_index(tuple(place), shape, mode="clip")
        count = np.bincount(index, minlength=depth.size)
        total = np.bincount(index, particles.sediment_fraction[fluid], depth.size)
        share = np.full(depth.size, np.nan)
        np.divide(total, count, out=share, where=count > 0)
        i, j = np.nonzero(depth > 0.0)
        return DepositProfile(
            x=(i.astype(np.float64) + 0.5) * cell,
            y=(j.astype(np.float64) + 0.5) * cell,
            deposit_height=deposit[i, j],
            flow_height=depth[i, j],
            concentration=share.reshape(shape)[i, j],
        )

    def _spread(self, position: Floats, velocity: Floats, density: Floats) -> NDArray[np.int64]:
        parts = threads()
        owner, touched = np.arange(self.grid.columns) % parts, np.zeros((parts, 4), dtype=np.int64)
        map_cells.spread(
            position, velocity, density, self.half, self.grid.cell, owner, self._sums, touched
        )
        return touched


def recorder_of(case: ResolvedCase) -> LayerRecorder | None:
    """Return what records the layers of a case on a terrain; None without one."""
    if not case.is_terrain:
        return None
    grid = ground_of(case).grid
    return LayerRecorder(grid, case.particles.spacing, case.output.layer_depth)
