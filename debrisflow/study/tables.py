"""The tables of a study: a case, what varies in it, how, and what is wanted of the runs."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Strict

from debrisflow.case.fields import NAME_PATTERN, NONE, Interval, Series, Table, Vector
from debrisflow.case.fields import quantity as field  # a table has a field of that name
from debrisflow.study.distributions import AnyParameter


class Correlation(Table):
    """How two parameters go together: the correlation of their normal scores."""

    parameters: Annotated[tuple[str, str], Strict(False)] = field(NONE, "names of two")
    coefficient: float = field(NONE, "positive where both are large together", gt=-1, lt=1)


class Grid(Table):
    """Every combination of evenly spaced shares of each parameter, or of its values.

    The first and the last are the bounds of a uniform or triangular parameter, and of the others
    the values below which 0.5 and 99.5 % lie.
    """

    type: Literal["grid"] = field(NONE, "chooses this table")
    levels: int = field(NONE, "of a parameter without values of its own", 3, ge=2, le=100)


class OneAtATime(Table):
    """All at their middle, then each at its low and high end."""

    type: Literal["one-at-a-time"] = field(NONE, "chooses this table")
    shares: Interval = field(NONE, "the ends, as shares of the values below", (0.05, 0.95))


class LatinHypercube(Table):
    """A random sample that is even in each parameter."""

    type: Literal["latin-hypercube"] = field(NONE, "chooses this table")
    members: int = field(NONE, "how many", ge=2, le=1_000_000)
    seed: int = field(NONE, "of the random numbers", 0, ge=0)


class SobolSequence(Table):
    """A sequence that fills the space evenly; a power of two is best, and can be doubled."""

    type: Literal["sobol"] = field(NONE, "chooses this table")
    members: int = field(NONE, "how many", ge=2, le=1_000_000)
    seed: int = field(NONE, "of the random numbers", 0, ge=0)


class Morris(Table):
    """Paths on which one parameter after the other takes a step: which matter at all.

    The lowest and the highest level are the ends, as in a grid.
    """

    type: Literal["morris"] = field(NONE, "chooses this table")
    paths: int = field(NONE, "each of as many runs as parameters and one", ge=2, le=100_000)
    levels: int = field(NONE, "of each parameter, an even number", 4, ge=2, le=100, multiple_of=2)
    seed: int = field(NONE, "of the random numbers", 0, ge=0)


class Saltelli(Table):
    """Samples for Sobol's indices: which share of the variance each parameter makes."""

    type: Literal["saltelli"] = field(NONE, "chooses this table")
    samples: int = field(
        NONE, "a power of two, each of as many runs as parameters and two", ge=2, le=1_000_000
    )
    seed: int = field(NONE, "of the random numbers", 0, ge=0)


class Scenarios(Table):
    """The rows of a CSV file, whose columns are the names of the parameters."""

    type: Literal["scenarios"] = field(NONE, "chooses this table")
    file: str = field(NONE, "CSV file, beside the study")


AnyDesign = Annotated[
    Grid | OneAtATime | LatinHypercube | SobolSequence | Morris | Saltelli | Scenarios,
    Field(discriminator="type"),
]
RandomDesign = LatinHypercube | SobolSequence
"""A design whose members are drawn from the distributions, each independently of the others."""


class Quantity(Table):
    """A figure that is wanted of each run."""

    name: str | None = field(
        NONE, "by which it is called; that of the answer if left out", None, pattern=NAME_PATTERN
    )
    answer: str | None = field(NONE, "a figure of postprocess/answers.csv", None)
    layer: str | None = field(NONE, "a layer of the map, with its place", None)
    at: Vector | None = field(
        "m", "place on the map, east and north, at which the layer is read", None
    )

    @property
    def called(self) -> str:
        """The name, given or not."""
        return self.name or self.answer or f"{self.layer}_at"


