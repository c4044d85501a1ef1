"""Dam break against a wall (Zhou, De Kat & Buchner 1999): depths, and the pressure on the wall.

A column 1.2 m wide and 0.6 m high in a tank 3.22 m long, two dimensions.  Nothing is shifted: time
counts from the release.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables
from debrisflow.run.probes import samplers
from debrisflow.validation.cases import case_of
from debrisflow.validation.files import REFERENCES
from debrisflow.validation.marching import energy, states

Floats = NDArray[np.float64]
LENGTH, COLUMN, DEPTH = 3.22, 1.2, 0.6
GAUGES = {"h1": 2.725, "h2": 2.228}  # x of the levels, m
HIGH, WIDE = 0.16, 0.09  # of the pressure gauge, m
WET, PRESSED = 0.02, 1000.0  # m, Pa
PLATEAU, FIRST = (0.8, 1.3), 0.9  # s; the first peak is before
INTERVAL = 0.002  # s, as long as a pressure is averaged


def experiment() -> dict[str, Floats]:
    """Return the measured series by name, (n, 2) arrays, s and m or Pa."""
    with (REFERENCES / "zhou_1999.csv").open() as lines:
        rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return {
        name: np.array([(float(r["time"]), float(r["value"])) for r in rows if r["series"] == name])
        for name in ("h1", "h2", "p2")
    }


@dataclass
class Impact:
    """What a run measured.

    Attributes
    ----------
    series : dict of (n,) float64 arrays
        ``time``, s; ``h1``, ``h2``, filled heights, m; ``p2``, Pa, by the fluid before the wall,
        and ``reaction_p2``, by the reaction of the wall.
    energy : float
        Greatest over that at the start.
    lost : int
        Particles through a wall.
    """

    series: dict[str, Floats]
    energy: float
    lost: int

    def level_error(self, gauge: str, until: float = 1.4) -> float:
        """Return the rms of the difference of a level up to a time, m."""
        time, level = experiment()[gauge].T
        ours = np.interp(time, self.series["time"], self.series[gauge])
        return float(np.sqrt(np.mean((ours - level)[time <= until] ** 2)))


def arrival(time: Floats, values: Floats, threshold: float) -> float:
    """Return when a series first passes a threshold, s; nan if never."""
    passed = values > threshold
    return float(time[np.argmax(passed)]) if passed.any() else np.nan


def mean(time: Floats, values: Floats, start: float, end: float) -> float:
    """Return the mean of a series between two times."""
    grid = np.linspace(start, end, 501)
    return float(np.interp(grid, time, values).mean())


def smoothed(time: Floats, values: Floats, over: float = 0.02) -> Floats:
    """Return the running mean of a series over a time, s."""
    width = max(1, round(over / float(np.diff(time).mean())))
    return np.convolve(values, np.full(width, 1.0 / width), mode="same")


def build(spacing: float, end: float = 1.4) -> tables.Case:
    """Return the case at a spacing."""
    levels = [
        {"name": name, "type": "height", "x": x, "size": 2.0 * spacing}
        for name, x in GAUGES.items()
    ]
    place = {"wall": "right", "x": LENGTH, "y": HIGH, "size": WIDE}
    gauge = {"name": "p2", "type": "pressure"} | place
    block = {"type": "block", "x": [0.0, COLUMN], "y": [0.0, DEPTH], "material": "water"}
    return case_of(
        title="dam break against a wall",
        particles={"spacing": spacing},
        geometry={"type": "tank", "length": LENGTH, "height": 2.0},
        fill=[block],
        walls={"floor": {"roughness": 3.0e-4}},
        probe=[probe | {"interval": INTERVAL} for probe in (*levels, gauge)],
        time={"end": end},
        output={"interval": end},
    )


def run(spacing: float, end: float = 1.4) -> Impact:
    """Run the case at a spacing and read its probes."""
    case = build(spacing, end)
    rows, measures, greatest, start, count = [], {}, 0.0, 0.0, -1
    for state in states(case):
        measures = measures or samplers(case, state)
        measures["p2"].add_step(state)
        if int(state.time / INTERVAL) <= count:
            continue
        count = int(state.time / INTERVAL)
        levels = [measures[name].sample(state)[1] for name in GAUGES]
        rows.append([state.time, *levels, *measures["p2"].sample(state)[:2]])
        greatest = max(greatest, energy(case, state))
        start = start or greatest
    names = ("time", *GAUGES, "p2", "reaction_p2")
    series = dict(zip(names, np.array(rows).T, strict=True))
    return Impact(series, greatest / start, int(state.through_wall.sum()))
