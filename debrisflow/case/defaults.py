"""Defaults that follow from other fields, written out so that a run can be repeated exactly.

Completing a completed case changes nothing.
"""

from __future__ import annotations

from math import hypot, inf, sqrt
from typing import Any

from debrisflow.case.built import as_built
from debrisflow.case.materials import Mixture, Sediment, Water, bulk_density
from debrisflow.case.regions import bed_end, extent_across, section_of_supply
from debrisflow.case.releases import AnyRelease, HydrographRelease, Zone
from debrisflow.case.resolved import (
    AnyResolvedScheme,
    ResolvedCase,
    ResolvedChannel,
    ResolvedChannel3D,
    ResolvedExplicitScheme,
    ResolvedGeometry,
    ResolvedInflow,
    ResolvedOutput,
    ResolvedScheme,
    ResolvedTerrain,
    ResolvedTime,
    SteadyInflow,
    UnsteadyInflow,
    resolved,
)
from debrisflow.case.rheology import NoStrength, Rheology
from debrisflow.case.shapes import Channel, Channel3D, Geometry, is_three_dimensional
from debrisflow.case.speeds import collapse_speed, fall_speed, given_speed
from debrisflow.case.tables import (
    AnyFill,
    Case,
    ExplicitScheme,
    Gravity,
    Inflow,
    Output,
    Particles,
    Scheme,
    Walls,
)
from debrisflow.case.terrain import Terrain
from debrisflow.case.terrain_built import built_releases, built_terrain, over_origin
from debrisflow.case.terrain_speeds import expected_speed
from debrisflow.errors import CaseError

RELAXATION_STEPS = 50
GRAINS_COLLIDE = 0.8  # spacings; without it the surface of a heap of grains is rough
SPREAD = 2.0  # spacings of the square of a map over which a particle is spread
LEAST_LAYER_DEPTH = 0.05  # m
MORE_THAN_ONE = 1.1  # depths of a lone particle; one alone marks no cell as reached
LARGEST_DIFFUSION = 0.3
LARGEST_PATH = 0.2  # spacings that a particle moves in a step of the explicit scheme
VISCOUS_LIMIT = 0.2  # of an explicit step, in d0^2 / nu
LEAST_SOUND_RATIO = 10.0
TERRAIN_SOUND_RATIO = 6.0  # to an upper estimate of the speed, which most of the flow is far below
FEWEST_RELAXATION_STEPS = 10
NO_SUPPLY = "missing: give a discharge, a velocity or a hydrograph"

_FORMS: dict[str, dict[str, str]] = {
    "stable": {
        "gradient": "sum",
        "interface": "symmetric",
        "free_surface": "asymmetry",
    },
    "study": {
        "gradient": "cmps",
        "interface": "study",
        "free_surface": "density",
    },
}


def complete(case: Case) -> ResolvedCase:
    """Return the case as it is built, with every default that follows from other fields filled in.

    Raises
    ------
    CaseError
        If a supply has neither discharge nor velocity, or a hydrograph that is not read.
    """
    scheme: AnyResolvedScheme
    asked = case.asked if isinstance(case, ResolvedCase) else None
    former_names = case.former_names if isinstance(case, ResolvedCase) else ()
    if built := as_built(dict(case)):
        if not isinstance(case.geometry, Terrain):  # whose lengths are as they are asked
            asked = case
        case = Case(**(dict(case) | built))
    if isinstance(case.scheme, ExplicitScheme):
        fastest = case.scheme.sound_speed or sound_speed(
            case.fill,
            case.inflow,
            case.geometry,
            case.particles,
            case.gravity,
            case.walls,
            case.release,
            case.zone,
        )
        step = min(acoustic_step(case.scheme, fastest, case.particles), *_viscous_steps(case))
        collides = 0.0 if isinstance(case.rheology, NoStrength) else GRAINS_COLLIDE
        scheme = resolved(
            ResolvedExplicitScheme,
            case.scheme,
            sound_speed=fastest,
            collision_distance=collides,
            density_relaxation=_fall_time(case) or RELAXATION_STEPS * step,
        )
    else:
        step = min(_outer_limit(case, case.scheme.courant), *_viscous_steps(case))
        scheme = _scheme(case.scheme, step, case.time.largest_step or step)
    found: dict[str, Any] = {
        "geometry": _geometry(case.geometry, case.particles),
        "inflow": _inflow(case.inflow, case.geometry),
        "scheme": scheme,
        "time": resolved(ResolvedTime, case.time, largest_step=step),
        "output": _output(case.output, case.geometry, case.particles),
        "probe": tuple(probe.complete(case.particles.spacing) for probe in case.probe),
    }
    if isinstance(case.geometry, ResolvedTerrain):
        found["release"] = built_releases(case.release, case.geometry, case.mixture)
        found |= over_origin(dict(case) | found)
    return ResolvedCase(**(dict(case) | found)).keep(asked, former_names)


