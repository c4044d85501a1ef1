"""The sampler of the volume in a box."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.volume import VolumeProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.measures import particle_volume
from debrisflow.run.probe import Column, Sampler, volume_unit


class BoxVolume(Sampler):
    """Volume of the fluid, and of the sediment in it, whose particles have their centers in a box.

    Whole particles are counted, so that the volumes of adjacent boxes add up.
    """

    def __init__(self, probe: VolumeProbe, case: ResolvedCase, particles: Particles) -> None:
        extents = (probe.x, probe.y, probe.z or (-np.inf, np.inf))
        self._lower, self._upper = np.array(extents).T
        self._volume = particle_volume(case)

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return volume and volume of sediment."""
        unit, meaning = volume_unit(dimension), "of the particles in the box"
        return Column("volume", unit, meaning), Column("sediment_volume", unit, meaning)

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return ("volume", "sediment_volume")

    def sample(self, state: State) -> tuple[float, ...]:
        """Return volume and volume of sediment, m3; in two dimensions m2."""
        p = state.particles
        place = p.position[p.fluid]
        inside = np.all((place >= self._lower) & (place < self._upper), axis=1)
        sediment = float(p.sediment_fraction[p.fluid][inside].sum())
        return np.count_nonzero(inside) * self._volume, sediment * self._volume
