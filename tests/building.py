"""Patches of particles, their neighbors and small cases that several tests build."""

from typing import NamedTuple

import numpy as np

from debrisflow._jit import kernel
from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.neighbors.beyond import Beyond
from debrisflow.neighbors.boundary import Walls, boundary_of
from debrisflow.neighbors.boxes import Boxes
from debrisflow.neighbors.half_space import PULLED_BACK
from debrisflow.neighbors.lattice import reference
from debrisflow.neighbors.lists import Neighbors, group
from debrisflow.neighbors.octant import octants
from debrisflow.neighbors.pairs import Near, repeats_of
from debrisflow.neighbors.surfaces import Surfaces
from debrisflow.neighbors.wall_access import Solid
from debrisflow.particles.maxima import no_maxima
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.physics.compressible import (
    Fluid,
    Numbers,
    density_of,
    pair_forces_at,
    wall_forces_at,
)
from debrisflow.physics.drag import DragLaw
from debrisflow.physics.operators import strain_rate, velocity_gradient_at
from debrisflow.physics.rheology import consistency_at, power_law_viscosity
from debrisflow.physics.rheology.coulomb import Coulomb
from debrisflow.physics.rheology.herschel_bulkley import HerschelBulkley
from debrisflow.physics.rheology.none import NoStrength
from debrisflow.physics.rheology.obrien_julien import OBrienJulien
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.surfaces import elements_from
from debrisflow.schemes.terms.term import Scene

NOWHERE = np.zeros(3)  # periods of a domain that does not repeat
RADII = [(2, 3.1), (2, 2.1), (3, 2.4), (3, 2.1)]  # dimension, influence radius in spacings
NO_STRENGTH = NoStrength()
CAPS = {"smallest_shear_rate": 0.001, "largest_viscosity": 1e6}
RAMP = {"ramp_start": 0.20, "ramp_end": 0.35}
COULOMB = Coulomb(friction=0.7, **RAMP, **CAPS)
HERSCHEL_BULKLEY = HerschelBulkley(yield_stress=30.0, consistency=5.0, exponent=0.4, **RAMP, **CAPS)
# of the size of the muds of O'Brien & Julien 1988
MUD = OBrienJulien(
    yield_stress=0.0181, yield_growth=25.7, consistency=0.0036, viscosity_growth=22.1, **CAPS
)
GIDASPOW = DragLaw(
    ergun_from=0.2,
    diameter=0.003,
    density=1000.0,
    viscosity=1e-3,
    grain_density=2650.0,
    packing_limit=0.55,
)
WEN_YU = GIDASPOW._replace(ergun_from=np.inf)


def lattice_block(dimension, counts, spacing=1.0):
    """Return the points of a block of cells from the origin, 0 along axes beyond the dimension."""
    axes = [np.arange(n) + 0.5 for n in np.broadcast_to(counts, dimension)]
    points = np.zeros((np.prod([a.size for a in axes]), 3))
    for axis, values in enumerate(np.meshgrid(*axes, indexing="ij")):
        points[:, axis] = spacing * values.ravel()
    return points


def random_patch(dimension, count, rng, length=1.0):
    """Return particles anywhere in a cube, 0 along axes beyond the dimension."""
    position = np.zeros((count, 3))
    position[:, :dimension] = rng.uniform(0.0, length, (count, dimension))
    return position


def one_list(
    position, lattice, rows=None, period=NOWHERE, wall_from=None, supply_from=None, lists=None
):
    """Return who is near whom, with fluid, supply and walls in one list.

    As :class:`debrisflow.schemes.vicinity.OneList` has it: the first ``rows`` particles, all by
    default, have a row of neighbors and a pressure; walls are those from ``wall_from`` on, by
    default those without a row.  Neighbors are listed unless lists are given.
    """
    rows = len(position) if rows is None else rows
    wall_from = rows if wall_from is None else wall_from
    if lists is None:
        lists = Neighbors(lattice.effective_radius, lattice.spacing, period)
        lists.build(position, rows)
    moving, pressed = np.empty((2, rows), dtype=np.int32)
    group(lists.index, lists.count, wall_from, rows, moving, pressed)
    return _near(
        lattice,
        period,
        position=position,
        neighbors=lists.index,
        fluid_count=moving,
        wall=lists.index,
        wall_row=np.arange(rows, dtype=np.int32),
        wall_start=moving,
        wall_count=lists.count - moving,
        pressed_count=pressed,
        wall_from=wall_from,
        supply_from=wall_from if supply_from is None else supply_from,
    )


