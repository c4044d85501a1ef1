"""What resists the shear of a weakly compressible flow: viscosity, collisions and strength."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import LARGEST_PATH, VISCOUS_LIMIT
from debrisflow.case.materials import pore_density
from debrisflow.case.strength import FrictionalStrength, NoStrength
from debrisflow.errors import NotConvergedError
from debrisflow.neighbors import pairs
from debrisflow.particles.matter import concentrations
from debrisflow.particles.record import Particles
from debrisflow.physics import agitation, exchange, images
from debrisflow.physics.kinetic_theory import Grains, radial_distribution
from debrisflow.physics.rheology import consistency_at
from debrisflow.schemes.records import law_of

Floats = NDArray[np.float64]
RESIDUAL = 0.01  # of gravity, that the implicit exchange of momentum leaves out of balance
STILL = 1e-3  # of the speed, the gain against which it is measured where nothing else acts
GRAIN_RESIDUAL = 1e-3  # of the weight of the grains, that their static balance leaves
MOST_ITERATIONS = 1000
WEIGHING = 0.5  # of the concentration where strength begins: there grains begin to weigh


class Resistance:
    """Viscosity, stress of colliding grains and strength of the particles of a run.

    Without a strength law viscosity is explicit and part of the forces; with one all of it acts
    after them, implicitly, so that what does not yield comes to rest.

    Parameters
    ----------
    case : ResolvedCase
    numbers : Numbers

    Attributes
    ----------
    is_implicit : bool
    viscosity : (n,) float64 array, Pa s
        Of fluid and supply: Newtonian and of colliding grains.
    """

    def __init__(self, case: ResolvedCase, numbers: pairs.Numbers) -> None:
        stress, sediment = case.collision_stress, case.sediment
        self.case, self.numbers = case, numbers
        self.is_implicit = not isinstance(case.strength, NoStrength)
        self._law = law_of(case)
        self._has_collisions = stress.enabled
        self._is_algebraic = stress.granular_temperature == "algebraic"
        self._grains = Grains(
            sediment.density,
            sediment.grain_diameter,
            sediment.restitution,
            sediment.packing_limit,
            stress.largest_concentration,
        )
        # what the artificial viscosity along the line of two particles is in shear
        kinematic = numbers.artificial_viscosity * numbers.sound_speed * numbers.spacing
        self._least_viscosity = numbers.density * kinematic / (numbers.dimension + 2.0)
        self._g = float(np.linalg.norm(numbers.gravity))
        self._down = numbers.gravity / (self._g or 1.0)
        self._is_even = len(concentrations(case)) == 1
        self._level = self._rate = self.viscosity = np.zeros(0)
        self._gradient = np.zeros((0, 9), np.float32)
        self.forget()

    def forget(self) -> None:
        """Let the next exchange of momentum begin without what the last one found."""
        self._gain = np.zeros((0, 3))

    def observe(
        self, p: Particles, fluid: pairs.Fluid, solid: pairs.Solid, near: pairs.Near
    ) -> None:
        """Find concentration, shear rate and stress of colliding grains at the positions."""
        rows, n = p.moving, p.moving.stop
        fraction = p.sediment_fraction[rows]
        self.viscosity = np.where(
            fraction > 0.0, self.case.mixture.viscosity, self.case.water.viscosity
        )
        self._observe_concentration(p, fluid, near)
        if self.is_implicit or (self._has_collisions and self._is_algebraic):
            self._gradient, self._rate = np.empty((n, 9), np.float32), np.empty(n)
            agitation.velocity_gradients(
                fluid, solid, near, self.numbers, self._gradient, self._rate
            )
        if self._has_collisions:
            self._observe_collisions(p, fluid, near)

    def _observe_concentration(self, p: Particles, fluid: pairs.Fluid, near: pairs.Near) -> None:
        rows = p.moving
        if self._is_even:
            p.concentration[rows] = self._level = p.sediment_fraction[rows]
            return
        around, level = p.sediment_fraction[rows], p.sediment_fraction[rows]
        for _ in range(2):
            smoothed, leveled = np.empty((2, p.moving.stop))
            agitation.concentrations(
                around, level, self._down, fluid, near, self.numbers, smoothed, leveled
            )
            around, level = smoothed, leveled
        p.concentration[rows], self._level = around, level

    def _observe_collisions(self, p: Particles, fluid: pairs.Fluid, near: pairs.Near) -> None:
        rows = p.moving
        c = np.minimum(p.concentration[rows], self._grains.largest_concentration)
        temperature = p.granular_temperature[rows]
        if self._is_algebraic:
            agitation.algebraic_temperatures(self._rate, self._grains, temperature)
        else:
            agitation.neighborhood_temperatures(
                fluid, near, c, self._grains, self.numbers, temperature
            )
        agitation.collide_grains(
            c,
            self._grains,
            self.numbers.number_density,
            p.number_density[rows],
            temperature,
            p.collision_pressure[rows],
            self.viscosity,
        )

    def step_limits(self, p: Particles) -> list[float]:
        """Return the time steps, s, that explicit viscosity and the push of the grains allow."""
        rows, limits = p.moving, []
        if self._has_collisions and not self.is_implicit:
            largest = float((self.viscosity / p.density[rows]).max(initial=0.0))
            limits.append(VISCOUS_LIMIT * self.numbers.spacing**2 / max(largest, 1e-300))
        if self._has_collisions:
            c = np.minimum(p.concentration[rows], self._grains.largest_concentration)
            densest = c.max(initial=0.0)
            stiffness = 2.0 + radial_distribution(densest, self._grains.packing_limit) / 3.0
            push = float((p.collision_pressure[rows] / p.density[rows]).max(initial=0.0))
            if push > 0.0:
                limits.append(LARGEST_PATH * self.numbers.spacing / np.sqrt(push * stiffness))
        return limits

    def exchange_momentum(
        self,
        p: Particles,
        dt: float,
        fluid: pairs.Fluid,
        solid: pairs.Solid,
        near: pairs.Near,
        velocity: Floats,
    ) -> int:
        """Exchange momentum implicitly; ``velocity``, (n, 3), is that after all other forces.

        Returns
        -------
        int
            Iterations.

        Raises
        ------
        NotConvergedError
        """
        self._weigh_grains(p, fluid, near)
        flow = self._flow(p)
        system = self._system(near, np.arange(p.moving.stop) < p.fluid_count)
        mirrors = images.no_mirrors(p.moving.stop)
        images.find_mirrors(fluid, solid, near, self.numbers, mirrors)
        exchange.couple_momentum(
            dt, fluid, solid, near, flow, mirrors, self._law, self._down, self.numbers, system
        )
        right = flow.density[:, None] * velocity
        started = p.velocity[p.moving]
        gain, speed = (np.sqrt(np.mean(u**2)) for u in (velocity - started, velocity))
        scale = dt * self._g or max(gain, STILL * speed)
        goal = (RESIDUAL * scale) ** 2 * float(np.sum(flow.density[: p.fluid_count] ** 2))
        velocity[:] = started
        if self._gain.shape == velocity.shape:
            # what goes on accelerating as before is found at once
            velocity[: p.fluid_count] += self._gain[: p.fluid_count]
        iterations = self._solved("the exchange of momentum", system, near, right, goal, velocity)
        self._gain = velocity - started
        return iterations

    def _flow(self, p: Particles) -> exchange.Flow:
        d0, rows = self.numbers.spacing, p.moving
        strength, deepening, ramp = np.empty((3, rows.stop))
        flow = exchange.Flow(
            p.density[rows],
            self._level,
            consistency_at(self._level, self._law),
            self.viscosity.copy(),
            strength,
            deepening,
            ramp,
            self._rate,
            self._gradient,
            self._least_viscosity,
        )
        exchange.resist(
            p.grain_pressure[rows],
            self._grain_weight(p),
            d0,
            self.case.strength.mixing_length,
            self._law,
            flow,
        )
        return flow

    def _grain_weight(self, p: Particles) -> Floats:
        """Return the weight that the grains carry, N/m3: that less buoyancy, where water is."""
        pores = pore_density(self.case.water, self.case.strength)
        return np.asarray(self._level * (self.case.sediment.density - pores) * self._g)

    def _weigh_grains(self, p: Particles, fluid: pairs.Fluid, near: pairs.Near) -> None:
        """Write the effective pressure between grains.

        Where all matter is alike it is the share of the pressure that the grains carry; under
        water that of the static balance of the buoyant grains, as water on a bed adds nothing.  No
        less than the weight of half a row, which ties the uppermost one.
        """
        strength = self.case.strength
        if not isinstance(strength, FrictionalStrength):
            return
        rows = p.moving
        weight, half = self._grain_weight(p), 0.5 * self.numbers.spacing
        if self._is_even:
            share = weight / (p.density[rows] * (self._g or 1.0))
            np.maximum(share * p.pressure[rows], half * weight, out=p.grain_pressure[rows])
            return
        least = WEIGHING * strength.concentration_ramp[0]
        is_bed = self._level >= least
        surface = p.on_free_surface[rows]
        system = self._system(near, is_bed & ~surface)
        right = np.empty((rows.stop, 1))
        excess = (self.case.sediment.density - self.case.water.density) * self.numbers.gravity
        exchange.couple_grains(fluid, near, self._level, excess, self.numbers, system, right)
        pressure = np.where(system.is_free, p.grain_pressure[rows], 0.0)
        pressure[is_bed & surface] = half * weight[is_bed & surface]
        goal = GRAIN_RESIDUAL**2 * float(np.sum(right[system.is_free] ** 2))
        solution = pressure[:, None].copy()
        self._solved("the balance of the grains", system, near, right, goal, solution)
        np.maximum(solution[:, 0], 0.0, out=p.grain_pressure[rows])

    def _system(self, near: pairs.Near, is_free: NDArray[np.bool_]) -> exchange.Couplings:
        return exchange.Couplings(
            np.empty(near.fluid.shape, dtype=np.float32), np.empty(is_free.size), is_free
        )

    def _solved(
        self,
        name: str,
        system: exchange.Couplings,
        near: pairs.Near,
        right: Floats,
        goal: float,
        x: Floats,
    ) -> int:
        iterations = int(exchange.solve(system, near, right, goal, MOST_ITERATIONS, x))
        if iterations < 0:
            raise NotConvergedError(name)
        return iterations
