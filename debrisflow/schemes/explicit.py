"""The explicit scheme: density by continuity, equation of state, forces, all at one position."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.defaults import LARGEST_PATH
from debrisflow.errors import DivergedError
from debrisflow.neighbors import pairs
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.lists import FixedNeighbors, Neighbors, order_by_cell
from debrisflow.neighbors.wall_access import WallSurface
from debrisflow.particles.inflow_outflow import advance_supply, remove_leaving, remove_lost, wrap
from debrisflow.particles.matter import concentrations, reference_density
from debrisflow.particles.record import Kind
from debrisflow.particles.state import State
from debrisflow.physics import compressible
from debrisflow.schemes.clock import Clock
from debrisflow.schemes.resistance import Resistance
from debrisflow.schemes.wall_surface import wall_surface
from debrisflow.space.domain import WALL_NAMES, domain
from debrisflow.space.floor import driving_gravity
from debrisflow.space.gravity import gravity_vector

Floats = NDArray[np.float64]
LEAST_SKIN, GREATEST_SKIN = 0.15, 0.6  # spacings
BLOCKS = 16


class Explicit:
    """Weakly compressible step, symplectic and with one evaluation of all terms.

        s' = s + dt ds/dt(r, u),  p = rho0 c^2 s',  u' = u + dt a(r, u, p),  r' = r + dt u'

    Each particle stands for water or for a mixture.  With a strength law, and so with a viscosity
    that has no bound, momentum is exchanged implicitly between forces and motion:

        (1 + dt K / rho) u' = u + dt a(r, u, p)

    Parameters
    ----------
    case : ResolvedCase
        A checked case with its defaults resolved.

    Attributes
    ----------
    seconds : Clock
        Wall time by phase of the step.
    """

    REFRESH = 40
    """Steps after which particles are sorted; a resumed run begins at such a step and so repeats
    the bits of an uninterrupted one."""

    def __init__(self, case: ResolvedCase) -> None:
        self.case, self.scheme = case, case.explicit_scheme
        self.lattice = reference(
            case.dimension, case.particles.effective_radius, case.particles.spacing
        )
        self.domain = domain(case)
        self.seconds = Clock()
        self._is_even = len(concentrations(case)) == 1
        self._set_numbers(case)
        self._resistance = Resistance(case, self._numbers)
        self._force_numbers = self._numbers
        if self._resistance.is_implicit:
            # there the artificial viscosity is a part of the exchange of momentum
            self._force_numbers = self._numbers._replace(artificial_viscosity=0.0)
        self._near = Neighbors(
            self.lattice.effective_radius, self.lattice.spacing, self.domain.period
        )
        self._observed_step = -1

    def _set_numbers(self, case: ResolvedCase) -> None:
        lattice, scheme = self.lattice, self.scheme
        dimension = float(lattice.dimension)
        self._numbers = pairs.Numbers(
            spacing=lattice.spacing,
            effective_radius=lattice.effective_radius,
            dimension=dimension,
            number_density=lattice.number_density,
            gradient=dimension / lattice.number_density,
            laplacian=2.0 * dimension / (lattice.laplacian_lambda * lattice.number_density),
            smooth_density=lattice.smooth_density,
            smooth_steepness=lattice.smooth_steepness,
            density=reference_density(case),
            sound_speed=scheme.sound_speed,
            gravity=gravity_vector(case),
            diffusion=scheme.density_diffusion,
            relaxation=scheme.density_relaxation,
            artificial_viscosity=scheme.artificial_viscosity,
            collision_distance=scheme.collision_distance * lattice.spacing,
            restitution=scheme.collision_restitution,
        )

    def observe(self, state: State) -> None:
        """Bring neighbors and granular stress up to the positions."""
        with self.seconds.of("neighbors"):
            self._observe_neighbors(state)
        with self.seconds.of("resistance"):
            fluid = self._fluid(state)
            self._resistance.observe(state.particles, fluid, self._solid, self._list)
        self._observed_step = state.step

    def fill_number_density(self, state: State) -> None:
        """Write number density and pressure of a state that no step has seen yet."""
        self.observe(state)
        p = state.particles
        p.compression[p.moving] = self._advance_density(state, 0.0)

    def stable_dt(self, state: State) -> float:
        """Return the greatest time step, s, that the state allows."""
        if self._observed_step != state.step:
            self.observe(state)
        d0, limits = self.lattice.spacing, [self.case.time.largest_step]
        speed, _ = self._survey(state, state.particles.velocity)
        if speed > 0.0:
            limits.append(LARGEST_PATH * d0 / speed)
        limits += self._resistance.step_limits(state.particles)
        return min(limits)

    def step(self, state: State, dt: float) -> int:
        """Advance a state by a time step that :meth:`stable_dt` allows.

        Returns
        -------
        int
            Iterations of the implicit exchange of momentum, 0 where there is none.

        Raises
        ------
        NotConvergedError
            If the exchange of momentum was not solved.
        DivergedError
            If a velocity is not finite.  Positions and velocities are then as before in both cases.
        """
        if self._observed_step != state.step:
            self.observe(state)
        p, rows = state.particles, state.particles.fluid
        iterations = 0

        with self.seconds.of("density"):
            compression = self._advance_density(state, dt)
        with self.seconds.of("forces"):
            velocity = p.velocity[p.moving].copy()
            compressible.advance_velocity(
                dt, self._fluid(state), self._solid, self._list, self._force_numbers, velocity[rows]
            )
        if self._resistance.is_implicit:
            with self.seconds.of("exchange of momentum"):
                iterations = self._resistance.exchange_momentum(
                    p, dt, self._fluid(state), self._solid, self._list, velocity
                )
        with self.seconds.of("motion"):
            self._check(state, velocity[rows])
            p.compression[p.moving] = compression
            p.velocity[rows] = velocity[rows]
            compressible.move(dt, velocity[rows], p.position[rows])
            advance_supply(state, self.case, dt)
            wrap(p, self.domain)
            _, outside = self._survey(state, p.velocity)
            if outside:
                remove_leaving(state, self.case, self.domain)
        return iterations

    def _observe_neighbors(self, state: State) -> None:
        p = state.particles
        if self._observed_step < 0:
            self._set_walls(state)
        if state.step % self.REFRESH == 0:
            p.reorder(p.fluid, order_by_cell(p.position[p.fluid], self.lattice.spacing))
            self._resistance.forget()
            self._choose_skin(state)
            self._list_neighbors(state)
            lost = np.empty(p.fluid_count, dtype=np.bool_)
            compressible.find_inside_walls(
                p.position[p.fluid], self._solid, self._list, self._numbers, lost
            )
            if lost.any():
                remove_lost(state, lost)
                self._list_neighbors(state)
        elif self._near.is_stale(p.position[p.moving], p.moving.stop):
            self._list_neighbors(state)

    def _choose_skin(self, state: State) -> None:
        """Weigh building lists often against passing over many neighbors out of reach.

        A wide skin costs the sums some (r_e + skin)^2 a spacing, a list lasts for skin / (2 m)
        steps where the fastest particle moves by m spacings in one: the least of both lies at
        1.4 sqrt(m).
        """
        speed, _ = self._survey(state, state.particles.velocity)
        path = speed * self.case.time.largest_step / self.lattice.spacing
        skin = min(max(1.4 * np.sqrt(path), LEAST_SKIN), GREATEST_SKIN)
        self._near.set_skin(skin)
        self._near_walls.set_skin(skin)

    def _list_neighbors(self, state: State) -> None:
        p, period = state.particles, self.domain.period
        inverse = np.divide(1.0, period, out=np.zeros(3), where=period > 0.0)
        position = p.position[p.moving]
        self._near.build(position, p.moving.stop)
        self._near_walls.build(position)
        self._list = pairs.Near(
            self._near.index,
            self._near.count,
            self._near_walls.index,
            self._near_walls.row,
            self._near_walls.count,
            np.stack([period, inverse]) if period.any() else None,
        )

    def _set_walls(self, state: State) -> None:
        """Sort the walls, which do not move, once."""
        p = state.particles
        walls = slice(p.inflow.stop, p.count)
        surface = wall_surface(p, self.case)
        is_mesh = [part.type == "mesh" for part in self.case.obstacle]
        is_mesh = [False] * len(WALL_NAMES) + is_mesh
        on_mesh = np.array(is_mesh)[p.wall[walls]]
        reach = self._numbers.collision_distance - 0.5 * self.lattice.spacing
        contact = np.where(on_mesh, reach, self._contact_height(surface, reach)[walls])
        self._solid = pairs.Solid(
            p.position[walls],
            surface.normal[walls],
            surface.depth[walls],
            surface.slip[walls],
            np.where(p.kind[walls] == Kind.WALL, contact, -np.inf),
            on_mesh,
            driving_gravity(self.case, p.position[walls, 0], surface.normal[walls]),
        )
        self._near_walls = FixedNeighbors(
            p.position[walls],
            self.lattice.effective_radius,
            self.lattice.spacing,
            self.domain.period,
            GREATEST_SKIN,
        )

    def _contact_height(self, surface: WallSurface, reach: float) -> Floats:
        """Return the height over a cell of wall, along its normal, at which contact begins, m.

        It is the reach over a face; at an edge or corner, whose normal halves the angle, that of
        the point over the rim of the cell, in reach of one of its faces, that is highest.
        """
        slanted = np.abs(surface.normal)
        rim = 0.501 * self.lattice.spacing * slanted.sum(axis=1) - surface.depth
        highest: Floats = rim + reach * slanted.max(axis=1)
        return highest

    def _advance_density(self, state: State, dt: float) -> Floats:
        """Write number density and pressure, and return the compression after a step."""
        p, rows = state.particles, state.particles.moving
        compression = np.empty(rows.stop)
        compressible.advance_density(
            dt,
            self._fluid(state),
            self._solid,
            self._list,
            self._numbers,
            p.number_density[rows],
            compression,
            p.pressure[rows],
        )
        p.on_free_surface[rows] = (
            p.number_density[rows] < compressible.SURFACE * self.lattice.number_density
        )
        return compression

    def _fluid(self, state: State) -> pairs.Fluid:
        p, rows = state.particles, state.particles.moving
        has_collisions = self.case.collision_stress.enabled
        return pairs.Fluid(
            p.position[rows],
            p.velocity[rows],
            p.compression[rows],
            p.pressure[rows],
            p.pressure[rows] + p.collision_pressure[rows] if has_collisions else p.pressure[rows],
            None if self._is_even else p.density[rows],
            np.zeros(rows.stop) if self._resistance.is_implicit else self._resistance.viscosity,
        )

    def _survey(self, state: State, velocity: Floats) -> tuple[float, int]:
        """Return the greatest speed, m/s, and whether particles are outside the domain."""
        p = state.particles
        fastest, outside = np.empty(BLOCKS), np.empty(BLOCKS, dtype=np.int64)
        compressible.survey_motion(
            p.position[p.fluid],
            velocity[: p.fluid_count],
            self.domain.lower,
            self.domain.upper,
            self.domain.mouth,
            fastest,
            outside,
        )
        return float(np.sqrt(fastest.max())), int(outside.sum())

    def _check(self, state: State, velocity: Floats) -> None:
        p = state.particles
        if np.isfinite(velocity.sum()):
            return
        worst = int(np.argmin(np.isfinite(velocity).all(axis=1)))
        raise DivergedError(
            f"at t = {state.time:g} s, step {state.step}, particle {p.id[worst]} at "
            f"{p.position[worst]} m got the velocity {velocity[worst]} m/s"
        )
