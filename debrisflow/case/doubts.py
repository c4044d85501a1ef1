"""What is allowed and was hardly meant: units mistaken, signs turned, a flow too thin to resolve.

Each is a warning of ``debrisflow check`` and of a run, with what was probably meant; none stops it.
Former names of fields are told beside them.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import atan, degrees, hypot, inf, isclose

import numpy as np

from debrisflow.case.bodies import PolygonObstacle
from debrisflow.case.built import LARGEST_MISFIT, enough
from debrisflow.case.defaults import LARGEST_PATH, phases
from debrisflow.case.motion import Motion
from debrisflow.case.polygons import share_without_rows
from debrisflow.case.released import area, entering_depth, length_of, share_below, volume
from debrisflow.case.resolved import (
    ResolvedCase,
    ResolvedHydrographRelease,
    ResolvedRelease,
    ResolvedTerrain,
)
from debrisflow.case.tables import Block, Scheme
from debrisflow.case.terrain_built import CELL_SPACINGS

EARTH = 9.81  # m/s2
STEEP = 45.0  # degrees, steeper than any debris flow on record
WATERS = 500.0, 2000.0  # kg/m3, with what fine grains make of it
ROCKS = 1500.0, 5000.0  # kg/m3
GREATEST_GRAIN = 1.0  # spacings
FEWEST_ROWS = 2  # of particles over a depth
MOST_WITHOUT_ROWS = 0.25  # of the sides of a polygon; a sharp wedge has some at its tips
MOST_THIN = 0.5  # of the time of a hydrograph, in which it is less than a row deep
SHORTENED = 0.1  # of the greatest time step, by a wall that moves


def doubts(case: ResolvedCase) -> list[str]:
    """Return what is doubtful about a case, a line each, beginning with the key."""
    return [*case.former_names, *(line for doubt in DOUBTS for line in doubt(case))]


def _gravity(case: ResolvedCase) -> Iterator[str]:
    along, up = case.gravity.components
    size, axis = hypot(along, up), "yz"[case.dimension - 2]
    if up > 0.0:
        yield f"gravity points upward, by {up:.3g} m/s2; down is negative {axis}"
    elif case.gravity.vector is None and abs(case.gravity.slope) > STEEP:
        yield (
            f"gravity.slope = {case.gravity.slope:g} degree: steeper than debris flows are; it is "
            "the angle of the x axis below the horizontal, in degrees"
        )
    if size > 3.0 * EARTH:
        yield f"gravity is {size:.3g} m/s2; on Earth it is {EARTH:g} m/s2"


def _densities(case: ResolvedCase) -> Iterator[str]:
    for name, value, (least, greatest), usual in (
        ("water.density", case.water.density, WATERS, 1000),
        ("sediment.density", case.sediment.density, ROCKS, 2650),
    ):
        if not least <= value <= greatest:
            yield f"{name} = {value:g} kg/m3: {usual} is usual; densities are in kg/m3"


def _shares(case: ResolvedCase) -> Iterator[str]:
    limit = case.sediment.packing_limit
    for number, part in enumerate(case.fill):
        share = getattr(part, "sediment_share", 0.0)
        if part.material == "two-phase" and share > limit:
            yield (
                f"fill.{number}.sediment_share = {share:g}: more grains than fit, "
                f"sediment.packing_limit = {limit:g}"
            )


def _grains(case: ResolvedCase) -> Iterator[str]:
    diameter, spacing = case.sediment.grain_diameter, case.particles.spacing
    has_grains = "mixture" in phases(case.fill, None, case.geometry, case.release)
    has_grains = has_grains or any(part.material != "water" for part in case.fill)
    if has_grains and case.collision_stress.enabled and diameter > GREATEST_GRAIN * spacing:
        yield (
            f"sediment.grain_diameter = {diameter:g} m: grains larger than a particle, "
            f"particles.spacing = {spacing:g} m"
        )


def _times(case: ResolvedCase) -> Iterator[str]:
    end = case.time.end
    named = [("output.interval", case.output.interval)]
    named += [(f"probe.{probe.name}.interval", probe.interval) for probe in case.probe]
    for name, interval in named:
        if interval > end and not isclose(interval, end):
            yield f"{name} = {interval:g} s: longer than the run, time.end = {end:g} s"
    for body in case.obstacle:
        if isinstance(body.motion, Motion) and body.motion.start >= end:
            start = f"obstacle.{body.name}.motion.start = {body.motion.start:g} s"
            yield f"{start}: it never moves, since the run ends at {end:g} s"
    for number, part in enumerate(case.release):
        if part.start >= end:
            key = f"release.{part.name or number}.start"
            yield f"{key} = {part.start:g} s: never released, since the run ends at {end:g} s"


def rows_over_depths(case: ResolvedCase) -> dict[str, int]:
    """Return the rows of particles over the depths of what flows, by their keys.

    Of a release the mean depth counts, of a hydrograph that at its greatest discharge.
    """
    return {name: round(depth / case.particles.spacing) for name, depth in _depths(case).items()}


def _depths(case: ResolvedCase) -> dict[str, float]:
    up = "yz"[case.dimension - 2]
    depths = {
        f"fill.{number}": extent[1] - extent[0]
        for number, part in enumerate(case.fill)
        if isinstance(part, Block) and (extent := getattr(part, up)) is not None
    }
    if case.inflow is not None:
        depths["inflow"] = case.inflow.depth
    for number, part in enumerate(case.release):
        depths[f"release.{part.name or number}"] = _depth_of(part)
    return depths


def _depth_of(part: ResolvedRelease) -> float:
    """Return the mean depth of a release, and that in which a hydrograph enters at its peak, m."""
    if isinstance(part, ResolvedHydrographRelease):
        return entering_depth(part)
    return volume(part) / area(part)


def _rows(case: ResolvedCase) -> Iterator[str]:
    depths = _depths(case)
    for name, rows in rows_over_depths(case).items():
        if rows < FEWEST_ROWS:
            count = "one row" if rows else "less than a row"
            yield (
                f"{name}: {count} of particles over its depth of {depths[name]:g} m; with two or "
                f"more, particles.spacing = {depths[name] / FEWEST_ROWS:.2g}, it has a profile"
            )


def _supply(case: ResolvedCase) -> Iterator[str]:
    asked = case.asked.inflow if case.asked else None
    if asked is None or case.inflow is None:
        return
    depth = case.inflow.depth
    if abs(depth - asked.depth) > LARGEST_MISFIT * asked.depth * (1.0 + 1e-6):
        fits = enough(asked.depth, case.particles.spacing)
        yield (
            f"inflow.depth = {asked.depth:g} m is built {depth:g} m deep, with the discharge that "
            f"is asked; particles.spacing = {fits:.4g} would fit"
        )


def _fast_walls(case: ResolvedCase) -> Iterator[str]:
    path = LARGEST_PATH
    if isinstance(case.scheme, Scheme):
        path = case.scheme.courant
    for body in case.obstacle:
        speed = body.motion.greatest_speed if isinstance(body.motion, Motion) else 0.0
        step = path * case.particles.spacing / speed if speed > 0.0 else inf
        if step < SHORTENED * case.time.largest_step:
            yield (
                f"obstacle.{body.name}.motion: up to {speed:.3g} m/s; while it moves so fast, the "
                f"time step is {step:.2g} s instead of {case.time.largest_step:.2g} s"
            )


def _thin_parts(case: ResolvedCase) -> Iterator[str]:
    for body in case.obstacle:
        if isinstance(body, PolygonObstacle):
            share = share_without_rows(body, case.particles.spacing)
            if share > MOST_WITHOUT_ROWS:
                yield (
                    f"obstacle.{body.name}: {share:.0%} of its sides belong to parts thinner than "
                    "a spacing, which do not hold the fluid"
                )


def _steep_ground(case: ResolvedCase) -> Iterator[str]:
    if not isinstance(case.geometry, ResolvedTerrain):
        return
    levels = case.geometry.levels
    rise = np.hypot(*np.gradient(levels.values, levels.grid.cell))
    steep = degrees(atan(float(np.nanmedian(rise)))) if np.isfinite(rise).any() else 0.0
    if steep > STEEP:
        yield (
            f"geometry.dem: half of the ground is steeper than {steep:.0f} degrees; are its levels "
            "in feet, or its coordinates not in meters?"
        )


def _fine_ground(case: ResolvedCase) -> Iterator[str]:
    if not isinstance(case.geometry, ResolvedTerrain):
        return
    cell, least = case.geometry.cell, CELL_SPACINGS * case.particles.spacing
    if cell < least * (1.0 - 1e-6):
        yield (
            f"geometry.cell = {cell:g} m: less than {CELL_SPACINGS:g} spacings, {least:g} m; the "
            "flow sees bumps of its ground that its particles do not resolve, as if it were "
            "rougher than it is; leave geometry.cell out, or take a smaller particles.spacing"
        )


def _thin_supply(case: ResolvedCase) -> Iterator[str]:
    spacing = case.particles.spacing
    for number, part in enumerate(case.release):
        if not isinstance(part, ResolvedHydrographRelease) or entering_depth(part) < spacing:
            continue  # of that one row is told
        one_row = spacing * part.velocity * length_of(part.line)
        thin, flows = share_below(part, one_row, case.time.end), f"{one_row:.3g} m3/s"
        if thin > MOST_THIN:
            yield (
                f"release.{part.name or number}: for {thin:.0%} of the time in which it flows its "
                f"discharge is below {flows}, a row of particles over the line: they enter in "
                "single rows with gaps between them; with a smaller velocity, a shorter line or a "
                "smaller particles.spacing the flow is deeper than a row"
            )


def _bare_ground(case: ResolvedCase) -> Iterator[str]:
    floor = case.walls.floor
    if isinstance(case.geometry, ResolvedTerrain) and floor.friction is None:
        yield (
            f"walls.floor: {floor.slip}, without a law of friction; over a terrain a flow is a few "
            "rows of particles deep, and a law like that of Voellmy, walls.floor.friction, says "
            "what holds it"
        )


DOUBTS = (
    _gravity,
    _densities,
    _shares,
    _grains,
    _times,
    _rows,
    _supply,
    _fast_walls,
    _thin_parts,
    _steep_ground,
    _fine_ground,
    _thin_supply,
    _bare_ground,
)
