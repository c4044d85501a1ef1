"""Quantities measured from a set of particles: fronts, deposit, flow, energy (NumPy only).

The writers and the post-processing both call these functions, so that their figures agree.  The
functions take the arrays of all particles in any order and select the fluid by its kind.  All
particles have the volume d0^Ds: m2, per meter of width, in two dimensions, and m3 in three.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.materials import pore_density
from debrisflow.case.resolved import ResolvedExplicitScheme
from debrisflow.particles.record import Kind, Particles
from debrisflow.particles.state import PHASES
from debrisflow.space.gravity import gravity_vector
from debrisflow.space.plan_grid import Grid, Located, locate, plan, wrapped
from debrisflow.space.released import source_of

Floats = NDArray[np.float64]
FRONT_SHARE = 0.995
DEPOSIT_CONCENTRATION = 0.3
LARGEST_GAP = 1.5
LEAST_DENSITY_RATIO = 0.5
NEAR_FLOOR = 1.0  # spacings; up to this height of its center a particle stands on the floor


class DepositProfile(NamedTuple):
    """Deposit and flow in the cells of :func:`debrisflow.space.plan_grid.plan`.

    Attributes
    ----------
    x, y : (n,) float64 array, m
        Centers of the cells; in two dimensions y, which is across, is 0.
    deposit_height, flow_height : (n,) float64 array, m
        Above the fixed floor or the top of an obstacle; 0 where there is none.  The flow is as
        :func:`lowest_pile` has it.
    concentration : (n,) float64 array
        Volume share of sediment up to ``flow_height``; nan where nothing flows or lies.
    """

    x: Floats
    y: Floats
    deposit_height: Floats
    flow_height: Floats
    concentration: Floats


class Flow(NamedTuple):
    """Flow over the cells of :func:`debrisflow.space.plan_grid.plan`; 0 where there is none.

    Attributes
    ----------
    depth : (n,) float64 array, m
    speed : (n,) float64 array, m/s
    momentum_flux : (n,) float64 array, N/m
    whole_depth : (n,) float64 array, m
        With films of one row.
    rests : (n,) bool array
        Where the mean speed of that is less than ``output.rest_speed``.
    """

    depth: Floats
    speed: Floats
    momentum_flux: Floats
    whole_depth: Floats
    rests: NDArray[np.bool_]


class Pile(NamedTuple):
    """The lowest matter over the cells of a grid that hangs together; 0 where there is none.

    Attributes
    ----------
    bottom : (n,) float64 array, m
        Height over the floor at which it begins: 0 if it stands on it.
    depth : (n,) float64 array, m
        From there to its top.
    """

    bottom: Floats
    depth: Floats


class Energies(NamedTuple):
    """Energy of the fluid, J; per meter of width in two dimensions."""

    kinetic: float
    potential: float


def particle_volume(case: ResolvedCase) -> float:
    """Return d0^Ds: m2, per meter of width, in two dimensions, and m3 in three."""
    return float(case.particles.spacing**case.dimension)


def mass(case: ResolvedCase, number: ArrayLike, sediment: ArrayLike) -> Floats:
    """Return the mass of particles, kg; per meter of width in two dimensions.

    Parameters
    ----------
    number : (...) array
        Of the particles.
    sediment : (...) array
        The volume of sediment in them, in particles.
    """
    pores, volume = pore_density(case.water, case.rheology), particle_volume(case)
    excess = case.sediment.density - pores
    return np.asarray(number) * (pores * volume) + np.asarray(sediment) * (excess * volume)


def is_fluid(kind: ArrayLike) -> NDArray[np.bool_]:
    """Return which particles are liquid, sediment or mixture; inflow particles are not fluid."""
    return np.asarray(kind) <= Kind.MIXTURE


def fronts(
    case: ResolvedCase,
    position: Floats,
    velocity: Floats,
    kind: NDArray[np.integer],
    reached: NDArray[np.bool_] | None = None,
    share: float = FRONT_SHARE,
) -> dict[str, float]:
    """Return how far the flow reaches: the x behind which a share of its volume lies, m.

    A particle flows if it is faster than ``output.rest_speed``.  One over a cell that the flow has
    not reached, because fluid stood there at the start and has not risen, counts as behind the
    front wherever it is: a wave moves the water ahead of it too.  Particles count whole, by their
    centers, so that a front is the x of a particle, and that of a flow of fewer than 200 particles
    is the x of the foremost one.  In three dimensions the front is the foremost of the whole width.
    On a terrain it is the distance in plan from the first release, not x.

    Parameters
    ----------
    position, velocity : (n, 3) array, m, m/s
    kind : (n,) int array
    reached : (cells,) bool array, optional
        Over which cells of :func:`debrisflow.space.plan_grid.plan` the flow has come, see
        :meth:`debrisflow.particles.maxima.Maxima.reached`; over all if left out.
    share : float
        99.5 % if left out.

    Returns
    -------
    dict
        x by ``liquid``, ``sediment``, ``mixture`` and ``all``; nan if nothing of it flows.
    """
    flowing = is_fluid(kind) & (np.linalg.norm(velocity, axis=1) > case.output.rest_speed)
    x, phase = wrapped(case, position[flowing])[:, 0], np.asarray(kind)[flowing]
    if case.is_terrain:
        x = np.linalg.norm(position[flowing, :2] - source_of(case), axis=1)
    if reached is not None and not reached.all():
        above = locate(case, plan(case), position[flowing])
        x[above.row[~reached[above.cell]]] = -np.inf
    found = {name: _front(x[phase == number], share) for number, name in enumerate(PHASES)}
    return found | {"all": _front(x, share)}


def _front(x: Floats, share: float) -> float:
    if x.size == 0:
        return np.nan
    front = float(np.quantile(x, share, method="inverted_cdf"))
    return front if np.isfinite(front) else np.nan


def deposit_profile(
    case: ResolvedCase,
    position: Floats,
    velocity: Floats,
    kind: NDArray[np.integer],
    concentration: Floats,
    sediment_fraction: Floats,
    number_density: Floats,
    reference_number_density: float,
) -> DepositProfile:
    """Return deposit height, flow height and concentration in cells 2 d0 wide.

    Heights are measured from the floor under the middle of the cell, along its normal: the fixed
    floor, which under a bed is the bottom of its recess, or the top of an obstacle.  A particle
    reaches d0/2 above its center.

    A particle is deposited if it is slower than ``output.rest_speed`` and, unless it is a mixture
    particle, its local concentration is 0.3 or more.  The deposit grows from the floor from one
    deposited particle to the next higher one of the cell, whichever column it stands in, until the
    next is more than 1.5 d0 higher: a layer without deposited particles ends it, but a single
    particle that flows or is surrounded by water does not.  (The local concentration in a mixed bed
    scatters; if any particle below 0.3 ended the deposit, it would be measured too thin.)

    The flow height is the depth of the :func:`lowest_pile` of the particles with n >= 0.5 n0, and
    the concentration that of all particles in it.

    Parameters
    ----------
    position, velocity : (n, 3) array, m, m/s
    kind : (n,) int array
    concentration, sediment_fraction, number_density : (n,) array
    reference_number_density : float
        n0 of the lattice.
    """
    d0, grid = case.particles.spacing, plan(case)
    rows, cell, height = above = locate_fluid(case, grid, position, kind)
    pile = _flowing_pile(case, above, number_density, reference_number_density)

    lying = deposited(case, above, velocity, kind, concentration)
    deposit = _greatest_height(lying.cell, lying.height, grid.x.size, d0)
    top = (pile.bottom + pile.depth)[cell]
    within = (height + 0.5 * d0 <= top) & (height + 0.5 * d0 > pile.bottom[cell])
    share = _mean_by_cell(sediment_fraction[rows], cell, within, grid)
    return DepositProfile(grid.x, grid.y, deposit, pile.depth, share)


def locate_fluid(
    case: ResolvedCase, grid: Grid, position: Floats, kind: NDArray[np.integer]
) -> Located:
    """Return the fluid particles above the cells of a grid; rows are those of the arrays."""
    fluid = np.flatnonzero(is_fluid(kind))
    found = locate(case, grid, position[fluid])
    return found._replace(row=fluid[found.row])


def deposited(
    case: ResolvedCase,
    above: Located,
    velocity: Floats,
    kind: NDArray[np.integer],
    concentration: Floats,
) -> Located:
    """Return the particles of the deposit as :func:`deposit_profile` defines it.

    Parameters
    ----------
    above : Located
        The fluid over the cells.
    velocity : (n, 3) array, m/s
    kind : (n,) int array
    concentration : (n,) array
    """
    rows, cell, height = above
    slow = np.linalg.norm(velocity[rows], axis=1) < case.output.rest_speed
    packed = (kind[rows] == Kind.MIXTURE) | (concentration[rows] >= DEPOSIT_CONCENTRATION)
    chosen = np.flatnonzero(slow & packed & (height > 0.0))
    lying = chosen[piled(cell[chosen], height[chosen], case.particles.spacing)]
    return Located(rows[lying], cell[lying], height[lying])


def piled(cell: NDArray[np.int64], height: Floats, d0: float) -> NDArray[np.bool_]:
    """Return which particles follow each other upward from the floor of their cell.

    From one to the next without a gap of more than 1.5 d0; the floor counts as a particle d0/2
    below it.

    Parameters
    ----------
    cell : (n,) int array
    height : (n,) array, m
        Of the centers.
    d0 : float, m
    """
    order = np.lexsort((height, cell))
    cell, height = cell[order], height[order]
    is_lowest = np.diff(cell, prepend=-1) > 0
    below = np.where(is_lowest, -0.5 * d0, np.roll(height, 1))
    is_gap = height - below > LARGEST_GAP * d0
    gaps: NDArray[np.int64] = np.cumsum(is_gap)
    in_cells_before = (gaps - is_gap)[is_lowest][np.cumsum(is_lowest) - 1]
    found = np.empty(order.size, dtype=bool)
    found[order] = gaps == in_cells_before
    return found


def lowest_pile(cell: NDArray[np.int64], height: Floats, cells: int, d0: float) -> Pile:
    """Return the lowest matter over each cell that hangs together.

    Of particles that follow each other upward without a gap of more than 1.5 d0.  It begins on the
    floor, or d0/2 below the lowest particle if the center of this is more than d0 above the floor,
    in a jet over air or on top of a mesh.  Spray over a flow therefore does not make it deeper, and
    what flies over a dry floor is as deep as it is thick.

    Parameters
    ----------
    cell : (n,) int array
    height : (n,) array, m
        Of the centers, over the floor.
    cells : int
        How many there are.
    d0 : float, m

    Examples
    --------
    Water up to 3 with a drop over it, and a jet between 4 and 6.

    >>> cell, height = np.array([0, 0, 0, 0, 1, 1]), np.array([0.5, 1.5, 2.5, 7.5, 4.5, 5.5])
    >>> print(*lowest_pile(cell, height, 3, 1.0))
    [0. 4. 0.] [3. 2. 0.]
    """
    lowest = np.full(cells, np.inf)
    np.minimum.at(lowest, cell, height)
    flies = np.isfinite(lowest) & (lowest > NEAR_FLOOR * d0)
    bottom = np.where(flies, lowest - 0.5 * d0, 0.0)
    above = height - bottom[cell]
    pile = piled(cell, above, d0)
    return Pile(bottom, _greatest_height(cell[pile], above[pile], cells, d0))


def flow_height(
    case: ResolvedCase,
    position: Floats,
    kind: NDArray[np.integer],
    number_density: Floats,
    reference_number_density: float,
) -> Floats:
    """Return the flow height of :func:`deposit_profile` over each cell, (cells,) array, m."""
    above = locate_fluid(case, plan(case), position, kind)
    return _flowing_pile(case, above, number_density, reference_number_density).depth


def _flowing_pile(
    case: ResolvedCase, above: Located, number_density: Floats, reference_number_density: float
) -> Pile:
    """Return the lowest pile of the particles with n >= 0.5 n0."""
    dense = number_density[above.row] >= LEAST_DENSITY_RATIO * reference_number_density
    counted = dense & (above.height > -0.5 * case.particles.spacing)
    cells = plan(case).x.size
    return lowest_pile(above.cell[counted], above.height[counted], cells, case.particles.spacing)


def whole_depth(
    case: ResolvedCase, position: Floats, velocity: Floats, kind: NDArray[np.integer]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the depth of all fluid over each cell, films of one row too, and where it rests.

    The depth of the :func:`lowest_pile`, m; it rests where its mean speed is less than
    ``output.rest_speed``.
    """
    grid = plan(case)
    row, cell, height = locate_fluid(case, grid, position, kind)
    pile = lowest_pile(cell, height, grid.x.size, case.particles.spacing)
    speed = np.linalg.norm(velocity[row], axis=1)
    mean_speed = _mean_by_cell(speed, cell, np.ones(cell.size, dtype=bool), grid)
    return pile.depth, mean_speed < case.output.rest_speed


