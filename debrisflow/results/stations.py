"""What passes a station x: profiles over the height, and hydrographs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probe import Probe
from debrisflow.case.shapes import Channel3D, Tank3D
from debrisflow.results.frames import Frame
from debrisflow.run.measures import particle_volume, wetted_width
from debrisflow.run.probes import columns_of
from debrisflow.run.tables import Row, Table, rows_where
from debrisflow.space.domain import domain
from debrisflow.space.floor import floor_bend, height_over_floor

Floats = NDArray[np.float64]
UP = {2: "y", 3: "z"}
ACROSS = {2: "", 3: ", over the width"}
QUANTITIES = (
    "velocity",
    "concentration",
    "sediment_fraction",
    "density",
    "granular_temperature",
)
PROFILES_HEAD = (
    "time: s; station: m, x along the bed; averages over one spacing to either side of it{across}",
    "  and over layers one spacing thick; layers without particles are left out",
    "{up}: m, middle of the layer above the fixed floor (under a bed: the bottom of its recess),",
    "  along its normal",
    "velocity: m/s, mean of the component along the floor",
    "concentration: mean of the sediment concentrations that the particles see around them",
    "sediment_fraction: share of sediment in the particles themselves, as is density",
    "density: kg/m3; granular_temperature: m2/s2; means",
    "samples: particles in the mean",
)
OF_MEANS = ("samples", "shear_rate", "y_over_h", "u_over_us")
MOVING_SHARE = 0.1
LEAST_FILLING = 1.0 / 3.0
MEAN_HEAD = (
    "mean profiles over the {frames} frames from {start:g} to {end:g} s",
    "station: m, x along the bed; averages as in profiles.csv",
    "{up}, velocity, concentration, sediment_fraction, density, granular_temperature, samples: as",
    "  there",
    "shear_rate: 1/s, of the mean velocity, by central differences over the layers",
    "y_over_h: (y - y0) / h, where y0 is the height at which the velocity is a tenth of u_s, the",
    "  floor if it is nowhere less, and y0 + h the middle of the uppermost layer a third full",
    "u_over_us: velocity over u_s, the velocity of that layer",
    "y_over_h and u_over_us are nan below y0, above that layer, and where nothing moves",
)
HYDROGRAPH_COLUMNS = (
    "time",
    "station",
    "discharge",
    "sediment_discharge",
    "depth",
    "speed",
    "volume",
    "sediment_volume",
)
HYDROGRAPH_HEAD = (
    "time: s; station: m, x along the bed",
    "discharge, sediment_discharge: {volume}/s, positive along x, of all matter and of the grains",
    "  in it; the rate of change of the volumes, by central differences between the frames",
    "depth: m, area of the flow{width}; what lies at rest counts",
    "speed: m/s, mean over the area of the flow at the time of the frame; nan where it is dry",
    "volume, sediment_volume: {volume}, net of what went through since the first frame, to the",
    "  particle: what is downstream now and what has left the run, downstream as it is taken",
    "in a case that repeats along x there are no volumes: nan",
)
FLOW_COLUMNS = {"discharge", "sediment_discharge", "volume", "sediment_volume"}
VOLUME = {2: "m2", 3: "m3"}
COUNT_DIGITS = 6  # of a particle, above the rounding of sums over particles


def profile_columns(dimension: int) -> tuple[str, ...]:
    """Return the columns of ``profiles.csv``."""
    return ("time", "station", UP[dimension], *QUANTITIES, "samples")


def profile_rows(case: ResolvedCase, frame: Frame, stations: Iterable[float]) -> Iterator[Row]:
    """Yield the profile at each station, a row a layer.

    A layer is d0 thick and 2 d0 long; one without particles is left out.  In three dimensions it
    reaches across the whole width, and its height is over the floor, also beside an obstacle.

    Parameters
    ----------
    case : ResolvedCase
    frame : Frame
    stations : iterable of float
        x, m.

    Yields
    ------
    tuple
        As :func:`profile_columns` names them.
    """
    d0, up = case.particles.spacing, case.dimension - 1
    x, fluid = frame.position[:, 0], frame.fluid
    for station in stations:
        near = np.flatnonzero((np.abs(_offset(case, x, station)) <= d0) & fluid)
        near = near[_offset(case, x[near], station) < d0]
        at = np.full(1, station)
        place = station + _offset(case, x[near], station)
        height = height_over_floor(case, place, frame.position[near, up], at)
        here, height = near[height > 0.0], height[height > 0.0]
        along = np.array([*np.cos(floor_bend(case, at)), *np.sin(floor_bend(case, at))])
        layer = (height / d0).astype(int)
        count = np.bincount(layer)
        values = (
            frame.velocity[here][:, [0, up]] @ along,
            *(getattr(frame, name)[here] for name in QUANTITIES[1:]),
        )
        sums = [np.bincount(layer, value) for value in values]
        for j in np.flatnonzero(count):
            means = (float(total[j] / count[j]) for total in sums)
            yield frame.time, station, (j + 0.5) * d0, *means, int(count[j])


def _offset(case: ResolvedCase, x: Floats, station: float) -> Floats:
    """Return how far places are downstream of a station, m, the short way where x repeats."""
    period = domain(case).period[0]
    offset = x - station
    return offset - period * np.rint(offset / period) if period > 0.0 else offset


def mean_profiles(
    case: ResolvedCase, profiles: Table, window: tuple[float, float], pooled: bool = False
) -> Table:
    """Return the profiles averaged over the frames of a window of time, by station.

    Parameters
    ----------
    case : ResolvedCase
    profiles : Table
        As :func:`profile_columns` names it.
    window : (float, float), s
        Both ends belong to it.
    pooled : bool
        Average over the stations too; the station is then their mean.

    Returns
    -------
    Table
        station, height, the quantities, samples, shear_rate, y_over_h, u_over_us.
    """
    inside = is_within(profiles["time"], window)
    stations = np.unique(profiles["station"][inside])
    frames = np.unique(profiles["time"][inside]).size
    if pooled and stations.size:
        groups = [(float(stations.mean()), inside, frames * stations.size)]
    else:
        groups = [(float(x), inside & (profiles["station"] == x), frames) for x in stations]
    names = ("station", UP[case.dimension], *QUANTITIES, *OF_MEANS)
    parts = [_mean_profile(case, rows_where(profiles, rows), x, count) for x, rows, count in groups]
    columns = zip(*parts, strict=True) if parts else ([np.empty(0)] for _ in names)
    return {name: np.concatenate(column) for name, column in zip(names, columns, strict=True)}


def _mean_profile(case: ResolvedCase, rows: Table, station: float, count: int) -> list[Floats]:
    """Return the columns of the mean of a number of profiles, whose layers are the rows."""
    d0 = case.particles.spacing
    layer, weight = (rows[UP[case.dimension]] / d0).astype(int), rows["samples"]
    samples: Floats = np.bincount(layer, weight).astype(np.float64)
    filled = np.flatnonzero(samples)
    sums = (np.bincount(layer, rows[name] * weight) for name in QUANTITIES)
    means: list[Floats] = [total[filled] / samples[filled] for total in sums]
    y = np.asarray((filled + 0.5) * d0, dtype=np.float64)
    shear = np.gradient(means[0], y) if y.size > 1 else np.full(y.size, np.nan)
    full = np.asarray(samples[filled] >= LEAST_FILLING * count * _particles_of_a_full_layer(case))
    scaled = normalized(y, means[0], full, case.output.rest_speed)
    return [np.full(y.size, station), y, *means, samples[filled], shear, *scaled]


def is_within(time: Floats, window: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which times are in a window; a frame that rounding puts beside its ends is.

    Examples
    --------
    >>> is_within(0.1 * np.arange(5), (0.1, 0.3))
    array([False,  True,  True,  True, False])
    """
    rounding = 1e-9 * max(abs(window[0]), abs(window[1]))
    return (time >= window[0] - rounding) & (time <= window[1] + rounding)


