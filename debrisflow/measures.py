"""What is read from a set of particles: fronts, deposit and flow height, energy (NumPy only).

The writers and the post-processing measure alike because both call these functions.  They take
the arrays of all particles, in any order, and choose the fluid by its kind.  All particles have
the volume d0^2 per meter of width.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from debrisflow import geometry
from debrisflow.case import tables
from debrisflow.particles import Kind
from debrisflow.state import PHASES

Floats = NDArray[np.float64]
FRONT_SHARE = 0.995
DEPOSIT_CONCENTRATION = 0.3
LARGEST_GAP = 1.5
LEAST_DENSITY_RATIO = 0.5


class DepositProfile(NamedTuple):
    """Deposit and flow in bins 2 d0 wide along the bed.

    Attributes
    ----------
    x : (n,) float64 array, m
        Centers of the bins.
    deposit_height, flow_height : (n,) float64 array, m
        Above the fixed floor; 0 where there is none.
    concentration : (n,) float64 array
        Volume share of sediment up to ``flow_height``; nan where nothing flows or lies.
    """

    x: Floats
    deposit_height: Floats
    flow_height: Floats
    concentration: Floats


class Energies(NamedTuple):
    """Energy of the fluid per meter of width, J/m."""

    kinetic: float
    potential: float


def gravity_vector(case: tables.Case) -> Floats:
    """Return the acceleration of gravity in the axes of the case, (3,) float64 array, m/s2.

    Examples
    --------
    >>> from types import SimpleNamespace as Case
    >>> gravity = tables.Gravity(acceleration=10.0, slope=30.0)
    >>> gravity_vector(Case(gravity=gravity, dimension=2)).round(3)
    array([ 5.  , -8.66,  0.  ])
    """
    along, upward = case.gravity.components
    return np.array([along, 0.0, upward] if case.dimension == 3 else [along, upward, 0.0])


def phase_fractions(case: tables.Case) -> Floats:
    """Return the volume of sediment in a particle of each phase, (3,) float64 array."""
    return np.array([0.0, 1.0, case.mixture.concentration])


def phase_masses(case: tables.Case) -> Floats:
    """Return the mass of a particle of each phase, (3,) float64 array, kg per meter of width."""
    water, rock = case.water.density, case.sediment.density
    return (water + phase_fractions(case) * (rock - water)) * case.particles.spacing**2


def is_fluid(kind: ArrayLike) -> NDArray[np.bool_]:
    """Return which particles are liquid, sediment or mixture; waiting supply is not."""
    return np.asarray(kind) <= Kind.MIXTURE


def floor_length(case: tables.Case) -> float:
    """Return the extent of a tank or channel along x, m."""
    shape = case.geometry
    return shape.width if isinstance(shape, tables.Tank) else shape.length


def wrapped(case: tables.Case, x: Floats) -> Floats:
    """Return x brought back between 0 and the length where the case repeats along x, m."""
    return np.mod(x, floor_length(case)) if case.geometry.periodic else x


def fronts(
    case: tables.Case, position: Floats, velocity: Floats, kind: NDArray[np.integer]
) -> dict[str, float]:
    """Return how far the flow reaches: the x behind which 99.5 % of its volume lies, m.

    What is faster than ``output.rest_speed`` flows.  Particles count whole, by their centers, so
    that a front is the x of a particle and a flow of fewer than 200 ends at its foremost one.

    Parameters
    ----------
    position, velocity : (n, 3) array, m, m/s
    kind : (n,) int array

    Returns
    -------
    dict
        x by ``liquid``, ``sediment``, ``mixture`` and ``all``; nan if nothing of it flows.
    """
    flowing = is_fluid(kind) & (np.linalg.norm(velocity, axis=1) > case.output.rest_speed)
    x, phase = wrapped(case, position[flowing, 0]), np.asarray(kind)[flowing]
    found = {name: _front(x[phase == number]) for number, name in enumerate(PHASES)}
    return found | {"all": _front(x)}


def _front(x: Floats) -> float:
    if x.size == 0:
        return np.nan
    return float(np.quantile(x, FRONT_SHARE, method="inverted_cdf"))


def deposit_profile(
    case: tables.Case,
    position: Floats,
    velocity: Floats,
    kind: NDArray[np.integer],
    concentration: Floats,
    number_density: Floats,
    reference_number_density: float,
) -> DepositProfile:
    """Return deposit height, flow height and concentration in bins 2 d0 wide along the bed.

    Heights are measured from the fixed floor at the middle of the bin, which under a bed is the
    bottom of its recess, along its normal; a particle reaches d0/2 above its center.

    A particle is deposited if it is slower than ``output.rest_speed`` and, other than a mixture
    particle, sees a concentration of 0.3 or more.  The deposit grows from the floor from one
    deposited particle to the next higher one of the bin, whichever column it stands in, until the
    next is more than 1.5 d0 higher: a layer without any ends it, a single particle that flows or
    stands among water does not.  (The concentration seen by a particle of a mixed bed scatters: if
    any such particle ended the deposit, it would be measured too thin.)

    The flow reaches up to the highest particle with n >= 0.5 n0, so that drops do not count.

    Parameters
    ----------
    position, velocity : (n, 3) array, m, m/s
    kind : (n,) int array
    concentration, number_density : (n,) array
    reference_number_density : float
        n0 of the lattice.
    """
    d0, length = case.particles.spacing, floor_length(case)
    # the last bin of an odd number of spacings is narrower; rounding must not make one of nothing
    edges = np.append(np.arange(0.0, length - 1e-6 * d0, 2.0 * d0), length)
    centers = 0.5 * (edges[:-1] + edges[1:])
    x = wrapped(case, position[:, 0])
    rows = np.flatnonzero(is_fluid(kind) & (x >= 0.0) & (x < length))
    number = np.searchsorted(edges, x[rows], side="right") - 1
    height = geometry.height_over_floor(case, x[rows], position[rows, 1], centers[number])

    slow = np.linalg.norm(velocity[rows], axis=1) < case.output.rest_speed
    packed = (kind[rows] == Kind.MIXTURE) | (concentration[rows] >= DEPOSIT_CONCENTRATION)
    dense = number_density[rows] >= LEAST_DENSITY_RATIO * reference_number_density
    deposited = slow & packed & (height > 0.0)

    deposit, flow = np.zeros((2, centers.size))
    for i in np.unique(number[deposited]):
        deposit[i] = contiguous_height(height[deposited & (number == i)], d0)
    np.maximum.at(flow, number[dense], height[dense] + 0.5 * d0)
    share = _mean_by_bin(
        phase_fractions(case)[kind[rows]], number, height + 0.5 * d0 <= flow[number], centers.size
    )
    return DepositProfile(centers, deposit, flow, share)


def contiguous_height(height: Floats, d0: float) -> float:
    """Return the top of a pile; the floor counts as a particle half a spacing below it."""
    climbing = np.append(-0.5 * d0, np.sort(height))
    gaps = np.flatnonzero(np.diff(climbing) > LARGEST_GAP * d0)
    return float(climbing[gaps[0] if gaps.size else -1] + 0.5 * d0)


def _mean_by_bin(
    value: Floats, number: NDArray[np.int64], chosen: NDArray[np.bool_], bins: int
) -> Floats:
    count = np.bincount(number[chosen], minlength=bins)
    total = np.bincount(number[chosen], value[chosen], minlength=bins)
    mean = np.full(bins, np.nan)
    np.divide(total, count, out=mean, where=count > 0)
    return mean


def energies(
    case: tables.Case,
    position: Floats,
    velocity: Floats,
    density: Floats,
    kind: NDArray[np.integer],
) -> Energies:
    """Return the energy of the fluid, J per meter of width.

    ``E_k = sum rho d0^2 u^2 / 2`` and ``E_p = -sum rho d0^2 g . x``, zero at the origin.

    Parameters
    ----------
    position, velocity : (n, 3) array, m, m/s
    density : (n,) array, kg/m3
    kind : (n,) int array
    """
    fluid = is_fluid(kind)
    mass = density[fluid] * case.particles.spacing**2
    speed_squared = np.einsum("ij,ij->i", velocity[fluid], velocity[fluid])
    fall = position[fluid] @ gravity_vector(case)
    return Energies(0.5 * float(mass @ speed_squared), -float(mass @ fall))
