"""The case file as frozen tables: every field with its unit, its default and what it means.

The tables hold what one field can say of itself (type, range, unit).  What needs two or more
fields is said in :mod:`debrisflow.case.checks`.
"""

from __future__ import annotations

from math import atan2, cos, radians, sin
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Strict, Tag, model_validator

from debrisflow.case.bodies import BoxObstacle, MeshFill, MeshObstacle, PolygonObstacle
from debrisflow.case.fields import NONE, Components, Interval, Table, Vector, quantity
from debrisflow.case.friction import Friction
from debrisflow.case.materials import (
    Mixture,
    Sediment,
    Water,
    pore_pressure_decay,
    pore_pressure_share,
)
from debrisflow.case.probes import AnyProbe
from debrisflow.case.releases import DISCHARGE, AnyRelease, Hydrograph, Zone
from debrisflow.case.rheology import AnyRheology, NoStrength
from debrisflow.case.shapes import THREE_DIMENSIONAL, Geometry, is_three_dimensional

EXPLICIT_RADIUS = 2.4  # influence radius of the explicit scheme, in spacings


class Particles(Table):
    """How the continuum is cut into particles."""

    spacing: float = quantity("m", "initial distance d0 between particles", gt=0)
    effective_radius: float = quantity(
        "spacing",
        "influence radius r_e as a multiple of the spacing; 2.4 in three dimensions if left out",
        3.1,
        ge=1.5,
        le=5.0,
    )
    seed: int = quantity(NONE, "seed of every random choice of the run", 1, ge=0)


class Gravity(Table):
    """Gravity: either a slope of the x axis or a vector."""

    acceleration: float = quantity("m/s2", "magnitude of gravity, used with slope", 9.81, ge=0)
    slope: float = quantity(
        "degree", "angle by which the x axis falls below the horizontal", 0.0, gt=-90, lt=90
    )
    vector: Vector | None = quantity(
        "m/s2",
        "acceleration along x and upwards (y, in three dimensions z), instead of acceleration "
        "and slope",
        None,
    )

    @property
    def fall(self) -> float:
        """Angle by which the x axis falls below the horizontal, however it was given, rad."""
        along, down = self.components
        return atan2(along, -down)

    @property
    def components(self) -> tuple[float, float]:
        """Acceleration along x and upwards, m/s2, however it was given."""
        if self.vector is not None:
            return self.vector
        angle = radians(self.slope)
        return self.acceleration * sin(angle), -self.acceleration * cos(angle)


class Block(Table):
    """A rectangle, in three dimensions a box, filled with particles on a lattice."""

    type: Literal["block"]
    x: Interval = quantity("m", "extent along x")
    y: Interval = quantity("m", "extent along y")
    z: Interval | None = quantity("m", "extent along z, in three dimensions", None)
    material: Literal["water", "sediment", "mixture", "two-phase"] = quantity(
        NONE,
        "water; sediment (rock); mixture (one kind of particle for both); "
        "two-phase (water and sediment particles, seeded at random, evenly)",
    )
    sediment_share: float = quantity(
        NONE, "share of sediment particles in a two-phase fill", 0.5, ge=0, le=1
    )
    velocity: Components = quantity("m/s", "initial velocity", (0.0, 0.0))
    pore_pressure: float = pore_pressure_share()
    pore_pressure_time: float | None = pore_pressure_decay()


class Bed(Table):
    """The recess of a channel, filled to the level of its fixed floor."""

    type: Literal["bed"]
    material: Literal["water", "sediment", "mixture", "two-phase"] = quantity(
        NONE, "as in a block", "two-phase"
    )
    sediment_share: float = quantity(
        NONE, "share of sediment particles in a two-phase fill", 0.5, ge=0, le=1
    )
    pore_pressure: float = pore_pressure_share()
    pore_pressure_time: float | None = pore_pressure_decay()


AnyFill = Block | Bed | MeshFill
AnyObstacle = BoxObstacle | PolygonObstacle | MeshObstacle


