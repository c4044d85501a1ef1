"""How many particles a case makes and what memory they need, before any array is made."""

from __future__ import annotations

import os
from math import pi
from pathlib import Path

from debrisflow.case.bodies import BoxObstacle, MeshFill
from debrisflow.case.regions import covered, recess, section_of_supply, surface_of
from debrisflow.case.shapes import (
    Channel,
    Channel3D,
    Geometry,
    Tank,
    Tank3D,
    plain_of,
)
from debrisflow.case.tables import AnyFill, AnyObstacle, Case, Inflow, Particles

# Measured on dam breaks: 2,700 bytes a particle at an influence radius of 3.1, 5,350 at 5.0.  The
# second term is the neighbor list, the pair geometry and the linear system.
BYTES_A_PARTICLE = 800
BYTES_A_NEIGHBOR = 50
BYTES_OF_THE_PROGRAM = 200_000_000
BYTES_IN_THREE = 400
BYTES_A_CELL = 16  # of the box in which walls are drawn
SKIN = 0.4


def particle_estimate(case: Case) -> dict[str, float]:
    """Return the numbers of fluid, inflow and wall particles and the memory that they need.

    Returns
    -------
    dict
        ``fluid``, ``inflow`` (all that a channel can hold of the supply), ``wall``, ``total``
        and ``memory`` in bytes.
    """
    return estimate(case.particles, case.geometry, case.obstacle, case.fill, case.inflow)


def estimate(
    particles: Particles,
    geometry: Geometry,
    obstacle: tuple[AnyObstacle, ...],
    fill: tuple[AnyFill, ...],
    inflow: Inflow | None,
) -> dict[str, float]:
    """Return the estimate of :func:`particle_estimate` from single tables.

    Areas over the square of the spacing; walls by their length and the layers that the influence
    radius reaches.
    """
    spacing = particles.spacing
    layers = int(particles.effective_radius) + 1
    if isinstance(geometry, Tank3D | Channel3D):
        return _estimate_in_three(particles, geometry, obstacle, fill, inflow)
    areas = [area.volume for part in fill if (area := covered(part, geometry, particles))]
    supply = inflow.depth if inflow and isinstance(geometry, Channel) else 0.0
    # Divided twice, since the square of a very small spacing would be zero.
    fluid = sum(areas) / spacing / spacing
    waiting = supply / spacing * layers + supply * _length(geometry) / spacing / spacing
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
    """Return the estimate of a tank or channel in three dimensions.

    Obstacles by their surface and the layers under it, at most by their volume.
    """
    layers, spacing = int(particles.effective_radius) + 1, particles.spacing
    if isinstance(geometry, Tank3D):
        wall, drawn = _cells_of_tank(geometry, layers, spacing)
    else:
        wall, drawn = _cells_of_channel(geometry, layers, spacing)
    for body in obstacle:
        volume, surface = _volume_and_area(body)
        wall += min(volume / spacing, surface * layers) / spacing / spacing
    volumes = [
        surface_of(part).volume if isinstance(part, MeshFill) else area.volume
        for part in fill
        if (area := covered(part, geometry, particles))
    ]
    fluid = sum(volumes) / spacing / spacing / spacing
    waiting = 0.0
    if inflow and isinstance(geometry, Channel3D):
        section = section_of_supply(inflow, geometry) / spacing / spacing
        waiting = section * (layers + geometry.length / spacing)
    total = fluid + waiting + wall
    return {
        "fluid": fluid,
        "inflow": waiting,
        "wall": wall,
        "total": total,
        "memory": BYTES_OF_THE_PROGRAM + BYTES_IN_THREE * total + BYTES_A_CELL * drawn,
    }


def _cells_of_tank(geometry: Tank3D, layers: int, spacing: float) -> tuple[float, float]:
    """Return the number of wall particles, and of the cells among which they are found."""
    long, wide, high = (s / spacing for s in (geometry.length, geometry.width, geometry.height))
    across = wide if geometry.periodic else wide + 2 * layers
    around = (long + 2 * layers) * across - long * wide
    wall = (long + 2 * layers) * across * layers + around * high
    return wall, (long + 2 * layers) * across * (high + layers)


def _cells_of_channel(geometry: Channel3D, layers: int, spacing: float) -> tuple[float, float]:
    """Return the same of a channel; of a plain only the head wall is found among cells."""
    long, wide, high = (s / spacing for s in (geometry.length, geometry.width, geometry.height))
    deep, crest = geometry.bed_thickness / spacing, geometry.weir_height / spacing
    ends = 0.0 if geometry.periodic else 4.0 * layers
    beyond, plain, head = 0.0, plain_of(geometry), 0.0
    if plain is not None:
        outer = (plain.back - plain.front) / spacing + 4.0 * layers
        beyond = (long + 0.5 * ends - plain.start / spacing) * outer * layers
        long, ends = plain.start / spacing, 0.5 * ends
        head = (outer - wide) * (high + layers)
    across, sides = wide + 2 * layers, 2.0 * layers * (high + deep)
    closed = 0.0 if geometry.periodic else layers * wide * (high + crest)
    wall = (long + ends) * (across * layers + sides) + 2.0 * deep * wide * layers + closed
    drawn = (long + ends) * across * (high + deep + layers) + 4.0 * layers * head
    return wall + beyond + layers * head, drawn


def _volume_and_area(body: AnyObstacle) -> tuple[float, float]:
    if not isinstance(body, BoxObstacle):
        surface = surface_of(body)
        return surface.volume, surface.area
    a, b, c = (end - start for start, end in (body.x, body.y, body.z))
    return a * b * c, 2 * (a * b + b * c + c * a)


def available_memory() -> float | None:
    """Return the memory, in bytes, that can be had now, None where it cannot be told."""
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * int(line.split()[1])
        return float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None


def size(count: float) -> str:
    """Return a number of bytes as people write it.

    Examples
    --------
    >>> size(3.2e7), size(5e9)
    ('32 MB', '5.0 GB')
    """
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:.0f} MB"


def _length(geometry: Tank | Channel) -> float:
    return geometry.width if isinstance(geometry, Tank) else geometry.length


def _wall_length(geometry: Tank | Channel, particles: Particles) -> float:
    length = _length(geometry)
    if isinstance(geometry, Tank):
        sides = 0.0 if geometry.periodic else 2 * geometry.height
        return length * (2 if geometry.ceiling else 1) + sides
    hollow = recess(geometry, particles)
    sides = 0.0 if geometry.periodic else geometry.height + geometry.weir_height
    return length + sides + (2 * geometry.bed_thickness if hollow else 0.0)
