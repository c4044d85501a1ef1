"""Runs written by hand: particles placed where a test wants them, in the files of a real run."""

import numpy as np

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.matter import set_material
from debrisflow.particles.maxima import no_maxima
from debrisflow.particles.record import Kind, blank
from debrisflow.particles.state import State
from debrisflow.results import open_run
from debrisflow.results.survey import survey
from debrisflow.run.folder import RunFolder
from debrisflow.run.history import history_row
from debrisflow.run.measures import deposit_profile, flow
from debrisflow.space.plan_grid import plan


def channel_case(length=4.0, spacing=0.02, slope=0.0, shape=None, **tables):
    """Return a case: a channel in two dimensions, with a block for the sake of the checks."""
    block = {"type": "block", "x": [0.0, 0.1], "y": [0.0, 0.1], "material": "water"}
    geometry = {"type": "channel", "length": length, "height": 2.0} | (shape or {})
    return _case(block, geometry, spacing, slope, tables)


def channel3d_case(length=4.0, width=0.4, spacing=0.05, slope=0.0, shape=None, **tables):
    """Return a case: a channel in three dimensions, with a block for the sake of the checks."""
    block = {"type": "block", "x": [0.0, 0.2], "y": [0.0, 0.2], "z": [0.0, 0.2]}
    geometry = {"type": "channel3d", "length": length, "width": width, "height": 1.5}
    block["material"] = "water"
    return _case(block, geometry | (shape or {}), spacing, slope, tables)


def _case(block, geometry, spacing, slope, tables):
    tables = {
        "title": "placed by hand",
        "particles": {"spacing": spacing},
        "gravity": {"slope": slope},
        "geometry": geometry,
        "fill": [block],
        "mixture": {"concentration": 0.4},
        "time": {"end": 1.0},
        "output": {"interval": 0.1},
    } | tables
    return complete(Case(**tables))


def cells(case, columns, rows, layers=None):
    """Return the middles of the cells of a lattice, (n, 3) array, m; the last axis is upwards."""
    axes = (columns, rows) if layers is None else (columns, rows, layers)
    found = np.meshgrid(*(np.asarray(axis) for axis in axes), indexing="ij")
    position = np.zeros((found[0].size, 3))
    for axis, numbers in enumerate(found):
        position[:, axis] = (numbers.ravel() + 0.5) * case.particles.spacing
    return position


def placed(case, position, kind=Kind.MIXTURE, velocity=0.0):
    """Return fluid particles of full number density; kind and velocity may be arrays.

    A velocity of one number is along x.
    """
    particles = blank(len(position))
    particles.position[:] = position
    kinds = np.broadcast_to(np.asarray(kind), len(position))
    for one in np.unique(kinds):
        set_material(particles, np.flatnonzero(kinds == one), Kind(one), case)
    velocity = np.asarray(velocity, dtype=float)
    if velocity.ndim == 2:
        particles.velocity[:] = velocity
    else:
        particles.velocity[:, 0] = velocity
    particles.concentration[:] = particles.sediment_fraction
    particles.number_density[:] = lattice_of(case).number_density
    particles.fluid_count = len(position)
    return particles


def lattice_of(case):
    """Return the reference values of the lattice of a case."""
    return reference(case.dimension, case.particles.effective_radius, case.particles.spacing)


def state_of(case, particles, time=0.0):
    """Return a state that holds some particles."""
    return State(particles, no_maxima(plan(case).x.size), time=time)


def record(path, case, states):
    """Write states as the frames of a run, with history, deposit and maxima, and return its folder.

    Parameters
    ----------
    path : Path
    case : Case
    states : iterable of State
    """
    lattice = lattice_of(case)
    n0, d0, maxima = lattice.number_density, case.particles.spacing, None
    with RunFolder.create(path, case) as folder:
        for state in states:
            p = state.particles
            maxima = state.maxima if maxima is None else maxima
            found = flow(case, p, n0)
            maxima.include(state.time, *found, spacing=d0)
            state.maxima = maxima
            reached = maxima.reached(found.depth, d0)
            folder.write_history(history_row(case, state, 0, lattice, reached))
            arrays = p.position, p.velocity, p.kind, p.concentration, p.sediment_fraction
            folder.write_deposit(state.time, deposit_profile(case, *arrays, p.number_density, n0))
            folder.write_frame(state)
    return path


def sliding(case, particles, times):
    """Yield states in which all particles go on at the velocity that they have."""
    start = particles.position.copy()
    for time in times:
        particles.position[:] = start + time * particles.velocity
        yield state_of(case, particles, time)


def surveyed(path, case, states, *arguments, **options):
    """Return the survey of states that are written as a run first."""
    return survey(open_run(record(path, case, states)), *arguments, **options)
