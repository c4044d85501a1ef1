"""The ground of a terrain: its surface, scars and zones, and what is released onto it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from debrisflow.case import ResolvedCase, build_case
from debrisflow.case.coverage import depth_on, holds_middles
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.case.released import volume
from debrisflow.neighbors.height_field import ground_at, levels_at, number_under
from debrisflow.particles.releases import is_pending, release_due, volume_until, waiting
from debrisflow.particles.start import initial_state
from debrisflow.run.ledger import ledger_row
from debrisflow.schemes.surfaces import record_of_ground
from debrisflow.schemes.terms.base_friction import friction_of
from debrisflow.space.domain import first_zone, wall_names
from debrisflow.space.ground import ground_of, smooth_surface
from debrisflow.space.released import columns_of, released_depth, source_of

WEST, SOUTH, CELL = 500_000.0, 4_000_000.0, 4.0
GRID = MapGrid(WEST, SOUTH, CELL, 40, 20)
SPACING = 1.0
VOELLMY = {"law": "voellmy", "coefficient": 0.1, "turbulence": 400.0}
GRAPH = {"time": [0.0, 4.0, 12.0], "discharge": [0.0, 30.0, 0.0], "concentration": [0.3] * 3}

Build = Callable[..., ResolvedCase]


def levels() -> np.ndarray:
    x, y = np.meshgrid((np.arange(40) + 0.5) * CELL, (np.arange(20)[::-1] + 0.5) * CELL)
    return 300.0 - 0.3 * x + 0.004 * (y - 40.0) ** 2


def corners(*ends: float) -> list[list[float]]:
    x0, x1, y0, y1 = ends
    return [[WEST + x, SOUTH + y] for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))]


@pytest.fixture
def build(tmp_path: Path) -> Build:
    write_raster(tmp_path / "dem.asc", Raster(GRID, levels()))
    depth = np.zeros(GRID.shape)
    depth[8:11, 6:9] = 2.0
    write_raster(tmp_path / "depth.asc", Raster(GRID, depth))

    def built(*release: dict[str, Any], **tables: Any) -> ResolvedCase:
        return build_case(
            {
                "title": "a valley",
                "particles": {"spacing": SPACING},
                "geometry": {"type": "terrain", "dem": "dem.asc"},
                "release": list(release),
                "walls": {"floor": {"friction": VOELLMY}},
                "time": {"end": 20.0},
                "output": {"interval": 5.0},
            }
            | tables,
            folder=tmp_path,
        )

    return built


POLYGON = {"type": "polygon", "corners": corners(21.0, 43.0, 31.0, 47.0), "depth": 1.7}
RASTER = {"type": "raster", "file": "depth.asc"}
FLOOD = {
    "type": "hydrograph",
    "line": [[WEST + 20.0, SOUTH + 36.0], [WEST + 20.0, SOUTH + 44.0]],
    "hydrograph": GRAPH,
    "velocity": 3.0,
}


def test_kernels_and_arrays_know_one_surface(build: Build) -> None:
    case = build(POLYGON)
    rng = np.random.default_rng(3)
    x, y = rng.uniform(0.0, 160.0, 50), rng.uniform(0.0, 80.0, 50)
    surface, record = ground_of(case).surface, record_of_ground(case)
    level, along, across = surface.level_and_slope(x, y)
    found = np.empty(50)
    levels_at(x, y, record, found)
    np.testing.assert_allclose(found, level, rtol=0.0, atol=1e-9)
    slopes = np.array([ground_at(*place, record)[1:3] for place in zip(x, y, strict=True)])
    np.testing.assert_allclose(slopes, np.column_stack([along, across]), atol=1e-12)


def test_the_surface_goes_through_a_plane_and_means_of_cells() -> None:
    rough = np.random.default_rng(1).normal(size=(24, 18))
    surface = smooth_surface(rough, 1.0, 3.0)
    middles = np.meshgrid(np.arange(8) * 3.0 + 1.5, np.arange(6) * 3.0 + 1.5, indexing="ij")
    means = rough.reshape(8, 3, 6, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(surface.level(*middles), means, atol=1e-12)


def test_gaps_take_the_nearest_level() -> None:
    values = np.add.outer(np.arange(30.0), np.zeros(20))
    values[10:12, 5:8] = np.nan
    surface = smooth_surface(values, 1.0, 1.0)
    assert abs(surface.level(np.array([11.0]), np.array([6.0]))[0] - 10.5) < 1.0


def test_depths_on_cells_hold_the_volume(build: Build) -> None:
    case = build(POLYGON)
    depth = depth_on(case.release[0], GRID)
    assert depth.sum() * CELL**2 == pytest.approx(22.0 * 16.0 * 1.7, rel=1e-12)
    assert depth[5, 7] == pytest.approx(1.7 * 0.75 * 0.25)  # in the corner at 21, 31


def test_a_raster_on_another_grid_keeps_its_volume(build: Build, tmp_path: Path) -> None:
    fine = MapGrid(WEST + 11.0, SOUTH + 21.0, 1.5, 14, 12)
    write_raster(tmp_path / "depth.asc", Raster(fine, np.full(fine.shape, 1.2)))
    case = build(RASTER)
    depth = depth_on(case.release[0], GRID)
    assert depth.sum() * CELL**2 == pytest.approx(volume(case.release[0]), rel=1e-12)
    assert depth[4, 7] == pytest.approx(1.2)
    assert depth[2, 7] == pytest.approx(1.2 * 0.25)


@pytest.mark.parametrize("release", [POLYGON, RASTER, RASTER | {"place": "in-terrain"}])
def test_a_mass_holds_its_volume_to_a_particle(build: Build, release: dict[str, Any]) -> None:
    case = build(release)
    columns = columns_of(case.release[0], case)
    assert len(columns.position) == round(volume(case.release[0]) / SPACING**3)
    x, y, z = columns.position.T
    level, along, across = ground_of(case).surface.level_and_slope(x, y)
    distance = (z - level) / np.sqrt(1.0 + along**2 + across**2)
    assert distance.min() > 0.44 * SPACING
    assert np.all(released_depth(case)[ground_of(case).cells(x, y)] > 0.0) or "place" in release


def test_a_scar_is_as_deep_as_what_is_taken_out(build: Build) -> None:
    ground = ground_of(build(RASTER | {"place": "in-terrain"}))
    x, y = np.meshgrid(np.arange(0.5, 160.0), np.arange(0.5, 80.0), indexing="ij")
    cut = ground.whole.level(x, y) - ground.surface.level(x, y)
    assert cut.sum() == pytest.approx(9 * CELL**2 * 2.0, rel=2e-3)
    assert cut[30, 42] == pytest.approx(2.0, rel=0.1)


def test_zones_are_walls_of_their_own(build: Build) -> None:
    zone = {"name": "forest", "corners": corners(80.0, 120.0, 0.0, 40.0)}
    law = {"law": "manning", "coefficient": 0.1}
    case = build(POLYGON, zone=[zone | {"friction": law}])
    assert wall_names(case)[first_zone(case)] == "forest"
    record = record_of_ground(case)
    assert number_under(100.0, 20.0, record) == first_zone(case)
    assert number_under(100.0, 60.0, record) == 0
    assert number_under(-50.0, 500.0, record) == 0
    assert holds_middles(case.zone[0], GRID).sum() == 100
    friction = friction_of(case)
    assert friction.manning[first_zone(case)] == pytest.approx(9.81 * 0.01)
    assert friction.sliding[0] == pytest.approx(0.1)
    assert friction.sliding[first_zone(case)] == 0.0


def test_the_source_is_the_middle_of_the_first_release(build: Build) -> None:
    case = build(POLYGON | {"start": 3.0}, FLOOD)
    np.testing.assert_allclose(source_of(case), [20.0, 40.0])
    np.testing.assert_allclose(source_of(build(RASTER)), [30.0, 42.0])


def test_a_mass_is_released_at_its_time(build: Build) -> None:
    case = build(POLYGON, RASTER | {"start": 2.0})
    state = initial_state(case)
    first, later = (round(volume(release) / SPACING**3) for release in case.release)
    assert state.particles.fluid_count == first
    assert is_pending(case, state)
    release_due(state, case, 1.99)
    assert state.particles.fluid_count == first
    release_due(state, case, 2.0)
    release_due(state, case, 3.0)
    assert state.particles.fluid_count == first + later
    np.testing.assert_array_equal(state.released, [first, later])
    state.time = 2.5
    assert not is_pending(case, state)
    assert len(set(state.particles.id.tolist())) == state.particles.count


def test_a_hydrograph_brings_its_volume(build: Build) -> None:
    case = build(FLOOD | {"start": 1.0})
    graph, state = case.release[0], initial_state(case)
    assert volume_until(graph, 1.0) == 0.0
    assert volume_until(graph, 5.0) == pytest.approx(60.0)
    assert volume_until(graph, 99.0) == pytest.approx(180.0)
    for time in np.arange(0.0, 16.0, 0.02):
        before = state.particles.fluid_count
        release_due(state, case, float(time))
        p = state.particles
        # moved on as they came, so that those who follow have room
        p.position[p.fluid, 0] += 0.02 * 3.0
        owed = volume_until(graph, float(time)) / SPACING**3 - p.fluid_count
        born = p.velocity[before:, :][: p.fluid_count - before]
        assert owed > -1.0
        assert np.allclose(np.linalg.norm(born, axis=1), 3.0)
    assert 180 - state.particles.fluid_count <= 1
    assert state.particles.sediment_fraction[state.particles.fluid] == pytest.approx(0.3)


def test_nobody_is_born_into_others(build: Build) -> None:
    case = build(FLOOD)
    state = initial_state(case)
    release_due(state, case, 3.0)
    first = state.particles.fluid_count
    release_due(state, case, 4.0)  # nobody has moved away
    assert first > 0
    position = state.particles.position[state.particles.fluid]
    apart = np.linalg.norm(position[:, None] - position[None], axis=2)
    assert apart[np.triu_indices(len(position), 1)].min() > 0.69 * SPACING


def test_the_ledger_closes(build: Build) -> None:
    case = build(POLYGON)
    state = initial_state(case)
    state.particles.velocity[:100, 0] = 1.0
    _, released, moving, at_rest, left, lost, whole = ledger_row(case, state)
    assert released == moving + at_rest + left + lost
    assert (moving, left, lost) == (100, 0, 0)
    assert whole == pytest.approx(released * SPACING**3)


def nearest(position: np.ndarray) -> float:
    """Return the least distance between two places, in spacings."""
    apart, _ = cKDTree(position).query(position, k=2)
    return float(apart[:, 1].min() / SPACING)


def test_scars_side_by_side_share_no_place(build: Build) -> None:
    scar = {"type": "polygon", "depth": 2.0, "place": "in-terrain"}
    one = scar | {"corners": corners(40.0, 56.0, 24.0, 40.0)}
    other = scar | {"corners": corners(56.0, 72.0, 24.0, 40.0)}
    state = initial_state(build(one, other))
    assert state.particles.fluid_count == 2 * 512
    assert nearest(state.particles.position) > 0.8


def test_masses_side_by_side_share_no_place(build: Build) -> None:
    mass = {"type": "polygon", "depth": 2.0}
    one = mass | {"corners": corners(41.0, 55.0, 25.0, 40.0)}
    other = mass | {"corners": corners(55.0, 71.0, 25.0, 40.0)}
    state = initial_state(build(one, other))
    assert nearest(state.particles.position) > 0.8


def test_a_later_mass_comes_on_top_of_what_is_there(build: Build) -> None:
    case = build(POLYGON, POLYGON | {"start": 1.0})
    state = initial_state(case)
    release_due(state, case, 1.0)
    assert state.released[0] == state.released[1]
    assert nearest(state.particles.position) > 0.69


def test_a_narrow_mass_keeps_its_volume(build: Build) -> None:
    narrow = {"type": "polygon", "corners": corners(41.1, 41.4, 20.0, 60.0), "volume": 60.0}
    position = initial_state(build(narrow)).particles.position
    assert len(position) == 60
    assert np.ptp(position[:, 1]) > 38.0


def test_a_flow_that_enters_a_valley_bears_the_load_of_its_own_columns(build: Build) -> None:
    across = [[WEST + 20.0, SOUTH + 2.0], [WEST + 20.0, SOUTH + 78.0]]
    graph = {"time": [0.0, 4.0], "discharge": [300.0, 300.0], "concentration": [0.3, 0.3]}
    case = build(FLOOD | {"line": across, "hydrograph": graph})
    state = initial_state(case)
    release_due(state, case, 1.0)
    assert np.ptp(state.particles.position[:, 2]) > 5.0  # banks and bed
    load = state.particles.compression * case.explicit_scheme.sound_speed**2 / 9.81
    assert 0.0 < load.max() < 300.0 / 76.0 + 1.0


def test_a_hydrograph_without_room_waits(build: Build) -> None:
    case = build(FLOOD)
    state = initial_state(case)
    for state.time in (2.0, 4.0, 30.0):  # nothing moves on
        release_due(state, case, state.time)
    owed = int(waiting(case, state)[0])
    assert owed == 180 - state.particles.fluid_count
    assert owed > 40
    assert is_pending(case, state)


def test_a_mass_moves_along_the_ground(build: Build) -> None:
    case = build(POLYGON | {"velocity": [3.0, 0.0]})
    u, _, w = initial_state(case).particles.velocity.T
    np.testing.assert_allclose(w / u, -0.3, atol=0.01)