class Wall(Table):
    """What a wall does to the fluid along it."""

    slip: Literal["no-slip", "free-slip"] = quantity(NONE, "condition along the wall", "no-slip")
    velocity: Vector = quantity("m/s", "velocity of the wall along itself", (0.0, 0.0))
    roughness: float = quantity(
        "m",
        "equivalent sand roughness of the law of the wall; 0 for none, so that a no-slip wall "
        "holds the flow by its viscosity, Newtonian and turbulent",
        0.0,
        ge=0,
    )
    friction: Friction | None = quantity(
        NONE, "law of the friction along the wall, in three dimensions, instead of slip", None
    )


class Walls(Table):
    """The named walls."""

    floor: Wall = Field(
        default=Wall(),
        description="floor of a tank, of a channel and its run-out, or of a terrain",
    )
    bed: Wall = Field(default=Wall(), description="floor and steps of the recess under the bed")
    left: Wall = Field(default=Wall(), description="wall at x = 0")
    right: Wall = Field(
        default=Wall(), description="wall at x = length, or the end weir of a channel"
    )
    ceiling: Wall = Field(default=Wall(), description="ceiling of a tank")
    front: Wall = Field(
        default=Wall(),
        description="wall at y = 0, in three dimensions, and the head wall beside it",
    )
    back: Wall = Field(
        default=Wall(),
        description="wall at y = width, in three dimensions, and the head wall beside it",
    )


class Inflow(Table):
    """A supply through x = 0 of a channel; its particles turn into fluid when they pass x = 0.

    In three dimensions it comes through a rectangle on the floor.  Of its sediment every particle
    carries the same part there; in two dimensions as many particles as are due are sediment.
    """

    depth: float = quantity("m", "depth of the supply above the fixed floor", gt=0)
    across: Interval | None = quantity(
        "m", "extent along y, in three dimensions; the whole width if left out", None
    )
    discharge: float | None = quantity(
        DISCHARGE, "discharge, in two dimensions per unit width", None, gt=0
    )
    velocity: float | None = quantity("m/s", "velocity of the supply", None, gt=0)
    concentration: float = quantity(
        NONE, "volumetric sediment concentration of the supply", 0.0, ge=0, lt=1
    )
    hydrograph: Hydrograph | str | None = quantity(
        NONE,
        "table, or a CSV file beside the case with the columns time, discharge, concentration; "
        "instead of discharge, velocity and concentration",
        None,
    )


class CollisionStress(Table):
    """Kinetic-theory stress of colliding grains."""

    enabled: bool = quantity(NONE, "let grains exchange momentum by collisions", False)
    granular_temperature: Literal["algebraic", "neighborhood", "fluctuation"] = quantity(
        NONE,
        "algebraic: production equals dissipation; "
        "neighborhood: variance of the velocity inside the influence radius, as the study; "
        "fluctuation: that variance about the local velocity gradient",
        "algebraic",
    )
    concentration: float | None = quantity(
        NONE,
        "concentration of the colliding grains; the local share of sediment if left out",
        None,
        gt=0,
        lt=1,
    )
    largest_concentration: float = quantity(
        NONE, "concentration at which the radial distribution is clipped", 0.5, gt=0, lt=1
    )


class Drag(Table):
    """Momentum exchange and slip between water and sediment particles."""

    law: Literal["none", "wen-yu", "gidaspow"] = quantity(
        NONE,
        "wen-yu: settles nearly as Richardson & Zaki found; gidaspow: Ergun's law above a "
        "concentration of 0.2; none: no slip, particles of both phases push each other aside",
        "none",
    )


