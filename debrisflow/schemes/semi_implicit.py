"""The semi-implicit scheme: predictor, pressure equation, corrector, exchange of momentum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.materials import pore_density
from debrisflow.case.resolved import ResolvedScheme
from debrisflow.case.strength import FrictionalStrength, NoStrength
from debrisflow.errors import DivergedError, NotConvergedError
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.lists import Neighbors, order_by_cell
from debrisflow.neighbors.stencil import Stencil, empty_stencil, survey
from debrisflow.particles.inflow_outflow import advance_supply, remove_leaving, wrap
from debrisflow.particles.record import Kind, Particles
from debrisflow.particles.state import State
from debrisflow.particles.supply import supply
from debrisflow.physics import momentum, pressure
from debrisflow.physics.collision_stress import collision_state, largest_collision_step, throw
from debrisflow.physics.concentration import concentration, level_concentration
from debrisflow.physics.contact import collide
from debrisflow.physics.drag import DragLaw
from debrisflow.physics.grain_pressure import assemble_grain_pressure
from debrisflow.physics.granular_temperature import TEMPERATURES
from debrisflow.physics.kinetic_theory import Grains
from debrisflow.physics.operators import number_density
from debrisflow.schemes.clock import Clock
from debrisflow.schemes.linear import Solver, remove_mean
from debrisflow.schemes.records import law_of
from debrisflow.schemes.slip import Materials, Slip
from debrisflow.schemes.system import empty_system, residual
from debrisflow.schemes.wall_surface import wall_surface
from debrisflow.space.domain import WALL_NAMES, domain
from debrisflow.space.floor import floor_roughness, height_over_floor
from debrisflow.space.gravity import gravity_vector

Floats = NDArray[np.float64]
DIMENSION = 2
ERGUN_FROM = {"gidaspow": 0.2, "wen-yu": np.inf}
GRAIN_TOLERANCE = 1.0e-3
# Grains too few for strength still weigh on those below, over which a flow carries them; less would
# take the first row of water on a bed for part of it.
WEIGHING = 0.5
# tight, because what is left undone is given back to particles that had no part in it
EXCHANGE_TOLERANCE = 1.0e-5


class SemiImplicit:
    """Fractional step with variable density, everything evaluated at the old positions.

    Predict the velocity from gravity, viscosity, collision stress and drag; let particles that come
    too close collide; solve the pressure equation and correct by its gradient; exchange momentum
    implicitly by viscosity and friction; move.  With a drag law all that follows the drag is done
    with the velocity of the mixture, and the slip moves particles by exchange of places, see
    :mod:`debrisflow.physics.slip`; without one each particle moves by its own velocity.

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
    """Steps after which particles are sorted and the multigrid hierarchy is built anew; a resumed
    run begins at such a step and so repeats the bits of an uninterrupted one."""

    def __init__(self, case: ResolvedCase) -> None:
        self.case = case
        self.lattice = reference(DIMENSION, case.particles.effective_radius, case.particles.spacing)
        self.domain = domain(case)
        self.gravity = gravity_vector(case)
        self._down = self.gravity / (np.linalg.norm(self.gravity) or 1.0)
        self.seconds = Clock()
        self._near = Neighbors(
            self.lattice.effective_radius, self.lattice.spacing, self.domain.period
        )
        self.numbers = case.semi_implicit_scheme
        self._set_operators(self.numbers)
        self._set_materials(case)
        self._observed_step = -1
        self._stencil: Stencil

    def _set_operators(self, scheme: ResolvedScheme) -> None:
        symmetric = scheme.interface == "symmetric"
        self._conserves = scheme.gradient == "sum"
        self._interface = (
            pressure.Interface(0.0, 0.0, 5.0 - DIMENSION)
            if symmetric
            else pressure.Interface(6.0 - DIMENSION, -1.0, 0.0)
        )
        self._surface = (
            pressure.FreeSurface(0.8, 0.97, 0.1)
            if scheme.free_surface == "asymmetry"
            else pressure.FreeSurface(0.97, 0.97, np.inf)
        )
        self._density_rate = 1.0 / scheme.density_relaxation if scheme.density_relaxation else 0.0
        self._pressure_solver = Solver(scheme.tolerance, symmetric)
        self._grain_solver = Solver(GRAIN_TOLERANCE)
        self._exchange_solver = Solver(EXCHANGE_TOLERANCE)

    def _set_materials(self, case: ResolvedCase) -> None:
        sediment = case.sediment
        self._law = law_of(case)
        self._slip: Slip | None = None
        if case.drag.law != "none":
            drag = DragLaw(
                ERGUN_FROM[case.drag.law],
                sediment.grain_diameter,
                case.water.density,
                case.water.viscosity,
                sediment.packing_limit,
            )
            self._slip = Slip(drag, Materials(sediment.density, case.water.density))
        self._grains = Grains(
            sediment.density,
            sediment.grain_diameter,
            sediment.restitution,
            sediment.packing_limit,
            case.collision_stress.largest_concentration,
        )
        self._find_temperatures = TEMPERATURES[case.collision_stress.granular_temperature]
        self._has_strength = not isinstance(case.strength, NoStrength)
        self._mixing_length = case.strength.mixing_length
        self._has_collisions = case.collision_stress.enabled
        self._thrown = np.zeros((0, 3))
        self._is_rough = any(getattr(case.walls, name).roughness > 0.0 for name in WALL_NAMES)
        self._viscosity = np.zeros(len(Kind))
        self._viscosity[Kind.LIQUID] = case.water.viscosity
        self._viscosity[Kind.SEDIMENT] = sediment.viscosity
        self._viscosity[Kind.MIXTURE] = case.mixture.viscosity
        self._viscosity[Kind.INFLOW] = case.water.viscosity

    def observe(self, state: State) -> None:
        """Bring neighbors, concentration, shear rate and granular state up to the positions."""
        p = state.particles
        with self.seconds.of("neighbors"):
            self._observe_neighbors(state)
        with self.seconds.of("grains"):
            self._observe_grains(p)
        self._observed_step = state.step

    def fill_number_density(self, state: State) -> None:
        """Write number density and free surface of a state that no step has seen yet."""
        self.observe(state)
        p, m = state.particles, state.particles.unknown_count
        number_density(self._stencil, p.number_density[:m], np.empty(m))
        p.on_free_surface[:m] = (
            p.number_density[:m] < self._surface.lower * self.lattice.number_density
        )

    def stable_dt(self, state: State) -> float:
        """Return the greatest time step, s, that the state allows."""
        if self._observed_step != state.step:
            self.observe(state)
        p, case = state.particles, self.case
        speed = max(
            float(np.sqrt(np.max(np.sum(p.velocity[p.fluid] ** 2, axis=1), initial=0.0))),
            supply(case, state.time)[0],
        )
        limits = [case.time.largest_step]
        if speed > 0.0:
            limits.append(self.numbers.courant * self.lattice.spacing / speed)
        if self._has_collisions:
            limits.append(
                largest_collision_step(
                    self._grain_concentration(p),
                    p.density[p.fluid],
                    *self._collisions,
                    self._grains,
                    self.lattice.spacing,
                )
            )
        return min(limits)

    def step(self, state: State, dt: float) -> int:
        """Advance a state by a time step that :meth:`stable_dt` allows.

        Returns
        -------
        int
            Iterations of the pressure equation.

        Raises
        ------
        NotConvergedError
            If a linear system was not solved.
        DivergedError
            If a velocity is not finite.  Time, positions, velocities and pressures are then as
            before in both cases.
        """
        if self._observed_step != state.step:
            self.observe(state)
        p = state.particles
        solved = p.pressure.copy()

        with self.seconds.of("predictor"):
            velocity = self._predict(p, dt)
        if self._slip is not None:
            with self.seconds.of("slip"):
                self._slip.act(p, self._thrown, dt, velocity)
                velocity[p.fluid] -= self._slip.velocity
        with self.seconds.of("predictor"):
            velocity = self._collide(p, velocity)

        iterations = self._solve_pressure(p, velocity, dt, solved)

        with self.seconds.of("corrector"):
            self._correct(p, velocity, dt, solved)
        if isinstance(self.case.strength, FrictionalStrength):
            self._balance_grains(p, self.case.strength)
        if self._has_strength and p.fluid_count > 0:
            velocity = self._exchange_momentum(p, velocity, dt)
        if self._is_rough:
            velocity = self._rub(p, velocity, dt)

        self._check(state, velocity)
        with self.seconds.of("motion"):
            p.pressure[:] = solved
            p.velocity[p.fluid] = velocity[p.fluid]
            p.position[p.fluid] += dt * velocity[p.fluid]
            if self._slip is not None:
                p.velocity[p.fluid] += self._slip.velocity
                self._slip.move(p, dt)
            advance_supply(state, self.case, dt)
            wrap(p, self.domain)
            remove_leaving(state, self.case, self.domain)
        return iterations

    def _observe_neighbors(self, state: State) -> None:
        p = state.particles
        if state.step % self.REFRESH == 0:
            p.reorder(p.fluid, order_by_cell(p.position[p.fluid], self.lattice.spacing))
            for solver in (self._pressure_solver, self._grain_solver, self._exchange_solver):
                solver.forget()
            self._near.build(p.position, p.unknown_count)
        elif self._near.is_stale(p.position, p.unknown_count):
            self._near.build(p.position, p.unknown_count)
        if self._observed_step < 0 or self._stencil.neighbors.shape != self._near.index.shape:
            self._stencil = empty_stencil(*self._near.index.shape, self.lattice)
            self._room = empty_system(self._stencil.neighbors)
        self._stencil = self._stencil._replace(wall_from=p.inflow.stop)
        self._walls = wall_surface(p, self.case)
        survey(p.position, self.domain.period, self._near.index, self._near.count, self._stencil)

    def _observe_grains(self, p: Particles) -> None:
        n = p.fluid_count
        if np.any(p.sediment_fraction[p.fluid] > 0.0):
            raw = np.zeros(n)
            concentration(n, p.sediment_fraction, self._stencil, raw)
            concentration(n, raw, self._stencil, p.concentration)
        else:
            p.concentration[p.fluid] = 0.0
        self._mixture_velocity = p.velocity
        if self._slip is not None:
            self._slip.observe(p, self._stencil)
            self._mixture_velocity = p.velocity.copy()
            self._mixture_velocity[p.fluid] -= self._slip.velocity
        self._shear_rate, self._level_concentration, self._turbulent_viscosity = np.zeros((3, n))
        if self._has_strength and n > 0:
            self._observe_strength(p)
        if self._has_collisions:
            self._observe_collisions(p)

    def _observe_strength(self, p: Particles) -> None:
        """Find what friction and turbulence depend on."""
        n, case = p.fluid_count, self.case
        fractions = p.sediment_fraction
        for _ in range(2):
            at_level = np.zeros(n)
            level_concentration(n, fractions, self._down, self._stencil, at_level)
            fractions = at_level
        self._level_concentration = at_level
        x, y = p.position[p.fluid, 0], p.position[p.fluid, 1]
        momentum.survey_shear(
            self._mixture_velocity,
            p.density,
            np.maximum(height_over_floor(case, x, y, x), 0.5 * self.lattice.spacing),
            floor_roughness(case, x),
            self._mixing_length,
            self._walls,
            self._stencil,
            self._shear_rate,
            self._turbulent_viscosity,
        )

    def _observe_collisions(self, p: Particles) -> None:
        """Find the stress of colliding grains; slip, which is no agitation, does not count."""
        n, fraction = p.fluid_count, p.sediment_fraction
        self._find_temperatures(
            n,
            self._mixture_velocity,
            fraction,
            self._walls,
            self._grains,
            self._stencil,
            p.granular_temperature,
        )
        self._collisions = (np.zeros(n), np.zeros(n))
        collision_state(
            fraction,
            self._grain_concentration(p),
            p.granular_temperature,
            self._grains,
            self._stencil,
            *self._collisions,
        )
        self._thrown = np.empty((n, 3))
        throw(
            self._mixture_velocity,
            p.density,
            fraction,
            *self._collisions,
            self._walls,
            self._stencil,
            self._thrown,
        )

    def _grain_concentration(self, p: Particles) -> Floats:
        given = self.case.collision_stress.concentration
        return p.concentration[p.fluid] if given is None else np.full(p.fluid_count, given)

    def _matter(self, p: Particles, velocity: Floats) -> momentum.Matter:
        return momentum.Matter(
            velocity,
            p.density,
            self._viscosity[p.kind],
            self._turbulent_viscosity,
            self._level_concentration,
            self._shear_rate,
            p.grain_pressure,
        )

    def _predict(self, p: Particles, dt: float) -> Floats:
        velocity = p.velocity.copy()
        momentum.predict(
            dt,
            self.gravity,
            p.velocity,
            self._matter(p, self._mixture_velocity),
            self._thrown,
            not self._has_strength and self._viscosity.any(),
            self._walls,
            self._stencil,
            velocity[p.fluid],
        )
        return velocity

    def _collide(self, p: Particles, velocity: Floats) -> Floats:
        collided = velocity.copy()
        collide(
            p.fluid_count,
            velocity,
            p.density,
            self._walls,
            self.numbers.collision_distance * self.lattice.spacing,
            self.numbers.collision_restitution,
            self._stencil,
            collided,
        )
        return collided

    def _solve_pressure(self, p: Particles, velocity: Floats, dt: float, solved: Floats) -> int:
        m = p.unknown_count
        with self.seconds.of("pressure assembly"):
            pressure.assemble(
                p.fluid_count,
                velocity,
                p.density,
                self._stencil,
                self._surface,
                self._interface,
                pressure.Source(dt, self._density_rate, 6.0 if self._conserves else 0.0),
                self._room,
                p.number_density[:m],
                p.on_free_surface[:m],
            )
        with self.seconds.of("pressure solution"):
            no_surface = remove_mean(self._room)
            iterations = self._pressure_solver.solve(self._room, solved[:m])
        if iterations < 0:
            raise NotConvergedError("the pressure equation")
        if no_surface:
            # the pressure of a full, closed domain is known up to a constant
            solved[:m] -= solved[:m].min()
        np.maximum(solved, 0.0, out=solved)
        return iterations

    def _correct(self, p: Particles, velocity: Floats, dt: float, solved: Floats) -> None:
        if self._conserves:
            pressure.correct(dt, solved, p.density, True, self._stencil, velocity[p.fluid])
        else:
            least = np.empty(p.unknown_count)
            pressure.least_pressure(solved, self._stencil, least)
            excess = solved[: p.unknown_count] - least
            pressure.correct(dt, excess, p.density, False, self._stencil, velocity[p.fluid])

    def _balance_grains(self, p: Particles, strength: FrictionalStrength) -> None:
        """Solve the static pressure between the grains of the bed."""
        m = p.unknown_count
        case = self.case
        submerged = case.sediment.density - pore_density(case.water, strength)
        with self.seconds.of("grain pressure"):
            assemble_grain_pressure(
                p.fluid_count,
                self._level_concentration,
                WEIGHING * strength.concentration_ramp[0],
                p.on_free_surface,
                submerged,
                self.gravity,
                self._stencil,
                self._room,
            )
            if self._grain_solver.solve(self._room, p.grain_pressure[:m]) < 0:
                raise NotConvergedError("the balance of the grains")
            np.maximum(p.grain_pressure, 0.0, out=p.grain_pressure)

    def _exchange_momentum(self, p: Particles, velocity: Floats, dt: float) -> Floats:
        right = np.zeros((p.unknown_count, 3))
        with self.seconds.of("exchange of momentum"):
            self._room.entries[p.fluid_count :] = 0
            momentum.assemble_exchange(
                dt,
                p.fluid_count,
                self._matter(p, velocity),
                self._law,
                self._walls,
                self._stencil,
                self._room,
                right,
            )
            exchanged, rest = velocity.copy(), np.empty(p.unknown_count)
            for axis in range(DIMENSION):
                self._room.right[:] = right[:, axis]
                # nearer to the solution than the projected velocity: half the iterations
                start = self._mixture_velocity[: p.unknown_count, axis].copy()
                if self._exchange_solver.solve(self._room, start) < 0:
                    raise NotConvergedError("the exchange of momentum")
                residual(self._room, self._room.right, start, rest)
                # what the solver left undone is given back evenly, so that none is lost
                start[p.fluid] += rest[p.fluid].sum() / p.density[p.fluid].sum()
                exchanged[p.fluid, axis] = start[p.fluid]
        return exchanged

    def _check(self, state: State, velocity: Floats) -> None:
        p = state.particles
        finite = np.isfinite(velocity[p.fluid]).all(axis=1)
        if not finite.all():
            worst = int(np.argmin(finite))
            raise DivergedError(
                f"at t = {state.time:g} s, step {state.step}, particle {p.id[worst]} at "
                f"{p.position[worst, :DIMENSION]} m got the velocity "
                f"{velocity[worst, :DIMENSION]} m/s"
            )

    def _rub(self, p: Particles, velocity: Floats, dt: float) -> Floats:
        slowed = velocity.copy()
        momentum.rub(dt, velocity, self._walls, self._stencil, slowed[p.fluid])
        return slowed