class Map(Table):
    """What is wanted of a layer over all members."""

    layer: str = field(NONE, "of the layers that a run on a terrain writes")
    exceeds: Series = field(
        NONE, "thresholds whose probability of exceedance is mapped, in the unit of the layer", ()
    )
    quantiles: Series = field(NONE, "shares of the members, between 0 and 1", ())
    before: Series = field("s", "times before which the flow arrives; of the layer arrival", ())


class MapArea(Table):
    """The grid of the maps; the map of the case if left out."""

    cell: float | None = field("m", "side of a cell", None, gt=0)
    x: Interval | None = field("m", "extent to the east", None)
    y: Interval | None = field("m", "extent to the north", None)


class Extent(Table):
    """An observed extent, or a surveyed change of the elevation."""

    type: Literal["extent"] = field(NONE, "chooses this table")
    name: str = field(NONE, "by which it is called", "extent", pattern=NAME_PATTERN)
    file: str = field(NONE, "polygons of the reached area, or a raster of the change, m")
    threshold: float | None = field(
        "m", "depth, and change, from which a cell counts; as for debrisflow score", None, ge=0
    )
    error: float = field(
        NONE,
        "of the missed and of the falsely reached area, each as a share of the observed one, that "
        "a perfect model would still have: errors of the map, of the terrain and of the physics",
        gt=0,
    )
    false_error: float | None = field(
        NONE,
        "of the falsely reached area, if another: a survey overlooks where thin flow passed",
        None,
        gt=0,
    )


class Figure(Table):
    """An observed figure: an arrival, a level, a volume, a run-out."""

    type: Literal["figure"] = field(NONE, "chooses this table")
    quantity: str = field(NONE, "name of a [[quantity]] of the study")
    value: float = field(NONE, "as observed, in the unit of the quantity")
    error: float = field(
        NONE, "standard deviation of the observation and of the model, in the same unit", gt=0
    )


AnyObservation = Annotated[Extent | Figure, Field(discriminator="type")]


class Part(Table):
    """A part of the map, by its extent."""

    x: Interval | None = field("m", "extent to the east; all if left out", None)
    y: Interval | None = field("m", "extent to the north; all if left out", None)


class Calibration(Table):
    """How the parameters are fitted to the observations."""

    runs: int = field(
        NONE, "in all, those of the design among them; the others are chosen one by one", ge=4
    )
    at_once: int = field(
        NONE,
        "how many of these are chosen at a time, to be computed together; as many as there are "
        "workers saves time, one saves runs",
        2,
        ge=1,
    )
    predictive: int = field(
        NONE, "runs drawn from the posterior, for its maps; besides the others", 0, ge=0
    )
    held_out: Part | None = field(
        NONE, "part of the observed extents that is not used, and compared afterwards", None
    )
    seed: int = field(NONE, "of the random numbers", 0, ge=0)


class Study(Table):
    """A study as its file states it."""

    title: str = field(NONE, "one line")
    notes: str = field(NONE, "what a reader must know", "")
    case: str = field(NONE, "case file that all members start from, beside the study")
    set: dict[str, Any] = field(
        NONE,
        "changes to the case for all members, by its keys; what a parameter sets too is its start, "
        "which the parameter multiplies or replaces",
        {},
    )
    parameter: Annotated[tuple[AnyParameter, ...], Strict(False)] = field(
        NONE, "what differs between members", min_length=1
    )
    correlation: Annotated[tuple[Correlation, ...], Strict(False)] = field(
        NONE, "of pairs of parameters; the others vary independently", ()
    )
    design: AnyDesign = field(NONE, "which values are computed")
    quantity: Annotated[tuple[Quantity, ...], Strict(False)] = field(
        NONE, "figures wanted of each run; run-out and the like of a run if left out", ()
    )
    map: Annotated[tuple[Map, ...], Strict(False)] = field(NONE, "maps over all members", ())
    area: MapArea = field(NONE, "the grid of the maps", MapArea())
    observation: Annotated[tuple[AnyObservation, ...], Strict(False)] = field(
        NONE, "what the runs are compared with", ()
    )
    calibration: Calibration | None = field(NONE, "of the parameters, by observations", None)
