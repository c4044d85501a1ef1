"""Cross-checks at the door: what only two or more fields of a case can tell.

Each check asks for the tables that it compares, by the names they have in the case, and yields
problems; so that those that can be run are run even where another table could not be built.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from inspect import signature
from itertools import combinations, pairwise
from math import degrees, hypot, isclose, isfinite, radians, sqrt, tan
from typing import Any

from debrisflow.case import probe_checks
from debrisflow.case.defaults import FEWEST_RELAXATION_STEPS, phases, viscous_limits
from debrisflow.case.estimate import available_memory, estimate, size
from debrisflow.case.fields import Table
from debrisflow.case.problems import Problem
from debrisflow.case.regions import WEIR_SPACINGS, Geometry, bed_end, covered, open_space
from debrisflow.case.tables import (
    AnyScheme,
    Bed,
    Block,
    Channel,
    CollisionStress,
    Drag,
    ExplicitScheme,
    Gravity,
    Inflow,
    Mixture,
    Particles,
    Scheme,
    Sediment,
    Strength,
    Tank,
    Tank3D,
    Time,
    Walls,
    Water,
)

Problems = Iterator[Problem]
Fill = tuple[Block | Bed, ...]

# Share of a spacing by which a length may miss a multiple of it, for round-off in decimals.
TOLERANCE = 1e-6
FEWEST_SPACINGS = 4
FEWEST_BED_SPACINGS = 3
LARGEST_BEND = 25.0  # degrees; its cosine is above operators.EDGE, so that a floor is no edge


def cross_check(tables: Mapping[str, Any]) -> list[Problem]:
    """Return the problems among the given tables of a case, by name."""
    found: list[Problem] = []
    for check in CHECKS:
        wanted = signature(check).parameters
        if all(name in tables for name in wanted):
            found.extend(check(**{name: tables[name] for name in wanted}))
    return found


def anything_to_compute(fill: Fill, inflow: Inflow | None) -> Problems:
    """Check that there is something to compute."""
    if not fill and inflow is None:
        yield Problem("fill", "no particles: give at least one [[fill]] or an [inflow]")


def one_way_of_gravity(gravity: Gravity) -> Problems:
    """Check that gravity is a vector or a slope, not both."""
    if gravity.vector is None:
        return
    for name in ("acceleration", "slope"):
        if name in gravity.model_fields_set:
            message = "gravity.vector is given as well; leave one of them out"
            yield Problem(f"gravity.{name}", message, getattr(gravity, name))


def intervals_in_order(
    geometry: Geometry, particles: Particles, fill: Fill, strength: Strength
) -> Problems:
    """Check that intervals begin before they end."""
    intervals = {
        f"fill.{k}.{axis}": getattr(block, axis)
        for k, block in enumerate(fill)
        if isinstance(block, Block)
        for axis in ("x", "y")
    }
    intervals["strength.concentration_ramp"] = strength.concentration_ramp
    for key, interval in intervals.items():
        if interval[0] >= interval[1]:
            yield Problem(key, "the first number must be less than the second", interval)
    if isinstance(geometry, Channel):
        end = bed_end(geometry, particles)
        if geometry.bed_thickness > 0 and geometry.bed_start >= end:
            message = f"must be less than bed_end = {end:g} m"
            yield Problem("geometry.bed_start", message, geometry.bed_start)
        if end > geometry.length:
            message = f"must be at most the length {geometry.length:g} m"
            yield Problem("geometry.bed_end", message, end)


def lengths_on_lattice(
    geometry: Geometry, particles: Particles, fill: Fill, inflow: Inflow | None
) -> Problems:
    """Check that lengths are multiples of the spacing, so that the lattice has no gaps."""
    lengths: dict[str, float] = {}
    if isinstance(geometry, Tank):
        names = ["width", "height"]
    elif isinstance(geometry, Tank3D):
        names = ["length", "width", "height"]
    else:
        names = ["length", "bed_start", "bed_thickness", "weir_height"]
        names += [n for n in ("bed_end", "runout_start") if getattr(geometry, n) is not None]
    lengths |= {f"geometry.{name}": getattr(geometry, name) for name in names}
    if inflow is not None and inflow.depth >= particles.spacing:
        lengths["inflow.depth"] = inflow.depth
    for k, block in enumerate(fill):
        if isinstance(block, Block):
            lengths |= {
                f"fill.{k}.{axis}.{end}": extent[end]
                for axis in "xyz"
                for end in (0, 1)
                if (extent := getattr(block, axis)) is not None
            }
    for key, length in lengths.items():
        count = length / particles.spacing
        if not isfinite(count) or abs(count - round(count)) <= TOLERANCE:
            continue
        nearest = max(round(count), 1) if length > 0 else min(round(count), -1)
        yield Problem(
            key,
            f"not a multiple of the spacing {particles.spacing:g} m; "
            f"the nearest is {nearest * particles.spacing:.10g} m",
            length,
        )


def space_resolved(geometry: Geometry, particles: Particles, inflow: Inflow | None) -> Problems:
    """Check that the spacing resolves tank, channel, bed and supply."""
    spacing = particles.spacing
    across = ["height"]
    if isinstance(geometry, Tank3D):
        across.append("length")
    if not geometry.periodic:
        across.append("length" if isinstance(geometry, Channel) else "width")
    for name in across:
        length = getattr(geometry, name)
        if length < (FEWEST_SPACINGS - TOLERANCE) * spacing:
            message = f"not resolved: must be at least {FEWEST_SPACINGS} spacings of {spacing:g} m"
            yield Problem(f"geometry.{name}", message, length)
    if (
        isinstance(geometry, Channel)
        and 0 < geometry.bed_thickness < (FEWEST_BED_SPACINGS - TOLERANCE) * spacing
    ):
        message = f"not resolved: must be at least {FEWEST_BED_SPACINGS} spacings of {spacing:g} m"
        yield Problem("geometry.bed_thickness", message, geometry.bed_thickness)
    if inflow and inflow.depth < (1 - TOLERANCE) * spacing:
        message = f"not resolved: must be at least one spacing of {spacing:g} m"
        yield Problem("inflow.depth", message, inflow.depth)


def periodic_space(geometry: Geometry, particles: Particles) -> Problems:
    """Check that a periodic space does not see itself and has no weir."""
    if not geometry.periodic:
        return
    name = "length" if isinstance(geometry, Channel) else "width"
    least = 3 * (particles.effective_radius + 1) * particles.spacing
    if getattr(geometry, name) < least * (1 - TOLERANCE):
        message = (
            f"too short to be periodic: at least 3 (effective_radius + 1) spacings, {least:g} m"
        )
        yield Problem(f"geometry.{name}", message, getattr(geometry, name))
    if isinstance(geometry, Channel) and geometry.weir_height > 0:
        yield Problem(
            "geometry.weir_height", "a periodic channel has no weir", geometry.weir_height
        )


def weir_in_channel(geometry: Geometry) -> Problems:
    """Check that the weir leaves the channel open above it."""
    if isinstance(geometry, Channel) and geometry.weir_height >= geometry.height:
        message = f"must be less than the height of the channel, {geometry.height:g} m"
        yield Problem("geometry.weir_height", message, geometry.weir_height)


def runout_behind_bed(
    geometry: Geometry, gravity: Gravity, particles: Particles, fill: Fill
) -> Problems:
    """Check that a run-out bends up, behind bed and blocks and below the top of the channel."""
    if not isinstance(geometry, Channel):
        return
    start, slack = geometry.runout_start, TOLERANCE * particles.spacing
    if start is None:
        if _was_set(geometry, "runout_slope"):
            message = "has no effect without geometry.runout_start"
            yield Problem("geometry.runout_slope", message, geometry.runout_slope)
        return
    if geometry.periodic or geometry.weir_height > 0:
        other = "geometry.periodic" if geometry.periodic else "geometry.weir_height"
        yield Problem(other, "leave it out where the channel has a run-out")
    bend = degrees(gravity.fall) - geometry.runout_slope
    if not TOLERANCE < bend <= LARGEST_BEND + TOLERANCE:
        message = (
            f"the floor must bend up, by at most {LARGEST_BEND:g} degrees, and not by {bend:g}: "
            f"give less than {degrees(gravity.fall):g} and at least "
            f"{degrees(gravity.fall) - LARGEST_BEND:g}"
        )
        yield Problem("geometry.runout_slope", message, geometry.runout_slope)
    behind = bed_end(geometry, particles) if geometry.bed_thickness > 0 else 0.0
    apart = max(WEIR_SPACINGS, int(particles.effective_radius) + 1)
    behind, before = behind + apart * particles.spacing, geometry.length - apart * particles.spacing
    if not behind - slack <= start <= before + slack:
        message = (
            f"must leave {apart} spacings behind it, and in front of it to the bed or to x = 0: "
            f"at least {behind:g} and at most {before:g} m"
        )
        yield Problem("geometry.runout_start", message, start)
    rise = (geometry.length - start) * tan(radians(bend))
    if rise >= geometry.height:
        message = f"must be greater than the rise of the run-out along the x axis, {rise:.3g} m"
        yield Problem("geometry.height", message, geometry.height)
    for k, part in enumerate(fill):
        if isinstance(part, Block) and part.x[1] > start + slack:
            message = f"must end before the run-out, x = {start:g} m"
            yield Problem(f"fill.{k}.x.1", message, part.x[1])


def fills_inside(geometry: Geometry, particles: Particles, fill: Fill) -> Problems:
    """Check that fills lie in the open space, and a bed in a recess."""
    tolerance = TOLERANCE * particles.spacing
    spaces = [space.shrunk(-tolerance) for space in open_space(geometry, particles)]
    for k, part in enumerate(fill):
        area = covered(part, geometry, particles)
        if area is None:
            message = "needs a recess: a channel whose bed_thickness is greater than 0"
            yield Problem(f"fill.{k}.type", message, part.type)
        elif isinstance(part, Block) and not any(space.holds(area) for space in spaces):
            room = " or ".join(map(str, dict.fromkeys(open_space(geometry, particles))))
            yield Problem(
                f"fill.{k}", f"the block {area} is not inside the {geometry.type}, {room}"
            )


def fills_apart(geometry: Geometry, particles: Particles, fill: Fill) -> Problems:
    """Check that no two fills overlap."""
    areas = [covered(part, geometry, particles) for part in fill]
    for (j, one), (k, other) in combinations(enumerate(areas), 2):
        if one is None or other is None:
            continue
        shared = one.overlap(other)
        if shared.shrunk(TOLERANCE * particles.spacing).volume > 0:
            yield Problem(f"fill.{k}", f"overlaps fill.{j} in {shared}")


def shares_of_mixes(fill: Fill) -> Problems:
    """Check that only a mix has a share of sediment."""
    for k, part in enumerate(fill):
        if part.material != "mix" and _was_set(part, "sediment_share"):
            message = f"has no effect on the material '{part.material}', only on 'mix'"
            yield Problem(f"fill.{k}.sediment_share", message, part.sediment_share)


def walls_that_drag(walls: Walls, geometry: Geometry) -> Problems:
    """Check that a moving wall exists, moves along itself and lets no fluid slip."""
    present = _walls_present(geometry)
    for name, wall in walls:
        key, (along_x, along_y) = f"walls.{name}.velocity", wall.velocity
        if along_x == 0 and along_y == 0:
            continue
        if not present[name]:
            message = f"there is no {name} wall in this {geometry.type}"
        elif (
            name == "floor" and isinstance(geometry, Channel) and geometry.runout_start is not None
        ):
            message = "a floor that bends to a run-out cannot move"
        elif wall.slip == "free-slip":
            message = "a free-slip wall drags no fluid along; set slip = 'no-slip'"
        elif along_y != 0 and name in ("floor", "ceiling"):
            message = "must be along the wall: the second number must be 0"
        elif along_x != 0 and name in ("left", "right"):
            message = "must be along the wall: the first number must be 0"
        else:
            continue
        yield Problem(key, message, wall.velocity)


def _walls_present(geometry: Geometry) -> dict[str, bool]:
    """Tell which of the named walls a geometry has."""
    closed = not geometry.periodic
    if isinstance(geometry, Tank3D):
        sides = {"left": True, "right": True, "front": closed, "back": closed}
        return {"floor": True, "bed": False, "ceiling": False} | sides
    tank = isinstance(geometry, Tank)
    return {
        "floor": True,
        "bed": isinstance(geometry, Channel) and geometry.bed_thickness > 0,
        "left": closed,
        "right": closed and (tank or (isinstance(geometry, Channel) and geometry.weir_height > 0)),
        "ceiling": isinstance(geometry, Tank) and geometry.ceiling,
        "front": False,
        "back": False,
    }


def inflow_in_channel(inflow: Inflow | None, geometry: Geometry) -> Problems:
    """Check that a supply enters the open end of a channel, below its height."""
    if inflow is None:
        return
    if not isinstance(geometry, Channel):
        yield Problem("inflow", "a tank has no inflow; use geometry.type = 'channel'")
        return
    if geometry.periodic:
        yield Problem("inflow", "a periodic channel has no inflow; set geometry.periodic = false")
    if inflow.depth > geometry.height:
        message = f"deeper than the channel, whose height is {geometry.height:g} m"
        yield Problem("inflow.depth", message, inflow.depth)


def one_way_of_supply(inflow: Inflow | None) -> Problems:
    """Check that a supply has a discharge, a velocity or a hydrograph, or two that agree."""
    if inflow is None:
        return
    if inflow.hydrograph is not None:
        for name in ("discharge", "velocity", "concentration"):
            if name in inflow.model_fields_set and getattr(inflow, name) is not None:
                message = "inflow.hydrograph is given as well; leave one of them out"
                yield Problem(f"inflow.{name}", message, getattr(inflow, name))
    elif inflow.discharge is None and inflow.velocity is None:
        yield Problem("inflow", "missing: give a discharge, a velocity or a hydrograph")
    elif inflow.discharge is not None and inflow.velocity is not None:
        product = inflow.velocity * inflow.depth
        if not isclose(inflow.discharge, product, rel_tol=1e-6):
            message = f"does not agree with velocity times depth, {product:g} m2/s; leave one out"
            yield Problem("inflow.discharge", message, inflow.discharge)


def hydrograph_in_order(inflow: Inflow | None) -> Problems:
    """Check that a hydrograph has a value for every time and that its times increase."""
    graph = inflow.hydrograph if inflow else None
    if graph is None or isinstance(graph, str):
        return
    key = "inflow.hydrograph"
    for name in ("discharge", "concentration"):
        count = len(getattr(graph, name))
        if count != len(graph.time):
            yield Problem(
                f"{key}.{name}", f"must have a value for each time, {len(graph.time)}, not {count}"
            )
    if not graph.time:
        yield Problem(f"{key}.time", "is empty")
    elif graph.time[0] > 0:
        yield Problem(f"{key}.time.0", "the first time must be 0 or before", graph.time[0])
    for k, (before, after) in enumerate(pairwise(graph.time), start=1):
        if after <= before:
            yield Problem(
                f"{key}.time.{k}", f"must be later than the one before, {before:g} s", after
            )
    for name in ("discharge", "concentration"):
        for k, value in enumerate(getattr(graph, name)):
            if value < 0:
                yield Problem(f"{key}.{name}.{k}", "must be at least 0", value)


def concentrations_below_packing(
    sediment: Sediment,
    mixture: Mixture,
    collision_stress: CollisionStress,
    fill: Fill,
    inflow: Inflow | None,
) -> Problems:
    """Check that no concentration that is used, or was set, reaches that of a packing."""
    stated: dict[str, float] = {}
    if any(part.material == "mixture" for part in fill) or _was_set(mixture, "concentration"):
        stated["mixture.concentration"] = mixture.concentration
    if collision_stress.enabled or _was_set(collision_stress, "largest_concentration"):
        stated["collision_stress.largest_concentration"] = collision_stress.largest_concentration
    if inflow is not None:
        stated["inflow.concentration"] = inflow.concentration
        if inflow.hydrograph and not isinstance(inflow.hydrograph, str):
            stated |= {
                f"inflow.hydrograph.concentration.{k}": value
                for k, value in enumerate(inflow.hydrograph.concentration)
            }
    for key, value in stated.items():
        if value >= sediment.packing_limit:
            message = f"must be less than sediment.packing_limit = {sediment.packing_limit:g}"
            yield Problem(key, message, value)


def collisions_within_clip(collision_stress: CollisionStress) -> Problems:
    """Check that a given concentration of the colliding grains is not clipped."""
    given, clip = collision_stress.concentration, collision_stress.largest_concentration
    if given is not None and given > clip:
        message = f"would be clipped at collision_stress.largest_concentration = {clip:g}"
        yield Problem("collision_stress.concentration", message, given)


def slip_of_pure_phases(drag: Drag, fill: Fill, inflow: Inflow | None) -> Problems:
    """Check that slip, which is between sediment and water, meets no mixture particles."""
    materials = phases(fill, inflow)
    if drag.law != "none" and "mixture" in materials and len(materials) > 1:
        message = (
            "acts between sediment and water particles, and not on those of a mixture beside them; "
            "fill with 'mix' instead of 'mixture'"
        )
        yield Problem("drag.law", message, drag.law)


def _was_set(table: Table, name: str) -> bool:
    """Tell whether a field differs from its default, however the file came to state it."""
    return bool(getattr(table, name) != type(table).model_fields[name].default)


def step_within_limits(
    time: Time,
    particles: Particles,
    fill: Fill,
    inflow: Inflow | None,
    water: Water,
    sediment: Sediment,
    mixture: Mixture,
    strength: Strength,
    gravity: Gravity,
    scheme: AnyScheme,
) -> Problems:
    """Check that the largest step keeps within the limits of explicit viscosity and gravity."""
    if time.largest_step is None or isinstance(scheme, ExplicitScheme):
        return
    limits = viscous_limits(particles, fill, inflow, water, sediment, mixture, strength)
    phase = min(limits, key=lambda name: limits[name], default=None)
    fall = hypot(*gravity.components)
    if phase and time.largest_step > limits[phase] * (1 + TOLERANCE):
        message = (
            f"above the limit of explicit viscosity in {phase}, "
            f"0.2 spacing^2 density / viscosity = {limits[phase]:.3g} s"
        )
        yield Problem("time.largest_step", message, time.largest_step)
    elif fall > 0 and time.largest_step > 0.1 * sqrt(particles.spacing / fall):
        message = (
            "gravity would move a particle by more than a hundredth of the spacing in a step; "
            f"at most 0.1 sqrt(spacing / gravity) = {0.1 * sqrt(particles.spacing / fall):.3g} s"
        )
        yield Problem("time.largest_step", message, time.largest_step)


def density_relaxation_slow(particles: Particles, scheme: AnyScheme, time: Time) -> Problems:
    """Check that a density error does not decay within few steps, which throws the fluid."""
    if not isinstance(scheme, Scheme):
        return
    step, relaxation = time.largest_step, scheme.density_relaxation
    if step is None or not relaxation:
        return
    if relaxation < FEWEST_RELAXATION_STEPS * step * (1 - TOLERANCE):
        message = (
            f"must be 0 or at least {FEWEST_RELAXATION_STEPS} times time.largest_step = {step:g} s"
        )
        yield Problem("scheme.density_relaxation", message, relaxation)


def memory_suffices(
    particles: Particles, geometry: Geometry, fill: Fill, inflow: Inflow | None
) -> Problems:
    """Check that the particles fit into the memory that is free."""
    expected = estimate(particles, geometry, fill, inflow)
    available = available_memory()
    if available is not None and expected["memory"] > available:
        message = (
            f"makes about {expected['total']:,.0f} particles, which need "
            f"{size(expected['memory'])} of memory; {size(available)} are available"
        )
        yield Problem("particles.spacing", message, particles.spacing)


CHECKS: tuple[Callable[..., Problems], ...] = (
    anything_to_compute,
    one_way_of_gravity,
    intervals_in_order,
    lengths_on_lattice,
    space_resolved,
    periodic_space,
    weir_in_channel,
    runout_behind_bed,
    fills_inside,
    fills_apart,
    shares_of_mixes,
    walls_that_drag,
    inflow_in_channel,
    one_way_of_supply,
    hydrograph_in_order,
    concentrations_below_packing,
    collisions_within_clip,
    slip_of_pure_phases,
    step_within_limits,
    density_relaxation_slow,
    *probe_checks.CHECKS,
    memory_suffices,
)