def two_lists(position, lattice, period=NOWHERE, supply_from=None):
    """Return who is near whom where walls are surfaces, as in ``vicinity.ListAndSurfaces``."""
    count = len(position)
    lists = Neighbors(lattice.effective_radius, lattice.spacing, period)
    lists.build(position, count)
    return _near(
        lattice,
        period,
        position=position,
        neighbors=lists.index,
        fluid_count=lists.count,
        wall=None,
        wall_row=None,
        wall_start=None,
        wall_count=None,
        pressed_count=None,
        wall_from=0,
        supply_from=count if supply_from is None else supply_from,
    )


def _near(lattice, period, **lists):
    return Near(
        period=repeats_of(period),
        spacing=lattice.spacing,
        effective_radius=lattice.effective_radius,
        dimension=float(lattice.dimension),
        number_density=lattice.number_density,
        laplacian_lambda=lattice.laplacian_lambda,
        **lists,
    )


def solid_of(
    position,
    normal=(0.0, 0.0, 1.0),
    depth=0.0,
    slip=0.0,
    roughness=0.0,
    velocity=None,
    layers=1.0,
):
    """Return wall particles that are all alike but for what is given as an array."""
    count = len(position)

    def vectors(value):
        return np.array(np.broadcast_to(value, (count, 3)), dtype=float)

    depths, slips, roughnesses, layers = (
        np.full(count, 1.0) * value for value in (depth, slip, roughness, layers)
    )
    return Solid(
        position=position,
        normal=vectors(normal),
        depth=depths,
        slip=slips,
        roughness=roughnesses,
        velocity=None if velocity is None else vectors(velocity),
        contact_height=np.where(layers == 1.0, np.inf, -np.inf),  # at any height
    )


def no_solid():
    """Return no wall particles, for which kernels are compiled as for walls that may move."""
    return solid_of(np.zeros((0, 3)), velocity=0.0)


class Plane(NamedTuple):
    """A wall that fills the half space under a plane."""

    point: tuple[float, ...] = (0.0, 0.0, 0.0)
    normal: tuple[float, ...] = (0.0, 0.0, 1.0)
    slip: float = 0.0


def no_walls(count):
    """Return what particles feel that are far from all surfaces."""
    far = np.full(count, -1, dtype=np.int32)
    return boundary_of(far, smooth_walls(np.zeros(1)), Beyond(2.4, 3.0), 11)


def smooth_walls(slip):
    """Return what walls at rest are like that differ by their slip only."""
    slip = np.array(slip, dtype=float)
    return Walls(slip, np.zeros(slip.size), motion=None)


def planes(position, lattice, *walls):
    """Return what particles feel of half spaces, each a wall of its own."""
    count, d0 = len(walls), lattice.spacing
    upper = np.tile([np.inf, np.inf, 0.0], (count, 1))
    boxes = boxes_from(
        np.full((count, 3), -np.inf),
        upper,
        origin=[wall.point for wall in walls],
        axes=[frame_of(wall.normal) for wall in walls],
        inner_upper=upper - [0.0, 0.0, PULLED_BACK * d0],
    )
    return felt(position, lattice, boxes, [wall.slip for wall in walls])


def frame_of(normal):
    """Return a rotation, by rows, whose third row is the normal."""
    normal = np.array(normal) / np.linalg.norm(normal)
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])


