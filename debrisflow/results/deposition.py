"""What lies where: heights and volumes of deposit and flow, erosion and deposition."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from debrisflow.case import ResolvedCase
from debrisflow.neighbors.lattice import reference
from debrisflow.results.frames import Frame
from debrisflow.run.measures import deposit_profile, deposited, locate_fluid, particle_volume
from debrisflow.run.tables import Table
from debrisflow.space.floor import floor_bend
from debrisflow.space.plan_grid import FLOOR_WORDS, PLACE, PLACE_WORDS, Grid, cell_level, plan

Floats = NDArray[np.float64]
COLUMNS = (
    "floor_level",
    "deposit_height",
    "flow_height",
    "concentration",
    "deposit_depth",
    "deposit_sediment_depth",
    "sediment_depth",
    "water_depth",
    "bed_change",
)
HEAD = (
    "the deposit at chosen times",
    "time: s",
    "{place}",
    "floor_level: m, of {floor}",
    "deposit_height, flow_height: m above it along its normal; concentration: volume share of",
    "  sediment up to flow_height; all as in deposit.csv, where their definitions stand",
    "deposit_depth, deposit_sediment_depth: m, volume of the particles that make up the deposit,",
    "  and of the grains in them, over the area of the cell",
    "sediment_depth, water_depth: m, volume of all grains and of all water over that area,",
    "  deposited or not",
    "bed_change: m, gain of sediment_depth since the first frame over sediment.packing_limit, so",
    "  with the pores of a packed bed: deposition, or erosion where it is negative; a mean over",
    "  five cells; what moves counts where it is, and a released mass is gone from where it was",
)
REACH = 5  # cells over which the change of the bed is averaged
LEAST_STEEP_CELLS = 3


class Deposition(NamedTuple):
    """Deposit and flow over the cells of :func:`debrisflow.space.plan_grid.plan` at a time.

    Attributes
    ----------
    time : float, s
    grid : Grid
    table : Table
        ``COLUMNS``, an array each, over the cells.
    upright : (n,) array
        Length along y, in three dimensions z, over that along the normal of the floor; 1 but on a
        run-out that bends.
    """

    time: float
    grid: Grid
    table: Table
    upright: Floats

    @property
    def area(self) -> float:
        """Return the area on which there is a deposit, m2; m of length in two dimensions."""
        return float(self.grid.area[self.table["deposit_height"] > 0.0].sum())

    @property
    def volume(self) -> float:
        """Return the volume of the particles of the deposit, pores included, m3 or m2."""
        return float(self.table["deposit_depth"] @ self.grid.area)

    @property
    def deposition(self) -> float:
        """Return the volume that the bed gained where it did, with pores, m3 or m2."""
        return float(np.maximum(self.table["bed_change"], 0.0) @ self.grid.area)

    @property
    def erosion(self) -> float:
        """Return the volume that the bed lost where it did, with pores, m3 or m2."""
        return float(np.maximum(-self.table["bed_change"], 0.0) @ self.grid.area)

    @property
    def sediment_volume(self) -> float:
        """Return the volume of the grains in the deposit, m3 or m2."""
        return float(self.table["deposit_sediment_depth"] @ self.grid.area)

    def gradient(self, fall: float) -> float:
        """Return by how much the surface of the deposit falls along x, degrees.

        Of the straight line, in three dimensions the plane, that is nearest to the tops of the
        cells with a deposit; nan where there are fewer than three.

        Parameters
        ----------
        fall : float, rad
            By which the x axis falls below the horizontal.
        """
        here = self.table["deposit_height"] > 0.0
        if np.count_nonzero(here) < LEAST_STEEP_CELLS:
            return float("nan")
        x, y = self.grid.x[here], self.grid.y[here]
        top = (self.table["floor_level"] + self.upright * self.table["deposit_height"])[here]
        terms = np.column_stack([x, y, np.ones(x.size)])
        slope = np.linalg.lstsq(terms, top, rcond=None)[0][0]
        return float(np.degrees(fall - np.arctan(slope)))


def deposition(case: ResolvedCase, frame: Frame, first: Deposition | None = None) -> Deposition:
    """Return deposit and flow of a frame over the cells of its case.

    Parameters
    ----------
    case : ResolvedCase
    frame : Frame
    first : Deposition, optional
        Of the frame since which the bed has changed; this one if left out.
    """
    grid = plan(case)
    lattice = reference(case.dimension, case.particles.effective_radius, case.particles.spacing)
    profile = deposit_profile(
        case,
        frame.position,
        frame.velocity,
        frame.kind,
        frame.concentration,
        frame.sediment_fraction,
        frame.number_density,
        reference_number_density=lattice.number_density,
    )
    above = locate_fluid(case, grid, frame.position, frame.kind)
    lying = deposited(case, above, frame.velocity, frame.kind, frame.concentration)
    depth = particle_volume(case) / grid.area
    sediment = np.bincount(above.cell, frame.sediment_fraction[above.row], grid.x.size) * depth
    everything = np.bincount(above.cell, minlength=grid.x.size) * depth
    grains = np.bincount(lying.cell, frame.sediment_fraction[lying.row], grid.x.size) * depth
    before = sediment if first is None else first.table["sediment_depth"]
    columns = (
        cell_level(case, grid),
        profile.deposit_height,
        profile.flow_height,
        profile.concentration,
        np.bincount(lying.cell, minlength=grid.x.size) * depth,
        grains,
        sediment,
        everything - sediment,
        smoothed(grid, sediment - before) / case.sediment.packing_limit,
    )
    upright = 1.0 / np.cos(floor_bend(case, grid.x))
    return Deposition(frame.time, grid, dict(zip(COLUMNS, columns, strict=True)), upright)


def smoothed(grid: Grid, depth: Floats) -> Floats:
    """Return the mean of depths over the cells around each, weighted by their area, (n,) array.

    Of single cells that hold a few particles each, what one loses another gains by chance.
    """
    here = grid.number >= 0
    area, volume = np.zeros(here.shape), np.zeros(here.shape)
    area[here] = grid.area[grid.number[here]]
    volume[here] = (depth * grid.area)[grid.number[here]]
    size = [min(REACH, length) for length in here.shape]
    means = uniform_filter(volume, size, mode="constant")[here]
    means /= uniform_filter(area, size, mode="constant")[here]
    found = np.empty(grid.x.size)
    found[grid.number[here]] = np.round(means, 9)  # the filter leaves rounding behind
    return found


def greatest_across(grid: Grid, values: Floats) -> tuple[Floats, Floats]:
    """Return the middles of the columns of a grid along x, and the greatest value in each."""
    field = np.where(grid.number >= 0, values[grid.number], -np.inf)
    return 0.5 * (grid.along[:-1] + grid.along[1:]), field.max(axis=1)


def deposit_columns(dimension: int) -> tuple[str, ...]:
    """Return the columns of ``deposit_profile.csv``."""
    return ("time", *PLACE[dimension], *COLUMNS)


def deposit_table(case: ResolvedCase, found: list[Deposition]) -> Table:
    """Return deposits at several times as one table."""
    parts = [
        [
            np.full(one.grid.x.size, one.time),
            *(getattr(one.grid, axis) for axis in PLACE[case.dimension]),
            *one.table.values(),
        ]
        for one in found
    ]
    columns = (np.concatenate(column) for column in zip(*parts, strict=True))
    return dict(zip(deposit_columns(case.dimension), columns, strict=True))


def deposit_head(dimension: int) -> list[str]:
    """Return what the columns of ``deposit_profile.csv`` mean."""
    words = {"place": PLACE_WORDS[dimension], "floor": FLOOR_WORDS[dimension]}
    return [line.format(**words) for line in HEAD]