def _particles_of_a_full_layer(case: ResolvedCase) -> float:
    """Return the particles of a layer 2 d0 long that is full from side to side.

    On a plain, which no flow fills, those of a channel as wide as its mouth.
    """
    shape = case.geometry
    if not isinstance(shape, Tank3D | Channel3D):
        return 2.0
    return 2.0 * shape.width / case.particles.spacing


def normalized(
    y: Floats, velocity: Floats, full: NDArray[np.bool_], least_speed: float
) -> tuple[Floats, Floats]:
    """Return (y - y0) / h and u / u_s of a profile; nan below y0 and above its surface.

    Parameters
    ----------
    y, velocity : (n,) array, m, m/s
        Upwards.
    full : (n,) bool array
        Which layers are full enough for the surface to be in or above them.
    least_speed : float, m/s
        A flow is faster at its surface; else all is nan.

    Examples
    --------
    >>> y = np.array([0.5, 1.5, 2.5, 3.5, 4.5])
    >>> scaled = normalized(y, np.array([0.0, 0.0, 1.0, 2.0, 2.5]), np.arange(5) < 4, 0.05)
    >>> print(*scaled)
    [       nan        nan 0.44444444 1.                nan] [nan nan 0.5 1.  nan]
    """
    height, speed = np.full(y.size, np.nan), np.full(y.size, np.nan)
    surface = int(np.flatnonzero(full)[-1]) if full.any() else -1
    if surface < 0 or velocity[surface] <= least_speed:
        return height, speed
    least = MOVING_SHARE * velocity[surface]
    slower = np.flatnonzero(velocity[:surface] < least)
    lowest = int(slower[-1]) + 1 if slower.size else 0
    zero = 0.0
    if slower.size:
        between = slice(lowest - 1, lowest + 1)
        zero = float(np.interp(least, velocity[between], y[between]))
    moving = slice(lowest, surface + 1)
    height[moving] = (y[moving] - zero) / (y[surface] - zero)
    speed[moving] = velocity[moving] / velocity[surface]
    return height, speed