def boxes_from(lower, upper, **known):
    """Return boxes along the axes, each a wall of its own, but for what is known of them."""
    lower, upper = np.atleast_2d(lower).astype(float), np.atleast_2d(upper).astype(float)
    count = len(lower)
    fields = {
        "origin": np.zeros((count, 3)),
        "axes": np.tile(np.eye(3), (count, 1, 1)),
        "lower": lower,
        "upper": upper,
        "inner_lower": lower,
        "inner_upper": upper,
        "number": np.tile(np.arange(count)[:, None, None], (1, 3, 2)),
        "is_floor": np.zeros(count, dtype=bool),
        "is_thin": np.zeros((count, 3), dtype=bool),
    }
    return Boxes(**(fields | {name: np.array(value) for name, value in known.items()}))


def felt(position, lattice, boxes, slip=(0.0,), elements=None, ground=None):
    """Return what particles feel of boxes and of the elements of closed surfaces."""
    surfaces = Surfaces(
        boxes,
        octants(lattice.effective_radius / lattice.spacing),
        lattice.spacing,
        smooth_walls(slip),
        no_elements() if elements is None else elements,
        ground=ground,
        skin=0.0,
        period=NOWHERE,
    )
    surfaces.build(position, 0.0)
    return surfaces.survey(position)


def no_elements():
    """Return no elements of closed surfaces."""
    nothing = np.zeros((0, 3, 6)), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_)
    return elements_from(*nothing)


def scene_of(particles, near, solid=None):
    """Return the scene of a state at its start; by default without walls."""
    state = State(particles=particles, maxima=no_maxima(0))
    velocity = particles.velocity[particles.moving].copy()
    return Scene(state, near, no_solid() if solid is None else solid, velocity)


def center_of_block(dimension, radius, spacing=1.0):
    """Return positions and neighbors of a block of lattice, and its central particle.

    The block is wide enough that the neighbors of the central particle have all of theirs.
    """
    position = lattice_block(dimension, 4 * int(radius) + 1, spacing)
    return position, one_list(position, reference(dimension, radius, spacing)), len(position) // 2


def separations(position, period=NOWHERE, others=None):
    """Return ``r_j - r_i`` of every pair, or from all to all others, through the nearest image."""
    others = position if others is None else others
    between = others[None, :, :] - position[:, None, :]
    repeat = np.where(period > 0.0, period, 1.0)
    return between - np.where(period > 0.0, repeat * np.rint(between / repeat), 0.0)


def within(position, radius, period=NOWHERE):
    """Return the (n, n) matrix that is 1 where two particles are nearer than the radius."""
    near = np.sum(separations(position, period) ** 2, axis=2) < radius**2
    return (near & ~np.eye(len(position), dtype=bool)).astype(int)


def times_listed(index, count, particles):
    """Return the (rows, n) matrix of how often each particle stands in each row of a list."""
    times = np.zeros((count.size, particles), dtype=int)
    for i, listed in enumerate(count):
        np.add.at(times[i], index[i, :listed], 1)
    return times


def numbers_of(lattice, **changes):
    """Return the constants of the explicit scheme, of water with c = 20 m/s."""
    return Numbers(
        smooth_density=lattice.smooth_density,
        smooth_steepness=lattice.smooth_steepness,
        density=1000.0,
        sound_speed=20.0,
        viscosity=0.0,
        gravity=np.array([1.0, 2.0, -9.0]),
        diffusion=0.1,
        relaxation=0.1,
        artificial_viscosity=0.05,
        collision_distance=0.8 * lattice.spacing,
        restitution=0.2,
    )._replace(**changes)


def fluid_of(count, **known):
    """Return fluid particles at rest, all of density rho0; what is not known of them is 0.

    The total pressure is ``pressure`` and ``grain_pressure``, if they are known.
    """
    fields = {name: np.zeros(count) for name in Fluid._fields}
    fields |= {"velocity": np.zeros((count, 3)), "density": None}
    grains = known.pop("grain_pressure", 0.0)
    fields["total_pressure"] = known.get("pressure", fields["pressure"]) + grains
    return Fluid(**(fields | known))