def viscous_limits(
    particles: Particles,
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
    geometry: Geometry,
    water: Water,
    sediment: Sediment,
    mixture: Mixture,
    rheology: Rheology,
    release: tuple[AnyRelease, ...] = (),
) -> dict[str, float]:
    """Return the time step, s, that the explicit viscosity of each phase present allows.

    The limit is ``0.2 d0^2 rho / mu``; with a rheological law viscosity is implicit and there is
    none.  Of mixtures of several concentrations the lightest counts.
    """
    if not isinstance(rheology, NoStrength):
        return {}
    solid = mixture.concentration
    if is_three_dimensional(geometry):
        solid = min(solid, *_carried(inflow), *_released(release), 1.0)
    mixed_density = bulk_density(solid, water, sediment, rheology)
    properties = {
        "water": (water.density, water.viscosity),
        "sediment": (sediment.density, sediment.viscosity),
        "mixture": (mixed_density, mixture.viscosity),
    }
    return {
        phase: VISCOUS_LIMIT * particles.spacing * particles.spacing * density / viscosity
        for phase, (density, viscosity) in properties.items()
        if viscosity > 0 and phase in phases(fill, inflow, geometry, release)
    }


def phases(
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
    geometry: Geometry,
    release: tuple[AnyRelease, ...] = (),
) -> set[str]:
    """Return which of water, sediment and mixture fills, releases and the supply bring."""
    materials: set[str] = {part.material for part in fill}
    materials |= {part.material for part in release if not isinstance(part, HydrographRelease)}
    materials |= {"mixture" if share > 0 else "water" for share in _entering(release)}
    present = materials - {"two-phase"}
    if "two-phase" in materials:
        present |= {"water", "sediment"}
    if inflow is not None:
        carried, laden = _carried(inflow), inflow.concentration > 0 or inflow.hydrograph is not None
        if not is_three_dimensional(geometry):
            present |= {"water", "sediment"} if laden else {"water"}
        else:
            present |= {"mixture" if share > 0 else "water" for share in carried}
    return present


def _carried(inflow: Inflow | None) -> tuple[float, ...]:
    """Return the concentrations that a supply states; none of a hydrograph that is not read."""
    if inflow is None or isinstance(inflow.hydrograph, str):
        return ()
    graph = inflow.hydrograph
    return (inflow.concentration,) if graph is None else graph.concentration


def _entering(release: tuple[AnyRelease, ...]) -> tuple[float, ...]:
    """Return the concentrations that the hydrographs of releases state."""
    graphs = [part.hydrograph for part in release if isinstance(part, HydrographRelease)]
    return tuple(
        share for graph in graphs if not isinstance(graph, str) for share in graph.concentration
    )


def _released(release: tuple[AnyRelease, ...]) -> tuple[float, ...]:
    """Return the concentrations that releases state of mixtures."""
    stated = [part.concentration for part in release if not isinstance(part, HydrographRelease)]
    return (*_entering(release), *(share for share in stated if share is not None))


def _geometry(geometry: Geometry, particles: Particles) -> ResolvedGeometry:
    if isinstance(geometry, Channel):
        return resolved(ResolvedChannel, geometry, bed_end=bed_end(geometry, particles))
    if isinstance(geometry, Channel3D):
        return resolved(ResolvedChannel3D, geometry, bed_end=bed_end(geometry, particles))
    return built_terrain(geometry, particles) if isinstance(geometry, Terrain) else geometry


def _scheme(scheme: Scheme, step: float, largest: float) -> ResolvedScheme:
    """Return the scheme with the choices of its form; density errors decay in fifty steps.

    Of the step that gravity and viscosity allow, so that a shorter ``largest`` step leaves the
    time of the decay as it is.
    """
    slow = max(RELAXATION_STEPS * step, FEWEST_RELAXATION_STEPS * largest)
    relaxation = slow if scheme.form == "stable" else 0.0
    return resolved(ResolvedScheme, scheme, **_FORMS[scheme.form], density_relaxation=relaxation)