def flow_probes(case: ResolvedCase) -> list[Probe]:
    """Return the probes of a case whose samples are hydrographs, as those at stations are."""
    return [
        probe
        for probe in case.probe
        if {column.name for column in columns_of(probe, case.dimension)} >= FLOW_COLUMNS
    ]


def hydrograph_rows(
    case: ResolvedCase, frame: Frame, stations: Iterable[float], gone: tuple[float, float]
) -> Iterator[Row]:
    """Yield how much is downstream of each station, and depth and speed there, in a frame.

    Depth and speed are those of a section probe: sums over particles of volume V with the weight
    ``h = (1 - |x_i - x| / d0) / d0``, whose integral is 1.

    Parameters
    ----------
    case : ResolvedCase
    frame : Frame
    stations : iterable of float, m
    gone : (float, float)
        Particles that have left the run until then, and the volume of the grains in them, in
        particles.

    Yields
    ------
    tuple
        time, station, particles and volume of grains downstream or gone, depth, speed.
    """
    d0, volume, fluid = case.particles.spacing, particle_volume(case), frame.fluid
    x, share = frame.position[fluid, 0], frame.sediment_fraction[fluid]
    across, velocity = frame.position[fluid, 1], frame.velocity[fluid, 0]
    repeats = domain(case).period[0] > 0.0
    for station in stations:
        past = np.nan if repeats else x >= station
        passed = np.sum(past) + gone[0], np.sum(past * share) + gone[1]
        offset = np.abs(_offset(case, x, station))
        rows = np.flatnonzero(offset < d0)
        part = volume * (1.0 - offset[rows] / d0) / d0
        area, flux = float(part.sum()), float(part @ velocity[rows])
        width = 1.0
        if case.dimension == 3:
            width = wetted_width(across[rows], d0)
        is_wet = area > 0.0
        depth, speed = (area / width, flux / area) if is_wet else (0.0, np.nan)
        yield frame.time, station, *passed, depth, speed


def hydrographs(case: ResolvedCase, rows: list[Row]) -> Table:
    """Return the hydrographs of all frames from how much is downstream of each station."""
    known = np.array(rows, dtype=float).reshape(len(rows), 6)
    time, station, passed = known[:, 0], known[:, 1], known[:, 2:4]
    volumes, rates = np.full((2, len(rows), 2), np.nan)
    for place in np.unique(station):
        here = station == place
        count = np.round(passed[here] - passed[here][0], COUNT_DIGITS)
        volumes[here] = particle_volume(case) * count
        if np.count_nonzero(here) > 1:
            rates[here] = np.gradient(volumes[here], time[here], axis=0)
    columns = np.column_stack([time, station, rates, known[:, 4:], volumes]).T
    return dict(zip(HYDROGRAPH_COLUMNS, columns, strict=True))
