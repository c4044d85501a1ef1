"""The whole state of a run: a checkpoint of it lets the run continue bit for bit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.neighbors.patches import Patches, no_patches
from debrisflow.particles.layers import Layers, no_layers
from debrisflow.particles.maxima import Maxima
from debrisflow.particles.record import Particles

Floats = NDArray[np.float64]
PHASES = ("liquid", "sediment", "mixture")


def _counts() -> NDArray[np.int64]:
    return np.zeros(len(PHASES), dtype=np.int64)


def _sums() -> Floats:
    return np.zeros(len(PHASES))


class Escaped(NamedTuple):
    """A particle that was lost through a wall.

    Attributes
    ----------
    id : int
    position : (3,) float64 array, m
        Where it was found.
    speed : float, m/s
    """

    id: int
    position: Floats
    speed: float


@dataclass
class State:
    """Particles, maxima, clock and counters of a run.

    Attributes
    ----------
    particles : Particles
    maxima : Maxima
        The greatest depth, speed and momentum flux since t = 0.
    layers : Layers
        What the flow has done in each cell of a map; without cells in a case without terrain.
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
    released : (releases,) int64 array
        Particles that each release of a terrain has brought so far.
    next_id : int
        The number that the next new particle gets.
    peak_energy : float, J
        Greatest kinetic energy of the fluid since t = 0, in two dimensions J/m; kept where a case
        has a stop rule.
    sampled_energy : float, J
        That at the last sample of the history.
    sums : dict of str to float64 array
        Running sum of each probe that has one, by the name of the probe.
    wall_force : (walls, 6) float64 array, N, N m
        Force and its moment about the origin on each wall and obstacle in the last step, where
        walls are surfaces and a probe asks for it; else without rows.  No checkpoint holds it.
    patches : Patches
        Patches of walls that probes want the force on; no checkpoint holds them.
    patch_force : (patches, 3) float64 array, N
        On each of these in the last step, as ``wall_force``.
    escaped : list of Escaped
        Particles lost through walls, until somebody has told of them; no checkpoint holds them.
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
    released: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    next_id: int = 0
    peak_energy: float = 0.0
    sampled_energy: float = 0.0
    layers: Layers = field(default_factory=no_layers)
    sums: dict[str, Floats] = field(default_factory=dict)
    wall_force: Floats = field(default_factory=lambda: np.zeros((0, 6)))
    patches: Patches = field(default_factory=no_patches)
    patch_force: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    escaped: list[Escaped] = field(default_factory=list)

    def inside(self) -> tuple[NDArray[np.int64], Floats]:
        """Return the fluid particles by phase, (3,), and the sediment in them, in particles."""
        p, number, sediment = self.particles, _counts(), _sums()
        count_phases(p.kind[p.fluid], p.sediment_fraction[p.fluid], number, sediment)
        return number, sediment


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