class Scheme(Table):
    """Operators and numbers of the semi-implicit scheme; a choice left out follows the form."""

    type: Literal["semi-implicit"] = quantity(NONE, "incompressible", "semi-implicit")
    form: Literal["stable", "study"] = quantity(
        NONE,
        "stable: recommended operators, walls are surfaces, virtual air at the free surface; "
        "study: those of the study, walls of particles, for comparison",
        "stable",
    )
    gradient: Literal["sum", "cmps"] | None = quantity(
        NONE, "pressure gradient: conservative sum, or, in the form study, CMPS", None
    )
    interface: Literal["symmetric", "study"] | None = quantity(
        NONE, "coefficient of the pressure equation where the density varies", None
    )
    free_surface: Literal["asymmetry", "density"] | None = quantity(
        NONE,
        "detection by number density and asymmetry, or, in the form study, by number density alone",
        None,
    )
    density_relaxation: float | None = quantity(
        "s", "time in which a density error decays; 0 for no correction", None, ge=0
    )
    courant: float = quantity(
        NONE, "greatest path of a particle in a step, in spacings", 0.2, gt=0, le=1
    )
    tolerance: float = quantity(
        NONE, "relative residual of the pressure equation", 1.0e-4, gt=0, lt=1
    )
    collision_distance: float = quantity(
        "spacing",
        "distance below which approaching particles collide, in the form study only",
        0.9,
        ge=0,
        le=1,
    )
    collision_restitution: float = quantity(
        NONE,
        "coefficient of restitution of bounces off walls, and in the form study of collisions",
        0.2,
        ge=0,
        le=1,
    )


class ExplicitScheme(Table):
    """Numbers of the explicit, weakly compressible scheme."""

    type: Literal["explicit"]
    form: Literal["stable", "study"] = quantity(
        NONE,
        "stable: recommended operators, walls are surfaces; study: those of the study, walls of "
        "particles, for comparison",
        "stable",
    )
    sound_speed: float | None = quantity(
        "m/s",
        "numerical speed of sound c; ten times the speed of a free fall through the fills, on a "
        "terrain six times that which friction lets the flow reach, if left out",
        None,
        gt=0,
    )
    courant: float = quantity(NONE, "time step times c, in spacings", 0.4, gt=0, le=1.2)
    density_diffusion: float = quantity(NONE, "delta, evens out the density", 0.1, ge=0, le=1)
    density_relaxation: float | None = quantity(
        "s",
        "time in which the density follows that summed over the particles; that of a free fall "
        "through the fills or releases if left out",
        None,
        gt=0,
    )
    artificial_viscosity: float = quantity(
        NONE, "alpha, viscosity alpha c d0 along the line of two particles", 0.05, ge=0, le=1
    )
    collision_distance: float | None = quantity(
        "spacing",
        "distance below which approaching particles collide, 0 for never; with a rheological law "
        "0.8, else 0, if left out",
        None,
        ge=0,
        le=1,
    )
    collision_restitution: float = quantity(
        NONE,
        "coefficient of restitution of collisions, and of bounces off walls",
        0.2,
        ge=0,
        le=1,
    )
    jitter: float = quantity(
        "spacing", "greatest seeded displacement of a particle at the start", 0.01, ge=0, le=0.1
    )


def _scheme_type(table: Any) -> str:
    """Return which scheme a table asks for; semi-implicit where it does not say."""
    found = table.get("type") if isinstance(table, dict) else getattr(table, "type", None)
    return "explicit" if found == "explicit" else "semi-implicit"


AnyScheme = Annotated[
    Annotated[Scheme, Tag("semi-implicit")] | Annotated[ExplicitScheme, Tag("explicit")],
    Discriminator(_scheme_type),
]


class Time(Table):
    """Simulated time."""

    end: float = quantity("s", "end of the simulated time", gt=0)
    largest_step: float | None = quantity(
        "s",
        "greatest time step; if left out, 0.03 sqrt(spacing / gravity), without gravity courant "
        "spacing / speed of fills and supply, "
        "or the limit of explicit viscosity, whichever is less; in the explicit scheme courant "
        "spacing / c instead of the first",
        None,
        gt=0,
    )
    settling: float = quantity(
        "s", "time for which the fills settle, without inflow, before t = 0", 0.0, ge=0
    )
    stop_energy: float | None = quantity(
        NONE,
        "share of its greatest value so far at which the kinetic energy ends the run before its "
        "end, once all supply is in and no obstacle moves; looked at with the history",
        None,
        gt=0,
        lt=1,
    )


