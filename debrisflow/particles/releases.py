"""Releases onto a terrain: masses that start to move at a time, and hydrographs through lines.

What each has released so far is kept in particles.  A hydrograph owes the volume that has come
through its line, in particles; these are born in slabs a spacing thick beside the line, from the
ground upward, as often as the last slab has moved on by a spacing.
"""

from __future__ import annotations

from math import cos, hypot, radians, sin

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from debrisflow.case import ResolvedCase
from debrisflow.case.released import volume_until
from debrisflow.case.resolved import ResolvedHydrographRelease, ResolvedRelease
from debrisflow.particles.matter import (
    concentrations_of,
    has_pore_pressure,
    leave_out_unasked,
    reference_density,
    set_fraction,
    set_pore_pressure,
)
from debrisflow.particles.record import Kind, Particles, blank
from debrisflow.particles.state import State, count_phases
from debrisflow.space.ground import MassRelease, ground_of
from debrisflow.space.released import columns_of

Floats = NDArray[np.float64]
NEAREST = 0.7
"""Spacings from others that a particle needs to be born."""
ROUND_OFF = 1e-9  # of a particle


def release_due(state: State, case: ResolvedCase, time: float) -> None:
    """Add to a state what is to be released up to a time, s, as fluid."""
    for k, release in enumerate(case.release):
        if time < release.start:
            continue
        if isinstance(release, ResolvedHydrographRelease):
            group = _born(release, state, case, time, int(state.released[k]))
        elif state.released[k] == 0:
            group = mass_of(release, case)
            _lift(group, state.particles, NEAREST * case.particles.spacing)
        else:
            continue
        if group.count:
            _admit(group, state)
            leave_out_unasked(state.particles, case)
            state.released[k] += group.count


def is_pending(case: ResolvedCase, state: State) -> bool:
    """Return whether anything is still to be released."""
    return any(state.time < end_of(release) for release in case.release) or bool(
        waiting(case, state).any()
    )


def waiting(case: ResolvedCase, state: State) -> NDArray[np.int64]:
    """Return how many particles of each release found no room to come in, (releases,) array."""
    owed = np.zeros(len(case.release), dtype=np.int64)
    for k, release in enumerate(case.release):
        if isinstance(release, ResolvedHydrographRelease):
            due = _particles_until(release, state.time, case) - int(state.released[k])
            owed[k] = due if due >= _slab_of(release, state.time, case) else 0
    return owed


def end_of(release: ResolvedRelease) -> float:
    """Return the time at which all of a release has been released, s."""
    if isinstance(release, ResolvedHydrographRelease):
        return release.start + release.hydrograph.time[-1]
    return release.start


def _admit(group: Particles, state: State) -> None:
    """Put new fluid behind the other fluid particles and count it."""
    particles = state.particles
    group.id[:] = state.next_id + np.arange(group.count)
    state.next_id += group.count
    count_phases(group.kind, group.sediment_fraction, state.entered, state.entered_sediment)
    particles.insert(particles.fluid.stop, group)
    particles.fluid_count += group.count


def mass_of(release: MassRelease, case: ResolvedCase) -> Particles:
    """Return a released mass at its place, compressed under its own weight.

        s = (rho / rho0) g (h - z) / c^2

    with the height h - z of its column over a particle.
    """
    places = columns_of(release, case)
    group = blank(len(places.position))
    group.position[:] = places.position
    _fill(group, release, concentrations_of(release, case.mixture)[0], case)
    group.velocity[:, :2] = release.velocity
    _, along, aside = ground_of(case).surface.level_and_slope(*group.position[:, :2].T)
    group.velocity[:, 2] = along * release.velocity[0] + aside * release.velocity[1]
    group.compression[:] = _compression(group, places.above, case)
    return group


def _fill(group: Particles, release: ResolvedRelease, fraction: float, case: ResolvedCase) -> None:
    """Give new particles their matter."""
    if has_pore_pressure(case):
        time = release.pore_pressure_time
        set_pore_pressure(group, slice(None), release.pore_pressure, time)
    set_fraction(group, slice(None), fraction, case)
    group.kind[:] = Kind.LIQUID if fraction == 0.0 else Kind.MIXTURE