@kernel
def acceleration_at(i, fluid, near, solid, numbers):
    """Return acceleration, change of velocity by collisions, and what walls push and drag by."""
    x, y, z, cx, cy, cz = pair_forces_at(i, fluid, near, numbers)
    px, py, pz, sx, sy, sz = wall_forces_at(i, fluid, near, solid, numbers)
    per, g = 1.0 / density_of(i, fluid.density, numbers), numbers.gravity
    ax, ay, az = per * (x + px + sx), per * (y + py + sy), per * (z + pz + sz)
    px, py, pz, sx, sy, sz = per * px, per * py, per * pz, per * sx, per * sy, per * sz
    return ax + g[0], ay + g[1], az + g[2], cx, cy, cz, px, py, pz, sx, sy, sz


def tank_case(columns, rows, material, tank=None, spacing=0.01, **tables):
    """Return a case: a block in the left corner of a tank whose size is given in spacings."""
    length, height = tank or (columns, 2 * rows)
    block = {"type": "block", "x": [0.0, columns * spacing], "y": [0.0, rows * spacing]}
    tables = {"time": {"end": 1.0}, "output": {"interval": 1.0}} | tables
    return complete(
        Case(
            title="tank",
            particles={"spacing": spacing},
            geometry={"type": "tank", "length": length * spacing, "height": height * spacing},
            fill=[block | {"material": material}],
            **tables,
        )
    )


def tank3d_case(z=(0.0, 0.5), size=(0.8, 0.6, 1.0), particles=None, **tables):
    """Return a case: water between two heights in a tank of three dimensions, spacing 0.1 m."""
    length, width, height = size
    block = {"type": "block", "x": [0.0, length], "y": [0.0, width], "z": z, "material": "water"}
    tables = {"fill": [block], "time": {"end": 1.0}, "output": {"interval": 1.0}} | tables
    tank = {"type": "tank3d", "length": length, "width": width, "height": height}
    return complete(
        Case(
            title="tank3d",
            particles={"spacing": 0.1} | (particles or {}),
            geometry=tank | tables.pop("geometry", {}),
            **tables,
        )
    )


def settling_case(**tables):
    """Return a case whose grains settle, so that some exchange places within 40 steps."""
    block = {"type": "block", "x": [0.0, 0.24], "y": [0.0, 0.2], "material": "two-phase"}
    tables = {"time": {"end": 1.0}, "output": {"interval": 1.0}} | tables
    return complete(
        Case(
            title="settling",
            particles={"spacing": 0.01},
            geometry={"type": "tank", "length": 0.24, "height": 0.3, "periodic": True},
            fill=[block | {"sediment_share": 0.25}],
            collision_stress={"enabled": True},
            drag={"law": "wen-yu"},
            **tables,
        )
    )


def bed_case(spacing=0.02, **tables):
    """Return a case in which everything acts: a supply of water and sediment runs over a bed."""
    tables = {"time": {"end": 1.0}, "output": {"interval": 1.0}} | tables
    return complete(
        Case(
            title="bed",
            particles={"spacing": spacing},
            gravity={"slope": 15.0},
            geometry={
                "type": "channel",
                "length": 1.0,
                "height": 0.4,
                "bed_start": 0.2,
                "bed_thickness": 0.1,
            },
            fill=[{"type": "bed"}],
            inflow={"depth": 0.04, "velocity": 1.0, "concentration": 0.2},
            collision_stress={"enabled": True},
            drag={"law": "gidaspow"},
            rheology={"type": "coulomb", "mixing_length": 0.006},
            **tables,
        )
    )


def started(case):
    """Return scheme and state of a case before its first step."""
    return scheme_of(case), initial_state(case)


def momentum_of(particles):
    """Return the momentum of the fluid in particle volumes, kg/m3 m/s."""
    return particles.density[particles.fluid] @ particles.velocity[particles.fluid]


def energy_of(density, velocity):
    """Return the kinetic energy of particles in particle volumes, J/m3."""
    return 0.5 * float(density @ np.sum(velocity**2, axis=1))


def shear_rate_at(i, velocity, near, solid):
    """Return the shear rate at a particle, 1/s."""
    return strain_rate(*velocity_gradient_at(i, velocity, near, solid))


def consistency_viscosity(concentration, shear_rate, law):
    """Return what the consistency of a law adds to the viscosity, Pa s."""
    consistency = consistency_at(concentration, law)
    return 0.0 if consistency is None else power_law_viscosity(consistency, shear_rate, law)
