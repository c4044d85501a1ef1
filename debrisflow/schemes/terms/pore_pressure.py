"""The pore pressure of the material: the load that is left to the grains, and its decay."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.particles.record import Particles
from debrisflow.schemes.terms.term import Step, Term


class PorePressure(Term):
    """The decay of the pore pressure of fluid particles, ``lambda(t) = lambda(0) exp(-t / T)``.

    After the motion, so that a step that fails leaves it as it was; not while fills settle.
    """

    name = "pore pressure"

    def act(self, step: Step) -> None:
        """Lower the share that pore water bears in the fluid particles by a step."""
        if step.state.time >= 0.0:
            p = step.particles
            p.pore_pressure[p.fluid] *= np.exp(-step.dt * p.pore_pressure_rate[p.fluid])


def borne_by_grains(particles: Particles, rows: slice | None = None) -> NDArray[np.float64] | None:
    """Return the share 1 - lambda of the load on particles that their grains bear.

    For the fluid particles or the given rows; None if the grains bear the whole load.
    """
    if len(particles.pore_pressure) == 0:
        return None
    return 1.0 - particles.pore_pressure[particles.fluid if rows is None else rows]