def _compression(group: Particles, above: Floats, case: ResolvedCase) -> Floats:
    gradient = max(-case.gravity.components[1], 0.0) / case.explicit_scheme.sound_speed**2
    found: Floats = gradient * group.density / reference_density(case) * above
    return found


def _born(
    release: ResolvedHydrographRelease, state: State, case: ResolvedCase, time: float, released: int
) -> Particles:
    """Return the particles that a hydrograph brings now; mostly none."""
    d0, graph, now = case.particles.spacing, release.hydrograph, time - release.start
    owed = _particles_until(release, time, case) - released
    if owed < _slab_of(release, time, case):
        return blank(0)
    place, along, above = _places_at_line(release, owed, released, case)
    group = blank(len(place))
    group.position[:] = place
    group.velocity[:] = release.velocity * along
    concentration = float(np.interp(now, graph.time, graph.concentration))
    _fill(group, release, concentration, case)
    group.compression[:] = _compression(group, above, case)
    free = _is_free(place, state.particles, NEAREST * d0)
    return _chosen(group, free)


def _particles_until(release: ResolvedHydrographRelease, time: float, case: ResolvedCase) -> int:
    """Return how many whole particles a hydrograph has brought at a time, s."""
    return int(volume_until(release, time) / case.particles.spacing**3 + ROUND_OFF)


def _slab_of(release: ResolvedHydrographRelease, time: float, case: ResolvedCase) -> float:
    """Return the particles that come in while the flow moves by a spacing at a time, s; 1 at least.

    They are born together.
    """
    graph, now = release.hydrograph, time - release.start
    discharge = float(np.interp(now, graph.time, graph.discharge, right=0.0))
    return max(discharge / release.velocity / case.particles.spacing**2, 1.0)


def _places_at_line(
    release: ResolvedHydrographRelease, count: int, released: int, case: ResolvedCase
) -> tuple[Floats, Floats, Floats]:
    """Return where particles are born, the unit vectors along which they move, and their loads.

    Both are (n, 3) arrays; the load is the height of the flow over the center of each, (n,), m.

    Rows along the line are filled from the ground upward; the last is spread over the line, each
    time by other places.
    """
    d0, ground = case.particles.spacing, ground_of(case)
    start, end = np.array(release.line) - ground.grid[:2]
    length = hypot(*(end - start))
    across = max(1, round(length / d0))
    row, column = np.divmod(np.arange(count), across)
    last = count % across
    share = (column + 0.5) / across
    if last:
        turned = (np.arange(last) + 0.5) / last + released * 0.618034
        share[row == count // across] = turned % 1.0
    bearing = radians(release.direction)
    ahead = np.array([sin(bearing), cos(bearing)])
    x, y = (start + share[:, None] * (end - start) + 0.5 * d0 * ahead).T
    level, along, aside = ground.surface.level_and_slope(x, y)
    place = np.column_stack([x, y, level + (row + 0.5) * d0])
    rise = along * ahead[0] + aside * ahead[1]
    way = np.column_stack([np.full(count, ahead[0]), np.full(count, ahead[1]), rise])
    above = (count / across - row - 0.5) * d0
    return place, way / np.linalg.norm(way, axis=1, keepdims=True), np.maximum(above, 0.0)


def _lift(group: Particles, particles: Particles, distance: float) -> None:
    """Put the columns of a mass on top of fluid that stands in their places."""
    _, column = np.unique(group.position[:, :2], axis=0, return_inverse=True)
    column = column.reshape(-1)
    while True:
        taken = np.unique(column[~_is_free(group.position, particles, distance)])
        if not taken.size:
            return
        group.position[np.isin(column, taken), 2] += distance


def _is_free(place: Floats, particles: Particles, distance: float) -> NDArray[np.bool_]:
    """Return which places are farther than a distance, m, from all fluid particles."""
    lower, upper = place.min(axis=0) - distance, place.max(axis=0) + distance
    position = particles.position[particles.fluid]
    near = position[np.all((position > lower) & (position < upper), axis=1)]
    if not len(near):
        return np.ones(len(place), dtype=bool)
    apart, _ = cKDTree(near).query(place)
    return np.asarray(apart > distance)


def _chosen(group: Particles, rows: NDArray[np.bool_]) -> Particles:
    group.keep(np.flatnonzero(rows), group.count)
    return group
