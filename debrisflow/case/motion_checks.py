"""Checks of the motions of obstacles."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

from debrisflow.case.motion import Motion
from debrisflow.case.problems import Problem, Problems, was_set
from debrisflow.case.shapes import Geometry, is_three_dimensional
from debrisflow.case.tables import AnyObstacle, AnyScheme

Obstacles = tuple[AnyObstacle, ...]


def _motions(obstacle: Obstacles) -> dict[str, Motion]:
    """Return the motions by their keys."""
    return {
        f"obstacle.{k}.motion": body.motion
        for k, body in enumerate(obstacle)
        if isinstance(body.motion, Motion)
    }


def one_way_of_motion(obstacle: Obstacles) -> Problems:
    """Check that a motion is a velocity or a table, and complete."""
    for key, motion in _motions(obstacle).items():
        if motion.velocity is None:
            if motion.time is None:
                yield Problem(key, "give a velocity, or a table: time with any of x, y, z, angle")
            elif not motion.table:
                yield Problem(key, "a table needs, besides time, any of x, y, z, angle")
            if was_set(motion, "start"):
                message = "has an effect with a velocity only; leave it out"
                yield Problem(f"{key}.start", message, motion.start)
        else:
            for name in ("time", *motion.table):
                if getattr(motion, name) is not None:
                    message = f"{key}.velocity is given as well; leave one of them out"
                    yield Problem(f"{key}.{name}", message, getattr(motion, name))
        if motion.angle is not None and motion.about is None:
            message = "missing: x and level of the axis that it turns about (m)"
            yield Problem(f"{key}.about", message)
        if motion.angle is None and motion.about is not None:
            yield Problem(f"{key}.about", "has an effect with an angle only", motion.about)


def table_of_motion_in_order(obstacle: Obstacles) -> Problems:
    """Check that the times of a motion increase from 0 on, and that it begins where it stands."""
    for key, motion in _motions(obstacle).items():
        if motion.time is None:
            continue
        if len(motion.time) < 2:
            yield Problem(f"{key}.time", "needs two times at least", motion.time)
        if motion.time and motion.time[0] < 0.0:
            message = "must not be before the start of the run, 0 s"
            yield Problem(f"{key}.time.0", message, motion.time[0])
        for k, (before, after) in enumerate(pairwise(motion.time), start=1):
            if after <= before:
                message = f"must be later than the one before, {before:g} s"
                yield Problem(f"{key}.time.{k}", message, after)
        for name, column in motion.table.items():
            if len(column) != len(motion.time):
                message = f"must have a value for each time, {len(motion.time)}, not {len(column)}"
                yield Problem(f"{key}.{name}", message)
            elif column[0] != 0.0:
                message = "must be 0: the obstacle begins where the case puts it"
                yield Problem(f"{key}.{name}.0", message, column[0])


def motions_of_dimension(geometry: Geometry, obstacle: Obstacles) -> Problems:
    """Check that motions have the dimension of the space."""
    dimension = 3 if is_three_dimensional(geometry) else 2
    for key, motion in _motions(obstacle).items():
        if motion.velocity is not None and len(motion.velocity) != dimension:
            message = f"must be a list of {dimension} numbers, one for each dimension"
            yield Problem(f"{key}.velocity", message, motion.velocity)
        if dimension == 2 and motion.z is not None:
            yield Problem(f"{key}.z", "only in three dimensions; in two y is up", motion.z)


def motions_of_surfaces(scheme: AnyScheme, geometry: Geometry, obstacle: Obstacles) -> Problems:
    """Check that what moves is felt as a surface, and turns in a space that does not repeat."""
    for key, motion in _motions(obstacle).items():
        if scheme.form == "study":
            yield Problem(key, "walls of particles do not move; set scheme.form = 'stable'")
        if geometry.periodic and motion.angle is not None:
            yield Problem(f"{key}.angle", "nothing turns in a space that repeats; leave it out")


CHECKS: tuple[Callable[..., Problems], ...] = (
    one_way_of_motion,
    table_of_motion_in_order,
    motions_of_dimension,
    motions_of_surfaces,
)
