"""Implicit exchange of momentum in a mixture that yields, and the pressure between its grains."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import tables
from debrisflow.case.materials import pore_density
from debrisflow.errors import NotConvergedError
from debrisflow.particles.record import Particles
from debrisflow.physics.compressible import Numbers
from debrisflow.physics.grain_pressure import couple_grains
from debrisflow.physics.images import find_mirrors, no_mirrors
from debrisflow.physics.momentum_exchange import Flow, couple_momentum, resist
from debrisflow.physics.rheology import consistency_at
from debrisflow.schemes.pair_solver import Couplings, solve
from debrisflow.schemes.records import law_of
from debrisflow.schemes.terms.grain_pressure import WEIGHING
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]
RESIDUAL = 0.01  # of gravity, that the implicit exchange of momentum leaves out of balance
STILL = 1e-3  # of the speed, the gain against which it is measured where nothing else acts
GRAIN_RESIDUAL = 1e-3  # of the weight of the grains, that their static balance leaves
MOST_ITERATIONS = 1000


class MixtureGrainPressure(Term):
    """The effective pressure between the grains of a mixture.

    Where all matter is alike it is the share of the pressure that the grains carry; under water
    that of the static balance of the buoyant grains, as water on a bed adds nothing.  No less than
    the weight of half a row, which ties the uppermost one.

    Parameters
    ----------
    case : Case
    numbers : Numbers
    is_even : bool
        Whether all matter has the same concentration.
    """

    name = "grain pressure"

    def __init__(self, case: tables.Case, numbers: Numbers, is_even: bool) -> None:
        self._case, self._is_even, self._ramp_start = case, is_even, law_of(case).ramp_start
        self._gravity = numbers.gravity

    def act(self, step: Step) -> None:
        """Write the pressure between the grains of the mixture."""
        scene, p, rows = step.scene, step.particles, step.particles.moving
        g = float(np.linalg.norm(self._gravity))
        weight, half = grain_weight(scene, self._case, g), 0.5 * scene.near.spacing
        if self._is_even:
            share = weight / (p.density[rows] * (g or 1.0))
            np.maximum(share * step.pressure, half * weight, out=p.grain_pressure[rows])
            return
        is_bed = scene.level >= WEIGHING * self._ramp_start
        surface = p.on_free_surface[rows]
        system = _empty(scene, is_bed & ~surface)
        right = np.empty((rows.stop, 1))
        excess = (self._case.sediment.density - self._case.water.density) * self._gravity
        couple_grains(scene.near, scene.level, excess, system, right)
        pressure = np.where(system.is_free, p.grain_pressure[rows], 0.0)
        pressure[is_bed & surface] = half * weight[is_bed & surface]
        goal = GRAIN_RESIDUAL**2 * float(np.sum(right[system.is_free] ** 2))
        solution = pressure[:, None].copy()
        _solved("the balance of the grains", system, scene, right, goal, solution)
        np.maximum(solution[:, 0], 0.0, out=p.grain_pressure[rows])


class MixtureExchange(Term):
    """All viscosity and the strength of a mixture, so that what does not yield comes to rest.

    Parameters
    ----------
    case : Case
    numbers : Numbers
    """

    name = "exchange of momentum"

    def __init__(self, case: tables.Case, numbers: Numbers) -> None:
        self._case, self._law = case, law_of(case)
        self._g = float(np.linalg.norm(numbers.gravity))
        self._down = numbers.gravity / (self._g or 1.0)
        # what the artificial viscosity along the line of two particles is in shear
        kinematic = numbers.artificial_viscosity * numbers.sound_speed * case.particles.spacing
        self._least_viscosity = numbers.density * kinematic / (case.dimension + 2.0)
        self.refresh()

    def refresh(self) -> None:
        """Let the next exchange begin without what the last one found."""
        self._gain = np.zeros((0, 3))

    def act(self, step: Step) -> None:
        """Exchange momentum; the velocity of the step is that after all other forces."""
        scene, p, velocity = step.scene, step.particles, step.velocity
        flow = self._flow(scene)
        system = _empty(scene, np.arange(p.moving.stop) < p.fluid_count)
        mirrors = no_mirrors(p.moving.stop)
        find_mirrors(scene.near, scene.solid, mirrors)
        couple_momentum(
            step.dt,
            scene.velocity,
            scene.near,
            scene.solid,
            flow,
            mirrors,
            self._law,
            self._down,
            system,
        )
        right = flow.density[:, None] * velocity
        started = scene.velocity
        goal = self._goal(step.dt, started, velocity, p)
        solution = started.copy()
        if self._gain.shape == velocity.shape:
            # what goes on accelerating as before is found at once
            solution[p.fluid] += self._gain[p.fluid]
        step.iterations = _solved("the exchange of momentum", system, scene, right, goal, solution)
        self._gain = solution - started
        step.velocity = solution

    def _goal(self, dt: float, started: Floats, velocity: Floats, p: Particles) -> float:
        gain, speed = (np.sqrt(np.mean(u**2)) for u in (velocity - started, velocity))
        scale = dt * self._g or max(gain, STILL * speed)
        return float((RESIDUAL * scale) ** 2 * np.sum(p.density[p.fluid] ** 2))

    def _flow(self, scene: Scene) -> Flow:
        p, rows, level = scene.particles, scene.particles.moving, scene.level
        strength, deepening, ramp = np.empty((3, rows.stop))
        flow = Flow(
            density=p.density[rows],
            concentration=level,
            consistency=consistency_at(level, self._law) if self._law.consistency > 0.0 else None,
            viscosity=scene.viscosity.copy(),
            strength=strength,
            deepening=deepening,
            ramp=ramp,
            shear_rate=scene.shear_rate,
            gradient=scene.gradient,
            least_viscosity=self._least_viscosity,
        )
        resist(
            p.grain_pressure[rows],
            grain_weight(scene, self._case, self._g),
            scene.near.spacing,
            self._case.strength.mixing_length,
            self._law,
            flow,
        )
        return flow


def grain_weight(scene: Scene, case: tables.Case, g: float) -> Floats:
    """Return the weight that the grains carry, N/m3: that less buoyancy, where water is."""
    pores = pore_density(case.water, case.strength)
    return np.asarray(scene.level * (case.sediment.density - pores) * g)


def _empty(scene: Scene, is_free: NDArray[np.bool_]) -> Couplings:
    return Couplings(
        value=np.empty(scene.near.neighbors.shape, dtype=np.float32),
        diagonal=np.empty(is_free.size),
        is_free=is_free,
    )


def _solved(
    name: str, system: Couplings, scene: Scene, right: Floats, goal: float, x: Floats
) -> int:
    iterations = int(solve(system, scene.near, right, goal, MOST_ITERATIONS, x))
    if iterations < 0:
        raise NotConvergedError(name)
    return iterations