def _greatest_height(cell: NDArray[np.int64], height: Floats, cells: int, d0: float) -> Floats:
    """Return how high the particles of each cell reach, m; 0 where there are none."""
    greatest = np.zeros(cells)
    np.maximum.at(greatest, cell, height + 0.5 * d0)
    return greatest


def _mean_by_cell(
    value: Floats, cell: NDArray[np.int64], chosen: NDArray[np.bool_], grid: Grid
) -> Floats:
    count = np.bincount(cell[chosen], minlength=grid.x.size)
    total = np.bincount(cell[chosen], value[chosen], minlength=grid.x.size)
    mean = np.full(grid.x.size, np.nan)
    np.divide(total, count, out=mean, where=count > 0)
    return mean


def flow(case: ResolvedCase, particles: Particles, reference_number_density: float) -> Flow:
    """Return depth, mean speed and momentum flux of the flow over each cell.

    The depth is the flow height of :func:`deposit_profile`, including material at rest.  Of the
    particles with n >= 0.5 n0 up to that height, the speed is the mean of ``|u|``, and the momentum
    flux is ``sum rho V |u|^2 / A``, the integral of rho u^2 over the depth, with the volume V =
    d0^Ds of a particle and the area A of the cell.

    Parameters
    ----------
    case : ResolvedCase
    particles : Particles
    reference_number_density : float
        n0 of the lattice.
    """
    d0, grid, fluid = case.particles.spacing, plan(case), particles.fluid
    position, velocity = particles.position[fluid], particles.velocity[fluid]
    number_density = particles.number_density[fluid]
    row, cell, height = above = locate(case, grid, position)
    pile = _flowing_pile(case, above, number_density, reference_number_density)
    counted = number_density[row] >= LEAST_DENSITY_RATIO * reference_number_density
    counted &= (height > -0.5 * d0) & (height < (pile.bottom + pile.depth)[cell])
    row, cell = row[counted], cell[counted]

    speed = np.linalg.norm(velocity[row], axis=1)
    mean_speed = np.nan_to_num(_mean_by_cell(speed, cell, np.ones(cell.size, dtype=bool), grid))
    momentum = particles.density[fluid][row] * particle_volume(case) * speed**2
    flux = np.bincount(cell, momentum, minlength=grid.x.size) / grid.area
    whole = whole_depth(case, position, velocity, particles.kind[fluid])
    return Flow(pile.depth, mean_speed, flux, *whole)


