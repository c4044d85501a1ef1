"""A run on a terrain written by hand: a mass slides down a slope and stops, without a solver."""

import numpy as np

from debrisflow.case import build_case
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.start import initial_state
from debrisflow.run.folder import RunFolder
from debrisflow.run.history import history_row
from debrisflow.run.layer_recorder import recorder_of
from debrisflow.run.ledger import ledger_row
from debrisflow.space.ground import ground_of

WEST, SOUTH, CELL = 500_000.0, 4_000_000.0, 5.0
GRID = MapGrid(WEST, SOUTH, CELL, 24, 8)
FALL = 0.3
SQUARE = [[WEST + x, SOUTH + y] for x, y in ((10, 15), (20, 15), (20, 25), (10, 25))]
MIDDLE = WEST + 15.0, SOUTH + 20.0
GAUGE = {"type": "point", "name": "gauge", "x": WEST + 40.0, "y": SOUTH + 20.0, "z": 89.0}


def sloping_case(folder, **tables):
    """Return a case: 100 m3 of mixture on a slope that falls to the east."""
    x = (np.arange(GRID.columns) + 0.5) * CELL
    write_raster(folder / "dem.asc", Raster(GRID, np.tile(100.0 - FALL * x, (GRID.rows, 1))))
    friction = {"law": "voellmy", "coefficient": 0.1, "turbulence": 400.0}
    tables = {
        "title": "a mass on a slope",
        "particles": {"spacing": 1.0},
        "geometry": {"type": "terrain", "dem": "dem.asc"},
        "release": [{"type": "polygon", "name": "scar", "corners": SQUARE, "depth": 1.0}],
        "walls": {"floor": {"friction": friction}},
        "mixture": {"concentration": 0.4},
        "time": {"end": 10.0},
        "output": {"interval": 1.0},
    } | tables
    return build_case(tables, folder=folder)


def slide(path, speed=5.0, stop=8.0, leave=0, **tables):
    """Write a run of ten seconds in which the mass moves east until a time, and return its folder.

    Parameters
    ----------
    path : Path
        Of the run, in a folder that takes the DEM.
    speed : float, m/s
    stop : float, s
        Until which it moves.
    leave : int
        Particles that are gone at the end.
    tables
        Of the case.
    """
    case = sloping_case(path.parent, **tables)
    state, recorder = initial_state(case), recorder_of(case)
    lattice = reference(3, case.particles.effective_radius, case.particles.spacing)
    p, surface = state.particles, ground_of(case).surface
    start = p.position.copy()
    above = start[:, 2] - surface.level(*start[:, :2].T)
    p.number_density[:] = lattice.number_density
    with RunFolder.create(path, case) as folder:
        for time in np.arange(11.0):
            state.time = float(time)
            p.position[:, 0] = start[:, 0] + speed * min(time, stop)
            p.position[:, 2] = surface.level(*p.position[:, :2].T) + above
            p.velocity[:] = (speed if time < stop else 0.0, 0.0, 0.0)
            if time == 10.0 and leave:
                state.left[2] += leave
                state.left_sediment[2] += leave * p.sediment_fraction[0]
                p.keep(np.arange(p.count - leave), p.count)
                p.fluid_count -= leave
            recorder.add_step(state.layers, p, state.time, 1.0)
            folder.write_history(history_row(case, state, 0, lattice))
            folder.write_ledger(ledger_row(case, state))
            folder.write_frame(state)
            for probe in case.probe:
                rows = [(5.0 * time, 0.0, 0.0, 100.0 * time, 0.4, 1.0, *([0.0] * 8))]
                folder.write_probe(probe.name, state.time, rows)
        depths = recorder.depth(p, case.output.rest_speed), recorder.depth(p)
        folder.write_layers(state, *depths)
    return path
