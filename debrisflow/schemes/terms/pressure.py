"""The pressure of an incompressible fluid: its equation, and the correction by its gradient."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case.resolved import ResolvedScheme
from debrisflow.errors import NotConvergedError
from debrisflow.physics import pressure
from debrisflow.physics.free_surface import FreeSurface
from debrisflow.physics.virtual_air import VirtualAir
from debrisflow.schemes.linear import Solver, remove_mean
from debrisflow.schemes.system import SystemRoom
from debrisflow.schemes.terms.term import Step, Term

Floats = NDArray[np.float64]


class PressureEquation(Term):
    """The pressure Poisson equation, whose solution makes the velocity free of divergence.

    Parameters
    ----------
    scheme : ResolvedScheme
    dimension : int
    surface : FreeSurface or VirtualAir
    gravity : (3,) float64 array, m/s2
    """

    name = "pressure equation"

    def __init__(
        self,
        scheme: ResolvedScheme,
        dimension: int,
        surface: FreeSurface | VirtualAir,
        gravity: Floats,
    ) -> None:
        self._room = SystemRoom()
        is_symmetric = scheme.interface == "symmetric"
        self._interface = (
            pressure.symmetric_interface(dimension)
            if is_symmetric
            else pressure.study_interface(dimension)
        )
        self.surface, self._gravity = surface, gravity
        has_air = isinstance(surface, VirtualAir)
        self._consistency = pressure.higher_order_factor(dimension) / 2.0 if has_air else 1.0
        self._density_rate = 1.0 / scheme.density_relaxation if scheme.density_relaxation else 0.0
        self._disorder = pressure.DISORDER if scheme.gradient == "sum" else 0.0
        self.solver = Solver(scheme.tolerance, is_symmetric)

    def refresh(self) -> None:
        """Forget the coarse levels of the solver."""
        self.solver.forget()

    def act(self, step: Step) -> None:
        """Find the pressure of fluid, supply and walls, and who is on the free surface."""
        scene, p, m = step.scene, step.particles, step.particles.unknown_count
        system, air = self._room.fit(scene.near.neighbors.shape), np.empty(m)
        pressure.assemble(
            step.velocity,
            p.density,
            scene.near,
            scene.solid,
            self.surface,
            self._interface,
            pressure.Source(
                step.dt,
                self._density_rate,
                self._disorder,
                self._consistency,
                step.dt * self._gravity,
            ),
            system,
            p.number_density[:m],
            p.on_free_surface[:m],
            air,
        )
        has_no_surface = not air.any() and remove_mean(system)
        step.iterations = self.solver.solve(system, step.pressure)
        if step.iterations < 0:
            raise NotConvergedError("the pressure equation")
        if has_no_surface:
            # the pressure of a full, closed domain is known up to a constant
            step.pressure -= step.pressure.min()
        np.maximum(step.pressure, 0.0, out=step.pressure)


class PressureGradient(Term):
    """``u - dt grad p / rho``: the sum form, or the study's equation (4).

    Parameters
    ----------
    is_conservative : bool
        Whether the gradient is the sum form.
    """

    name = "pressure gradient"

    def __init__(self, is_conservative: bool) -> None:
        self._is_conservative = is_conservative

    def act(self, step: Step) -> None:
        """Subtract the pressure gradient from the velocity of the fluid particles."""
        scene, p, excess = step.scene, step.particles, step.pressure
        if not self._is_conservative:
            least = np.empty(step.pressure.size)
            pressure.least_pressure(step.pressure, scene.near, scene.solid, least)
            excess = step.pressure - least
        pressure.correct(
            step.dt,
            excess,
            p.density,
            self._is_conservative,
            scene.near,
            scene.solid,
            step.velocity[p.fluid],
        )


class PressurePush(Term):
    """``u - dt grad p / rho``, the sum form, before walls that are surfaces.

    Parameters
    ----------
    gravity : (3,) float64 array, m/s2
    """

    name = "pressure gradient"

    def __init__(self, gravity: Floats) -> None:
        self._gravity = gravity

    def act(self, step: Step) -> None:
        """Subtract the pressure gradient from the velocity of the fluid particles."""
        scene, p = step.scene, step.particles
        step.push = np.empty((p.fluid_count, 3))
        pressure.correct_before_surfaces(
            step.dt,
            step.pressure,
            p.density,
            self._gravity,
            scene.near,
            scene.solid,
            step.velocity[p.fluid],
            step.push,
        )
        step.reaction += step.push
