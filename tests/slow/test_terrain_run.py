"""Runs on a small terrain: what leaves is counted, what is resumed is the same, maps lie right."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio

from debrisflow._jit import set_threads
from debrisflow.case import ResolvedCase, build_case
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.errors import DivergedError
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.results import open_run
from debrisflow.results.answers import answers
from debrisflow.results.terrain_survey import survey_terrain
from debrisflow.run import simulation
from debrisflow.run.tables import read_table
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.explicit import Explicit

UTM = rasterio.crs.CRS.from_epsg(32653).to_wkt()
GRID = MapGrid(400_000.0, 3_900_000.0, 2.0, 50, 24, UTM)
EAST_EDGE, LATE = 80.0, 0.3  # m, s

Build = Callable[..., ResolvedCase]


def square(x: float, y: float, side: float) -> list[list[float]]:
    half = 0.5 * side
    ends = ((-half, -half), (half, -half), (half, half), (-half, half))
    return [[GRID.west + x + a, GRID.south + y + b] for a, b in ends]


@pytest.fixture
def build(tmp_path: Path) -> Build:
    x, y = np.meshgrid((np.arange(50) + 0.5) * 2.0, (np.arange(24)[::-1] + 0.5) * 2.0)
    levels = 200.0 - 0.5 * x + 0.01 * (y - 24.0) ** 2
    levels[x > EAST_EDGE] = np.nan
    write_raster(tmp_path / "dem.tif", Raster(GRID, levels))

    def built(*release: dict[str, Any], end: float = 0.6, **tables: Any) -> ResolvedCase:
        flood = {
            "type": "hydrograph",
            "line": [[GRID.west + 8.0, GRID.south + 20.0], [GRID.west + 8.0, GRID.south + 28.0]],
            "hydrograph": {"time": [0, 9], "discharge": [40, 40], "concentration": [0.2, 0.4]},
            "velocity": 4.0,
        }
        mass = {"type": "polygon", "corners": square(22.0, 22.0, 8.0), "depth": 2.0}
        return build_case(
            {
                "title": "a gully",
                "particles": {"spacing": 1.0},
                "geometry": {"type": "terrain", "dem": "dem.tif"},
                "release": list(release) or [flood, mass, mass | {"start": LATE}],
                "walls": {"floor": {"friction": {"law": "coulomb", "angle": 5.0}}},
                "scheme": {"sound_speed": 80.0},
                "time": {"end": end},
                "output": {"interval": 0.2, "layer_interval": 0.2},
            }
            | tables,
            folder=tmp_path,
        )

    return built


def results(folder: Path) -> dict[str, bytes]:
    """Return the files that must not depend on how a run came to its end."""
    kept = [*folder.glob("*.csv"), *folder.glob("layers/*"), *folder.glob("vtu/*")]
    return {str(file.relative_to(folder)): file.read_bytes() for file in kept if file.is_file()}


def test_faults_on_a_terrain_are_told_in_map_coordinates(
    build: Build, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    step = Explicit.step

    def step_and_spoil(scheme: Explicit, state: State, dt: float) -> int:
        iterations = step(scheme, state, dt)
        if state.step == 30:  # a hole in the ground; found when neighbors are sorted, at 40
            state.particles.position[3, 2] -= 3.0
        if state.step == 60:
            state.released[0] += 1
            state.entered[2] += 1
        return iterations

    monkeypatch.setattr(Explicit, "step", step_and_spoil)
    with pytest.raises(DivergedError, match=r"ledger .*: 1 are missing; 0 at the start") as found:
        simulation.simulate(build(end=1.0), tmp_path / "run", threads=1)
    assert re.search(r"at easting 4000\d\d\.\d\d, northing 39000\d\d\.", str(found.value))
    told = (tmp_path / "run" / "run.log").read_text()
    assert re.search(r"particle \d+ went through the ground at easting 4000\d\d\.", told)


def test_an_interrupted_run_on_a_terrain_goes_on_bit_for_bit(
    build: Build, tmp_path: Path, interrupt: Callable[[], None]
) -> None:
    case = build()
    simulation.simulate(case, tmp_path / "whole", threads=1)
    interrupt()
    with pytest.raises(KeyboardInterrupt):
        simulation.simulate(case, tmp_path / "broken", threads=1)
    shutil.copytree(tmp_path / "broken", tmp_path / "rest")
    try:
        simulation.resume(tmp_path / "rest", threads=2)
    finally:
        set_threads(1)
    whole, rest = results(tmp_path / "whole"), results(tmp_path / "rest")
    assert len(whole) > 20
    assert whole.keys() == rest.keys()
    assert [name for name in whole if whole[name] != rest[name]] == []


def test_what_passes_an_edge_or_a_gap_has_left(build: Build, tmp_path: Path) -> None:
    mass = {"type": "polygon", "depth": 2.0, "velocity": [12.0, 0.0]}
    to_gap = mass | {"corners": square(52.0, 24.0, 8.0)}
    to_edge = mass | {"corners": square(30.0, 8.0, 8.0), "velocity": [0.0, -9.0]}
    case = build(to_gap, to_edge, end=1.5)
    figures = simulation.simulate(case, tmp_path / "run", threads=1)
    ledger = read_table(tmp_path / "run" / "ledger.csv", ())
    total = ledger["moving"] + ledger["at_rest"] + ledger["left"] + ledger["through_ground"]
    np.testing.assert_array_equal(ledger["released"], total)
    assert ledger["through_ground"][-1] == 0
    assert ledger["left"][-1] > 50
    assert sum(figures["left"].values()) == ledger["left"][-1]
    assert figures["ledger"] == {name: ledger[name][-1] for name in ledger if name != "time"}
    found = survey_terrain(open_run(tmp_path / "run"))
    told = {row.quantity: row.value for row in answers(found)}
    assert told["ledger_error"] == 0.0
    assert told["volume_left"] == ledger["left"][-1]
    assert told["mass_closure_water"] == pytest.approx(0.0, abs=1e-6 * told["mass_in_water"])
    assert found.mobility.bound == "a lower bound: some of it left over an edge of the DEM"
    with rasterio.open(tmp_path / "run" / "layers" / "peak_depth.tif") as file:
        assert np.all(file.read(1)[:, 41:] == file.nodata)  # no map where there is no level


def test_a_mass_on_a_known_cell_is_on_that_cell(build: Build, tmp_path: Path) -> None:
    x, y = 27.0, 13.0
    case = build({"type": "polygon", "corners": square(x, y, 2.0), "volume": 36.0}, end=0.02)
    simulation.simulate(case, tmp_path / "run", threads=1)
    for name in ("peak_depth", "release", "final_depth"):
        with (
            rasterio.open(tmp_path / "run" / "layers" / f"{name}.tif") as file,
            rasterio.open(tmp_path / "dem.tif") as dem,
        ):
            assert (file.transform, file.crs) == (dem.transform, dem.crs)
            assert (file.nodata, file.shape) == (-9999.0, dem.shape)
            row, column = np.unravel_index(np.argmax(file.read(1)), file.shape)
            west = file.transform.c + column * file.transform.a
            north = file.transform.f + row * file.transform.e
            assert west < GRID.west + x < west + 2.0
            assert north - 2.0 < GRID.south + y < north


def test_nothing_goes_through_the_ground(build: Build) -> None:
    case = build(
        {"type": "polygon", "corners": square(20.0, 24.0, 12.0), "depth": 6.0},
        walls={"floor": {"slip": "free-slip"}},
    )
    state, scheme = initial_state(case), scheme_of(case)
    scheme.fill_number_density(state)
    for _ in range(400):
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time, state.step = state.time + dt, state.step + 1
    solid = scheme.vicinity.solid
    assert np.count_nonzero(solid.faces) > 100
    assert solid.distance[solid.faces > 0, 0].min() > 0.0
    assert state.through_wall.sum() == 0
