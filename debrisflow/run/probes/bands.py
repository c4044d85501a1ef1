"""The sampler of the pressure on a structure by height."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.bodies import BoxObstacle, MeshObstacle
from debrisflow.case.probes.bands import BandsProbe
from debrisflow.case.structures import levels_of
from debrisflow.errors import CaseError
from debrisflow.neighbors.patches import Band
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run import row_statistics
from debrisflow.run.probe import Column, Sampler
from debrisflow.run.tables import Row
from debrisflow.space.domain import wall_names
from debrisflow.space.mesh_pieces import area_vectors, faces_in_open

Floats = NDArray[np.float64]


class BandPressure(Sampler):
    """Force on an obstacle in bands of equal height, and the pressure that it makes.

    The bands reach from the lowest place of the obstacle above the ground to its top.  Each
    particle presses on the square of wall, a spacing wide, around its foot, which bands share, so
    that their forces add up to the force on the obstacle.  The pressure is the force along the
    given direction over the area of the band as seen along it, wetted or not: of a dam the area of
    its face.
    """

    has_many_points = True

    def __init__(self, probe: BandsProbe, case: ResolvedCase, particles: Particles) -> None:
        if not case.has_surfaces:
            raise CaseError(
                f"probe '{probe.name}': walls of particles have no bands; set scheme.form = "
                "'stable'"
            )
        faces, count = faces_in_open(case, probe.wall), probe.bands
        body = next(part for part in case.obstacle if part.name == probe.wall)
        assert isinstance(body, BoxObstacle | MeshObstacle)
        low, high = faces[:, :, 2].min(), levels_of(body)[1]
        if high - low < count * case.particles.spacing * (1.0 - 1e-6):
            most = max(1, int((high - low) / case.particles.spacing))
            raise CaseError(
                f"probe '{probe.name}': bands of {(high - low) / count:.3g} m are lower than a "
                f"spacing; {probe.wall} stands {high - low:.3g} m high, so that bands = {most} is "
                "the most"
            )
        self._name, self._ends = probe.name, np.linspace(low, high, count + 1)
        self._direction = np.array([*probe.direction, 0.0]) / np.hypot(*probe.direction)
        self._area = _areas(faces, self._ends, self._direction)
        number, far = wall_names(case).index(probe.wall), high - low
        ends = self._ends.copy()
        ends[0], ends[-1] = low - far, high + far  # a particle may press below or above all faces
        self.patches = [Band(number, *pair) for pair in pairwise(ends)]
        self.sum_shape = row_statistics.sum_shape(4 * count)

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return the ends of a band, force and pressure."""
        mean = "mean since the row before, in the first row that at rest"
        pressure = "force along the direction over the area"
        extremes = "least and greatest of the steps since the row before"
        return (
            Column("lower", "m", "ends of the band; a row for each"),
            Column("upper", "m", "ends of the band; a row for each"),
            Column("area", "m2", "of its faces as seen along the direction, wetted or not"),
            *(Column(f"force_{axis}", "N", f"on the band; {mean}") for axis in "xyz"),
            Column("pressure", "Pa", f"{pressure}; {mean}"),
            Column("pressure_least", "Pa", f"{pressure}; {extremes}"),
            Column("pressure_greatest", "Pa", f"{pressure}; {extremes}"),
        )

    def rows(self, state: State) -> Iterable[Row]:
        """Return a row for each band."""
        row = row_statistics.since_row(state.sums[self._name], state, self._values(state))
        mean, least, greatest = (values.reshape(-1, 4) for values in row)
        ends = self._ends[:-1], self._ends[1:], self._area
        return np.column_stack([*ends, mean, least[:, 3], greatest[:, 3]])

    def add_step(self, state: State) -> None:
        """Add the last step."""
        row_statistics.add_step(state.sums[self._name], state, self._values(state))

    def _values(self, state: State) -> Floats:
        """Return force, N, and pressure, Pa, of each band, in one row."""
        rows = slice(self.patch_row, self.patch_row + len(self.patches))
        push = state.patch_force[rows]
        pressure = push @ self._direction / np.maximum(self._area, np.finfo(float).tiny)
        return np.column_stack([push, pressure]).ravel()


def _areas(faces: Floats, ends: Floats, direction: Floats) -> Floats:
    """Return the area that faces between levels show along a direction, (n,) array, m2.

    Half of the sum over all faces, since front and back have the same projected area.

    Examples
    --------
    >>> face = np.array([[[0.0, 0, 0], [0, 2, 0], [0, 0, 2]]])
    >>> _areas(np.concatenate([face, face]), np.array([0.0, 1.0, 2.0]), np.array([1.0, 0.0, 0.0]))
    array([1.5, 0.5])
    """
    shown = np.abs(area_vectors(faces) @ direction)
    below = [float(shown @ _share_below(faces[:, :, 2], level)) for level in ends]
    return 0.5 * np.diff(below)


def _share_below(levels: Floats, level: float) -> Floats:
    """Return the share of triangles that lies below a level; (n, 3) levels of their corners, m."""
    a, b, c = np.sort(levels, axis=1).T
    with np.errstate(divide="ignore", invalid="ignore"):
        lower = (level - a) ** 2 / ((b - a) * (c - a))
        upper = 1.0 - (c - level) ** 2 / ((c - b) * (c - a))
    found = np.where(level < b, lower, upper)
    return np.where(level <= a, 0.0, np.where(level >= c, 1.0, found))
