"""The sampler of the pressure on a patch of a wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import MeshObstacle
from debrisflow.case.probe import SLACK
from debrisflow.case.probes.pressure import PressureProbe
from debrisflow.errors import CaseError
from debrisflow.neighbors.patches import Patch, shares
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run import row_statistics
from debrisflow.run.probe import Column, Sampler, extreme_columns
from debrisflow.run.terrain_patches import patch_on_terrain
from debrisflow.run.wall_pressure import (
    OF_STEP,
    Faces,
    nearest_on,
    patches_in,
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
    area, of all that the wall does to the fluid; where walls are particles, the pressure again, and
    nan on a mesh off a terrain, whose patch is that of cells and not of its triangles.
    """

    sum_shape = row_statistics.sum_shape(1)
    averaged = ("reaction",)

    def __init__(self, probe: PressureProbe, case: ResolvedCase, particles: Particles) -> None:
        self._case, self._name = case, probe.name
        size, place = probe.side(case.particles.spacing), np.array([probe.x, probe.y, probe.z or 0])
        if case.is_terrain:
            patch, self._faces, self._area, distance = patch_on_terrain(
                case, probe.wall, place, size
            )
            self._share = np.ones(len(self._faces.position))
        else:
            faces = wall_faces(case, particles, probe.wall)
            if len(faces.position) == 0:
                raise CaseError(
                    f"probe '{probe.name}': nothing of {probe.wall} is open to the fluid"
                )
            center, normal, distance = nearest_on(faces, place, case)
            patch = Patch(wall_names(case).index(probe.wall), center, normal, size)
            share = shares(0, patches_in(case, [patch]), faces.position, faces.normal)
            self._share = share[share > 0.0]
            self._faces = Faces(faces.position[share > 0.0], faces.normal[share > 0.0])
            self._area = share.sum() * case.particles.spacing ** (case.dimension - 1)
        if distance > (1.0 + SLACK) * case.particles.spacing:
            raise CaseError(
                f"probe '{probe.name}': the place is {distance:.3g} m from the surface of "
                f"{probe.wall}; at most a spacing"
            )
        if not self._share.size:
            raise CaseError(
                f"probe '{probe.name}': a patch of {size:g} m there covers nothing of {probe.wall} "
                "that is open to the fluid"
            )
        self._normal = patch.normal
        self._is_mesh = not case.is_terrain and any(
            isinstance(body, MeshObstacle) and body.name == probe.wall for body in case.obstacle
        )
        if case.has_surfaces and not self._is_mesh:
            self.patches = [patch]

    @staticmethod
    def reads_walls(case: ResolvedCase) -> bool:
        """See :meth:`Sampler.reads_walls`."""
        return not case.is_terrain

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the two pressures."""
        reaction = "force across the patch over its area, by all that the wall does to the fluid"
        at_start = "that of the step before" if dimension == 2 else "that at rest"
        mean = f"mean since the row before, in the first row {at_start}"
        other = "in the form study the pressure, on a mesh none"
        pushed = Column("reaction", "Pa", f"{reaction}; {mean}; {other}")
        return (
            Column("pressure", "Pa", f"mean over the patch, 0 where it is dry; {OF_STEP}"),
            pushed,
            *extreme_columns([pushed]),
        )

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return ("reaction", "pressure")

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the mean pressure, and mean, least and greatest reaction, Pa."""
        pressure = float(self._share @ pressure_on(self._faces, self._case, state))
        pressure /= float(self._share.sum())
        if not self.patches:
            return pressure, *(3 * [np.nan if self._is_mesh else pressure])
        now = self._reaction(state)
        row = row_statistics.since_row(state.sums[self._name], state, now)
        return pressure, *(float(reaction) for (reaction,) in row)

    def add_step(self, state: State) -> None:
        """Add the reaction of the last step."""
        if self.patches:
            row_statistics.add_step(state.sums[self._name], state, self._reaction(state))

    def _reaction(self, state: State) -> Floats:
        push = -state.patch_force[self.patch_row] @ self._normal
        return np.array([push / self._area])
