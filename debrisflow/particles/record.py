"""The particles of a run: one record of arrays, in groups that the kernels use as slices."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Kind(IntEnum):
    """What a particle stands for; the number is the one in the particle files."""

    LIQUID = 0
    SEDIMENT = 1
    MIXTURE = 2
    WALL = 3
    DUMMY = 4
    INFLOW = 5


MATTER = (
    "velocity",
    "density",
    "kind",
    "id",
    "sediment_fraction",
    "granular_temperature",
    "relative_velocity",
    "owed_displacement",
    "pore_pressure",
    "pore_pressure_rate",
)
ROOM = 16  # arrays that have to grow get room for this part of their particles


@dataclass
class Particles:
    """State of all particles.

    They stand in groups: fluid (liquid, sediment, mixture), inflow, wall, dummy wall.  Fluid,
    inflow and wall particles are the unknowns of the pressure equation.  What comes and goes
    stands first, and the arrays end in larger ones with room before them, so that the walls, often
    most of the particles, are not copied when the number of the others changes.

    Attributes
    ----------
    position, velocity : (n, 3) float64 array, m, m/s
    pressure : (n,) float64 array, Pa
    density : (n,) float64 array, kg/m3
        Material density of the particle.
    kind : (n,) int8 array
        See :class:`Kind`.
    id : (n,) int64 array
        Number that a particle keeps for the whole run.
    number_density : (n,) float64 array
        n, dimensionless.
    sediment_fraction : (n,) float64 array
        Volume of sediment in the particle: 0 liquid, 1 sediment, between for a mixture.
    concentration : (n,) float64 array
        Local volumetric sediment concentration C.
    granular_temperature : (n,) float64 array, m2/s2
    relative_velocity : (n, 3) float64 array, m/s
        Velocity of the sediment relative to the water around the particle; without rows where
        the case has no drag.
    owed_displacement : (n, 3) float64 array, m
        What the particle's own path is ahead of its place, see :mod:`debrisflow.physics.slip`;
        without rows where the case has no drag.
    pore_pressure : (n,) float64 array
        lambda, the share that the water in the pores bears of what presses on a wall or between
        grains; without rows where no matter of the case has one.
    pore_pressure_rate : (n,) float64 array, 1/s
        Rate at which it decays, 0 for never; without rows as ``pore_pressure``.
    grain_pressure : (n,) float64 array, Pa
        Effective pressure between grains in contact.
    collision_pressure : (n,) float64 array, Pa
        Pressure of colliding grains in a weakly compressible mixture.
    compression : (n,) float64 array
        rho / rho0 - 1 of a weakly compressible fluid.
    on_free_surface : (n,) bool array
    wall : (n,) int8 array
        Index into ``debrisflow.space.domain.wall_names``; -1 for what is not a wall.
    wall_normal : (n, 3) float64 array
        Unit normal out of the wall; 0 for what is not a wall.
    wall_depth : (n,) float64 array, m
        Distance of a wall particle to the wall's surface.
    fluid_count, inflow_count, wall_count : int
        Sizes of the groups; the rest is dummies.
    """

    position: Floats
    velocity: Floats
    pressure: Floats
    density: Floats
    kind: NDArray[np.int8]
    id: NDArray[np.int64]
    number_density: Floats
    sediment_fraction: Floats
    concentration: Floats
    granular_temperature: Floats
    relative_velocity: Floats
    owed_displacement: Floats
    pore_pressure: Floats
    pore_pressure_rate: Floats
    grain_pressure: Floats
    collision_pressure: Floats
    compression: Floats
    on_free_surface: NDArray[np.bool_]
    wall: NDArray[np.int8]
    wall_normal: Floats
    wall_depth: Floats
    fluid_count: int
    inflow_count: int
    wall_count: int

    def __post_init__(self) -> None:
        """Start without room before the arrays."""
        self._buffers: dict[str, NDArray[np.generic]] = {}

    @property
    def count(self) -> int:
        """Number of all particles."""
        return int(self.position.shape[0])

    @property
    def unknown_count(self) -> int:
        """Number of particles that carry a pressure: fluid, inflow and wall."""
        return self.fluid_count + self.inflow_count + self.wall_count

    @property
    def fluid(self) -> slice:
        """The rows of the fluid particles."""
        return slice(0, self.fluid_count)

    @property
    def inflow(self) -> slice:
        """The rows of the inflow particles."""
        return slice(self.fluid_count, self.fluid_count + self.inflow_count)

    @property
    def moving(self) -> slice:
        """The rows of the fluid particles and of the supply behind them."""
        return slice(0, self.fluid_count + self.inflow_count)

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """Return the arrays of the record that have a row for every particle, by name."""
        named = {f.name: getattr(self, f.name) for f in fields(self)}
        return {
            name: value
            for name, value in named.items()
            if isinstance(value, np.ndarray) and len(value) == self.count
        }

    def keep(self, rows: NDArray[np.int64], among: int) -> None:
        """Keep of the first ``among`` particles the given rows, in their order, and all others.

        The caller keeps the group sizes right.
        """
        for name, value in self.arrays().items():
            self._replace_first(name, among, value[rows])

    def reorder(self, rows: slice, order: NDArray[np.int64]) -> None:
        """Put particles that stand together into the given order."""
        for value in self.arrays().values():
            value[rows] = value[rows][order]

    def exchange(self, one: NDArray[np.int64], other: NDArray[np.int64]) -> None:
        """Let particles change places in pairs.

        The rows stand for places; what moves is the matter, so that neighbor lists stay valid.
        """
        held = self.arrays()
        for name in MATTER:
            if name in held:
                value = held[name]
                value[one], value[other] = value[other], value[one]

    def insert(self, row: int, other: Particles) -> None:
        """Insert all rows of another record before a row; the caller keeps the group sizes."""
        for name, value in self.arrays().items():
            self._replace_first(name, row, np.concatenate([value[:row], getattr(other, name)]))

    def _replace_first(self, name: str, count: int, rows: NDArray[np.generic]) -> None:
        """Put rows in place of the first ones of an array; while there is room, no other moves.

        An array that is a view of its buffer ends where that ends.
        """
        value: NDArray[np.generic] = getattr(self, name)
        size = len(value) - count + len(rows)
        buffer = self._buffers.get(name, value)
        if value.base is not buffer or size > len(buffer):
            buffer = np.empty((size + size // ROOM, *value.shape[1:]), value.dtype)
            buffer[len(buffer) - len(value) + count :] = value[count:]
            self._buffers[name] = buffer
        value = buffer[len(buffer) - size :]
        value[: len(rows)] = rows
        setattr(self, name, value)


def blank(count: int) -> Particles:
    """Return a record of particles at rest at the origin."""
    scalar = {
        name: np.zeros(count)
        for name in (
            "pressure",
            "density",
            "number_density",
            "sediment_fraction",
            "concentration",
            "granular_temperature",
            "pore_pressure",
            "pore_pressure_rate",
            "grain_pressure",
            "collision_pressure",
            "compression",
            "wall_depth",
        )
    }
    vector = {
        name: np.zeros((count, 3))
        for name in (
            "position",
            "velocity",
            "relative_velocity",
            "owed_displacement",
            "wall_normal",
        )
    }
    return Particles(
        **scalar,
        **vector,
        kind=np.zeros(count, dtype=np.int8),
        id=np.arange(count),
        on_free_surface=np.zeros(count, dtype=bool),
        wall=np.full(count, -1, dtype=np.int8),
        fluid_count=0,
        inflow_count=0,
        wall_count=0,
    )