def energies(
    case: ResolvedCase,
    position: Floats,
    velocity: Floats,
    density: Floats,
    kind: NDArray[np.integer],
) -> Energies:
    """Return kinetic and potential energy of the fluid, J; per meter of width in two dimensions.

    ``E_k = sum rho V u^2 / 2`` and ``E_p = -sum rho V g . x``, zero at the origin, with the volume
    V = d0^Ds of a particle.

    Parameters
    ----------
    position, velocity : (n, 3) array, m, m/s
    density : (n,) array, kg/m3
    kind : (n,) int array
    """
    fluid = is_fluid(kind)
    mass = density[fluid] * particle_volume(case)
    speed_squared = np.einsum("ij,ij->i", velocity[fluid], velocity[fluid])
    fall = position[fluid] @ gravity_vector(case)
    return Energies(0.5 * float(mass @ speed_squared), -float(mass @ fall))


def elastic_energy(
    case: ResolvedCase,
    density: Floats,
    kind: NDArray[np.integer],
    compression: Floats,
) -> float:
    """Return the energy that compression stores in the fluid, J; 0 if it is incompressible.

    With p = rho0 c^2 s, the force ``-grad p / rho0`` and the continuity ``ds/dt = -(1 + s) div u``
    of the explicit scheme, the work against pressure is stored in a unit of mass as

        e = integral of c^2 s / (1 + s) ds from 0 to s = c^2 [s - ln(1 + s)],

    about ``c^2 s^2 / 2``; it is 0 where s < 0, because the fluid has no tensile strength.

    Parameters
    ----------
    density : (n,) array, kg/m3
        rho0, so that the mass is ``rho0 d0^Ds``.
    kind : (n,) int array
    compression : (n,) array
        s.
    """
    if not isinstance(case.scheme, ResolvedExplicitScheme):
        return 0.0
    fluid = is_fluid(kind)
    s = np.maximum(compression[fluid], 0.0)
    mass = density[fluid] * particle_volume(case)
    return case.scheme.sound_speed**2 * float(mass @ (s - np.log1p(s)))


def wetted_width(y: Floats, d0: float) -> float:
    """Return the length that particles cover, across gaps of up to 1.5 spacings, m.

    Examples
    --------
    >>> wetted_width(np.array([0.25, 2.75, 1.5]), 1.0)
    3.5
    >>> wetted_width(np.array([0.5, 5.5]), 1.0)
    2.0
    """
    gaps = np.diff(np.sort(y))
    return d0 * float(y.size > 0) + float(np.where(gaps <= LARGEST_GAP * d0, gaps, d0).sum())