def _inflow(inflow: Inflow | None, geometry: Geometry) -> ResolvedInflow | None:
    if inflow is None:
        return None
    across = extent_across(inflow, geometry) if isinstance(geometry, Channel3D) else None
    if isinstance(inflow.hydrograph, str):
        raise CaseError("inflow.hydrograph: a file is read by load_case; give a table instead")
    if inflow.hydrograph is not None:
        return resolved(UnsteadyInflow, inflow, across=across)
    area = section_of_supply(inflow, geometry)
    if inflow.discharge is not None:
        flow = {"discharge": inflow.discharge, "velocity": inflow.discharge / area}
    elif inflow.velocity is not None:
        flow = {"discharge": inflow.velocity * area, "velocity": inflow.velocity}
    else:
        raise CaseError(f"inflow: {NO_SUPPLY}")
    return resolved(SteadyInflow, inflow, across=across, hydrograph=None, **flow)


def _output(output: Output, geometry: Geometry, particles: Particles) -> ResolvedOutput:
    lone = 0.0
    if isinstance(geometry, ResolvedTerrain):
        side = max(SPREAD * particles.spacing, geometry.levels.grid.cell)
        lone = particles.spacing**3 / side**2
    return resolved(
        ResolvedOutput,
        output,
        deposit_interval=output.interval,
        history_interval=output.interval / 10,
        layer_depth=max(LEAST_LAYER_DEPTH, float(f"{MORE_THAN_ONE * lone:.2g}")),
    )


def sound_speed(
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
    geometry: Geometry,
    particles: Particles,
    gravity: Gravity,
    walls: Walls,
    release: tuple[AnyRelease, ...] = (),
    zone: tuple[Zone, ...] = (),
) -> float:
    """Return ten times the largest speed that a case gives or a free fall reaches, m/s.

    On a terrain six times that which friction lets the flow reach at most, see
    :func:`debrisflow.case.terrain_speeds.expected_speed`.
    """
    if isinstance(geometry, Terrain):
        given = given_speed(fill, inflow, geometry, walls, release)
        speed = expected_speed(geometry, release, zone, walls.floor, gravity)
        return TERRAIN_SOUND_RATIO * max(given, speed)
    fall = fall_speed(fill, inflow, geometry, particles, gravity, to_floor=True)
    return LEAST_SOUND_RATIO * (fall + given_speed(fill, inflow, geometry, walls))


def acoustic_step(scheme: ExplicitScheme, sound_speed: float, particles: Particles) -> float:
    """Return the time step that a speed of sound, m/s, allows, ``courant d0 / c``, s."""
    return scheme.courant * particles.spacing / sound_speed


def _fall_time(case: Case) -> float:
    """Return the time of a free fall through the height of what flows, s; 0 without gravity."""
    fall = fall_speed(case.fill, case.inflow, case.geometry, case.particles, case.gravity)
    fall = max(fall, collapse_speed(case.release, case.gravity))
    magnitude = hypot(*case.gravity.components)
    return fall / magnitude if magnitude > 0 else 0.0


def _viscous_steps(case: Case) -> tuple[float, ...]:
    """Return the steps that explicit viscosity allows, s."""
    limits = viscous_limits(
        case.particles,
        case.fill,
        case.inflow,
        case.geometry,
        case.water,
        case.sediment,
        case.mixture,
        case.rheology,
        case.release,
    )
    return (inf, *limits.values())


def _outer_limit(case: Case, courant: float) -> float:
    """Return the step that gravity allows, s; without gravity the speed that the case gives.

    It is the clock by which density errors decay, and so must know how fast the fluid is: a jet
    that strikes a plate is through in the time of some steps.  A tenth of an output interval is
    the bound of what moves by viscosity alone.
    """
    magnitude = hypot(*case.gravity.components)
    if magnitude > 0:
        return 0.03 * sqrt(case.particles.spacing / magnitude)
    speed = given_speed(case.fill, case.inflow, case.geometry, case.walls, case.release)
    path = courant * case.particles.spacing / speed if speed > 0 else inf
    return min(case.output.interval / 10, path)
