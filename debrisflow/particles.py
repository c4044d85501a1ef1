"""The particles of a run: one record of arrays, in groups that the kernels use as slices."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from debrisflow import geometry
from debrisflow.case import tables
from debrisflow.case.materials import bulk_density
from debrisflow.walls import WallPoints, wall_points

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
        What the particle's own path is ahead of its place, see :mod:`debrisflow.slip`; without
        rows where the case has no drag.
    grain_pressure : (n,) float64 array, Pa
        Effective pressure between grains in contact.
    collision_pressure : (n,) float64 array, Pa
        Pressure of colliding grains in a weakly compressible mixture.
    compression : (n,) float64 array
        rho / rho0 - 1 of a weakly compressible fluid.
    on_free_surface : (n,) bool array
    wall : (n,) int8 array
        Index into ``geometry.wall_names``; -1 for what is not a wall.
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
        for name in MATTER:
            value = getattr(self, name)
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


def set_material(
    particles: Particles, rows: slice | NDArray[np.int64], kind: Kind, case: tables.Case
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
    particles: Particles, rows: slice | NDArray[np.int64], fraction: float, case: tables.Case
) -> None:
    """Give rows a sediment fraction and the density of that mixture with water."""
    particles.sediment_fraction[rows] = fraction
    particles.density[rows] = bulk_density(fraction, case.water, case.sediment, case.strength)


def concentrations(case: tables.Case) -> set[float]:
    """Return the sediment concentrations of what a case is filled with and supplied by."""
    found = {case.mixture.concentration if f.material == "mixture" else 0.0 for f in case.fill}
    inflow = case.inflow
    if inflow is not None:
        graph = inflow.hydrograph
        if isinstance(graph, tables.Hydrograph):
            found.update(graph.concentration)
        else:
            found.add(inflow.concentration)
    return found


def reference_density(case: tables.Case) -> float:
    """Return rho0 of the equation of state, kg/m3: that of the heaviest matter of a case."""
    water, sediment, strength = case.water, case.sediment, case.strength
    return max(bulk_density(c, water, sediment, strength) for c in concentrations(case))


def seed(case: tables.Case) -> Particles:
    """Return the particles of a case at its start.

    Parameters
    ----------
    case : Case
        A checked case with its defaults resolved.
    """
    rng = np.random.default_rng(case.particles.seed)
    groups = [_filled(block, case, rng) for block in case.fill]
    fluid_count = sum(g.count for g in groups)
    columns = _first_columns(case) if case.inflow is not None else []
    inflow_count = sum(column.count for column in columns)
    groups += columns
    solid = _walls(case)
    wall_count = int(np.count_nonzero(solid.kind == Kind.WALL))
    particles = solid
    if case.drag.law == "none":
        particles.relative_velocity = particles.owed_displacement = np.zeros((0, 3))
    for group in reversed(groups):
        particles.insert(0, group)
    particles.id = np.arange(particles.count)
    particles.fluid_count = fluid_count
    particles.inflow_count = inflow_count
    particles.wall_count = wall_count
    return particles


def supply(case: tables.Case, time: float) -> tuple[float, float]:
    """Return velocity, m/s, and sediment concentration of the supply at a time.

    The velocity gives the discharge through the section of whole particles that stands for the
    supply.  Nothing is supplied before t = 0.
    """
    inflow = case.inflow
    if inflow is None or time < 0.0:
        return 0.0, 0.0
    if isinstance(inflow.hydrograph, tables.Hydrograph):
        h = inflow.hydrograph
        discharge = float(np.interp(time, h.time, h.discharge))
        concentration = float(np.interp(time, h.time, h.concentration))
    else:
        assert inflow.discharge is not None
        discharge, concentration = inflow.discharge, inflow.concentration
    section = geometry.inflow_section(case)
    cells = section.wide * section.high
    return discharge / (cells * case.particles.spacing ** (case.dimension - 1)), concentration


def supply_column(case: tables.Case, number: int, x: float, sediment: float) -> Particles:
    """Return a column of waiting supply at x that fills the section, and its sediment.

    In two dimensions whole particles are rock.  Their rows are drawn with the column's number as
    seed, so that a resumed run draws the same.  In three dimensions, where it is a slab, every
    particle carries the same part of the sediment and is compressed by those above it,

        s = (rho / rho0) g_n (h - z) / c^2

    with the component of gravity g_n normal to the floor and the depth h of the supply.

    Parameters
    ----------
    case : Case
    number : int
        Columns before this one since the start.
    x : float, m
    sediment : float
        Volume of sediment in the column, in particles; a whole number in two dimensions.
    """
    d0, section = case.particles.spacing, geometry.inflow_section(case)
    column = blank(section.wide * section.high)
    column.position[:, 0] = x
    column.position[:, case.dimension - 1] = np.tile(
        (np.arange(section.high) + 0.5) * d0, section.wide
    )
    if case.dimension == 3:
        y = (section.first + np.arange(section.wide) + 0.5) * d0
        column.position[:, 1] = np.repeat(y, section.high)
        set_fraction(column, slice(None), sediment / column.count, case)
        _compress_supply(column, case, section.high * d0)
    else:
        set_material(column, slice(None), Kind.LIQUID, case)
        rng = np.random.default_rng([case.particles.seed, number])
        drawn = rng.permutation(column.count)[: int(sediment)]
        set_material(column, drawn, Kind.SEDIMENT, case)
    column.kind[:] = Kind.INFLOW
    return column


def _compress_supply(column: Particles, case: tables.Case, depth: float) -> None:
    assert isinstance(case.scheme, tables.ExplicitScheme)
    assert case.scheme.sound_speed is not None
    gradient = max(-case.gravity.components[1], 0.0) / case.scheme.sound_speed**2
    heavy = column.density / reference_density(case)
    column.compression[:] = gradient * heavy * (depth - column.position[:, 2])


def supplied_sediment(case: tables.Case, columns: int) -> float:
    """Return the volume of sediment that the first columns owe at t = 0, in particles."""
    section = geometry.inflow_section(case)
    return supply(case, 0.0)[1] * section.wide * section.high * columns


def whole_sediment(case: tables.Case, owed: float) -> float:
    """Return how much of the sediment owed a column can hold: in two dimensions whole particles."""
    return owed if case.dimension == 3 else float(int(owed))


def _first_columns(case: tables.Case) -> list[Particles]:
    """Return the columns that wait behind x = 0 at the start, the foremost first."""
    d0, layers = case.particles.spacing, geometry.wall_layers(case)
    due = [whole_sediment(case, supplied_sediment(case, n)) for n in range(layers + 1)]
    return [supply_column(case, n, -(n + 0.5) * d0, due[n + 1] - due[n]) for n in range(layers)]


def _placed(position: Floats) -> Particles:
    particles = blank(position.shape[0])
    particles.position = position
    return particles


def _filled(block: tables.AnyFill, case: tables.Case, rng: np.random.Generator) -> Particles:
    particles = _placed(geometry.fill(block, case))
    if block.material == "mix":
        is_sediment = _evenly_mixed(
            particles.position / case.particles.spacing, block.sediment_share, rng
        )
        set_material(particles, np.flatnonzero(is_sediment), Kind.SEDIMENT, case)
        set_material(particles, np.flatnonzero(~is_sediment), Kind.LIQUID, case)
    else:
        kind = {"water": Kind.LIQUID, "sediment": Kind.SEDIMENT, "mixture": Kind.MIXTURE}
        set_material(particles, slice(None), kind[block.material], case)
    if not isinstance(block, tables.Bed):
        particles.velocity[:, : len(block.velocity)] = block.velocity
    return particles


def _evenly_mixed(position: Floats, share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return which particles of a mix are sediment: at random, but evenly over squares of four.

    Up to the end of each square there are as many as its share of the particles so far, rounded up
    or down at random.  Particles are much larger than grains, whose mixture is even at the size of
    a particle; phases drawn without this care leave loose and dense places in a bed, which then
    packs, gives off water, and slides on it.

    Parameters
    ----------
    position : (n, 3) array
        In spacings.
    share : float
    rng : Generator
    """
    across, up = (position[:, :2] // 2).T.astype(np.int64)
    # columns of squares up and down in turn, so that the next square is a neighbor
    order = np.lexsort((rng.random(len(position)), up * (-1) ** across, across))
    square = np.stack([across, up])[:, order]
    ends = np.flatnonzero(np.any(np.diff(square, axis=1, append=square[:, -1:] + 1), axis=0)) + 1
    rounding = rng.random(ends.size)
    rounding[-1] = 0.5
    due = np.floor(ends * share + rounding).astype(np.int64)
    is_sediment = np.zeros(len(position), dtype=bool)
    start, placed = 0, 0
    for end, until in zip(ends.tolist(), due.tolist(), strict=True):
        count = min(max(until - placed, 0), end - start)
        is_sediment[order[start : start + count]] = True
        start, placed = end, placed + count
    return is_sediment


def _walls(case: tables.Case) -> Particles:
    points = wall_points(case)
    order = np.argsort(points.layer > 1, kind="stable")
    points = WallPoints._make(field[order] for field in points)
    particles = _placed(points.position)
    particles.kind[:] = np.where(points.layer == 1, Kind.WALL, Kind.DUMMY)
    particles.density[:] = case.water.density
    particles.wall[:] = points.name
    particles.wall_normal[:] = points.normal
    particles.wall_depth[:] = points.depth
    for index, name in enumerate(geometry.WALL_NAMES):
        particles.velocity[points.name == index, :2] = getattr(case.walls, name).velocity
    return particles
