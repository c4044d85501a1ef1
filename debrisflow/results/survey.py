"""One pass over the frames of a run: fronts, profiles, hydrographs, deposits, momentum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from debrisflow.errors import OutputError
from debrisflow.particles.state import PHASES
from debrisflow.results.budgets import momentum_row, momentum_table
from debrisflow.results.deposition import Deposition, deposition
from debrisflow.results.frames import read_frame
from debrisflow.results.fronts import (
    Mobility,
    front_row,
    front_table,
    headline_of,
    mobility,
    moving_parts,
    source_of,
    start_of,
)
from debrisflow.results.measured import Measured, last_part
from debrisflow.results.reader import BAR, Run
from debrisflow.results.station_figures import station_figures
from debrisflow.results.stations import (
    hydrograph_rows,
    hydrographs,
    is_within,
    mean_profiles,
    profile_columns,
    profile_rows,
)
from debrisflow.results.terrain_survey import TerrainSurvey, survey_terrain
from debrisflow.run.bar import bar
from debrisflow.run.measures import particle_volume
from debrisflow.run.tables import Row, Table
from debrisflow.space.plan_grid import floor_length

Floats = NDArray[np.float64]
STATIONS_REFUSED = (
    "stations are places along x, and a flow on a terrain follows no axis: place probes, of the "
    "types section, point or height, in the case instead"
)
TIMES_REFUSED = (
    "deposits at times are of runs in a tank or a channel: on a terrain output.layer_interval "
    "keeps the depth at times"
)
STATIONS = 7


@dataclass(frozen=True)
class Survey(Measured):
    """What was measured in the frames of a run, beside what :class:`Measured` has.

    Attributes
    ----------
    stations : tuple of float, m
        Of profiles and hydrographs.
    chosen : bool
        Whether the stations were asked for, and so are averaged together too.
    profiles, hydrographs, momentum : Table
        As the tables of the same names.
    deposits : list of Deposition
        At the first frame, at chosen times and at the last frame.
    phases : tuple of str
        Kinds of fluid in the frames, of ``PHASES``.
    mobilities : dict of Mobility
        By phase, or of ``all``: the headline first, which is what carries grains where there is
        water too.  Empty where fluid was over the whole length from the start: none can run out.
    """

    stations: tuple[float, ...]
    chosen: bool
    profiles: Table
    hydrographs: Table
    momentum: Table
    deposits: list[Deposition]
    phases: tuple[str, ...]
    mobilities: dict[str, Mobility]

    @property
    def headline(self) -> str:
        """Return whose front is the headline: a phase, or ``all``."""
        return headline_of(self.phases)

    @property
    def mobility(self) -> Mobility | None:
        """Return fall and travel of the headline; None where nothing can run out."""
        return self.mobilities.get(self.headline)

    @cached_property
    def station_figures(self) -> Table:
        """Return arrivals, peaks and volumes, a row a station."""
        return station_figures(self.stations, self.phases, self.run.history, self.hydrographs)

    @cached_property
    def mean_profiles(self) -> Table:
        """Return the profiles averaged over the window, by station."""
        return mean_profiles(self.run.case, self.profiles, self.window)

    @cached_property
    def pooled_profile(self) -> Table:
        """Return the profile averaged over the window and the stations."""
        return mean_profiles(self.run.case, self.profiles, self.window, pooled=True)


AnySurvey = Survey | TerrainSurvey


def survey(
    run: Run,
    stations: Sequence[float] = (),
    window: tuple[float, float] | None = None,
    times: Sequence[float] = (),
    smoothing: float | None = None,
) -> Survey:
    """Measure the frames of a run, with a progress bar.

    Parameters
    ----------
    run : Run
    stations : sequence of float, m
        x of profiles and hydrographs; every eighth of the length if there are none.
    window : (float, float), s, optional
        Over which profiles and samples of probes are averaged; the last fifth of the frames' time
        if left out.
    times : sequence of float, s
        At which the deposit is measured, each at the nearest frame, beside first and last.
    smoothing : float, s, optional
        Span of the running means of probes; ten intervals of each if left out.

    Raises
    ------
    OutputError
        If the run is on a terrain; if there are no frames, or one is missing or damaged; if a
        station is outside the domain, or no frame within the window or at a time.
    """
    if run.case.is_terrain:
        raise OutputError(
            f"{run.folder} is a run on a terrain, which has no stations along x; it is measured by "
            "survey_of"
        )
    case, at = run.case, run.times
    if window is None:
        window = last_part(at)
    places = tuple(dict.fromkeys(stations)) or tuple(
        k * floor_length(case) / (STATIONS + 1) for k in range(1, STATIONS + 1)
    )
    _must_be_inside(run, places, window)
    wanted = {0, len(at) - 1, *run.nearest(times)}
    rows: dict[str, list[Row]] = {name: [] for name in ("front", "profile", "station", "momentum")}
    deposits: list[Deposition] = []
    kinds: set[int] = set()
    has_grains = False
    progress = bar(run.files, desc=f"{run.name}: frames", bar_format=BAR)
    for number, (time, file) in enumerate(progress):
        frame = read_frame(time, file)
        if number == 0:
            start, source = start_of(case, frame), source_of(case, frame)
        kinds |= {int(kind) for kind in np.unique(frame.kind[frame.fluid])}
        has_grains |= bool(frame.sediment_fraction[frame.fluid].any())
        rows["front"].append(front_row(case, frame, start))
        rows["profile"].extend(profile_rows(case, frame, places))
        rows["station"].extend(hydrograph_rows(case, frame, places, _gone(run, time)))
        rows["momentum"].append(momentum_row(case, frame))
        if number in wanted:
            deposits.append(deposition(case, frame, deposits[0] if deposits else None))
    fronts = front_table(rows["front"])
    phases = tuple(PHASES[kind] for kind in sorted(kinds))
    moving = () if start.fills(case) else moving_parts(phases)
    return Survey(
        run=run,
        stations=places,
        window=window,
        chosen=bool(stations),
        fronts=fronts,
        profiles=_table(profile_columns(case.dimension), rows["profile"]),
        hydrographs=hydrographs(case, rows["station"]),
        momentum=momentum_table(case, rows["momentum"]),
        deposits=deposits,
        phases=phases,
        has_grains=has_grains,
        mobilities={
            name: mobility(case, fronts["time"], fronts[f"front_{name}"], source) for name in moving
        },
        smoothing=smoothing,
    )


def _must_be_inside(run: Run, stations: Sequence[float], window: tuple[float, float]) -> None:
    length, times = floor_length(run.case), run.times
    for x in stations:
        if not 0.0 <= x <= length:
            raise OutputError(f"the station x = {x:g} m is outside the domain, 0 to {length:g} m")
    if not is_within(times, window).any():
        raise OutputError(
            f"no frame is between {window[0]:g} and {window[1]:g} s: {run.folder} has "
            f"{times.size} from {times[0]:g} to {times[-1]:g} s"
        )


def _gone(run: Run, time: float) -> tuple[float, float]:
    """Return the particles that have left a run until a time, and the grains in them."""
    history, ways = run.history, ("out", "through_wall")
    if history["time"].size == 0:
        return 0.0, 0.0  # it has not started
    count = sum(history[f"particles_{way}_{phase}"] for way in ways for phase in PHASES)
    grains = sum(history[f"sediment_volume_{way}"] for way in ways)
    both = count, grains / particle_volume(run.case)
    everything, sediment = (float(np.interp(time, history["time"], v)) for v in both)
    return everything, sediment


def _table(names: Sequence[str], rows: list[Row]) -> Table:
    columns = np.array(rows, dtype=float).reshape(len(rows), len(names)).T
    return dict(zip(names, columns, strict=True))


def survey_of(
    run: Run,
    stations: Sequence[float] = (),
    window: tuple[float, float] | None = None,
    times: Sequence[float] = (),
    smoothing: float | None = None,
) -> AnySurvey:
    """Return the survey of a run, by :func:`survey`, or of one on a terrain by its layers.

    Raises
    ------
    OutputError
        As :func:`survey`; if there are stations or times of deposits on a terrain, or its run has
        not written its layers yet.
    """
    if not run.case.is_terrain:
        return survey(run, stations, window, times, smoothing)
    if stations:
        raise OutputError(STATIONS_REFUSED)
    if times:
        raise OutputError(TIMES_REFUSED)
    return survey_terrain(run, window, smoothing)
