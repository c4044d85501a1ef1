"""The forecast of a run: particles, lattice, time step, memory and disk space."""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.built import HEAD, Rounded
from debrisflow.case.defaults import LEAST_SOUND_RATIO, TERRAIN_SOUND_RATIO
from debrisflow.case.doubts import doubts, rows_over_depths
from debrisflow.case.estimate import particle_estimate
from debrisflow.case.memory import size
from debrisflow.case.resolved import ResolvedExplicitScheme, ResolvedTerrain
from debrisflow.case.speeds import collapse_speed, fall_speed
from debrisflow.case.tables import EXPLICIT_RADIUS
from debrisflow.neighbors.lattice import Reference, reference
from debrisflow.particles.record import Kind
from debrisflow.particles.seeding import seed
from debrisflow.particles.state import PHASES
from debrisflow.run.disk import needed, times
from debrisflow.run.duration import duration
from debrisflow.run.ground_forecast import (
    AT_START,
    GroundForecast,
    ground_forecast,
    released_counts,
)
from debrisflow.run.pace import Pace
from debrisflow.run.work import mean_number, speeds, step_at
from debrisflow.space.encounters import encounters
from debrisflow.space.volumes import differences


@dataclass(frozen=True)
class Sound:
    """The figures that show how nearly incompressible a weakly compressible flow is.

    Attributes
    ----------
    speed : float, m/s
        Numerical speed of sound c.
    ratio : float
        c over the largest speed.
    compression : float
        rho g H / (rho c^2) of a column as high as fills and supply, or as the deepest release.
    least : float
        Of c over the largest speed, from which on a flow is nearly incompressible.
    """

    speed: float
    ratio: float
    compression: float
    least: float = LEAST_SOUND_RATIO

    def __str__(self) -> str:
        """Return the figures as a readable line, with a warning if they are poor."""
        line = (
            f"{self.ratio:.3g}: the speed of sound is {self.speed:.3g} m/s, "
            f"the compression at rest {100 * self.compression:.2g} %"
        )
        if self.ratio < self.least * (1 - 1e-9):
            enough = self.speed * self.least / self.ratio
            line += (
                f"\nwarning        c/u = {self.ratio:.3g}: below {self.least:g}, "
                f"the flow is compressible; scheme.sound_speed = {enough:.3g} m/s would do"
            )
        return line


@dataclass(frozen=True)
class Forecast:
    """Figures of a run before it starts.

    Attributes
    ----------
    counts : dict of str to int
        Particles by kind, without kinds that the case lacks; on a terrain all that are released,
        by when and how.
    rows : dict of str to int
        Rows of particles over the depths of blocks and supply, by their keys.
    lattice : Reference
        Lattice constants of the influence radius.
    first_step, smallest_step : float, s
        Time step at the start, and at the largest speed.
    largest_speed : float, m/s
        That of a free fall through the height of fills and supply, added to the given speeds; on a
        terrain that at which friction holds the flow.
    by : str
        What is expected to bring about that speed.
    fewest_steps, steps : int
        Steps to the end if all are as long as the first, and as short as the smallest.
    fluid : float
        Mean number of fluid particles, with those that the supply brings.
    pace : Pace or None
        How fast this machine computes; None if that is not known.
    memory, disk : float, bytes
    frames : int
        Particle files.
    sound : Sound or None
        None in the incompressible scheme.
    poor : dict of str to list of str
        Names of the probes whose answer will be poor, by the reason.
    doubts : list of str
        What is doubtful about the case.
    rounded : list of Rounded
        What is built otherwise than asked.
    ground : GroundForecast or None
        On a terrain.
    """

    counts: dict[str, int]
    rows: dict[str, int]
    lattice: Reference
    first_step: float
    smallest_step: float
    largest_speed: float
    by: str
    fewest_steps: int
    steps: int
    fluid: float
    pace: Pace | None
    memory: float
    disk: float
    frames: int
    sound: Sound | None
    poor: dict[str, list[str]]
    doubts: list[str]
    rounded: list[Rounded]
    ground: GroundForecast | None = None

    @property
    def wall_time(self) -> tuple[float, float] | None:
        """The least and the greatest wall time expected, s, without compiling kernels."""
        if self.pace is None:
            return None
        least, most = (
            self.pace.seconds_for(self.fluid, n) for n in (self.fewest_steps, self.steps)
        )
        return least, most

    def __str__(self) -> str:
        """Return the figures as a few readable lines."""
        kinds = ", ".join(f"{count:,} {kind}" for kind, count in self.counts.items())
        lattice, rows = self.lattice, ", ".join(f"{name}: {n}" for name, n in self.rows.items())
        sound = self.sound or "none: the semi-implicit scheme is incompressible"
        radius = lattice.effective_radius / lattice.spacing
        warning = ""
        if self.sound and abs(radius - EXPLICIT_RADIUS) > 1e-6:
            warning = (
                f"\nwarning        effective_radius = {radius:g}: water at rest keeps its height "
                f"at {EXPLICIT_RADIUS:g} only"
            )
        return "\n".join(
            [
                f"particles      {sum(self.counts.values()):,}: {kinds}",
                *([f"rows           over depths, {rows}"] if rows else []),
                *([str(self.ground)] if self.ground else []),
                f"lattice        n0 = {lattice.number_density:.4f}, "
                f"lambda = {lattice.laplacian_lambda:.4g} m2, {lattice.neighbors} neighbors"
                + warning,
                f"first step     {self.first_step:.3g} s",
                f"largest speed  {self.largest_speed:.3g} m/s by {self.by}, "
                f"there the step is {self.smallest_step:.3g} s",
                f"c/u            {sound}",
                f"steps          about {self.steps:,} at that step",
                f"wall time      {self._wall_time()}",
                f"memory         {size(self.memory)}",
                f"disk           {size(self.disk)}, {self.frames:,} particle files among it"
                + self._warnings(),
                *([HEAD, *map(str, self.rounded)] if self.rounded else []),
            ]
        )

    def _wall_time(self) -> str:
        if self.wall_time is None:
            return "unknown before the first run of this kind here; --measure takes a few steps"
        least, most = map(duration, self.wall_time)
        between = least if least == most else f"{least} to {most}"
        return f"{between} at {self.pace}"

    def _warnings(self) -> str:
        probes = [f"{', '.join(names)}: {text}" for text, names in self.poor.items()]
        return "".join(f"\nwarning        {text}" for text in (*probes, *self.doubts))


