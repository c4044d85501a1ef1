"""What a case will run, told before it runs: particles, lattice, time step, memory and disk."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, hypot, sqrt

import numpy as np

from debrisflow.case import Case
from debrisflow.case.estimate import particle_estimate, size
from debrisflow.case.regions import Rectangle, covered
from debrisflow.case.tables import Block
from debrisflow.lattice import Reference, reference
from debrisflow.particles import Kind, seed

# One fluid particle in a compressed particle file.  Walls take less: with random fields and three
# particles in five fluid, 37 were measured.
BYTES_ON_DISK = 60


@dataclass(frozen=True)
class Forecast:
    """Figures of a run before it starts.

    Attributes
    ----------
    counts : dict of str to int
        Particles by kind, those that are there.
    lattice : Reference
        Lattice constants of the influence radius.
    first_step, smallest_step : float, s
        Time step at the start, and at the largest speed.
    largest_speed : float, m/s
        Of a free fall through the height of fills and supply, on top of the speeds given.
    steps : int
        Steps to the end, at the smallest step.
    memory, disk : float, bytes
    frames : int
        Particle files.
    """

    counts: dict[str, int]
    lattice: Reference
    first_step: float
    smallest_step: float
    largest_speed: float
    steps: int
    memory: float
    disk: float
    frames: int

    def __str__(self) -> str:
        """Return the figures as a few lines for people."""
        kinds = ", ".join(f"{count:,} {kind}" for kind, count in self.counts.items())
        lattice = self.lattice
        return "\n".join(
            [
                f"particles      {sum(self.counts.values()):,}: {kinds}",
                f"lattice        n0 = {lattice.number_density:.4f}, "
                f"lambda = {lattice.laplacian_lambda:.4g} m2, {lattice.neighbors} neighbors",
                f"first step     {self.first_step:.3g} s",
                f"largest speed  {self.largest_speed:.3g} m/s by free fall, "
                f"there the step is {self.smallest_step:.3g} s",
                "c/u            none: the semi-implicit scheme is incompressible",
                f"steps          about {self.steps:,} at that step",
                f"memory         {size(self.memory)}",
                f"disk           {size(self.disk)} in {self.frames:,} particle files",
            ]
        )


def forecast(case: Case) -> Forecast:
    """Return the figures of a checked case.

    The number of steps is an upper estimate, since friction and walls keep the flow below the
    speed of a free fall.
    """
    given = _given_speed(case)
    speed = given + sqrt(2 * hypot(*case.gravity.components) * _fall(case))
    smallest = _step(case, speed)
    counts = _counts(case)
    frames = ceil(case.time.end / case.output.interval - 1e-9) + 1
    return Forecast(
        counts=counts,
        lattice=reference(2, case.particles.effective_radius, case.particles.spacing),
        first_step=_step(case, given),
        smallest_step=smallest,
        largest_speed=speed,
        steps=ceil((case.time.end + case.time.relaxation) / smallest),
        memory=particle_estimate(case)["memory"],
        disk=float(frames * sum(counts.values()) * BYTES_ON_DISK),
        frames=frames,
    )


def _counts(case: Case) -> dict[str, int]:
    """Return the numbers of the particles that are seeded, by kind."""
    numbers = np.bincount(seed(case).kind, minlength=len(Kind))
    names = {kind: kind.name.lower() for kind in Kind} | {Kind.DUMMY: "dummy wall"}
    return {names[kind]: int(numbers[kind]) for kind in Kind if numbers[kind]}


def _step(case: Case, speed: float) -> float:
    """Return the time step that the case allows at a speed, s."""
    assert case.time.largest_step is not None
    path = case.scheme.courant * case.particles.spacing
    return min(case.time.largest_step, path / speed if speed > 0 else float("inf"))


def _given_speed(case: Case) -> float:
    """Return the largest speed in the case file: of a fill, a wall or the supply, m/s."""
    speeds = [hypot(*part.velocity) for part in case.fill if isinstance(part, Block)]
    speeds += [hypot(*wall.velocity) for _, wall in case.walls]
    if case.inflow is not None:
        graph = case.inflow.hydrograph
        if graph is None:
            speeds.append(case.inflow.velocity or 0.0)
        elif not isinstance(graph, str):
            speeds.append(max(graph.discharge) / case.inflow.depth)
    return max(speeds)


def _fall(case: Case) -> float:
    """Return the height of fills and supply along gravity, m."""
    areas = [covered(part, case.geometry, case.particles) for part in case.fill]
    if case.inflow is not None:
        areas.append(Rectangle(0.0, 0.0, 0.0, case.inflow.depth))
    magnitude = hypot(*case.gravity.components)
    if magnitude == 0:
        return 0.0
    down = [component / magnitude for component in case.gravity.components]
    levels = [
        down[0] * x + down[1] * y
        for area in areas
        if area is not None
        for x in (area.left, area.right)
        for y in (area.bottom, area.top)
    ]
    return max(levels) - min(levels)
