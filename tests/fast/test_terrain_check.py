"""What ``debrisflow check`` says of a case on a terrain, and the picture of it."""

import numpy as np
import pytest
from click.testing import CliRunner

from debrisflow.case import build_case
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.case.terrain_speeds import within_reach
from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.results.maps.plan import draw_case, probe_places
from debrisflow.run.forecast import forecast
from debrisflow.run.ground_forecast import ground_forecast
from debrisflow.run.work import mean_number
from debrisflow.space.ground import ground_of, smooth_surface
from tests.building import tank3d_case

WEST, SOUTH = 500_000.0, 4_000_000.0
GRID = MapGrid(WEST, SOUTH, 1.0, 90, 40)
SQUARE = [[WEST + x, SOUTH + y] for x, y in ((10, 10), (20, 10), (20, 20), (10, 20))]
MASS = {"type": "polygon", "name": "scar", "corners": SQUARE, "depth": 2.0}
GRAPH = {"time": [0.0, 10.0, 20.0], "discharge": [0.0, 6.0, 0.0], "concentration": [0.3] * 3}
FLOOD = {
    "type": "hydrograph",
    "line": [[WEST + 30, SOUTH + 10], [WEST + 30, SOUTH + 14]],
    "hydrograph": GRAPH,
    "velocity": 3.0,
}


def slope(x, y):
    return 100.0 - 0.3 * x + 0.0 * y


def terrain_case(folder, release=MASS, level=slope, **tables):
    """Return a case on a terrain whose level is a function of x and y from its corner."""
    x, y = np.arange(GRID.columns) + 0.5, np.arange(GRID.rows)[::-1] + 0.5
    write_raster(folder / "dem.asc", Raster(GRID, level(*np.meshgrid(x, y))))
    friction = {"law": "voellmy", "coefficient": 0.1, "turbulence": 400.0}
    tables = {
        "title": "a slope",
        "particles": {"spacing": 1.0},
        "geometry": {"type": "terrain", "dem": "dem.asc"},
        "release": release if isinstance(release, list) else [release],
        "walls": {"floor": {"friction": friction}},
        "time": {"end": 20.0},
        "output": {"interval": 1.0},
    } | tables
    return build_case(tables, folder=folder)


def test_what_is_released_is_counted_by_when_and_how(tmp_path):
    later = MASS | {"name": "later", "start": 5.0, "depth": 1.0}
    later["corners"] = [[x + 20.0, y] for x, y in SQUARE]
    found = forecast(terrain_case(tmp_path, [MASS, later, FLOOD]))
    assert found.counts == {"at t = 0": 200, "of later masses": 100, "by hydrographs": 60}
    assert found.rows == {"release.scar": 2, "release.later": 1, "release.2": 0}
    assert found.ground.volumes == {"release.scar": 200, "release.later": 100, "release.2": 60}
    assert "particles      360: 200 at t = 0, 100 of later masses, 60 by hydrographs" in str(found)
    assert "released       360 m3, release.scar: 200, release.later: 100, release.2: 60" in str(
        found
    )


def test_what_comes_after_the_end_does_not_count(tmp_path):
    found = forecast(terrain_case(tmp_path, [MASS, FLOOD], time={"end": 10.0}))
    assert found.counts == {"at t = 0": 200, "by hydrographs": 30}
    assert found.ground.volumes["release.1"] == pytest.approx(30.0)


def test_the_mean_number_of_particles_is_that_over_the_time(tmp_path):
    late = MASS | {"start": 5.0}
    assert mean_number(terrain_case(tmp_path, late), 0) == pytest.approx(0.75 * 200, rel=0.01)
    assert forecast(terrain_case(tmp_path)).fluid == pytest.approx(200)


def test_a_plane_is_smooth_and_costs_nothing(tmp_path):
    found = ground_forecast(terrain_case(tmp_path))
    assert (found.cell, found.width) == (1.0, 3.0)
    assert found.rms < 0.02
    assert found.bent == found.sharp == 0.0
    assert "on 0 %, > 0.5 on 0 % of the ground within reach" in str(found)
    assert "warning" not in str(found)