def forecast(case: ResolvedCase, pace: Pace | None = None) -> Forecast:
    """Return the figures of a checked case.

    The number of steps is an upper estimate, because friction and walls keep the flow slower than
    a free fall.

    Parameters
    ----------
    case : ResolvedCase
    pace : Pace, optional
        How fast this machine computes.
    """
    given, speed = speeds(case)
    space = case.fill, case.inflow, case.geometry, case.particles, case.gravity
    released = case.release, case.gravity
    first, smallest = step_at(case, given), step_at(case, speed)
    whole = case.time.end + case.time.settling
    is_terrain = isinstance(case.geometry, ResolvedTerrain)
    counts = released_counts(case) if is_terrain else _counts(case)
    at_start = (AT_START,) if is_terrain else PHASES
    fluid = mean_number(case, sum(counts.get(name, 0) for name in at_start))
    frames = times(case.time.end, case.output.interval)
    return Forecast(
        counts=counts,
        rows=rows_over_depths(case),
        lattice=reference(case.dimension, case.particles.effective_radius, case.particles.spacing),
        first_step=first,
        smallest_step=smallest,
        largest_speed=speed,
        by="friction at most" if is_terrain else "free fall",
        fewest_steps=ceil(whole / first),
        steps=ceil(whole / smallest),
        fluid=fluid,
        pace=pace,
        memory=particle_estimate(case)["memory"],
        disk=needed(case, fluid if is_terrain else max(fluid, sum(counts.values()))),
        frames=frames,
        sound=_sound(case, speed, max(fall_speed(*space), collapse_speed(*released))),
        poor=_poor(case),
        doubts=[*doubts(case), *encounters(case)],
        rounded=differences(case),
        ground=ground_forecast(case) if is_terrain else None,
    )


def _poor(case: ResolvedCase) -> dict[str, list[str]]:
    """Return the names of the probes that warn, by what they say."""
    found: dict[str, list[str]] = {}
    for probe in case.probe:
        if text := probe.warning(case.particles.spacing):
            found.setdefault(text, []).append(probe.name)
    return found


def figures(found: Forecast) -> dict[str, Any]:
    """Return the figures of a forecast by name, as ``debrisflow check --json`` prints them."""
    least, most = found.wall_time or (None, None)
    lines = (re.split(r"( +)", line, maxsplit=1) for line in str(found).splitlines() if " " in line)
    return {
        "particles": sum(found.counts.values()),
        "counts": found.counts,
        "rows": found.rows,
        "first_step": found.first_step,
        "smallest_step": found.smallest_step,
        "largest_speed": found.largest_speed,
        "fewest_steps": found.fewest_steps,
        "steps": found.steps,
        "least_wall_seconds": least,
        "wall_seconds": most,
        "memory": found.memory,
        "disk": found.disk,
        "frames": found.frames,
        "warnings": [text for word, _, text in lines if word == "warning"],
        "built": [str(line) for line in found.rounded],
    }


def _sound(case: ResolvedCase, speed: float, fall: float) -> Sound | None:
    """Return the figures of the speed of sound; a fall from H ends at the speed sqrt(2 g H)."""
    if not isinstance(case.scheme, ResolvedExplicitScheme):
        return None
    c = case.scheme.sound_speed
    is_terrain = isinstance(case.geometry, ResolvedTerrain)
    least = TERRAIN_SOUND_RATIO if is_terrain else LEAST_SOUND_RATIO
    return Sound(c, c / speed if speed > 0 else float("inf"), fall**2 / (2.0 * c**2), least)


def _counts(case: ResolvedCase) -> dict[str, int]:
    """Return the number of seeded particles by kind."""
    numbers = np.bincount(seed(case).kind, minlength=len(Kind))
    names = {kind: kind.name.lower() for kind in Kind} | {Kind.DUMMY: "dummy wall"}
    return {names[kind]: int(numbers[kind]) for kind in Kind if numbers[kind]}
