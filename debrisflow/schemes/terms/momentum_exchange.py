"""Implicit exchange of momentum by viscosity and strength, after all other forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.record import Particles
from debrisflow.physics.images import find_mirrors, no_mirrors
from debrisflow.physics.momentum_exchange import Flow, couple_momentum, resist
from debrisflow.physics.rheology import consistency_at
from debrisflow.schemes.pair_solver import Couplings, couplings_of, left_undone, solve_pairs
from debrisflow.schemes.records import law_of
from debrisflow.schemes.terms.base_friction import BaseFrictions
from debrisflow.schemes.terms.grain_pressure import grain_weight
from debrisflow.schemes.terms.term import Scene, Step, Term

Floats = NDArray[np.float64]
ENTRIES = np.array([[0, 1, 3], [1, 2, 4], [3, 4, 5]])  # of a symmetric matrix, in its six numbers
STILL = 1e-3  # of the speed, the gain against which it is measured where nothing else acts


class MomentumExchange(Term):
    """All viscosity and strength, implicitly, so that what does not yield comes to rest.

    After the pressure projection of the semi-implicit scheme: before it the same friction would
    leave the noise of the pressure in a bed and fluidize it.

    Parameters
    ----------
    case : ResolvedCase
    gravity : (3,) float64 array, m/s2
    residual : float
        Share of gravity that the solution leaves out of balance.
    is_smooth : bool
        Whether pairs yield at the mean shear rate around the two, not at their own.
    least_viscosity : float, Pa s
        Between two particles.
    walls : BaseFrictions, optional
        Friction along walls, which acts within the exchange, so that what it holds stands still.
    """

    name = "exchange of momentum"

    def __init__(
        self,
        case: ResolvedCase,
        gravity: Floats,
        residual: float,
        *,
        is_smooth: bool,
        least_viscosity: float,
        walls: BaseFrictions | None = None,
    ) -> None:
        self._is_smooth, self._walls = is_smooth, walls
        self._case, self._law, self._residual = case, law_of(case), residual
        self._g = float(np.linalg.norm(gravity))
        self._down = gravity / (self._g or 1.0)
        self._least_viscosity = least_viscosity
        self.refresh()

    def refresh(self) -> None:
        """Let the next exchange begin without what the last one found."""
        self._gain = np.zeros((0, 3))

    def act(self, step: Step) -> None:
        """Exchange momentum; the velocity of the step is that after all other forces."""
        scene, p, velocity = step.scene, step.particles, step.velocity
        flow = self._flow(scene)
        system = couplings_of(scene.near, np.arange(p.moving.stop) < p.fluid_count)
        mirrors = no_mirrors(p.moving.stop)
        find_mirrors(scene.near, scene.solid, mirrors)
        right, drags = flow.density[:, None] * velocity, np.empty(p.moving.stop)
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
            right,
            drags,
        )
        started = scene.velocity
        goal = self._goal(step.dt, started, velocity, p)
        solution = started.copy()
        solution[p.inflow] = velocity[p.inflow]
        if self._gain.shape == velocity.shape:
            # what goes on accelerating as before is found at once
            solution[p.fluid] += self._gain[p.fluid]
        if self._walls is not None:
            hold, carried = self._walls.hold(step, solution)
            system = system._replace(hold=hold * flow.density[:, None])
            right += carried * flow.density[:, None]
        iterations = solve_pairs(
            "the exchange of momentum", system, scene.near, right, goal, solution
        )
        step.iterations = step.iterations or iterations
        if p.fluid_count > 0:
            # what the solver left undone is given back evenly, so that no momentum is lost
            undone = left_undone(system, scene.near, right, solution)
            solution[p.fluid] += np.linalg.solve(_inertia(system, drags, p), undone)
        if len(step.reaction):
            # the right side holds what moving walls give
            pulled = right / flow.density[:, None] - velocity
            slowed = _slowed(system, drags, flow, solution) - pulled
            step.reaction -= slowed[p.fluid] / step.dt
        self._gain = solution - started
        step.velocity = solution

    def _goal(self, dt: float, started: Floats, velocity: Floats, p: Particles) -> float:
        gain, speed = (np.sqrt(np.mean(u**2)) for u in (velocity - started, velocity))
        scale = dt * self._g or max(gain, STILL * speed)
        return float((self._residual * scale) ** 2 * np.sum(p.density[p.fluid] ** 2))

    def _flow(self, scene: Scene) -> Flow:
        p, rows, level = scene.particles, scene.particles.moving, scene.level
        strength, deepening, ramp = np.empty((3, rows.stop))
        flow = Flow(
            density=p.density[rows],
            concentration=level,
            consistency=consistency_at(level, self._law),
            viscosity=scene.viscosity,
            eddies=scene.eddies,
            strength=strength,
            deepening=deepening,
            ramp=ramp,
            shear_rate=scene.shear_rate,
            gradient=None if self._is_smooth else scene.gradient,
            least_viscosity=self._least_viscosity,
        )
        resist(
            p.grain_pressure[rows],
            grain_weight(scene, self._case, self._g),
            scene.near.spacing,
            self._law,
            flow,
        )
        return flow


def _inertia(system: Couplings, drags: Floats, particles: Particles) -> Floats:
    """Return what resists a common change of all velocities, (3, 3) array: mass and walls."""
    p = particles
    inertia: Floats = (p.density[p.fluid].sum() + drags[p.fluid].sum()) * np.eye(3)
    if system.hold is not None:
        inertia += system.hold[p.fluid].sum(axis=0)[ENTRIES]
    return inertia


def _slowed(system: Couplings, drags: Floats, flow: Flow, velocity: Floats) -> Floats:
    """Return by how much the walls slowed all particles, (n, 3) array, m/s."""
    slowed = drags[:, None] * velocity
    if system.hold is not None:
        slowed += np.einsum("ijk,ik->ij", system.hold[:, ENTRIES], velocity)
    return slowed / flow.density[:, None]
