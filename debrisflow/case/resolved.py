"""The tables of a resolved case, in which nothing is left open that follows from other fields."""

from __future__ import annotations

from typing import Any, Literal, Self, TypeVar

from pydantic import Field, PrivateAttr

from debrisflow.case.fields import Point, Table
from debrisflow.case.releases import (
    Hydrograph,
    HydrographRelease,
    PolygonRelease,
    RasterRelease,
    Segment,
)
from debrisflow.case.shapes import Channel, Channel3D, ChannelShape, Tank, Tank3D
from debrisflow.case.tables import (
    Case,
    ExplicitScheme,
    Inflow,
    Output,
    Scheme,
    Time,
)
from debrisflow.case.terrain import Box, Terrain

_Resolved = TypeVar("_Resolved", bound=Table)


def _known(table: type[Table], name: str) -> Any:
    """Return a field as a table has it, but without a default."""
    field = table.model_fields[name]
    return Field(description=field.description, json_schema_extra=field.json_schema_extra)


def resolved(kind: type[_Resolved], table: Table, **found: object) -> _Resolved:
    """Return a table as its resolved kind: what it leaves open takes the values found.

    Examples
    --------
    >>> resolved(ResolvedTime, Time(end=2.0), largest_step=0.001).largest_step
    0.001
    """
    given = {name: value for name, value in table if value is not None}
    return kind(**(found | given))


class ResolvedChannel(Channel):
    """A channel in two dimensions of which the end of the recess is known."""

    bed_end: float = _known(ChannelShape, "bed_end")


class ResolvedChannel3D(Channel3D):
    """A channel in three dimensions of which the end of the recess is known."""

    bed_end: float = _known(ChannelShape, "bed_end")


class ResolvedTerrain(Terrain):
    """A terrain whose extent, surface and origin are known; lengths are measured from the origin.

    Obstacles and probes of a resolved case have places over its origin, as particles have.
    """

    crop: Box = _known(Terrain, "crop")
    cell: float = _known(Terrain, "cell")
    upper_level: float = _known(Terrain, "upper_level")
    origin: Point = _known(Terrain, "origin")

    @property
    def box(self) -> Box:
        """West, south, east and north border of the cells that are computed, m."""
        return self.crop

    @property
    def height(self) -> float:
        """Level of the top of the space over the origin, m."""
        return self.upper_level - self.origin[2]


class MappedTerrain(ResolvedTerrain):
    """A terrain as it is built, of a case whose obstacles and probes are still on the map."""


class ResolvedHydrographRelease(HydrographRelease):
    """A flow that enters over a line, whose direction and hydrograph are known."""

    line: Segment = _known(HydrographRelease, "line")
    direction: float = _known(HydrographRelease, "direction")
    hydrograph: Hydrograph = _known(HydrographRelease, "hydrograph")


class SteadyInflow(Inflow):
    """A supply that does not change."""

    discharge: float = _known(Inflow, "discharge")
    velocity: float = _known(Inflow, "velocity")
    hydrograph: None = _known(Inflow, "hydrograph")


class UnsteadyInflow(Inflow):
    """A supply that follows a hydrograph."""

    hydrograph: Hydrograph = _known(Inflow, "hydrograph")


class ResolvedScheme(Scheme):
    """The semi-implicit scheme with its operators chosen."""

    gradient: Literal["sum", "cmps"] = _known(Scheme, "gradient")
    interface: Literal["symmetric", "study"] = _known(Scheme, "interface")
    free_surface: Literal["asymmetry", "density"] = _known(Scheme, "free_surface")
    density_relaxation: float = _known(Scheme, "density_relaxation")


class ResolvedExplicitScheme(ExplicitScheme):
    """The explicit scheme with its speed of sound."""

    sound_speed: float = _known(ExplicitScheme, "sound_speed")
    density_relaxation: float = _known(ExplicitScheme, "density_relaxation")
    collision_distance: float = _known(ExplicitScheme, "collision_distance")


class ResolvedTime(Time):
    """Simulated time, and the greatest step."""

    largest_step: float = _known(Time, "largest_step")


class ResolvedOutput(Output):
    """What is written and when."""

    deposit_interval: float = _known(Output, "deposit_interval")
    history_interval: float = _known(Output, "history_interval")
    layer_depth: float = _known(Output, "layer_depth")


ResolvedChannelShape = ResolvedChannel | ResolvedChannel3D
ResolvedGeometry = Tank | ResolvedChannel | Tank3D | ResolvedChannel3D | ResolvedTerrain
ResolvedRelease = PolygonRelease | RasterRelease | ResolvedHydrographRelease
ResolvedInflow = SteadyInflow | UnsteadyInflow
AnyResolvedScheme = ResolvedScheme | ResolvedExplicitScheme


class ResolvedCase(Case):
    """A case that is checked, and in which nothing is left open."""

    geometry: ResolvedGeometry = _known(Case, "geometry")
    release: tuple[ResolvedRelease, ...] = _known(Case, "release")
    inflow: ResolvedInflow | None = _known(Case, "inflow")
    scheme: AnyResolvedScheme = _known(Case, "scheme")
    time: ResolvedTime = _known(Case, "time")
    output: ResolvedOutput = _known(Case, "output")
    _asked: Case | None = PrivateAttr(None)
    _former_names: tuple[str, ...] = PrivateAttr(())

    @property
    def asked(self) -> Case | None:
        """The case before its lengths were rounded to the lattice; None if none was, or is known.

        A case that is read back from a run knows what is built only.
        """
        return self._asked

    @property
    def former_names(self) -> tuple[str, ...]:
        """What the file called by a former name, and its present one, a line each."""
        return self._former_names

    def keep(self, asked: Case | None, former_names: tuple[str, ...]) -> Self:
        """Keep the case as it was asked, and the former names in it, and return this one."""
        self._asked, self._former_names = asked, former_names
        return self

    @property
    def is_terrain(self) -> bool:
        """Whether the space is a terrain."""
        return isinstance(self.geometry, ResolvedTerrain)

    @property
    def terrain(self) -> ResolvedTerrain:
        """The geometry of a case on a terrain; TypeError of others."""
        if isinstance(self.geometry, ResolvedTerrain):
            return self.geometry
        raise TypeError("the case is not on a terrain")

    @property
    def has_surfaces(self) -> bool:
        """Whether walls are surfaces in the solution, not particles."""
        return self.scheme.form == "stable"

    @property
    def semi_implicit_scheme(self) -> ResolvedScheme:
        """The scheme of a case that is computed by the semi-implicit one; TypeError of others."""
        if isinstance(self.scheme, ResolvedScheme):
            return self.scheme
        raise TypeError("the scheme of the case is not semi-implicit")

    @property
    def explicit_scheme(self) -> ResolvedExplicitScheme:
        """The scheme of a case that is computed by the explicit one; TypeError of others."""
        if isinstance(self.scheme, ResolvedExplicitScheme):
            return self.scheme
        raise TypeError("the scheme of the case is not explicit")
