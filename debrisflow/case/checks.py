"""Cross-checks at the door: what only two or more fields of a case can tell.

Each check asks for the tables that it compares, by the names they have in the case, and yields
problems; so that those that can be run are run even where another table could not be built.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from inspect import signature
from math import hypot, isclose, sqrt
from typing import Any

from debrisflow.case import (
    motion_checks,
    obstacle_checks,
    pore_pressure_checks,
    probe_checks,
    release_checks,
    rheology_checks,
    space_checks,
    structure_checks,
    terrain_checks,
    weakly_compressible_checks,
)
from debrisflow.case.bodies import MeshFill
from debrisflow.case.built import as_built
from debrisflow.case.defaults import (
    FEWEST_RELAXATION_STEPS,
    NO_SUPPLY,
    phases,
    viscous_limits,
)
from debrisflow.case.estimate import estimate
from debrisflow.case.hydrograph import faults_of
from debrisflow.case.materials import Mixture, Sediment, Water
from debrisflow.case.memory import available_memory, size
from debrisflow.case.problems import Problem, Problems, was_set
from debrisflow.case.regions import TOLERANCE, section_of_supply
from debrisflow.case.releases import AnyRelease, Hydrograph, HydrographRelease
from debrisflow.case.rheology import Rheology
from debrisflow.case.shapes import Channel, Channel3D, ChannelShape, Geometry, is_three_dimensional
from debrisflow.case.tables import (
    AnyFill,
    AnyObstacle,
    AnyScheme,
    CollisionStress,
    Drag,
    Gravity,
    Inflow,
    Particles,
    Scheme,
    Time,
)
from debrisflow.case.terrain import Terrain
from debrisflow.case.words import ABSENT

Fill = tuple[AnyFill, ...]
Releases = tuple[AnyRelease, ...]


def cross_check(tables: Mapping[str, Any]) -> list[Problem]:
    """Return the problems among the given tables of a case, by name.

    Lengths are judged as they are built, and named as they are asked.
    """
    found = list(_problems(AS_ASKED, tables))
    tables = _without_wrong_maps(tables, found)
    told, built = {problem.key for problem in found}, as_built(tables)
    for problem in _problems(CHECKS, {**tables, **built}):
        if problem.key in told:
            continue
        if problem.value is not ABSENT and problem.key.split(".")[0] in built:
            problem = problem._replace(value=_value_at(problem.key, tables) or problem.value)
        found.append(problem)
    return found


def _without_wrong_maps(tables: Mapping[str, Any], found: list[Problem]) -> dict[str, Any]:
    """Return tables without those of a terrain that nothing can be built of."""
    wrong = {problem.key.partition(".")[0] for problem in found}
    is_terrain = isinstance(tables.get("geometry"), Terrain)
    unusable = wrong & ({"geometry", "release", "zone"} if is_terrain else {"release", "zone"})
    return {name: table for name, table in tables.items() if name not in unusable}


def _problems(checks: Sequence[Callable[..., Problems]], tables: Mapping[str, Any]) -> Problems:
    for check in checks:
        wanted = signature(check).parameters
        if all(name in tables for name in wanted):
            yield from check(**{name: tables[name] for name in wanted})


def _value_at(key: str, tables: Mapping[str, Any]) -> Any:
    """Return the value of a dotted key, None if it is left out."""
    first, *steps = key.split(".")
    value = tables[first]
    for step in steps:
        value = value[int(step)] if step.isdecimal() else getattr(value, step, None)
    return value


def anything_to_compute(
    fill: Fill, inflow: Inflow | None, release: Releases, geometry: Geometry
) -> Problems:
    """Check that there is something to compute."""
    if isinstance(geometry, Terrain):
        if not release:
            yield Problem("release", "nothing flows: give at least one [[release]]")
    elif not fill and inflow is None:
        yield Problem("fill", "no particles: give at least one [[fill]] or an [inflow]")


def one_way_of_gravity(gravity: Gravity) -> Problems:
    """Check that gravity is a vector or a slope, not both."""
    if gravity.vector is None:
        return
    for name in ("acceleration", "slope"):
        if name in gravity.model_fields_set:
            message = "gravity.vector is given as well; leave one of them out"
            yield Problem(f"gravity.{name}", message, getattr(gravity, name))


def shares_of_sediment(fill: Fill) -> Problems:
    """Check that only a two-phase fill has a share of sediment."""
    for k, part in enumerate(fill):
        if isinstance(part, MeshFill) or part.material == "two-phase":
            continue
        if was_set(part, "sediment_share"):
            message = f"has no effect on the material '{part.material}', only on 'two-phase'"
            yield Problem(f"fill.{k}.sediment_share", message, part.sediment_share)


def inflow_in_channel(inflow: Inflow | None, geometry: Geometry) -> Problems:
    """Check that a supply enters the open end of a channel, below its height."""
    if inflow is None:
        return
    if isinstance(geometry, Terrain):
        message = "a terrain has none; use a [[release]] with type = 'hydrograph'"
        yield Problem("inflow", message)
        return
    if not isinstance(geometry, ChannelShape):
        shape = "channel3d" if is_three_dimensional(geometry) else "channel"
        yield Problem("inflow", f"a tank has no inflow; use geometry.type = '{shape}'")
        return
    if geometry.periodic:
        yield Problem("inflow", "a periodic channel has no inflow; set geometry.periodic = false")
    if inflow.depth > geometry.height:
        message = f"deeper than the channel, whose height is {geometry.height:g} m"
        yield Problem("inflow.depth", message, inflow.depth)


def supply_across_channel(
    inflow: Inflow | None, geometry: Geometry, particles: Particles
) -> Problems:
    """Check that the extent of a supply across is one in three dimensions, inside the channel."""
    if inflow is None or inflow.across is None:
        return
    if not isinstance(geometry, Channel3D):
        if isinstance(geometry, Channel):
            message = "only in three dimensions; leave it out"
            yield Problem("inflow.across", message, inflow.across)
        return
    (start, end), slack = inflow.across, TOLERANCE * particles.spacing
    if start >= end:
        message = "the first number must be less than the second"
        yield Problem("inflow.across", message, inflow.across)
    elif start < -slack or end > geometry.width + slack:
        message = f"outside the channel, y = [0, {geometry.width:g}] m"
        yield Problem("inflow.across", message, inflow.across)


def one_way_of_supply(inflow: Inflow | None, geometry: Geometry) -> Problems:
    """Check that a supply has a discharge, a velocity or a hydrograph, or two that agree."""
    if inflow is None:
        return
    if inflow.hydrograph is not None:
        for name in ("discharge", "velocity", "concentration"):
            if name in inflow.model_fields_set and getattr(inflow, name) is not None:
                message = "inflow.hydrograph is given as well; leave one of them out"
                yield Problem(f"inflow.{name}", message, getattr(inflow, name))
    elif inflow.discharge is None and inflow.velocity is None:
        yield Problem("inflow", NO_SUPPLY)
    elif inflow.discharge is not None and inflow.velocity is not None:
        product = inflow.velocity * section_of_supply(inflow, geometry)
        if not isclose(inflow.discharge, product, rel_tol=1e-6):
            what, unit = "depth", "m2/s"
            if isinstance(geometry, Channel3D):
                what, unit = "depth times width", "m3/s"
            message = (
                f"does not agree with velocity times {what}, {product:g} {unit}; leave one out"
            )
            yield Problem("inflow.discharge", message, inflow.discharge)


def hydrograph_in_order(inflow: Inflow | None) -> Problems:
    """Check that a hydrograph has a value for every time and that its times increase."""
    graph = inflow.hydrograph if inflow else None
    if graph is None or isinstance(graph, str):
        return
    yield from faults_of(graph, "inflow.hydrograph")


def concentrations_below_packing(
    sediment: Sediment,
    mixture: Mixture,
    collision_stress: CollisionStress,
    fill: Fill,
    inflow: Inflow | None,
    release: Releases,
) -> Problems:
    """Check that no concentration that is used, or was set, reaches that of a packing."""
    masses = [part for part in release if not isinstance(part, HydrographRelease)]
    stated: dict[str, float] = {}
    if "mixture" in {part.material for part in (*fill, *masses)} or was_set(
        mixture, "concentration"
    ):
        stated["mixture.concentration"] = mixture.concentration
    if collision_stress.enabled or was_set(collision_stress, "largest_concentration"):
        stated["collision_stress.largest_concentration"] = collision_stress.largest_concentration
    if inflow is not None:
        stated["inflow.concentration"] = inflow.concentration
        if inflow.hydrograph and not isinstance(inflow.hydrograph, str):
            stated |= {
                f"inflow.hydrograph.concentration.{k}": value
                for k, value in enumerate(inflow.hydrograph.concentration)
            }
    for number, part in enumerate(release):
        if not isinstance(part, HydrographRelease):
            if part.concentration is not None:
                stated[f"release.{number}.concentration"] = part.concentration
        elif not isinstance(part.hydrograph, str):
            stated |= {
                f"release.{number}.hydrograph.concentration.{k}": value
                for k, value in enumerate(part.hydrograph.concentration)
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


def slip_of_pure_phases(
    drag: Drag, fill: Fill, inflow: Inflow | None, geometry: Geometry, release: Releases
) -> Problems:
    """Check that slip, which is between sediment and water, meets no mixture particles."""
    materials = phases(fill, inflow, geometry, release)
    if drag.law != "none" and "mixture" in materials and len(materials) > 1:
        message = (
            "acts between sediment and water particles, and not on those of a mixture beside them; "
            "fill with 'two-phase' instead of 'mixture'"
        )
        yield Problem("drag.law", message, drag.law)


def step_within_limits(
    time: Time,
    particles: Particles,
    fill: Fill,
    inflow: Inflow | None,
    geometry: Geometry,
    water: Water,
    sediment: Sediment,
    mixture: Mixture,
    rheology: Rheology,
    gravity: Gravity,
    scheme: AnyScheme,
    release: Releases,
) -> Problems:
    """Check that the largest step keeps within the limits of explicit viscosity and gravity."""
    if time.largest_step is None:
        return
    limits = viscous_limits(
        particles, fill, inflow, geometry, water, sediment, mixture, rheology, release
    )
    phase = min(limits, key=lambda name: limits[name], default=None)
    fall = hypot(*gravity.components)
    if phase and time.largest_step > limits[phase] * (1 + TOLERANCE):
        message = (
            f"above the limit of explicit viscosity in {phase}, "
            f"0.2 spacing^2 density / viscosity = {limits[phase]:.3g} s"
        )
        yield Problem("time.largest_step", message, time.largest_step)
    elif (
        isinstance(scheme, Scheme)
        and fall > 0
        and time.largest_step > 0.1 * sqrt(particles.spacing / fall)
    ):
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


def operators_of_form(scheme: AnyScheme) -> Problems:
    """Check that operators of the study are asked for in its form."""
    if not isinstance(scheme, Scheme) or scheme.form == "study":
        return
    usual = Scheme()
    without: dict[str, object] = {"gradient": "sum", "free_surface": "asymmetry"}
    without["collision_distance"] = usual.collision_distance
    for field, value in without.items():
        given = getattr(scheme, field)
        if given not in (None, value):
            message = "has an effect in scheme.form = 'study' only; leave it out"
            yield Problem(f"scheme.{field}", message, given)


def memory_suffices(
    particles: Particles,
    geometry: Geometry,
    obstacle: tuple[AnyObstacle, ...],
    fill: Fill,
    inflow: Inflow | None,
    scheme: AnyScheme,
    release: Releases,
) -> Problems:
    """Check that the particles fit into the memory that is free."""
    expected = estimate(particles, geometry, obstacle, fill, inflow, scheme, release)
    available = available_memory()
    if available is not None and expected["memory"] > available:
        message = (
            f"makes about {expected['total']:,.0f} particles and needs "
            f"{size(expected['memory'])} of memory; {size(available)} are available"
        )
        yield Problem("particles.spacing", message, particles.spacing)


def rest_after_supply(time: Time, inflow: Inflow | None) -> Problems:
    """Check that a run that is to stop at rest has a supply that ends."""
    if time.stop_energy is None or inflow is None:
        return
    graph = inflow.hydrograph
    if not isinstance(graph, Hydrograph) or graph.discharge[-1] > 0.0:
        message = (
            "has no effect, since the supply never ends: let its hydrograph end with the "
            "discharge 0, or leave it out"
        )
        yield Problem("time.stop_energy", message, time.stop_energy)


AS_ASKED: tuple[Callable[..., Problems], ...] = (
    *space_checks.AS_ASKED,
    *terrain_checks.AS_ASKED,
    *release_checks.AS_ASKED,
    supply_across_channel,
    one_way_of_supply,
)
CHECKS: tuple[Callable[..., Problems], ...] = (
    anything_to_compute,
    one_way_of_gravity,
    *space_checks.CHECKS,
    *obstacle_checks.CHECKS,
    *motion_checks.CHECKS,
    shares_of_sediment,
    inflow_in_channel,
    hydrograph_in_order,
    concentrations_below_packing,
    collisions_within_clip,
    slip_of_pure_phases,
    *rheology_checks.CHECKS,
    *pore_pressure_checks.CHECKS,
    *weakly_compressible_checks.CHECKS,
    operators_of_form,
    step_within_limits,
    density_relaxation_slow,
    rest_after_supply,
    *probe_checks.CHECKS,
    *terrain_checks.CHECKS,
    *release_checks.CHECKS,
    *structure_checks.CHECKS,
    memory_suffices,
)
