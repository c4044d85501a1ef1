"""What a term of a step is: it observes the particles, limits the time step, and acts."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np
from numpy.typing import NDArray

from debrisflow.neighbors.boundary import Boundary
from debrisflow.neighbors.pairs import Near
from debrisflow.neighbors.wall_access import Solid
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.physics.viscosity import wall_shear

Floats = NDArray[np.float64]


@dataclass
class Scene:
    """The particles at the beginning of a step, and what terms have found out about them.

    Attributes
    ----------
    state : State
    near : Near
    solid : Solid or Boundary
    velocity : (moving particles, 3) float64 array, m/s
        Of the mixture: that of the particle's phase less its slip.
    wall_speed : float, m/s
        The greatest of an obstacle that moves.
    level : (moving particles,) float64 array
        Share of sediment at the level of a particle.
    gradient : (moving particles, 9) float32 array, 1/s
        Velocity gradient by rows.
    shear_rate : (moving particles,) float64 array, 1/s
    viscosity : (moving particles,) float64 array, Pa s
        Newtonian viscosity of the matter, and what terms add: that of eddies, and in three
        dimensions that of colliding grains.
    eddies : (moving particles,) float64 array, Pa s
        That of eddies alone.
    collision_acceleration : (fluid particles, 3) float64 array, m/s2
        Of colliding grains, without rows where there are none.
    """

    state: State
    near: Near
    solid: Solid | Boundary
    velocity: Floats
    wall_speed: float = 0.0
    level: Floats = field(default_factory=lambda: np.zeros(0))
    gradient: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 9), np.float32))
    shear_rate: Floats = field(default_factory=lambda: np.zeros(0))
    viscosity: Floats = field(default_factory=lambda: np.zeros(0))
    eddies: Floats = field(default_factory=lambda: np.zeros(0))
    collision_acceleration: Floats = field(default_factory=lambda: np.zeros((0, 3)))

    @property
    def particles(self) -> Particles:
        """The particles of the state."""
        return self.state.particles


@dataclass
class Step:
    """A step that is being made: the last term, motion, carries it over to the particles.

    Attributes
    ----------
    scene : Scene
    dt : float, s
    velocity : (moving particles, 3) float64 array, m/s
        Changed by the terms.
    pressure : (rows,) float64 array, Pa
        Of all particles that have a list of neighbors.
    reaction : (fluid particles, 3) float64 array, m/s2
        What walls as surfaces do to the particles, bounces among it, summed over the terms.
    push : (fluid particles, 3) float64 array, m/s2
        What of it is by pressure.
    bounced : (fluid particles,) bool array
        Which of them bounced off such a wall; without rows where none can.
    compression : (moving particles,) float64 array
        rho / rho0 - 1 after the step; of a weakly compressible fluid.
    iterations : int
        Of the linear system that counts: the pressure equation, or the exchange of momentum.
    """

    scene: Scene
    dt: float
    velocity: Floats
    pressure: Floats
    reaction: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    push: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    bounced: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=np.bool_))
    compression: Floats = field(default_factory=lambda: np.zeros(0))
    iterations: int = 0

    @property
    def state(self) -> State:
        """The state at the beginning of the step."""
        return self.scene.state

    def react(self, acceleration: Floats) -> None:
        """Add what walls as surfaces do to the fluid particles, (n, 3) array, m/s2."""
        before = self.reaction
        self.reaction = before + acceleration if len(before) else acceleration

    def react_to_shear(self, velocity: Floats, viscosity: Floats) -> None:
        """Add what such walls do by an explicit viscosity, (n,) array, Pa s, at a velocity."""
        scene, p = self.scene, self.particles
        if isinstance(scene.solid, Boundary):
            shear = np.empty((p.fluid_count, 3))
            wall_shear(velocity, p.density, viscosity, scene.near, scene.solid, shear)
            self.react(shear)

    @property
    def particles(self) -> Particles:
        """The particles at the beginning of the step."""
        return self.scene.state.particles


class Term:
    """One term of a step; what it does not override it leaves alone.

    Attributes
    ----------
    name : str
        Under which its wall time is kept.
    """

    name = ""

    def observe(self, scene: Scene) -> None:
        """Find out what the term, or a later one, needs to know of the particles."""

    def limit(self, scene: Scene) -> float:
        """Return the greatest time step, s, that the term allows."""
        return inf

    def act(self, step: Step) -> None:
        """Change velocity, pressure or compression of the step.

        Raises
        ------
        NotConvergedError
            If a linear system was not solved.
        DivergedError
            If a velocity is not finite.
        """

    def refresh(self) -> None:
        """Forget what was kept from earlier steps, so that a resumed run repeats the bits."""
