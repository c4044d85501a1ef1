"""Checks of the explicit scheme: what it is validated for, and what it leaves out."""

from __future__ import annotations

from collections.abc import Callable

from debrisflow.case.defaults import (
    FEWEST_RELAXATION_STEPS,
    LARGEST_DIFFUSION,
    acoustic_step,
    phases,
    sound_speed,
)
from debrisflow.case.problems import Problem, Problems, was_set
from debrisflow.case.regions import TOLERANCE, covered
from debrisflow.case.releases import AnyRelease, Zone
from debrisflow.case.rheology import NoStrength, Rheology
from debrisflow.case.shapes import Geometry, is_three_dimensional
from debrisflow.case.tables import (
    AnyFill,
    AnyScheme,
    CollisionStress,
    Drag,
    ExplicitScheme,
    Gravity,
    Inflow,
    Particles,
    Scheme,
    Time,
    Walls,
)

Fill = tuple[AnyFill, ...]
INSTEAD = {  # of fields of a wall
    "velocity": "leave it out",
    "roughness": "use friction = { law = 'log', roughness = ... }",
}
HAS_NONE = "the explicit scheme has none; leave it out"


def scheme_of_dimension(geometry: Geometry, scheme: AnyScheme) -> Problems:
    """Check that a scheme is validated in the dimension of the space."""
    if is_three_dimensional(geometry) == isinstance(scheme, ExplicitScheme):
        return
    right, dimensions = (
        ("explicit", "two") if isinstance(scheme, Scheme) else ("semi-implicit", "three")
    )
    message = (
        f"the {scheme.type} scheme is validated in {dimensions} dimensions only; "
        f"in a {geometry.type} use '{right}'"
    )
    yield Problem("scheme.type", message, scheme.type)


def mixture_of_one_kind(scheme: AnyScheme, fill: Fill) -> Problems:
    """Check that in the explicit scheme particles of a mixture stand for sediment."""
    if not isinstance(scheme, ExplicitScheme):
        return
    for k, part in enumerate(fill):
        if part.material not in ("water", "mixture"):
            message = (
                "must be 'water' or 'mixture': in the explicit scheme one kind of particle stands "
                "for the mixture"
            )
            yield Problem(f"fill.{k}.material", message, part.material)


def laws_of_mixture(
    scheme: AnyScheme,
    drag: Drag,
    rheology: Rheology,
    collision_stress: CollisionStress,
    fill: Fill,
    inflow: Inflow | None,
    geometry: Geometry,
    release: tuple[AnyRelease, ...],
) -> Problems:
    """Check that the explicit scheme is asked for no slip, and has grains for its laws."""
    if not isinstance(scheme, ExplicitScheme):
        return
    if drag.law != "none":
        yield Problem("drag.law", HAS_NONE, drag.law)
    has_grains = "mixture" in phases(fill, inflow, geometry, release)
    if not isinstance(rheology, NoStrength) and not has_grains:
        message = "has no effect on water; fill with 'mixture'"
        yield Problem("rheology.type", message, rheology.type)
    if not collision_stress.enabled:
        return
    if not has_grains:
        message = "there are no grains to collide; fill with 'mixture'"
        yield Problem("collision_stress.enabled", message, collision_stress.enabled)
    if collision_stress.granular_temperature == "fluctuation":
        message = "not in the explicit scheme; use 'algebraic' or 'neighborhood'"
        key = "collision_stress.granular_temperature"
        yield Problem(key, message, collision_stress.granular_temperature)
    if collision_stress.concentration is not None:
        message = "in the explicit scheme it is mixture.concentration; leave it out"
        yield Problem("collision_stress.concentration", message, collision_stress.concentration)


def walls_at_rest(scheme: AnyScheme, walls: Walls) -> Problems:
    """Check that no wall is asked to move or to be rough where that has no effect."""
    if not isinstance(scheme, ExplicitScheme):
        return
    for name, wall in walls:
        for field, instead in INSTEAD.items():
            is_told = field == "roughness" and wall.friction is not None  # by another check
            if was_set(wall, field) and not is_told:
                message = f"has no effect in the explicit scheme; {instead}"
                yield Problem(f"walls.{name}.{field}", message, getattr(wall, field))


def laws_of_study(scheme: AnyScheme, rheology: Rheology, walls: Walls) -> Problems:
    """Check that the study's form of the explicit scheme is asked for what the study has."""
    if not isinstance(scheme, ExplicitScheme) or scheme.form == "stable":
        return
    instead = "not in scheme.form = 'study'; leave it out, or use 'stable'"
    if not isinstance(rheology, NoStrength):
        yield Problem("rheology.type", instead, rheology.type)
    for name, wall in walls:
        if wall.friction is not None and wall.friction.law != "no-slip":
            yield Problem(f"walls.{name}.friction.law", instead, wall.friction.law)


def no_settling(scheme: AnyScheme, time: Time) -> Problems:
    """Check that the explicit scheme, which starts from the state of rest, has no settling."""
    if isinstance(scheme, ExplicitScheme) and time.settling > 0:
        message = "the explicit scheme starts from hydrostatic columns instead; leave it out"
        yield Problem("time.settling", message, time.settling)


def step_below_acoustic(
    scheme: AnyScheme,
    particles: Particles,
    geometry: Geometry,
    gravity: Gravity,
    fill: Fill,
    inflow: Inflow | None,
    walls: Walls,
    time: Time,
    release: tuple[AnyRelease, ...],
    zone: tuple[Zone, ...],
) -> Problems:
    """Check that the speed of sound is known and the largest step below the acoustic limit."""
    if not isinstance(scheme, ExplicitScheme):
        return
    speed = scheme.sound_speed
    if speed is None:
        areas = [covered(part, geometry, particles) for part in fill]
        nothing = not areas and inflow is None and not release
        if nothing or any(area is None or area.volume == 0 for area in areas):
            return  # told by another check
        speed = sound_speed(fill, inflow, geometry, particles, gravity, walls, release, zone)
        if speed == 0:
            message = "missing: no speed follows from the case; give the speed of sound (m/s)"
            yield Problem("scheme.sound_speed", message)
            return
    limit = acoustic_step(scheme, speed, particles)
    if time.largest_step is not None and time.largest_step > limit * (1 + TOLERANCE):
        message = f"above the acoustic limit, courant spacing / sound_speed = {limit:.3g} s"
        yield Problem("time.largest_step", message, time.largest_step)
    if scheme.density_diffusion * scheme.courant > LARGEST_DIFFUSION:
        largest = LARGEST_DIFFUSION / scheme.courant
        message = f"times courant must be at most {LARGEST_DIFFUSION:g}: at most {largest:.3g}"
        yield Problem("scheme.density_diffusion", message, scheme.density_diffusion)
    slowest = FEWEST_RELAXATION_STEPS * (time.largest_step or limit)
    if scheme.density_relaxation is not None and scheme.density_relaxation < slowest:
        message = f"must be at least {FEWEST_RELAXATION_STEPS} time steps, {slowest:.3g} s"
        yield Problem("scheme.density_relaxation", message, scheme.density_relaxation)


CHECKS: tuple[Callable[..., Problems], ...] = (
    scheme_of_dimension,
    mixture_of_one_kind,
    laws_of_mixture,
    walls_at_rest,
    laws_of_study,
    no_settling,
    step_below_acoustic,
)
