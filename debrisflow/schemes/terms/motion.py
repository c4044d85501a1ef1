"""Motion: particles move with their velocity, supply comes in, and what is outside leaves."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError
from debrisflow.particles.inflow_outflow import advance_supply, remove_leaving, wrap
from debrisflow.particles.place import moment, named_particle
from debrisflow.particles.record import Particles
from debrisflow.particles.releases import release_due
from debrisflow.particles.supply import supply
from debrisflow.physics.motion import move, survey_motion
from debrisflow.schemes.terms.slip import Slip
from debrisflow.schemes.terms.term import Scene, Step, Term
from debrisflow.space.domain import Domain

Floats = NDArray[np.float64]
BLOCKS = 16


class Motion(Term):
    """The end of a step: what the other terms found is carried over to the particles.

    Parameters
    ----------
    case : ResolvedCase
    domain : Domain
    path : float
        Greatest path of a particle in a step, in spacings.
    slip : Slip or None
        By which particles exchange places.
    """

    name = "motion"

    def __init__(
        self, case: ResolvedCase, domain: Domain, path: float, slip: Slip | None = None
    ) -> None:
        self._case, self._domain, self._path, self._slip = case, domain, path, slip

    def limit(self, scene: Scene) -> float:
        """Return the time in which the fastest particle or wall moves by its greatest path, s."""
        entering, _ = supply(self._case, scene.state.time)
        fastest, _ = self.survey(scene.particles)
        speed = max(fastest, entering, scene.wall_speed)
        return self._path * scene.near.spacing / speed if speed > 0.0 else inf

    def act(self, step: Step) -> None:
        """Move the particles; first of all, check that their velocities are finite."""
        state, p, fluid = step.state, step.particles, step.particles.fluid
        self._check(step)
        state.particle_steps += p.fluid_count
        state.bounces += int(np.count_nonzero(step.bounced))
        p.pressure[: step.pressure.size] = step.pressure
        if step.compression.size:
            p.compression[p.moving] = step.compression
        p.velocity[fluid] = step.velocity[fluid]
        move(step.dt, step.velocity[fluid], p.position[fluid])
        if self._slip is not None:
            p.velocity[fluid] += self._slip.velocity
            self._slip.move(step)
        advance_supply(state, self._case, step.dt)
        release_due(state, self._case, state.time + step.dt)
        wrap(p, self._domain)
        _, outside = self.survey(p)
        # the box of a channel reaches down to the bottom of its recess, its floor does not
        if outside or self._case.dimension == 2:
            remove_leaving(state, self._case, self._domain)

    def survey(self, particles: Particles) -> tuple[float, int]:
        """Return the greatest speed of the fluid, m/s, and how many limits particles are beyond."""
        p = particles
        fastest, outside = np.empty(BLOCKS), np.empty(BLOCKS, dtype=np.int64)
        survey_motion(
            p.position[p.fluid],
            p.velocity[p.fluid],
            self._domain.lower,
            self._domain.upper,
            self._domain.mouth,
            fastest,
            outside,
        )
        return float(np.sqrt(fastest.max())), int(outside.sum())

    def _check(self, step: Step) -> None:
        state, p = step.state, step.particles
        velocity, axes = step.velocity[p.fluid], self._case.dimension
        if np.isfinite(velocity.sum()):
            return
        worst = int(np.argmin(np.isfinite(velocity).all(axis=1)))
        raise DivergedError(
            f"{moment(state)}, {named_particle(self._case, state, worst)} got the velocity "
            f"{velocity[worst, :axes]} m/s",
            "a force on it had no finite value: particles on top of each other, a value of the "
            "case far out of its range, or a time step too long for the scheme",
            "look at the place in the particles at the failure; check the units of what stands "
            "there (viscosity, friction, density, velocity of inflow or release), and try half of "
            "time.largest_step",
        )