class Output(Table):
    """What is written and when."""

    interval: float = quantity("s", "interval of the particle files", gt=0)
    deposit_interval: float | None = quantity(
        "s", "interval of the deposit series; as the particle files if left out", None, gt=0
    )
    history_interval: float | None = quantity(
        "s",
        "interval of the history and of the samples of the maxima; a tenth of the particle files "
        "if left out",
        None,
        gt=0,
    )
    rest_speed: float = quantity("m/s", "speed below which a deposit is at rest", 0.05, gt=0)
    layer_depth: float | None = quantity(
        "m",
        "depth from which the flow counts in the layers of a map, on terrain; 0.05 m, or a tenth "
        "more than the depth of a single particle, if that is greater, if left out",
        None,
        gt=0,
    )
    layer_interval: float | None = quantity(
        "s",
        "interval of the layers of the depth at a time, on terrain; none if left out",
        None,
        gt=0,
    )
    checkpoint_wall_time: float = quantity("s", "wall time between checkpoints", 300.0, gt=0)
    checkpoint_interval: float | None = quantity(
        "s",
        "simulated time between checkpoints, besides those by wall time; none if left out",
        None,
        gt=0,
    )


def follow_dimension(data: Any) -> Any:
    """Return the data of a case in which radius and scheme left out follow the dimension."""
    geometry = data.get("geometry") if isinstance(data, dict) else None
    named = geometry.get("type") if isinstance(geometry, dict) else None
    if named not in THREE_DIMENSIONAL and not is_three_dimensional(geometry):
        return data
    data = dict(data)
    for name, defaults in (
        ("particles", {"effective_radius": EXPLICIT_RADIUS}),
        ("scheme", {"type": "explicit"}),
    ):
        given = data.get(name, {})
        if isinstance(given, dict):
            data[name] = defaults | given
    return data


class Case(Table):
    """A whole case file."""

    title: str = quantity(NONE, "one line that says what is computed")
    notes: str = quantity(
        NONE,
        "source, what is calibrated, what to expect, for the reports on a run; the comment at the "
        "head of the file if left out",
        "",
    )
    particles: Particles
    gravity: Gravity = Gravity()
    geometry: Annotated[Geometry, Field(discriminator="type")]
    obstacle: Annotated[
        tuple[Annotated[AnyObstacle, Field(discriminator="type")], ...], Strict(False)
    ] = Field((), description="walls in the way of the flow")
    fill: Annotated[tuple[Annotated[AnyFill, Field(discriminator="type")], ...], Strict(False)] = (
        Field(
            (),
            description="regions that are filled with particles at the start, less obstacles; "
            "where fills overlap the later one in the file counts",
        )
    )
    release: Annotated[
        tuple[Annotated[AnyRelease, Field(discriminator="type")], ...], Strict(False)
    ] = Field((), description="masses and flows released on a terrain, at the start or later")
    walls: Walls = Walls()
    zone: Annotated[tuple[Zone, ...], Strict(False)] = Field(
        (), description="parts of a terrain with a friction of their own, instead of the floor's"
    )
    inflow: Inflow | None = None
    water: Water = Water()
    sediment: Sediment = Sediment()
    mixture: Mixture = Mixture()
    collision_stress: CollisionStress = CollisionStress()
    drag: Drag = Drag()
    rheology: AnyRheology = NoStrength()
    scheme: AnyScheme = Scheme()
    time: Time
    output: Output
    probe: Annotated[tuple[AnyProbe, ...], Strict(False)] = Field(
        (), description="what is measured while the case runs, each into its own file"
    )

    @property
    def dimension(self) -> int:
        """Number of space dimensions: 2, or 3."""
        return 3 if is_three_dimensional(self.geometry) else 2

    @model_validator(mode="before")
    @classmethod
    def _follow_dimension(cls, data: Any) -> Any:
        return follow_dimension(data)
