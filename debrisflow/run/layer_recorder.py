"""Records the layers of a map while a case runs: each step, and the depth at a time."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import threads
from debrisflow.case.rasters import MapGrid
from debrisflow.particles.layers import Layers
from debrisflow.particles.record import Particles
from debrisflow.physics import map_cells

Floats = NDArray[np.float64]
WIDTH = 2.0  # spacings of the square over which a particle is spread, if a cell is not wider


class LayerRecorder:
    """Spreads particles over the cells of a map, see :mod:`debrisflow.physics.map_cells`.

    Parameters
    ----------
    grid : MapGrid
        Its south-west corner is the origin of the particles.
    spacing : float
        d0, m.
    threshold : float, m
        Depth that tells flow from none.
    """

    def __init__(self, grid: MapGrid, spacing: float, threshold: float) -> None:
        self.grid, self.threshold = grid, threshold
        self.half = 0.5 * max(WIDTH * spacing / grid.cell, 1.0)
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

    def _spread(self, position: Floats, velocity: Floats, density: Floats) -> NDArray[np.int64]:
        parts = threads()
        owner, touched = np.arange(self.grid.columns) % parts, np.zeros((parts, 4), dtype=np.int64)
        map_cells.spread(
            position, velocity, density, self.half, self.grid.cell, owner, self._sums, touched
        )
        return touched
