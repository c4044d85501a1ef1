"""The sampler of the pressure on a patch of a wall."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.pressure import PressureProbe
from debrisflow.errors import CaseError
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.probe import Column, Sampler
from debrisflow.run.wall_pressure import (
    OF_STEP,
    Faces,
    nearest_on,
    patch_shares,
    pressure_on,
    wall_faces,
)


class PatchPressure(Sampler):
    """Mean pressure on a square patch of a wall.

    The mean of :func:`debrisflow.run.wall_pressure.face_pressure` over the faces of the
    wall, each by the part of it that the patch covers; 0 where the patch is dry.  The patch lies
    on the face that is nearest to the given place.
    """

    def __init__(self, probe: PressureProbe, case: ResolvedCase, particles: Particles) -> None:
        size = probe.side(case.particles.spacing)
        faces = wall_faces(case, particles, probe.wall)
        if len(faces.position) == 0:
            raise CaseError(f"probe '{probe.name}': nothing of {probe.wall} is open to the fluid")
        place = np.array([probe.x, probe.y, probe.z or 0.0])
        center, distance = nearest_on(faces, place, case)
        if distance > (1.0 + 1e-6) * case.particles.spacing:
            raise CaseError(
                f"probe '{probe.name}': the place is {distance:.3g} m from the surface of "
                f"{probe.wall}; at most a spacing"
            )
        share = patch_shares(faces, center, size, case)
        self._case, self._share = case, share[share > 0.0]
        self._faces = Faces(faces.position[share > 0.0], faces.normal[share > 0.0])

    @staticmethod
    def reads_walls(case: ResolvedCase) -> bool:
        """See :meth:`Sampler.reads_walls`."""
        return True

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the pressure."""
        return (Column("pressure", "Pa", f"mean over the patch, 0 where it is dry; {OF_STEP}"),)

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the mean pressure, Pa."""
        pressure = pressure_on(self._faces, self._case, state)
        return (float(self._share @ pressure / self._share.sum()),)