def test_the_curvature_of_the_surface_is_that_of_its_formula():
    x, y = np.meshgrid(np.arange(0.5, 40.0), np.arange(0.5, 40.0), indexing="ij")
    surface = smooth_surface(0.01 * (x - 20.0) ** 2 - 0.02 * (y - 20.0) ** 2, 1.0, 1.0)
    at = np.array([20.0]), np.array([20.0])
    assert surface.mean_curvature(*at) == pytest.approx(0.5 * (0.02 - 0.04), rel=1e-3)
    bowl = smooth_surface(0.01 * (x - 20.0) ** 2 + 0.0 * y, 1.0, 1.0)
    beside = bowl.mean_curvature(np.array([30.0]), np.array([20.0]))
    assert beside == pytest.approx(0.5 * 0.02 / (1.0 + 0.2**2) ** 1.5, rel=1e-3)


def test_a_gully_narrower_than_the_influence_is_warned_of(tmp_path):
    case = terrain_case(
        tmp_path, level=lambda x, y: slope(x, y) + 4.0 * np.cos(2.0 * np.pi * y / 8.0)
    )
    found = ground_forecast(case)
    assert found.sharp > 0.3
    assert found.rms > 0.1
    told = str(found)
    assert "warning        geometry.cell = 6 m would be smoother" in told
    x, y = found.place
    ground = ground_of(case)
    i, j = int(x - WEST), int(y - SOUTH)
    off = ground.given[i, j] - ground.whole.level(np.array([i + 0.5]), np.array([j + 0.5]))
    assert abs(off) == pytest.approx(found.greatest)


def test_within_reach_is_what_lies_below_the_energy_line(tmp_path):
    case = terrain_case(tmp_path, level=lambda x, y: 100.0 - 0.3 * np.minimum(x, 40.0) + 0.0 * y)
    reach = within_reach(case.terrain, case.release, case.zone, case.walls.floor)
    highest = 100.0 - 0.3 * 9.5  # of the ground around the release
    beyond = 20.0 + (highest - 88.0) / 0.1  # where a line that falls by 0.1 meets the plain
    last = np.flatnonzero(reach[25])[-1]
    assert last == GRID.columns - 1 or abs(last + 0.5 - beyond) <= 1.0
    assert not reach[:, :5].any()


class TestPicture:
    def test_a_case_is_drawn(self, tmp_path):
        box = {"type": "box", "name": "dam", "z": [70.0, 90.0]}
        box |= {"x": [WEST + 60, WEST + 62], "y": [SOUTH + 10, SOUTH + 30]}
        zone = {"name": "fan", "corners": [[x + 40, y] for x, y in SQUARE]}
        zone["friction"] = {"law": "coulomb", "angle": 20.0}
        tower = {"type": "point", "name": "tower", "x": WEST + 50.0, "y": SOUTH + 20.0, "z": 86.0}
        gate = {"type": "section", "name": "gate", "x": WEST + 55.0, "interval": 1.0}
        probe = [tower | {"interval": 1.0}, gate]
        case = terrain_case(
            tmp_path, [MASS, FLOOD], zone=[zone], obstacle=[box], probe=probe, title="a $ < b"
        )
        file = draw_case(case, tmp_path / "case.png")
        assert file.read_bytes().startswith(b"\x89PNG")
        places = {place.name: place.points.tolist() for place in probe_places(case)}
        assert places["tower"] == [[WEST + 50.0, SOUTH + 20.0]]
        assert places["gate"] == [[WEST + 55.0, SOUTH], [WEST + 55.0, SOUTH + 40.0]]

    def test_it_is_drawn_by_check(self, tmp_path):
        terrain_case(tmp_path)
        file = tmp_path / "case.toml"
        corners = ", ".join(map(str, SQUARE))
        file.write_text(
            'title = "a slope"\nparticles = { spacing = 1.0 }\ntime = { end = 20.0 }\n'
            'output = { interval = 1.0 }\n[geometry]\ntype = "terrain"\ndem = "dem.asc"\n'
            f'[[release]]\ntype = "polygon"\ndepth = 2.0\ncorners = [{corners}]\n'
        )
        told = CliRunner().invoke(main, ["check", str(file), "--plot", str(tmp_path / "a.png")])
        assert told.exit_code == 0, told.output
        assert f"wrote {tmp_path / 'a.png'}" in told.output
        assert "curvature      |H| r_e" in told.output

    def test_other_cases_and_files_are_refused(self, tmp_path):
        with pytest.raises(OutputError, match="on a terrain only"):
            draw_case(tank3d_case(), tmp_path / "case.png")
        with pytest.raises(OutputError, match="call it case"):
            draw_case(terrain_case(tmp_path), tmp_path / "case.jpg")
