"""The sampler of the pressure on a patch of a wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.pressure import PressureProbe
from debrisflow.errors import CaseError
from debrisflow.particles.patches import Patches
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run import row_mean
from debrisflow.run.probe import Column, Sampler
from debrisflow.run.wall_pressure import (
    OF_STEP,
    Faces,
    nearest_on,
    patch_shares,
    pressure_on,
    wall_faces,
)
from debrisflow.space.domain import wall_names

Floats = NDArray[np.float64]


class PatchPressure(Sampler):
    """Mean pressure on a square patch of a wall, by the fluid before it and by the reaction.

    The mean of :func:`debrisflow.run.wall_pressure.face_pressure` over the faces of the
    wall, each by the part of it that the patch covers; 0 where the patch is dry.  The patch lies
    on the face that is nearest to the given place.  Beside it the force across the patch over its
    area, of all that the wall does to the fluid; where walls are particles, the pressure again.
    """

    sum_shape = row_mean.sum_shape(1)

    def __init__(self, probe: PressureProbe, case: ResolvedCase, particles: Particles) -> None:
        size = probe.side(case.particles.spacing)
        faces = wall_faces(case, particles, probe.wall)
        if len(faces.position) == 0:
            raise CaseError(f"probe '{probe.name}': nothing of {probe.wall} is open to the fluid")
        place = np.array([probe.x, probe.y, probe.z or 0.0])
        center, normal, distance = nearest_on(faces, place, case)
        if distance > (1.0 + 1e-6) * case.particles.spacing:
            raise CaseError(
                f"probe '{probe.name}': the place is {distance:.3g} m from the surface of "
                f"{probe.wall}; at most a spacing"
            )
        share = patch_shares(faces, center, size, case)
        self._case, self._name, self._share = case, probe.name, share[share > 0.0]
        self._faces = Faces(faces.position[share > 0.0], faces.normal[share > 0.0])
        self._area = share.sum() * case.particles.spacing ** (case.dimension - 1)
        if case.has_surfaces:
            number = wall_names(case).index(probe.wall)
            self.patch = patch_around(number, center, normal, size, case)

    @staticmethod
    def reads_walls(case: ResolvedCase) -> bool:
        """See :meth:`Sampler.reads_walls`."""
        return True

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the two pressures."""
        reaction = "force across the patch over its area, by all that the wall does to the fluid"
        return (
            Column("pressure", "Pa", f"mean over the patch, 0 where it is dry; {OF_STEP}"),
            Column("reaction", "Pa", f"{reaction}; mean since the row before"),
        )

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the mean pressure and the reaction, Pa."""
        kept, now = state.sums[self._name], np.array([self._reaction(state)])
        (reaction,) = row_mean.mean_since_row(kept, state, now)
        return self._pressure(state), float(reaction)

    def add_step(self, state: State) -> None:
        """Add the reaction of the last step."""
        row_mean.add_step(state.sums[self._name], state, np.array([self._reaction(state)]))

    def _pressure(self, state: State) -> float:
        pressure = pressure_on(self._faces, self._case, state)
        return float(self._share @ pressure / self._share.sum())

    def _reaction(self, state: State) -> float:
        if self.patch is None:
            return self._pressure(state)
        if len(state.patch_force) == 0:
            return 0.0  # before any step in two dimensions
        return float(-state.patch_force[self.patch_row] @ self.patch.normal[0] / self._area)


def patch_around(
    number: int, center: Floats, normal: Floats, size: float, case: ResolvedCase
) -> Patches:
    """Return a square patch of a wall of some number, as :func:`patch_shares` takes it."""
    d0, across = case.particles.spacing, np.abs(normal) > np.sqrt(0.5)
    half = np.where(across, d0, 0.5 * size)
    half[case.dimension :] = np.inf
    cell = np.where(across, 0.0, d0 * np.sqrt(1.0 - normal**2))
    return Patches(np.array([number]), center[None], normal[None], half[None], cell[None])
