"""Energy above its budget: more than gravity, inflow and moving walls have brought."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import ResolvedExplicitScheme
from debrisflow.errors import DivergedError
from debrisflow.particles.place import moment, named_particle
from debrisflow.particles.state import State
from debrisflow.run.measures import particle_volume
from debrisflow.schemes.choice import AnyScheme
from debrisflow.space.domain import domain
from debrisflow.space.gravity import gravity_vector
from debrisflow.space.scene import trajectories

Floats = NDArray[np.float64]

MOST_UNEXPLAINED = 0.5
"""Of the kinetic energy and M g d0.  The greatest in the shipped cases is 0.083, while grains find
their places in a column at rest; where something flows it is below 0.02."""
SLOWEST = 0.01
"""Spacings in a largest time step; slower motion is no energy that counts."""
GLANCES = 5
"""Times between two rows at which walls that move are asked for their speed."""


class EnergyBudget:
    """Follows the energy of the particles that are there at two rows of the history.

    Kinetic, potential and elastic energy of these together can only fall: by friction, viscosity
    and impacts.  What enters counts when it is there, what leaves no more.  From their change is
    taken what else brings energy:

    - gravity along an axis that repeats, ``sum m g_x u_x`` by the trapezoidal rule;
    - the push of the supply, its greatest pressure times the volume that enters;
    - walls that move at w for a time t, at most ``M (g w t + 2 w^2)``: they lift all fluid and
      strike it to twice their speed.

    The rest, summed from the time at which its sum was least, is unexplained where it rises.

    Parameters
    ----------
    case : ResolvedCase
    scheme : Scheme
    """

    def __init__(self, case: ResolvedCase, scheme: AnyScheme) -> None:
        self._case = case
        gravity, repeats = gravity_vector(case), domain(case).period > 0.0
        self._gravity = float(np.linalg.norm(gravity))
        self._held, self._free = np.where(repeats, 0.0, gravity), np.where(repeats, gravity, 0.0)
        self._volume, self._ways = particle_volume(case), trajectories(case)
        is_compressible = isinstance(case.scheme, ResolvedExplicitScheme)
        self._sound_speed = case.explicit_scheme.sound_speed if is_compressible else 0.0
        self._slowest = SLOWEST * case.particles.spacing / case.time.largest_step
        self._before: Floats | None = None
        self._time = self._power = self._pressure = 0.0
        self._unexplained = 0.0

    def check(self, state: State) -> None:
        """Take the energies of a row, and compare what is unexplained with its bound.

        Raises
        ------
        DivergedError
        """
        p, before = state.particles, self._before
        mass = p.density[p.fluid] * self._volume
        velocity = p.velocity[p.fluid]
        kinetic = 0.5 * mass * np.einsum("ij,ij->i", velocity, velocity)
        energy = self._energy(state, mass, kinetic)
        power = float(mass @ (velocity @ self._free))
        pressure = float(p.pressure[p.inflow].max(initial=0.0))
        if before is not None and p.fluid_count:
            gain, entered = _gains(energy, p.id[p.fluid], before)
            brought = 0.5 * (power + self._power) * (state.time - self._time)
            brought += max(pressure, self._pressure) * self._volume * entered
            brought += float(mass.sum()) * self._by_walls(state.time)
            self._unexplained = max(0.0, self._unexplained + float(gain.sum()) - brought)
            self._compare(state, float(kinetic.sum()), float(mass.sum()), gain)
        self._before = np.full(int(p.id[p.fluid].max(initial=-1)) + 1, np.nan)
        self._before[p.id[p.fluid]] = energy
        self._time, self._power, self._pressure = state.time, power, pressure

    def _energy(self, state: State, mass: Floats, kinetic: Floats) -> Floats:
        """Return the energy of each fluid particle, J; in two dimensions J/m."""
        p = state.particles
        energy: Floats = kinetic - mass * (p.position[p.fluid] @ self._held)
        if self._sound_speed > 0.0:
            s = np.maximum(p.compression[p.fluid], 0.0)
            energy += self._sound_speed**2 * mass * (s - np.log1p(s))
        return energy

    def _by_walls(self, time: float) -> float:
        """Return the energy that moving walls can have given to a mass since the last row, J/kg."""
        if not self._ways:
            return 0.0
        times = np.linspace(self._time, time, GLANCES)
        speed = max(way.speed(at) for way in self._ways.values() for at in times)
        return float(self._gravity * speed * (time - self._time) + 2.0 * speed**2)

    def _compare(self, state: State, kinetic: float, mass: float, gain: Floats) -> None:
        d0 = self._case.particles.spacing
        scale = kinetic + mass * (self._gravity * d0 + 0.5 * self._slowest**2)
        if self._unexplained <= MOST_UNEXPLAINED * scale:
            return
        row = int(np.argmax(gain))
        speed = float(np.linalg.norm(state.particles.velocity[row]))
        unit = "J/m" if self._case.dimension == 2 else "J"
        raise DivergedError(
            f"{moment(state)}, the fluid has {self._unexplained:.3g} {unit} more energy than "
            f"gravity, inflow and moving walls brought; its kinetic energy is {kinetic:.3g} {unit}."
            f" Most was gained by {named_particle(self._case, state, row)}, now {speed:.3g} m/s",
            "the scheme is unstable there: a time step too long, particles pressed into each "
            "other, or a sharp corner of an obstacle that pushes on both sides",
            "look at the place in the particles at the failure, and try half of time.largest_step "
            "or of scheme.courant",
        )


def _gains(energy: Floats, ids: NDArray[np.int64], before: Floats) -> tuple[Floats, int]:
    """Return what particles have gained since the last row, and how many are new.

    Parameters
    ----------
    energy : (n,) float64 array, J
    ids : (n,) int64 array
    before : (m,) float64 array, J
        By id; nan where there was none.

    Examples
    --------
    >>> gain, new = _gains(np.array([3.0, 1.0, 9.0]), np.array([1, 0, 4]), np.array([1.5, 2.5]))
    >>> print(gain, new)
    [ 0.5 -0.5  0. ] 1
    """
    last = np.full(ids.size, np.nan)
    known = ids < before.size
    last[known] = before[ids[known]]
    was_there = ~np.isnan(last)
    return np.where(was_there, energy - last, 0.0), int(ids.size - np.count_nonzero(was_there))
