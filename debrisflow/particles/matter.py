"""What a particle is made of: density and sediment fraction of liquid, sediment and mixture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.materials import Mixture, bulk_density
from debrisflow.case.releases import Hydrograph
from debrisflow.case.resolved import ResolvedHydrographRelease, ResolvedRelease
from debrisflow.particles.record import Kind, Particles


def set_material(
    particles: Particles, rows: slice | NDArray[np.int64], kind: Kind, case: ResolvedCase
) -> None:
    """Give rows the density and the sediment fraction of liquid, sediment or mixture."""
    fraction = {
        Kind.LIQUID: 0.0,
        Kind.SEDIMENT: 1.0,
        Kind.MIXTURE: case.mixture.concentration,
    }[kind]
    particles.kind[rows] = kind
    set_fraction(particles, rows, fraction, case)


def set_fraction(
    particles: Particles, rows: slice | NDArray[np.int64], fraction: float, case: ResolvedCase
) -> None:
    """Give rows a sediment fraction and the density of that mixture with water.

    A particle keeps both while it moves: ``D rho / Dt = 0``, equation (1).
    """
    particles.sediment_fraction[rows] = fraction
    particles.density[rows] = bulk_density(fraction, case.water, case.sediment, case.rheology)


def set_pore_pressure(
    particles: Particles, rows: slice | NDArray[np.int64], share: float, time: float | None
) -> None:
    """Give rows the share of what presses on them that pore water bears, and its decay time, s."""
    particles.pore_pressure[rows] = share
    particles.pore_pressure_rate[rows] = 0.0 if time is None else 1.0 / time


def has_pore_pressure(case: ResolvedCase) -> bool:
    """Return whether any matter of a case has a pore pressure of its own."""
    return any(part.pore_pressure > 0.0 for part in (*case.fill, *case.release))


def leave_out_unasked(particles: Particles, case: ResolvedCase) -> None:
    """Leave the arrays without rows that no term of a case reads.

    To a record without particles they look as all others do, so that they get rows with the first.
    """
    if case.drag.law == "none":
        particles.relative_velocity = particles.owed_displacement = np.zeros((0, 3))
    if not has_pore_pressure(case):
        particles.pore_pressure = particles.pore_pressure_rate = np.zeros(0)


def concentrations(case: ResolvedCase) -> set[float]:
    """Return the sediment concentrations of what a case is filled with and supplied by."""
    found = {case.mixture.concentration if f.material == "mixture" else 0.0 for f in case.fill}
    for release in case.release:
        found.update(concentrations_of(release, case.mixture))
    inflow = case.inflow
    if inflow is not None:
        graph = inflow.hydrograph
        if isinstance(graph, Hydrograph):
            found.update(graph.concentration)
        else:
            found.add(inflow.concentration)
    return found


def concentrations_of(release: ResolvedRelease, mixture: Mixture) -> tuple[float, ...]:
    """Return the sediment concentrations of what a release of a terrain brings."""
    if isinstance(release, ResolvedHydrographRelease):
        return release.hydrograph.concentration
    if release.material == "water":
        return (0.0,)
    return (mixture.concentration if release.concentration is None else release.concentration,)


def reference_density(case: ResolvedCase) -> float:
    """Return rho0 of the equation of state, kg/m3: that of the heaviest matter of a case."""
    water, sediment, rheology = case.water, case.sediment, case.rheology
    return max(bulk_density(c, water, sediment, rheology) for c in concentrations(case))
