"""A wedge that lies on the floor: the wall under its toe, and water that runs up it."""

from __future__ import annotations

import numpy as np
import pytest

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.results import open_run
from debrisflow.run.simulation import simulate
from debrisflow.schemes.surfaces import walls_of

D0, TOE, SLOPE = 0.05, 1.5, 2.0 / 15.0
ON_A_PLANE = 6.809  # n of a half space half a spacing under a particle


def case(**tables):
    """Return a tank with a slope of 1 : 7.5 up to its right wall, and a film that runs at it."""
    film = {"type": "block", "x": [0.5, 1.3], "y": [0.0, D0], "material": "water"}
    corners = [[TOE, 0.0], [4.0, 0.0], [4.0, SLOPE * (4.0 - TOE)]]
    return complete(
        Case(
            title="wedge",
            particles={"spacing": D0},
            geometry={"type": "tank", "length": 4.0, "height": 1.0},
            walls={"floor": {"slip": "free-slip"}},
            fill=[film | {"velocity": [3.0, 0.0]}],
            obstacle=[{"type": "polygon", "name": "sill", "corners": corners, "slip": "free-slip"}],
            time={"end": 0.12},
            output={"interval": 0.04},
            **tables,
        )
    )


def density_on_the_slope(x):
    """Return n of the walls half a spacing over the slope."""
    place = np.stack([x, SLOPE * (x - TOE) + 0.5 * D0 * np.hypot(1.0, SLOPE), 0.0 * x], axis=1)
    surfaces = walls_of(case(), skin=0.3)[0]
    surfaces.build(place, 0.01)
    found = surfaces.survey(place)
    return found.sums[found.row, 0]


def test_the_wall_under_a_thin_wedge_is_that_under_a_plane():
    # rows end where the wedge is thinner than their depth, so that half a row more or less is seen
    n = density_on_the_slope(np.linspace(TOE + 1.2 * D0 / SLOPE, 3.0, 60))
    assert np.mean(n) == pytest.approx(ON_A_PLANE, rel=0.03)
    assert np.abs(n - ON_A_PLANE).max() < 0.2 * ON_A_PLANE


def test_water_on_the_floor_runs_up_a_flat_wedge(tmp_path):
    simulate(case(), tmp_path / "run", threads=1)
    last = open_run(tmp_path / "run").frame(0.12)
    front = np.argmax(last.position[:, 0])
    assert last.position[front, 0] > 1.275 + 0.9 * 3.0 * 0.12
    assert last.velocity[front, 0] > 0.9 * 3.0
    assert last.velocity[front, 1] == pytest.approx(3.0 * SLOPE, abs=0.3)
