"""What the tables of all probes have, and the space in which their places are checked."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from math import hypot
from typing import Any, ClassVar, NamedTuple, Self, TypeVar

from debrisflow.case.bodies import BoxObstacle, PolygonObstacle
from debrisflow.case.fields import NAME_PATTERN, NONE, Table, quantity
from debrisflow.case.polygons import distance_to_polygon, fault_of, is_in_polygon
from debrisflow.case.words import ABSENT, did_you_mean, either, place

SIZE = "side of the square, in two dimensions width of the strip, {}; 2 spacings if left out"
SIZE_SPACINGS = 2  # of a size that is left out
_Any = TypeVar("_Any")
TOLERANCE = 1e-6  # spacings
DIGITS = 9  # behind the point, of a place that is measured from another origin
SLACK = 0.5 + TOLERANCE  # spacings by which a wall may be built beside the place asked


class Fault(NamedTuple):
    """Something wrong with one field of a probe.

    Attributes
    ----------
    field : str
    message : str
        What is wrong, without the field and its value.
    value : object
        The wrong value, or ``ABSENT``.
    """

    field: str
    message: str
    value: Any = ABSENT


Faults = Iterator[Fault]


class Space(NamedTuple):
    """The space of a case, in which the places of its probes are checked.

    Attributes
    ----------
    shape : str
        Type of the geometry.
    dimension : int
    spacing : float, m
    extents : dict of str to (float, float), m
        Ends of the space by axis.
    repeats_along_x : bool
    planes : dict of str to (int, float) or None
        Axis and level, m, of each wall by name; None for a wall of several levels.
    obstacles : dict of str to obstacle
    """

    shape: str
    dimension: int
    spacing: float
    extents: Mapping[str, tuple[float, float]]
    repeats_along_x: bool
    planes: Mapping[str, tuple[int, float] | None]
    obstacles: Mapping[str, Table]

    def coordinate_faults(self, axis: str, value: object) -> Faults:
        """Yield a fault if a coordinate that only three dimensions have is missing or too many."""
        if self.dimension == 3 and value is None:
            yield Fault(axis, "missing: the place needs it in three dimensions")
        elif self.dimension == 2 and value is not None:
            yield Fault(axis, f"the place has no {axis} in two dimensions; leave it out", value)

    def place_faults(self, **place: float | None) -> Faults:
        """Yield a fault for each coordinate, by its axis, that is outside the space."""
        slack = SLACK * self.spacing
        for axis, (lower, upper) in self.extents.items():
            value = place.get(axis)
            if value is not None and not lower - slack <= value <= upper + slack:
                yield Fault(
                    axis, f"outside the {self.shape}, {axis} = {_ends(lower, upper)}", value
                )

    def extent_faults(self, **box: tuple[float, float] | None) -> Faults:
        """Yield a fault for each extent, by its axis, that is empty or wholly outside the space."""
        for axis, (lower, upper) in self.extents.items():
            extent = box.get(axis)
            if extent is None:
                continue
            if extent[0] >= extent[1]:
                yield Fault(axis, "the first number must be less than the second", extent)
            elif extent[1] <= lower or extent[0] >= upper:
                message = f"outside the {self.shape}, {axis} = {_ends(lower, upper)}"
                yield Fault(axis, message, extent)

    def wall_faults(self, wall: str) -> Faults:
        """Yield a fault if there is no wall or obstacle of a name."""
        known = (*self.planes, *self.obstacles)
        if wall not in known:
            message = f"there is no such wall, but {either(known)}" + did_you_mean(wall, known)
            yield Fault("wall", message, wall)

    def obstacle_around(self, place: tuple[float, float, float]) -> str | None:
        """Return the name of the box or polygon that stands at a place; None if none does."""
        for name, body in self.obstacles.items():
            if getattr(body, "motion", None) is not None:
                continue
            if isinstance(body, BoxObstacle) and all(
                low < at < high
                for at, (low, high) in zip(body.unturned(place), body.extents, strict=False)
            ):
                return name
            if (
                isinstance(body, PolygonObstacle)
                and not fault_of(body)
                and is_in_polygon(place[0], place[1], body)
            ):
                return name
        return None

    def distance_to(self, wall: str, place: tuple[float, float, float]) -> float | None:
        """Return the distance of a place to the surface of a wall, m.

        None for a bed and a mesh, whose surface only the run finds, and a polygon that is wrong.
        """
        plane, body = self.planes.get(wall), self.obstacles.get(wall)
        if plane is not None:
            return abs(place[plane[0]] - plane[1])
        if isinstance(body, BoxObstacle):
            return _distance_to_box(place, body)
        if isinstance(body, PolygonObstacle) and not fault_of(body):
            return distance_to_polygon(place[0], place[1], body)
        return None


def _ends(lower: float, upper: float) -> str:
    return f"[{place(lower)}, {place(upper)}] m"


def _distance_to_box(place: tuple[float, float, float], box: BoxObstacle) -> float:
    """Return the distance of a point, outside or inside, to the surface of a box, m."""
    place = box.unturned(place)
    gaps = [max(low - at, at - high) for at, (low, high) in zip(place, box.extents, strict=False)]
    return hypot(*(max(gap, 0.0) for gap in gaps)) if max(gaps) > 0 else -max(gaps)


class Probe(Table):
    """What all probes have; a probe is a table like this, see :mod:`debrisflow.case.probes`."""

    reads_reactions: ClassVar[bool] = False
    """Whether it reads what the walls do to the fluid."""

    name: str = quantity(
        NONE,
        "name of the probe, and of its file probes/NAME.csv; small letters, digits and _",
        pattern=NAME_PATTERN,
    )
    interval: float = quantity(
        "s", "sampling interval; a sample is taken at the end of the step in which it is due", gt=0
    )
    type: str

    def faults(self, space: Space) -> Faults:
        """Yield what is wrong with the probe in the space of its case."""
        raise NotImplementedError

    def complete(self, spacing: float) -> Self:
        """Return the probe with the fields filled in that follow from the spacing, m."""
        return self

    def moved(self, by: tuple[float, float, float]) -> Self:
        """Return the probe at another place, m: its x, y, z, start, end and about, if given."""
        found: dict[str, Any] = {}
        for axis, step in zip("xyz", by, strict=True):
            at = getattr(self, axis, None)
            if at is not None:
                ends = tuple(
                    round(a + step, DIGITS) for a in (at if isinstance(at, tuple) else (at,))
                )
                found[axis] = ends if isinstance(at, tuple) else ends[0]
        for name in {"start", "end", "about"} & self.model_fields_set:
            at = getattr(self, name)
            if isinstance(at, tuple):
                found[name] = tuple(
                    round(a + step, DIGITS) for a, step in zip(at, by, strict=False)
                )
        return self.model_copy(update=found)

    def warning(self, spacing: float) -> str:
        """Return what makes its answer poor at a spacing, m; empty if nothing does."""
        return ""

    def where(self) -> str:
        """Return the place of the probe as in the case file: ``x = 0.5, size = 0.04``."""
        fields = self.model_dump(exclude={"name", "interval", "type"}, exclude_none=True)
        return ", ".join(f"{key} = {value}" for key, value in fields.items())


def only_subclass(module: str, base: type[_Any]) -> type[_Any]:
    """Return the only subclass of a class that a module defines, given by the module's name."""
    [found] = (
        item
        for item in vars(import_module(module)).values()
        if isinstance(item, type) and issubclass(item, base) and item.__module__ == module
    )
    return found
