"""Depth, speed, momentum flux and pressure of the flow in the cells of a map.

The volume of each particle, d0^3, is spread evenly over a square of side 2 d0 around its place,
each cell getting the share by which the square overlaps it.  With the sums of a cell of area A over
its shares s

    h = d0^3 sum(s) / A,   u = |sum(s rho u)| / sum(s rho),   h u^2,   rho u^2

are its depth along the vertical, the speed of its mean momentum, the momentum flux and the
pressure of the flow.  Multiplied by the upward part of the terrain's normal, h is the depth along
that normal.  Greatest values are those of these products, not products of greatest values.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from debrisflow._jit import kernel, loop

SUMS = 5  # shares, and shares of the density and of the momentum along x, y, z
KILO = 1000.0


@kernel
def overlap(place, half, at):
    """Return the length of an interval ``place +- half`` that is in ``[at, at + 1]``.

    Examples
    --------
    >>> overlap(1.25, 0.5, 0), overlap(1.25, 0.5, 1), overlap(1.25, 0.5, 2)
    (0.25, 0.75, 0.0)
    """
    return max(min(place + half, at + 1.0) - max(place - half, at + 0.0), 0.0)


@kernel
def _spread(part, owner, position, velocity, density, half, cell, sums, touched):
    columns, rows = sums.shape[0], sums.shape[1]
    west, east, south, north = columns, 0, rows, 0
    scale, beyond = 1.0 / cell, int(half) + 1
    for i in range(density.size):
        x, y = position[i, 0] * scale, position[i, 1] * scale
        if not (0.0 <= x < columns and 0.0 <= y < rows):
            continue
        # the integer below, of what is not negative
        a, b = int(x - half + beyond) - beyond, int(x + half) + 1
        c, d = int(y - half + beyond) - beyond, int(y + half) + 1
        west, east = min(west, a), max(east, b)
        south, north = min(south, c), max(north, d)
        mass = density[i]
        u, v, w = mass * velocity[i, 0], mass * velocity[i, 1], mass * velocity[i, 2]
        for column in range(a, b):
            at = min(max(column, 0), columns - 1)
            if owner[at] != part:
                continue
            share_x = overlap(x, half, column) / (4.0 * half * half)
            for row in range(c, d):
                share = share_x * overlap(y, half, row)
                total = sums[at, min(max(row, 0), rows - 1)]
                total[0] += share
                total[1] += share * mass
                total[2] += share * u
                total[3] += share * v
                total[4] += share * w
    touched[part, 0], touched[part, 1] = max(min(west, east), 0), min(east, columns)
    touched[part, 2], touched[part, 3] = max(min(south, north), 0), min(north, rows)


@loop
def spread(position, velocity, density, half, cell, owner, sums, touched):
    """Add particles to the sums of the cells.

    What of a square is beyond the border of the map counts for the cell at the border, so that all
    volume on the map is in its cells; particles beyond the border do not count.  Each thread goes
    through all particles for the columns of a part, so that the sums do not depend on threads.

    Parameters
    ----------
    position, velocity : (n, 3) float64 array, m, m/s
        From the south-west corner of the map.
    density : (n,) float64 array, kg/m3
    half : float
        Half the side of a square, in cells.
    cell : float, m
    owner : (columns,) int64 array
        The part, by its number, that a column belongs to.
    sums : (columns, rows, 5) float64 array
        Shares, dimensionless, of the density, kg/m3, and of the momentum, kg/(m2 s).
    touched : (parts, 4) int64 array
        Written: in each row the first column that is touched, the one past the last, the first
        row and the one past the last; a row for each part.
    """
    for part in prange(touched.shape[0]):
        own = np.int64(part)  # else it would be compiled for unsigned numbers too
        _spread(own, owner, position, velocity, density, half, cell, sums, touched)


@kernel
def flow_in_cell(total, height):
    """Return depth, m, speed, m/s, momentum flux, m3/s2, and pressure, kPa, of the sums of a cell.

    Parameters
    ----------
    total : (5,) float64 array
    height : float, m
        Volume of a particle over the area of a cell.
    """
    depth = height * total[0]
    squared = (total[2] ** 2 + total[3] ** 2 + total[4] ** 2) / total[1] ** 2
    return depth, np.sqrt(squared), depth * squared, total[1] / total[0] * squared / KILO


@loop
def record(sums, touched, height, threshold, time, dt, layers):
    """Take the flow in the cells into the layers, and set its sums back to zero.

    The depth counts always, what else there is only while the depth exceeds the threshold: the
    speed of a splash is no speed of a flow.

    Parameters
    ----------
    sums : (columns, rows, 5) float64 array
        As :func:`spread` fills it.
    touched : (parts, 4) int64 array
        As :func:`spread` writes it.
    height : float, m
        Volume of a particle over the area of a cell.
    threshold : float, m
    time, dt : float, s
        The end of a step and its length.
    layers : tuple of (columns, rows) float64 array
        Depth, speed, momentum flux, pressure, arrival and duration, as
        :class:`debrisflow.particles.layers.Layers` has them.
    """
    peak_depth, peak_speed, peak_momentum_flux, peak_pressure, arrival, duration = layers
    west, east, south, north = touched[0]
    for column in prange(west, east):
        for row in range(south, north):
            total = sums[column, row]
            if total[0] > 0.0:
                depth, speed, momentum_flux, pressure = flow_in_cell(total, height)
                peak_depth[column, row] = max(peak_depth[column, row], depth)
                if depth > threshold:
                    peak_speed[column, row] = max(peak_speed[column, row], speed)
                    peak_momentum_flux[column, row] = max(
                        peak_momentum_flux[column, row], momentum_flux
                    )
                    peak_pressure[column, row] = max(peak_pressure[column, row], pressure)
                    if not arrival[column, row] <= time:
                        arrival[column, row] = time
                    duration[column, row] += dt
            total[:] = 0.0
