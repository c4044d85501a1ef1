"""The record of a weakly compressible fluid, as its kernels take it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.physics.compressible import Fluid
from debrisflow.schemes.terms.term import Scene

Floats = NDArray[np.float64]


def fluid_of(
    scene: Scene, is_even: bool, has_one_viscosity: bool, pressure: Floats | None = None
) -> Fluid:
    """Return the record of fluid and supply at the beginning of a step.

    Parameters
    ----------
    scene : Scene
    is_even : bool
        Whether all matter has the density of the numbers of the scheme.
    has_one_viscosity : bool
        Whether all matter has the viscosity of the numbers of the scheme.
    pressure : (moving particles,) float64 array, Pa, optional
        That of the particles if left out.
    """
    p, rows = scene.particles, scene.particles.moving
    own = p.pressure[rows] if pressure is None else pressure
    return Fluid(
        velocity=p.velocity[rows],
        compression=p.compression[rows],
        pressure=own,
        total_pressure=own + p.collision_pressure[rows],
        density=None if is_even else p.density[rows],
        viscosity=None if has_one_viscosity else scene.viscosity,
    )
