"""Grains in plane shear: granular temperature and ratio of the stresses, by kinetic theory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.neighbors.boundary import face_at, face_count
from debrisflow.neighbors.pairs import fluid_pair
from debrisflow.particles.start import initial_state
from debrisflow.physics.collision_stress import collision_force_at
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.schemes.terms.collision_stress import PhaseCollisions
from debrisflow.schemes.terms.term import Scene
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, exact, points
from debrisflow.validation.granular.grain_layer import HEIGHT, RESTITUTION, balance, layer
from debrisflow.validation.marching import advance
from debrisflow.validation.row import near

Floats = NDArray[np.float64]
RATE = 10.0  # 1/s
SAMPLES, FROM, APART = 20, 4.0, 0.1  # strain units
RATIO = 0.4 * np.sqrt(15.0 * (1.0 - RESTITUTION) / np.pi)
"""tau over p of Ding & Gidaspow (1990) where production equals dissipation."""


class PlaneShear(NamedTuple):
    """What a sheared layer did in its middle half.

    Attributes
    ----------
    temperature_ratio : float
        T over that of the balance.
    stress_ratio : float
        tau over p.
    height, speed : (n,) float64 array, m, m/s
        Of all particles at the end.
    """

    temperature_ratio: float
    stress_ratio: float
    height: Floats
    speed: Floats


def plane_shear(rows: int = 20, temperature: str = "algebraic") -> PlaneShear:
    """Shear a layer between walls and measure it, twenty times from the fourth strain unit on.

    The stress is that of the forces between the particles: the virial of the pairs within the
    middle half of the layer.
    """
    case = layer(rows, wall_speed=RATE * HEIGHT, temperature=temperature)
    scheme, state = SemiImplicit(case), initial_state(case)
    p = state.particles
    p.velocity[p.fluid, 0] = RATE * p.position[p.fluid, 1]
    temperatures, stresses = [], []
    for number in range(SAMPLES):
        advance(scheme, state, until=(FROM + APART * number) / RATE)
        scene = scheme.observe(state)
        y, u = p.position[p.fluid, 1], p.velocity[p.fluid, 0]
        middle = np.abs(y - 0.5 * HEIGHT) < 0.25 * HEIGHT
        slope = float(np.polyfit(y[middle], u[middle], 1)[0])
        temperatures.append(p.granular_temperature[p.fluid][middle].mean() / balance(slope))
        (collisions,) = (term for term in scheme.terms if isinstance(term, PhaseCollisions))
        stresses.append(virial(collisions, scene, middle))
    shear, pressure = np.mean(stresses, axis=0)
    ratios = float(np.mean(temperatures)), float(shear / pressure)
    return PlaneShear(*ratios, y.copy(), u.copy())


def virial(
    collisions: PhaseCollisions, scene: Scene, chosen: NDArray[np.bool_]
) -> tuple[float, float]:
    """Return shear stress and pressure, Pa, from the forces on the chosen particles.

    ``-1/2 sum of f_ij (x) r_ij`` a particle, whose volume is 1 here, each pair's force taken alone
    from the kernel.  The shear stress is what carries momentum along x through planes of y: as a
    Laplacian the viscous stress is ``mu grad u``, not its symmetric part.
    """
    near, solid = scene.near, scene.solid
    fraction = scene.particles.sediment_fraction[scene.particles.moving]
    rows = near.fluid_count.size
    lone, one = np.zeros((rows, 1), np.int32), np.ones(rows, np.int32)
    alone = near._replace(neighbors=lone, fluid_count=one)
    at_wall = near._replace(fluid_count=np.zeros(rows, np.int32))
    shear, normal = [], []
    for i in np.flatnonzero(chosen):
        found = np.zeros((2, 2))
        for k in range(near.fluid_count[i]):
            lone[i, 0] = near.neighbors[i, k]
            force = collision_force_at(
                i, scene.velocity, fraction, collisions.pressure, collisions.viscosity, alone, solid
            )
            _, dx, dy, *_ = fluid_pair(i, 0, alone)
            found += 0.5 * np.outer(force[:2], (dx, dy))
        if face_count(i, solid) > 0:
            height, nx, ny, *_ = face_at(i, 0, solid)
            grains = collisions.pressure, collisions.viscosity
            force = collision_force_at(i, scene.velocity, fraction, *grains, at_wall, solid)
            found -= np.outer(force[:2], (height * nx, height * ny))
        shear.append(found[0, 1])
        normal.append(-0.5 * np.trace(found))
    return float(np.mean(shear)), float(np.mean(normal))


def measure(level: Level) -> Measured:
    """Return temperature and stresses at a level."""
    found = plane_shear(round(level.across))
    reason = "resolution: shear is linear, so that nothing but the disorder of particles is left"
    y = np.array([0.0, 1.0])
    axes = "u / speed of the wall", "y / H"
    curves = (
        exact(y, y),
        points(found.speed[::3] / (RATE * HEIGHT), found.height[::3] / HEIGHT),
    )
    return Measured(
        (
            near(
                "granular temperature / that of the balance",
                found.temperature_ratio,
                1.0,
                reason,
                share=0.01,
            ),
            near(
                "shear stress / pressure of the grains",
                found.stress_ratio,
                RATIO,
                reason,
                share=0.01,
            ),
        ),
        abs(found.stress_ratio / RATIO - 1.0),
        (Panel("speed across the gap", *axes, curves),),
    )


COMPARISONS = (
    Comparison(
        name="plane_shear",
        title="Colliding grains in plane shear",
        group=Group.GRANULAR,
        compared=(
            "Granular temperature, and shear stress over pressure from the forces between the "
            "particles, in the middle half of a sheared layer; means of 20 samples from the fourth "
            "unit of strain on."
        ),
        reference=(
            "T = (d du/dy)² / (15 (1 - e)), τ/p = 0.4 √(15 (1 - e) / π): production equals "
            "dissipation, Ding & Gidaspow 1990, doi:10.1002/aic.690360404"
        ),
        parameters="two dimensions, without gravity, 10 /s, e = 0.7, grains of a tenth of the gap",
        levels=(
            Level(10, "10 rows", 1, is_quick=True),
            Level(20, "20 rows", 2, is_quick=True),
            Level(40, "40 rows", 4),
        ),
        measure=measure,
        error="shear stress / pressure over that of the closed form - 1",
    ),
)
