"""How many particles a case makes and what memory they need, before any array is made."""

from __future__ import annotations

from math import pi

from debrisflow.case.bodies import MeshFill, MeshObstacle
from debrisflow.case.regions import (
    boxes_among,
    covered,
    recess,
    section_of_supply,
    surface_of,
    volume_left,
)
from debrisflow.case.released import volume
from debrisflow.case.releases import AnyRelease, HydrographRelease
from debrisflow.case.shapes import (
    Channel,
    Channel3D,
    Geometry,
    Tank,
    Tank3D,
    plain_of,
)
from debrisflow.case.tables import (
    AnyFill,
    AnyObstacle,
    AnyScheme,
    Case,
    Inflow,
    Particles,
)
from debrisflow.case.terrain import Terrain

# Measured on dam breaks: 2,700 bytes a particle at an influence radius of 3.1, 5,350 at 5.0.  The
# second term is the neighbor list, the pair geometry and the linear system.
BYTES_A_PARTICLE = 800
BYTES_A_NEIGHBOR = 50
BYTES_OF_THE_PROGRAM = 200_000_000
BYTES_IN_THREE = 600  # 578 to 601 measured on dam breaks of 50,000 particles
ELEMENTS = 30  # of a mesh in a square of a spacing, halved until none is wider than half of it
BYTES_AN_ELEMENT = 200
BYTES_BESIDE_A_MESH = 10_000  # lists of elements of the three rows over a square of it
BYTES_OF_A_COLUMN = 150
SKIN = 0.4


def particle_estimate(case: Case) -> dict[str, float]:
    """Return the numbers of fluid, inflow and wall particles and the memory that they need.

    Returns
    -------
    dict
        ``fluid``, ``inflow`` (all that a channel can hold of the supply), ``wall``, ``total``
        and ``memory`` in bytes.
    """
    return estimate(
        case.particles,
        case.geometry,
        case.obstacle,
        case.fill,
        case.inflow,
        case.scheme,
        case.release,
    )


def estimate(
    particles: Particles,
    geometry: Geometry,
    obstacle: tuple[AnyObstacle, ...],
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
    scheme: AnyScheme,
    release: tuple[AnyRelease, ...] = (),
) -> dict[str, float]:
    """Return the estimate of :func:`particle_estimate` from single tables.

    Areas over the square of the spacing.  In the form study of two dimensions also walls, by their
    length and the layers that the influence radius reaches.
    """
    spacing = particles.spacing
    layers = int(particles.effective_radius) + 1
    if isinstance(geometry, Terrain):
        return _estimate_on_terrain(particles, geometry, obstacle, release)
    if isinstance(geometry, Tank3D | Channel3D):
        return _estimate_in_three(particles, geometry, obstacle, fill, inflow)
    areas = [area for part in fill if (area := covered(part, geometry, particles))]
    supply = inflow.depth if inflow and isinstance(geometry, Channel) else 0.0
    # Divided twice, since the square of a very small spacing would be zero.
    fluid = volume_left(areas, boxes_among(obstacle, 2)) / spacing / spacing
    waiting = supply / spacing * layers + supply * geometry.length / spacing / spacing
    wall = 0.0
    if scheme.form == "study":
        wall = (_wall_length(geometry, particles) / spacing + 4 * layers) * layers
    total = fluid + waiting + wall
    listed = pi * (particles.effective_radius + SKIN) ** 2
    return {
        "fluid": fluid,
        "inflow": waiting,
        "wall": wall,
        "total": total,
        "memory": BYTES_OF_THE_PROGRAM + total * (BYTES_A_PARTICLE + BYTES_A_NEIGHBOR * listed),
    }


def _estimate_in_three(
    particles: Particles,
    geometry: Tank3D | Channel3D,
    obstacle: tuple[AnyObstacle, ...],
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
) -> dict[str, float]:
    """Return the estimate of a tank or channel in three dimensions, whose walls are surfaces.

    The maxima take memory by the plan.
    """
    layers, spacing = int(particles.effective_radius) + 1, particles.spacing
    boxes = [
        area
        for part in fill
        if not isinstance(part, MeshFill) and (area := covered(part, geometry, particles))
    ]
    solids = boxes_among(obstacle, 3)
    meshes = sum(surface_of(part).volume for part in fill if isinstance(part, MeshFill))
    fluid = (volume_left(boxes, solids) + meshes) / spacing / spacing / spacing
    waiting = 0.0
    if inflow and isinstance(geometry, Channel3D):
        section = section_of_supply(inflow, geometry) / spacing / spacing
        waiting = section * (layers + geometry.length / spacing)
    total = fluid + waiting
    memory = BYTES_OF_THE_PROGRAM + BYTES_IN_THREE * total + _memory_of_meshes(obstacle, spacing)
    return {
        "fluid": fluid,
        "inflow": waiting,
        "wall": 0.0,
        "total": total,
        "memory": memory + BYTES_OF_A_COLUMN * _columns(geometry, spacing),
    }


def _estimate_on_terrain(
    particles: Particles,
    terrain: Terrain,
    obstacle: tuple[AnyObstacle, ...],
    release: tuple[AnyRelease, ...],
) -> dict[str, float]:
    """Return the estimate of a terrain: volumes over the cube of the spacing.

    Later releases and hydrographs count as inflow.  The memory of surface and layers is in
    proportion to the number of cells of the DEM.
    """
    spacing, fluid, waiting = particles.spacing, 0.0, 0.0
    for part in release:
        count = volume(part) / spacing / spacing / spacing
        if isinstance(part, HydrographRelease) or part.start > 0.0:
            waiting += count
        else:
            fluid += count
    memory = BYTES_OF_THE_PROGRAM + BYTES_IN_THREE * (fluid + waiting)
    cells = terrain.levels.values.size
    return {
        "fluid": fluid,
        "inflow": waiting,
        "wall": 0.0,
        "total": fluid + waiting,
        "memory": memory + _memory_of_meshes(obstacle, spacing) + BYTES_OF_A_COLUMN * cells,
    }


def _memory_of_meshes(obstacle: tuple[AnyObstacle, ...], spacing: float) -> float:
    """Return the memory that meshes of wall take, by their surface, bytes."""
    surfaces = [surface_of(body) for body in obstacle if isinstance(body, MeshObstacle)]
    squares = sum(surface.area for surface in surfaces) / spacing / spacing
    return squares * (BYTES_AN_ELEMENT * ELEMENTS + BYTES_BESIDE_A_MESH)


def _columns(geometry: Tank3D | Channel3D, spacing: float) -> float:
    """Return the number of cells of the plan, two spacings wide, in which maxima are kept."""
    plain = plain_of(geometry)
    across = plain.back - plain.front if plain else geometry.width
    return geometry.length / spacing * across / spacing / 4.0


def _wall_length(geometry: Tank | Channel, particles: Particles) -> float:
    length = geometry.length
    if isinstance(geometry, Tank):
        sides = 0.0 if geometry.periodic else 2 * geometry.height
        return length * (2 if geometry.ceiling else 1) + sides
    hollow = recess(geometry, particles)
    sides = 0.0 if geometry.periodic else geometry.height + geometry.weir_height
    return length + sides + (2 * geometry.bed_thickness if hollow else 0.0)
