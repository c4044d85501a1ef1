"""A landslide on real terrain: run-out at the S-1000 road near Mount St. Helens, December 2021.

The released mass lies over the ground that it left, sheared by friction inside and slowed by
Voellmy's law at the base, with coefficients that are not calibrated.  Nothing is eroded.

References
----------
Keck, Istanbulluoglu, Campforts, Tucker & Horner-Devine 2024, A landslide runout model for sediment
transport, landscape evolution, and hazard assessment applications, Earth Surface Dynamics 12.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from debrisflow.case import tables
from debrisflow.case.defaults import complete
from debrisflow.case.tables import Case
from debrisflow.neighbors.height_field import HeightField, height_field, levels_at
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.explicit import Explicit
from tests.validation.ground3d import distances

Floats = NDArray[np.float64]
DATA = Path(__file__).parents[2] / "cases" / "data" / "mt_st_helens2021"
VOLUME = 22_481.0  # m3, released
UNDER = 20.0  # m between the lowest ground and the floor of the case
FRICTION, TURBULENCE = 0.2, 500.0  # mu and xi, m/s2, of Voellmy's law
INSIDE = 16.7  # degrees, angle of friction between particles
LIFTED = 0.45  # spacings from the ground within which nothing stands at the start
FASTEST = 17.0  # m/s
COUNTS = 0.3  # m of depth or change from which a cell counts as reached


class Grid(NamedTuple):
    """Values of cells, (n, m) array along x and y, NaN where none, and the side of a cell, m."""

    values: Floats
    width: float


@dataclass
class Runout:
    """What a landslide did.

    Attributes
    ----------
    times, speed, farthest : (k,) float64 array, s, m/s, m
        Of the samples: mean speed, and the greatest distance in plan from the middle of the source.
    inside : int
        Most particles that were in the ground, by a tenth of a spacing, at a sample.
    nearest : float
        Least distance to the ground at a sample, in spacings.
    lost : int
    reached, deposit : (n, m) float64 array, m
        Greatest depth so far in the cells of the grid at a sample, and depth at the end.
    volume : float, m3
        Of all particles.
    moving : float
        Share of the particles that move by more than 1 cm/s at the end.
    """

    times: Floats
    speed: Floats
    farthest: Floats
    inside: int
    nearest: float
    lost: int
    reached: Floats
    deposit: Floats
    volume: float
    moving: float


def read_grid(name: str) -> Grid:
    """Return an ESRI ASCII grid with the row of the least y first."""
    lines = (DATA / f"{name}.asc").read_text().splitlines()
    head = dict(line.split() for line in lines[:6])
    values = np.array([row.split() for row in lines[6:]], dtype=float)
    values[values == float(head["NODATA_value"])] = np.nan
    return Grid(np.ascontiguousarray(values[::-1].T), float(head["cellsize"]))


def terrain() -> tuple[HeightField, HeightField, Floats]:
    """Return the ground without and with what was released, and the depth of that by cells, m.

    Levels are over the floor of the case; a cell without one has that of the nearest.
    """
    level, width = read_grid("pre_runout_DEM")
    depth = np.nan_to_num(-read_grid("landslide_depth").values)
    _, nearest = distance_transform_edt(np.isnan(level), return_indices=True)
    level = level[tuple(nearest)] - np.nanmin(level) + UNDER
    left, whole = (height_field(z, width, (0.0, 0.0), 0) for z in (level - depth, level))
    return left, whole, depth


def levels(x: Floats, y: Floats, ground: HeightField) -> Floats:
    """Return the level of a ground at places, m."""
    found = np.empty(len(x))
    levels_at(np.ascontiguousarray(x), np.ascontiguousarray(y), ground, found)
    return found


def build(spacing: float, end: float, depth: Floats, top: float, width: float) -> tables.Case:
    """Return the case: a block around the source, of which what was released is kept."""
    cells = np.argwhere(depth > 0.0)
    low, high = width * (cells.min(axis=0) - 1.0), width * (cells.max(axis=0) + 2.0)
    low, high = np.floor(low / spacing) * spacing, np.ceil(high / spacing) * spacing
    length, across = width * np.array(depth.shape)
    bottom = UNDER
    block = {"type": "block", "x": (low[0], high[0]), "y": (low[1], high[1]), "z": (bottom, top)}
    law = {"law": "voellmy", "coefficient": FRICTION, "turbulence": TURBULENCE}
    return complete(
        Case(
            title="landslide near Mount St. Helens",
            particles={"spacing": spacing},
            geometry={"type": "tank3d", "length": length, "width": across, "height": top},
            walls={"floor": {"friction": law}},
            fill=[block | {"material": "mixture"}],
            sediment={"density": 2700.0},
            mixture={"concentration": 0.59, "viscosity": 1.0},
            rheology={
                "type": "coulomb",
                "friction_angle": INSIDE,
                "saturated": True,
                "largest_viscosity": 1.0e8,
            },
            scheme={"type": "explicit", "sound_speed": 4.5 * FASTEST},
            time={"end": end},
            output={"interval": end},
        )
    )


def start(case: tables.Case, ground: HeightField, whole: HeightField, depth: Floats) -> State:
    """Return the state of what was released, at rest under its own weight."""
    state, d0 = initial_state(case), case.particles.spacing
    p = state.particles
    x, y, z = p.position[p.fluid].T
    under = levels(x, y, whole) - z
    width = ground.width
    in_source = depth[(x // width).astype(int), (y // width).astype(int)] > 0.0
    # as much as stands too near to the ground stands over the surface instead
    kept = np.flatnonzero(in_source & (under > -LIFTED * d0))
    kept = kept[distances(p.position[kept], ground) > LIFTED * d0]
    p.fluid_count = kept.size
    p.keep(kept, kept.size)
    p.compression[p.moving] = 9.81 * np.maximum(under[kept], 0.0) / case.scheme.sound_speed**2
    return state


def run(spacing: float = 2.0, end: float = 120.0, interval: float = 2.0) -> Runout:
    """Release the mass and follow it."""
    ground, whole, depth = terrain()
    source = depth > 0.0
    top = float(np.ceil(whole.coefficients[source].max() / 10.0 + 1.0) * 10.0)
    case = build(spacing, end, depth, top, ground.width)
    state, scheme = start(case, ground, whole, depth), Explicit(case, ground)
    scheme.fill_number_density(state)
    middle = ground.width * (np.argwhere(source) + 0.5).mean(axis=0)
    count, volume = state.particles.fluid_count, spacing**3
    times, speeds, farthest, reached = [], [], [], np.zeros(depth.shape)
    inside, nearest, due = 0, np.inf, 0.0
    while state.time < end:
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time, state.step = state.time + dt, state.step + 1
        if state.time < due and state.time < end:
            continue
        due += interval
        p = state.particles
        place, u = p.position[p.fluid], np.linalg.norm(p.velocity[p.fluid], axis=1)
        distance = distances(place, ground)
        inside = max(inside, int(np.count_nonzero(distance < -0.1 * spacing)))
        nearest = min(nearest, float(distance.min() / spacing))
        cell = tuple((place[:, :2] // ground.width).astype(int).T)
        thick = np.zeros(depth.shape)
        np.add.at(thick, cell, volume / ground.width**2)
        reached = np.maximum(reached, thick)
        times.append(state.time)
        speeds.append(u.mean())
        farthest.append(np.linalg.norm(place[:, :2] - middle, axis=1).max())
    return Runout(
        times=np.array(times),
        speed=np.array(speeds),
        farthest=np.array(farthest),
        inside=inside,
        nearest=nearest,
        lost=count - state.particles.fluid_count,
        reached=reached,
        deposit=thick,
        volume=count * volume,
        moving=float(np.mean(u > 0.01)),
    )


def observed() -> Floats:
    """Return the observed change of the ground, (n, m) array, m."""
    return np.nan_to_num(read_grid("DEM_of_Difference").values)


def observed_distance() -> float:
    """Return how far from the middle of the source a cell was raised, m."""
    _, _, depth = terrain()
    middle = (np.argwhere(depth > 0.0)).mean(axis=0)
    raised = np.argwhere(observed() > COUNTS)
    return float(10.0 * np.linalg.norm(raised - middle, axis=1).max())
