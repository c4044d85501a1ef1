"""The whole state of a run: a checkpoint of it lets the run continue bit for bit."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, tables
from debrisflow.neighbors.patches import Patches, no_patches
from debrisflow.particles import hydrostatic_start
from debrisflow.particles.maxima import Maxima, no_maxima
from debrisflow.particles.record import Particles
from debrisflow.particles.seeding import seed
from debrisflow.particles.supply import supplied_sediment, whole_sediment
from debrisflow.space.carving import fitted
from debrisflow.space.domain import wall_layers
from debrisflow.space.plan_grid import plan

Floats = NDArray[np.float64]
PHASES = ("liquid", "sediment", "mixture")


def _counts() -> NDArray[np.int64]:
    return np.zeros(len(PHASES), dtype=np.int64)


def _sums() -> Floats:
    return np.zeros(len(PHASES))


@dataclass
class State:
    """Particles, maxima, clock and counters of a run.

    Attributes
    ----------
    particles : Particles
    maxima : Maxima
        The greatest depth, speed and momentum flux since t = 0.
    time : float
        Simulated time, s; negative while the fills relax.
    step : int
        Steps taken since the start of the run.
    dt : float
        Length of the last step, s.
    entered, left, through_wall : (3,) int64 array
        Particles by phase that came in through the inflow, left through an open end or over a
        rim, and were lost through a wall.
    entered_sediment, left_sediment, through_wall_sediment : (3,) float64 array
        The volume of sediment in these, in particles.
    particle_steps, bounces : int
        Fluid particles summed over all steps, those before a resume among them, and how often one
        bounced off a wall as a surface.
    supply_columns : int
        Columns of inflow particles seeded so far.
    supply_sediment : float
        Sediment particles that the supply still has to bring to reach its concentration.
    next_id : int
        The number that the next new particle gets.
    peak_energy : float, J
        Greatest kinetic energy of the fluid since t = 0, in two dimensions J/m; kept where a case
        has a stop rule.
    sums : dict of str to float64 array
        Running sum of each probe that has one, by the name of the probe.
    wall_force : (walls, 6) float64 array, N, N m
        Force and its moment about the origin on each wall and obstacle in the last step, where
        walls are surfaces and a probe asks for it; else without rows.  No checkpoint holds it.
    patches : Patches
        Patches of walls that probes want the force on; no checkpoint holds them.
    patch_force : (patches, 3) float64 array, N
        On each of these in the last step, as ``wall_force``.
    """

    particles: Particles
    maxima: Maxima
    time: float = 0.0
    step: int = 0
    dt: float = 0.0
    entered: NDArray[np.int64] = field(default_factory=_counts)
    left: NDArray[np.int64] = field(default_factory=_counts)
    through_wall: NDArray[np.int64] = field(default_factory=_counts)
    entered_sediment: Floats = field(default_factory=_sums)
    left_sediment: Floats = field(default_factory=_sums)
    through_wall_sediment: Floats = field(default_factory=_sums)
    particle_steps: int = 0
    bounces: int = 0
    supply_columns: int = 0
    supply_sediment: float = 0.0
    next_id: int = 0
    peak_energy: float = 0.0
    sums: dict[str, Floats] = field(default_factory=dict)
    wall_force: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    patches: Patches = field(default_factory=no_patches)
    patch_force: Floats = field(default_factory=lambda: np.zeros((0, 3)))


def count_phases(
    kind: NDArray[np.integer],
    fraction: Floats,
    number: NDArray[np.int64],
    sediment: Floats,
    times: Floats | None = None,
) -> None:
    """Add particles of given kinds and sediment fractions to counters by phase, in place.

    Parameters
    ----------
    kind : (n,) int array
    fraction : (n,) float64 array
    number : (3,) int64 array
        Particles.
    sediment : (3,) float64 array
        The volume of sediment in them, in particles.
    times : (n,) float64 array, optional
        How often each counts; once if left out.
    """
    once = np.ones(kind.size) if times is None else times
    number += np.rint(np.bincount(kind, once, number.size)).astype(np.int64)
    sediment += np.bincount(kind, once * fraction, sediment.size)


def initial_state(case: ResolvedCase) -> State:
    """Return the state of a case at its start, before its fills relax."""
    particles = seed(case)
    if isinstance(case.scheme, tables.ExplicitScheme):
        hydrostatic_start.compress(particles, case)
    if case.obstacle:
        particles.position[particles.fluid] = fitted(case, particles.position[particles.fluid])
    if isinstance(case.scheme, tables.ExplicitScheme):
        hydrostatic_start.jitter(particles, case)
    maxima = no_maxima(plan(case).x.size)
    state = State(particles, maxima, time=0.0 - case.time.settling, next_id=particles.count)
    if case.inflow is not None:
        state.supply_columns = wall_layers(case)
        owed = supplied_sediment(case, state.supply_columns)
        state.supply_sediment = owed - whole_sediment(case, owed)
    return state
