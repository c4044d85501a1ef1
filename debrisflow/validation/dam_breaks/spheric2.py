"""Dam break against a box (SPHERIC test 2): water levels, pressures on the box, arrivals.

Water level is the filled height of a probe: the wire of a gauge counts the length of it that is
wet, to which air below a jet adds nothing and a jet its own thickness.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, load_case
from debrisflow.results.references import read_reference
from debrisflow.run.probe import Sampler
from debrisflow.run.probes import samplers
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, measured
from debrisflow.validation.dam_breaks.fronts import EXPERIMENTS
from debrisflow.validation.dam_breaks.known import Known
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import energy, states
from debrisflow.validation.row import Row, at_most, energy_gained, near, none_of, stated

Floats = NDArray[np.float64]
CASE = CASES / "marin3d.toml"
REFERENCE = EXPERIMENTS / "spheric2.csv"
GATE, WATER, DEPTH, WIDTH = 1.992, 1.228, 0.55, 1.0
BOX_FACE, BOX_LENGTH, BOX_WIDTH, BOX_HEIGHT = 0.8245, 0.161, 0.403, 0.161
FROM_EDGE, OFFSET = (0.021, 0.061, 0.101, 0.141), 0.0255  # of the pressure gauges
GAUGES = ("h1", "h2", "h3", "h4")
PRESSURES = tuple(f"p{k}" for k in range(1, 9))
FIRST_PRESSURE = len(GAUGES)  # among the probes of the case
WET, PRESSED = 0.01, 1000.0  # m, Pa
MEAN_OVER, SAMPLES = 0.01, 5  # s; as the measured series, and the samples in each mean
FACE, TOP = PRESSURES[:4], PRESSURES[4:]
END = 2.0  # s; then waves run back and forth
STRUCK = 0.4, 1.2  # s, while the first wave presses on the face of the box
RETURNED = 1.2, 2.0  # s, while the wave that the far wall sends back presses on its top


def experiment() -> dict[str, Floats]:
    """Return the measured series by name; ``time`` in s, levels in m, pressures in Pa."""
    table = read_reference(REFERENCE).table
    return {name.split(".")[0]: values for name, values in table.items()}


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


def build(spacing: float) -> ResolvedCase:
    """Return cases/marin3d.toml at another spacing, with its lengths rounded to it."""
    rounded = [f"{key}={value!r}" for key, value in changes(spacing).items()]
    return load_case(CASE, [*rounded, f"time.end={END!r}"])


@dataclass
class Marin:
    """What a run measured, beside the experiment.

    Attributes
    ----------
    series : dict
        By name the (n,) float64 arrays ``time``, s; ``h1`` to ``h4``, m, filled heights; ``p1`` to
        ``p8``, Pa, by the fluid before the patch, and ``reaction_p1`` to ``reaction_p8`` by the
        reaction of the wall; all means over 10 ms, as those of the experiment.
    through_wall, over_rim : int
        Particles that were lost.
    energy : float
        Greatest over that at the start.
    """

    series: dict[str, Floats]
    through_wall: int
    over_rim: int
    energy: float

    def level_error(self, gauge: str) -> float:
        """Return the rms of the difference of a water level, m."""
        read = experiment()
        inside = read["time"] <= self.series["time"][-1]
        ours = np.interp(read["time"], self.series["time"], self.series[gauge])
        return float(np.sqrt(np.mean((ours - read[gauge])[inside] ** 2)))


def arrival(series: dict[str, Floats], name: str) -> float:
    """Return when a level first passed 1 cm, or a pressure 1 kPa, s; nan if never."""
    passed = series[name] > (WET if name in GAUGES else PRESSED)
    return float(series["time"][np.argmax(passed)]) if passed.any() else np.nan


def impulse(series: dict[str, Floats], name: str, during: tuple[float, float] = STRUCK) -> float:
    """Return the integral of a pressure over a time, Pa s."""
    time = np.linspace(*during, 801)
    return float(np.trapezoid(np.interp(time, series["time"], series[name]), time))


def peak(series: dict[str, Floats], name: str) -> float:
    """Return the greatest mean over 10 ms of a pressure while the first wave presses, Pa."""
    inside = (series["time"] >= STRUCK[0]) & (series["time"] <= STRUCK[1])
    return float(series[name][inside].max())


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


def run(spacing: float) -> Marin:
    """Run the case at a spacing and read its probes."""
    case = build(spacing)
    measures: dict[str, Sampler] = {}
    rows, greatest, start, count = [], 0.0, 0.0, -1
    for state in states(case):
        measures = measures or samplers(case, state)
        for name in PRESSURES:
            measures[name].add_step(state)
        if int(state.time / MEAN_OVER * SAMPLES) <= count:
            continue
        count = int(state.time / MEAN_OVER * SAMPLES)
        samples = {name: measures[name].sample(state) for name in (*GAUGES, *PRESSURES)}
        levels = [samples[name][1] for name in GAUGES]
        pressures = np.array([samples[name][:2] for name in PRESSURES])
        rows.append([state.time, *levels, *pressures.T.ravel()])
        greatest = max(greatest, energy(case, state))
        start = start or greatest
    names = ("time", *GAUGES, *PRESSURES, *(f"reaction_{name}" for name in PRESSURES))
    table = np.array(rows)
    return Marin(
        dict(zip(names, means(table, table[:, 0]).T, strict=True)),
        int(state.through_wall.sum()),
        int(state.left.sum()),
        greatest / start,
    )


def level_rows(found: Marin, label: str) -> Iterable[Row]:
    """Yield the rows of the levels and of when water is there."""
    for name in ("h1", "h2", "h3", "h4"):
        reason = "chosen: a spacing of the coarsest run"
        error = 100.0 * found.level_error(name)
        yield at_most(f"rms of the level {name.upper()} to {END:g} s", error, 5.0, reason, "cm")
    read = experiment()
    for name in ("h3", "h2", "p1", "h1"):
        threshold = "1 kPa" if name in PRESSURES else "1 cm"
        yield near(
            f"arrival at {name.upper()}, {threshold}",
            arrival(found.series, name),
            arrival(read, name),
            "chosen: 10 %; lengths rounded to the spacing shift it by 0.01 s, the gate by as much",
            share=0.10,
            unit="s",
            **(_LATE[name].at(label) if name in _LATE else {}),
        )


def pressure_rows(found: Marin, label: str) -> Iterable[Row]:
    """Yield the rows of the pressures by the reaction of the box."""
    read, ours = experiment(), {"time": found.series["time"]}
    ours |= {name: found.series[f"reaction_{name}"] for name in PRESSURES}
    reason = "chosen: 25 %; runs that differ by a jitter of the start differ by a tenth"

    def row(title: str, values: list[float], unit: str, during: tuple[float, float]) -> Row:
        known = _UNEVEN[title].at(label) if title in _UNEVEN else {}
        mine, theirs = (value / 1e3 for value in values)
        title = f"{title}, {during[0]} to {during[1]} s"
        return near(title, mine, theirs, reason, share=0.25, unit=unit, **known)

    for name in FACE:
        sums = [impulse(one, name) for one in (ours, read)]
        yield row(f"impulse of {name.upper()}", sums, "kPa s", STRUCK)
    for name in ("p1", "p3"):
        tops = [peak(one, name) for one in (ours, read)]
        yield row(f"peak of {name.upper()}", tops, "kPa", STRUCK)
    sums = [float(np.mean([impulse(one, p, RETURNED) for p in TOP])) for one in (ours, read)]
    yield row("mean impulse of P5 to P8", sums, "kPa s", RETURNED)
    shaking = scatter(ours, "p1") / 1e3
    yield stated("scatter of P1 about its mean over 110 ms", shaking, "kPa")


def measure(level: Level) -> Measured:
    """Return what the case gave at a spacing."""
    found = run(DEPTH / level.across)
    rows = [
        *level_rows(found, level.label),
        *pressure_rows(found, level.label),
        energy_gained(found.energy),
        none_of("particles through a wall", found.through_wall),
    ]
    errors = [found.level_error(name) for name in ("h2", "h3", "h4")]
    return Measured(tuple(rows), float(np.mean(errors)) / DEPTH, _panels(found))


def _panels(found: Marin) -> tuple[Panel, ...]:
    read, time = experiment(), found.series["time"]
    before = read["time"] <= END
    drawn = []
    for name, series, unit, axis in (
        *((name, name, 1.0, "level (m)") for name in ("h4", "h3", "h2")),
        *((name, f"reaction_{name}", 1e-3, "pressure (kPa)") for name in ("p1", "p2", "p3")),
    ):
        curves = (
            measured(read["time"][before], unit * read[name][before]),
            computed(time, unit * found.series[series]),
        )
        drawn.append(Panel(name.upper(), "t (s)", axis, curves))
    return tuple(drawn)


_CLOCK = (
    "the run may be late, or the clock of this benchmark may start after the release; nothing is "
    "shifted. A conjecture, for: scaled to this depth, the front of the square column of Martin & "
    "Moyce would be at H3 after 0.27 s. The lag falls with the spacing"
)
_LATE = {
    "h3": Known(_CLOCK, {"d0 = 50 mm": 0.277, "d0 = 31 mm": 0.252, "d0 = 23 mm": 0.252}),
    "h2": Known(_CLOCK, {"d0 = 50 mm": 0.405}, uncertain=("d0 = 50 mm",)),
    "p1": Known(_CLOCK, {"d0 = 50 mm": 0.460}),
}
_PRESSED = (
    "the box is three to five particles high: what presses at the foot is too much and at the "
    "upper edge, from which P4 is half a spacing, too little. Changing the artificial viscosity, "
    "the speed of sound and the relaxation changed the sums by 10 % (an earlier treatment of walls)"
)
_UNEVEN: dict[str, Known] = {
    "impulse of P2": Known(_PRESSED, {"d0 = 50 mm": 4.5}),
    "impulse of P3": Known(_PRESSED, {"d0 = 50 mm": 1.4}),
    "impulse of P4": Known(_PRESSED, {"d0 = 50 mm": 0.1, "d0 = 31 mm": 0.2, "d0 = 23 mm": 0.2}),
    "peak of P1": Known(_PRESSED, {"d0 = 50 mm": 15.5, "d0 = 31 mm": 15.5}),
    "peak of P3": Known(_PRESSED, {"d0 = 31 mm": 4.5}, uncertain=("d0 = 31 mm",)),
}
COMPARISONS = (
    Comparison(
        name="spheric2",
        title="Dam break against a box, SPHERIC benchmark 2",
        group=Group.DAM_BREAKS,
        compared=(
            "Water levels at three gauges, arrivals, and pressures on the face of the box by its "
            "reaction, means over 10 ms as the measured ones; nothing is shifted."
        ),
        reference="Kleefsman et al. 2005, doi:10.1016/j.jcp.2004.12.007",
        parameters=(
            "marin3d.toml, all lengths rounded to the spacing (the box is met 0.01 s late by it at "
            "50 mm); no gate, no air"
        ),
        levels=(
            Level(11, "d0 = 50 mm", 15, is_quick=True),
            Level(18, "d0 = 31 mm", 110),
            Level(24, "d0 = 23 mm", 350),
        ),
        measure=measure,
        error="mean of the rms of H2, H3 and H4 to 2 s / depth of the column",
        discussion=(
            "The impact is chaotic: three runs that differ by a jitter of the start give impulses "
            "that differ by a tenth at 50 mm. The experiment lasts 7.4 s; the first 2 s, which are "
            "compared, have the impact and the wave that the far wall sends back over the box, "
            "which alone presses on its top; the rest would take three times as long again. "
            "In files in circulation the gauges H1 and H3 are swapped; here they are named by "
            "their place."
        ),
    ),
)
