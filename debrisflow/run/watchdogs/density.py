"""Density out of bounds: fluid that is compressed, or particles on top of each other."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import ResolvedExplicitScheme
from debrisflow.errors import DivergedError
from debrisflow.particles.place import moment, named_particle
from debrisflow.particles.state import State
from debrisflow.schemes.choice import AnyScheme

LOG = logging.getLogger(__name__)
FEW, FEWEST = 0.01, 5
"""Share and number of the particles that may be compressed: single ones are, in an impact."""
DOUBTFUL_COMPRESSION, MOST_COMPRESSION = 0.1, 0.25
"""rho/rho0 - 1 of a weakly compressible fluid, exceeded by a hundredth of its particles: a warning,
and the end.  The greatest in the shipped cases is 0.041, in a cube that falls apart."""
MOST_CROWDED, MANY = 1.5, 0.1
"""n/n0, and the share of the particles that may exceed it: where a hydrograph releases a slab, some
are born close to others.  In the shipped cases 1.2 % exceed it there, elsewhere no particle."""


class DensityBounds:
    """Checks compression and number density.

    Parameters
    ----------
    case : ResolvedCase
    scheme : Scheme
    """

    def __init__(self, case: ResolvedCase, scheme: AnyScheme) -> None:
        self._case, self._reference = case, scheme.lattice.number_density
        self._is_compressible = isinstance(case.scheme, ResolvedExplicitScheme)
        self._has_told = False

    def check(self, state: State) -> None:
        """Compare the densities of all fluid particles with their bounds.

        Raises
        ------
        DivergedError
        """
        p = state.particles
        if p.fluid_count == 0:
            return
        if self._is_compressible:
            self._check_compression(state)
        ratio = p.number_density[p.fluid] / self._reference
        if _are_many_above(ratio, MOST_CROWDED, MANY):
            row = int(np.argmax(ratio))
            raise DivergedError(
                f"{moment(state)}, {100.0 * _share_above(ratio, MOST_CROWDED):.2g} % of the "
                f"particles are crowded, n/n0 above {MOST_CROWDED:g}; most of all "
                f"{named_particle(self._case, state, row)}, n/n0 = {ratio[row]:.3g}",
                "particles were put on top of each other, or the pressure does not keep them "
                "apart: a time step too long, or too small a speed of sound",
                "check that fills, inflow and releases do not overlap, and try half of "
                "time.largest_step",
            )

    def _check_compression(self, state: State) -> None:
        s = state.particles.compression[state.particles.fluid]
        if not _are_many_above(s, DOUBTFUL_COMPRESSION, FEW):
            return
        row = int(np.argmax(s))
        stops = _are_many_above(s, MOST_COMPRESSION, FEW)
        bound = MOST_COMPRESSION if stops else DOUBTFUL_COMPRESSION
        what = (
            f"{moment(state)}, {100.0 * _share_above(s, bound):.2g} % of the particles are "
            f"compressed by more than {100.0 * bound:g} %; most of all "
            f"{named_particle(self._case, state, row)}, by {100.0 * s[row]:.3g} %"
        )
        cause = "the flow is too fast or too deep for the speed of sound"
        remedy = (
            f"set scheme.sound_speed = {self._better_sound_speed(state):.3g} m/s or more, ten "
            "times the greatest speed; the time step becomes shorter accordingly"
        )
        if stops:
            raise DivergedError(what, cause, remedy)
        if not self._has_told:
            self._has_told = True
            LOG.warning("%s; likely cause: %s; what to do: %s", what, cause, remedy)

    def _better_sound_speed(self, state: State) -> float:
        """Return a speed of sound, m/s, by which the compression would be a hundredth."""
        s = state.particles.compression[state.particles.fluid]
        high = float(np.quantile(s, 1.0 - FEW))
        return float(self._case.explicit_scheme.sound_speed * np.sqrt(high / 0.01))


def _are_many_above(values: NDArray[np.float64], bound: float, share: float) -> bool:
    """Return whether more than a share of the values, and more than five, exceed a bound."""
    return int(np.count_nonzero(values > bound)) > max(FEWEST, share * values.size)


def _share_above(values: NDArray[np.float64], bound: float) -> float:
    return float(np.count_nonzero(values > bound)) / values.size
