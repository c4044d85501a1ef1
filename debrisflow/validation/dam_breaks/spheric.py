"""Dam break against a box (SPHERIC test 2): water levels, pressures on the box, arrivals.

Water level is the filled height of a probe: the wire of a gauge counts the length of it that is
wet, to which air below a jet adds nothing and a jet its own thickness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case, tables
from debrisflow.run.probes import samplers
from debrisflow.validation.files import CASES, REFERENCES
from debrisflow.validation.marching import energy, states

Floats = NDArray[np.float64]
CASE = CASES / "marin3d.toml"
REFERENCE = REFERENCES / "kleefsman_2005.csv"
GATE, WATER, DEPTH, WIDTH = 1.992, 1.228, 0.55, 1.0
BOX_FACE, BOX_LENGTH, BOX_WIDTH, BOX_HEIGHT = 0.8245, 0.161, 0.403, 0.161
FROM_EDGE, OFFSET = (0.021, 0.061, 0.101, 0.141), 0.0255  # of the pressure gauges
GAUGES = ("h1", "h2", "h3", "h4")
PRESSURES = tuple(f"p{k}" for k in range(1, 9))
FIRST_PRESSURE = len(GAUGES)  # among the probes of the case
WET, PRESSED = 0.01, 1000.0  # m, Pa
MEAN_OVER, SAMPLES = 0.01, 5  # s; as the measured series, and the samples in each mean
SPACINGS = (0.05, DEPTH / 18)


def experiment() -> dict[str, Floats]:
    """Return the measured series by name; ``time`` in s, levels in m, pressures in Pa."""
    names = ("time", *PRESSURES, "h3", "h2", "h1", "h4")
    rows = np.loadtxt(REFERENCE, delimiter=",", skiprows=4)
    return dict(zip(names, rows.T, strict=True))


def changes(spacing: float) -> dict[str, float | list[float]]:
    """Return the changes to the shipped case that round all lengths to another spacing.

    Lengths along x count from the wall at x = 0, from which the gauges are placed; the tank ends
    with the water.  The box stands in the middle of the width, and the gauges on it keep their
    distances to the floor and to the edge that the water meets.

    Examples
    --------
    >>> [round(x, 3) for x in changes(0.05)["obstacle.0.x"]]
    [0.65, 0.8]
    """

    def rounded(length: float) -> float:
        return spacing * round(length / spacing)

    gate, face, width, top = map(rounded, (GATE, BOX_FACE, WIDTH, BOX_HEIGHT))
    end = gate + rounded(WATER)
    beside = rounded(0.5 * (width - BOX_WIDTH))
    found: dict[str, float | list[float]] = {
        "particles.spacing": spacing,
        "geometry.length": end,
        "geometry.width": width,
        "geometry.height": rounded(1.0),
        "obstacle.0.x": [face - rounded(BOX_LENGTH), face],
        "obstacle.0.y": [beside, width - beside],
        "obstacle.0.z": [0.0, top],
        "fill.0.x": [gate, end],
        "fill.0.y": [0.0, width],
        "fill.0.z": [0.0, rounded(DEPTH)],
    }
    for k, name in enumerate(GAUGES + PRESSURES):
        found[f"probe.{k}.y"] = 0.5 * width - (OFFSET if name in PRESSURES else 0.0)
    for k, from_edge in enumerate(FROM_EDGE):
        found[f"probe.{FIRST_PRESSURE + k}.x"] = face
        found[f"probe.{FIRST_PRESSURE + 4 + k}.x"] = face - from_edge
        found[f"probe.{FIRST_PRESSURE + 4 + k}.z"] = top
    return found


def build(spacing: float, end: float, overrides: tuple[str, ...] = ()) -> tables.Case:
    """Return cases/marin3d.toml at another spacing, with its lengths rounded to it."""
    rounded = [f"{key}={value!r}" for key, value in changes(spacing).items()]
    return load_case(CASE, [*rounded, f"time.end={end!r}", *overrides])


@dataclass
class Marin:
    """What a run measured, beside the experiment.

    Attributes
    ----------
    series : dict
        By name the (n,) float64 arrays ``time``, s; ``h1`` to ``h4``, m, filled heights;
        ``top_h1`` to ``top_h4``, m, contiguous heights; ``p1`` to ``p8``, Pa, by the fluid before
        the patch, and ``reaction_p1`` to ``reaction_p8`` by the reaction of the wall; all means
        over 10 ms, as those of the experiment.
    through_wall, over_rim : int
        Particles that were lost.
    energy : float
        Greatest over that at the start.
    """

    series: dict[str, Floats]
    through_wall: int
    over_rim: int
    energy: float

    def level_error(self, gauge: str, until: float, measure: str = "") -> float:
        """Return the rms of the difference of a water level up to a time, m."""
        measured = experiment()
        inside = measured["time"] <= min(until, self.series["time"][-1])
        ours = np.interp(measured["time"], self.series["time"], self.series[measure + gauge])
        return float(np.sqrt(np.mean((ours - measured[gauge])[inside] ** 2)))

    def arrival(self, name: str) -> float:
        """Return when a gauge was first wet, or first pressed on, s."""
        return arrival(self.series, name)

    def impulse(self, name: str, start: float = 0.4, end: float = 1.2) -> float:
        """Return the integral of a pressure over time, Pa s."""
        return impulse(self.series, name, start, end)

    def scatter(self, name: str, start: float = 0.6, end: float = 1.2) -> float:
        """Return the standard deviation of a series about its mean over 110 ms, Pa."""
        return scatter(self.series, name, start, end)


def arrival(series: dict[str, Floats], name: str) -> float:
    """Return when a level first passed 1 cm, or a pressure 1 kPa, s; nan if never."""
    passed = series[name] > (WET if name in GAUGES else PRESSED)
    return float(series["time"][np.argmax(passed)]) if passed.any() else np.nan


def impulse(series: dict[str, Floats], name: str, start: float = 0.4, end: float = 1.2) -> float:
    """Return the integral of a pressure from one time, s, to another, Pa s."""
    time = np.linspace(start, end, 801)
    return float(np.trapezoid(np.interp(time, series["time"], series[name]), time))


def scatter(series: dict[str, Floats], name: str, start: float = 0.6, end: float = 1.2) -> float:
    """Return the standard deviation of a series of 10 ms means about its mean over 110 ms, Pa."""
    time = np.arange(0.0, series["time"][-1], MEAN_OVER)
    values = np.interp(time, series["time"], series[name])
    about = values - np.convolve(values, np.full(11, 1.0 / 11.0), mode="same")
    return float(np.std(about[(time >= start) & (time <= end)]))


def means(rows: Floats, time: Floats) -> Floats:
    """Return the means of rows over 10 ms, as the experiment is given."""
    bins = (time / MEAN_OVER).astype(int)
    _, group, count = np.unique(bins, return_inverse=True, return_counts=True)
    summed = np.zeros((count.size, rows.shape[1]))
    np.add.at(summed, group, rows)
    return summed / count[:, None]


def run(spacing: float = 0.05, end: float = 2.0, overrides: tuple[str, ...] = ()) -> Marin:
    """Run the case at a spacing and read its probes."""
    case = build(spacing, end, overrides)
    rows, greatest, start, measures, count = [], 0.0, 0.0, {}, -1
    for state in states(case):
        measures = measures or samplers(case, state)
        for name in PRESSURES:
            measures[name].add_step(state)
        if int(state.time / MEAN_OVER * SAMPLES) <= count:
            continue
        count = int(state.time / MEAN_OVER * SAMPLES)
        samples = {name: measures[name].sample(state) for name in (*GAUGES, *PRESSURES)}
        levels = np.array([samples[name] for name in GAUGES])
        pressures = np.array([samples[name][:2] for name in PRESSURES])
        rows.append([state.time, *levels[:, 1], *levels[:, 0], *pressures.T.ravel()])
        greatest = max(greatest, energy(case, state))
        start = start or greatest
    tops, reactions = (f"top_{name}" for name in GAUGES), (f"reaction_{name}" for name in PRESSURES)
    names = ("time", *GAUGES, *tops, *PRESSURES, *reactions)
    table = np.array(rows)
    return Marin(
        dict(zip(names, means(table, table[:, 0]).T, strict=True)),
        int(state.through_wall.sum()),
        int(state.left.sum()),
        greatest / start,
    )
