"""A case on a terrain: resolved on the grid of its DEM, measured from an origin, read back."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable
from math import radians, sin, sqrt, tan
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
import rasterio
import shapely
from rasterio.transform import Affine

from debrisflow.case import ResolvedCase, build_case, dump_case, load_case
from debrisflow.case.content import content_of, digest_of
from debrisflow.case.doubts import doubts, rows_over_depths
from debrisflow.case.estimate import particle_estimate
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.case.released import depth_at, greatest_depth, is_in_zone, volume
from debrisflow.case.resolved import (
    MappedTerrain,
    ResolvedHydrographRelease,
    ResolvedTerrain,
)
from debrisflow.case.terrain_speeds import expected_speed
from debrisflow.case.vectors import write_polygons
from debrisflow.errors import CaseError
from debrisflow.particles.start import initial_state
from debrisflow.run.work import growth, speeds

WEST, SOUTH, CELL = 500_000.0, 4_000_000.0, 5.0
GRID = MapGrid(WEST, SOUTH, CELL, 60, 24)
ANGLE = 20.0  # degrees, by which the ground falls to the east
SQUARE = [[WEST + x, SOUTH + y] for x, y in ((20, 40), (40, 40), (40, 60), (20, 60))]
RELEASE = {"type": "polygon", "corners": SQUARE, "depth": 2.0}
LINE = [[WEST + 20.0, SOUTH + 40.0], [WEST + 20.0, SOUTH + 60.0]]
GRAPH = {"time": [0.0, 10.0, 30.0], "discharge": [0.0, 50.0, 0.0], "concentration": [0.3] * 3}
VOELLMY = {"law": "voellmy", "coefficient": 0.1, "turbulence": 400.0}

Build = Callable[..., ResolvedCase]


def levels() -> np.ndarray:
    x = (np.arange(GRID.columns) + 0.5) * CELL
    return np.tile(300.0 - tan(radians(ANGLE)) * x, (GRID.rows, 1))


@pytest.fixture
def build(tmp_path: Path) -> Build:
    write_raster(tmp_path / "dem.asc", Raster(GRID, levels()))

    def built(release: Any = RELEASE, **tables: Any) -> ResolvedCase:
        geometry = {"type": "terrain", "dem": "dem.asc"} | tables.pop("geometry", {})
        return build_case(
            {
                "title": "a slope",
                "particles": {"spacing": 1.0},
                "geometry": geometry,
                "release": release if isinstance(release, list) else [release],
                "walls": {"floor": {"friction": VOELLMY}},
                "time": {"end": 60.0},
                "output": {"interval": 5.0},
            }
            | tables,
            folder=tmp_path,
        )

    return built


def terrain(case: ResolvedCase) -> ResolvedTerrain:
    assert isinstance(case.geometry, ResolvedTerrain)
    assert not isinstance(case.geometry, MappedTerrain)
    return case.geometry


def test_the_digest_of_a_case_is_that_of_its_content(build: Build, tmp_path: Path) -> None:
    write_polygons(tmp_path / "scar.geojson", [shapely.Polygon(SQUARE)])
    scar = {"type": "polygon", "file": "scar.geojson", "depth": 2.0}
    first = digest_of(content_of(build(scar)))
    assert len(first) == 64
    assert digest_of(content_of(build(scar | {"depth": 2.1}))) != first
    (tmp_path / "elsewhere").mkdir()
    for name in ("dem.asc", "scar.geojson"):
        shutil.copy(tmp_path / name, tmp_path / "elsewhere" / name)
    away = {"dem": str(tmp_path / "elsewhere" / "dem.asc")}
    there = scar | {"file": str(tmp_path / "elsewhere" / "scar.geojson")}
    assert digest_of(content_of(build(there, geometry=away))) == first
    write_polygons(tmp_path / "elsewhere" / "scar.geojson", [shapely.Polygon(SQUARE[:3])])
    assert digest_of(content_of(build(there, geometry=away))) != first
    changed = levels()
    changed[0, -1] += 0.01
    write_raster(tmp_path / "dem.asc", Raster(GRID, changed))
    assert digest_of(content_of(build(scar))) != first


class TestResolved:
    def test_the_whole_dem(self, build: Build, tmp_path: Path) -> None:
        ground = terrain(build())
        assert ground.dem == str(tmp_path / "dem.asc")
        assert ground.crop == (WEST, SOUTH, WEST + 300.0, SOUTH + 120.0)
        assert (ground.length, ground.width, ground.periodic) == (300.0, 120.0, False)
        # lowest 191.7 m less ten spacings, highest 299.1 m and fifty spacings: rounded to 10 m
        assert ground.origin == (WEST, SOUTH, 180.0)
        assert (ground.upper_level, ground.height) == (350.0, 170.0)
        assert ground.cell == CELL

    def test_three_dimensions_and_their_scheme(self, build: Build) -> None:
        case = build()
        assert case.dimension == 3
        assert case.scheme.type == "explicit"
        assert case.particles.effective_radius == 2.4

    def test_a_crop_keeps_to_cells(self, build: Build) -> None:
        crop = [WEST + 9.0, SOUTH + 21.0, WEST + 101.0, SOUTH + 99.0]
        ground = terrain(build(geometry={"crop": crop}))
        assert ground.crop == (WEST + 10.0, SOUTH + 20.0, WEST + 100.0, SOUTH + 100.0)
        assert ground.levels.values.shape == (16, 18)

    def test_a_crop_by_polygons(self, build: Build, tmp_path: Path) -> None:
        part = shapely.Polygon([(WEST + x, SOUTH + y) for x, y in ((10, 20), (150, 60), (10, 110))])
        write_polygons(tmp_path / "part.geojson", [part])
        ground = terrain(build(geometry={"crop": "part.geojson"}))
        assert ground.crop == (WEST + 10.0, SOUTH + 20.0, WEST + 150.0, SOUTH + 110.0)

    def test_a_crop_holds_its_polygons(self, build: Build, tmp_path: Path) -> None:
        part = shapely.box(WEST + 12.4, SOUTH + 22.6, WEST + 147.4, SOUTH + 107.6)
        write_polygons(tmp_path / "part.geojson", [part])
        ground = terrain(build(geometry={"crop": "part.geojson"}))
        assert ground.crop == (WEST + 10.0, SOUTH + 20.0, WEST + 150.0, SOUTH + 110.0)
        assert ground.levels.grid.west == WEST + 10.0

    def test_the_surface_is_three_spacings_wide(self, build: Build) -> None:
        assert terrain(build(particles={"spacing": 2.0})).cell == 10.0

    def test_a_scar_lowers_the_origin(self, build: Build) -> None:
        scar = RELEASE | {"depth": 12.0, "place": "in-terrain"}
        assert terrain(build(scar)).origin[2] == 160.0

    def test_a_mixture_has_its_concentration(self, build: Build) -> None:
        own = RELEASE | {"concentration": 0.2, "start": 1.0}
        case = build([RELEASE, own, RELEASE | {"material": "water", "start": 2.0}])
        assert [part.concentration for part in case.release] == [0.5, 0.2, None]


class TestOrigin:
    TABLES: ClassVar[dict[str, Any]] = {
        "obstacle": [
            {
                "type": "box",
                "name": "dam",
                "x": [WEST + 100.0, WEST + 104.0],
                "y": [SOUTH + 40.0, SOUTH + 60.0],
                "z": [255.0, 275.0],
            }
        ],
        "probe": [
            {"type": "height", "name": "gauge", "interval": 1.0, "x": WEST + 90, "y": SOUTH + 50},
            {
                "type": "line",
                "name": "profile",
                "interval": 1.0,
                "start": [WEST + 90, SOUTH + 50, 260.0],
                "end": [WEST + 90, SOUTH + 50, 270.0],
            },
            {
                "type": "grid",
                "name": "section",
                "interval": 1.0,
                "x": [WEST + 90, WEST + 90],
                "y": [SOUTH + 40, SOUTH + 60],
                "z": [260.0, 270.0],
            },
        ],
    }

    def test_places_on_the_map_are_measured_from_it(self, build: Build) -> None:
        case = build(**self.TABLES)
        [dam] = case.obstacle
        assert dam.extents == ((100.0, 104.0), (40.0, 60.0), (75.0, 95.0))
        gauge, profile, section = case.probe
        assert (gauge.x, gauge.y) == (90.0, 50.0)
        assert (profile.start, profile.end) == ((90.0, 50.0, 80.0), (90.0, 50.0, 90.0))
        assert (section.x, section.z) == ((90.0, 90.0), (80.0, 90.0))
        assert case.asked is None  # nothing is rounded

    def test_a_resolved_case_reads_back_as_it_is(self, build: Build, tmp_path: Path) -> None:
        entering = {"type": "hydrograph", "line": LINE, "hydrograph": GRAPH, "velocity": 5.0}
        zone = {"name": "fan", "corners": SQUARE, "friction": VOELLMY}
        case = build([RELEASE, entering], zone=[zone], **self.TABLES)
        path = tmp_path / "elsewhere" / "case.toml"
        path.parent.mkdir()
        path.write_text(dump_case(case), encoding="utf-8")
        again = load_case(path)
        assert again.model_dump() == case.model_dump()
        assert dump_case(again) == dump_case(case)
        assert isinstance(again.release[1], ResolvedHydrographRelease)

    def test_lengths_over_an_origin_stay(self, build: Build) -> None:
        box = {"type": "box", "name": "dam", "x": [100.0, 104.0], "y": [40.0, 60.0]}
        case = build(
            geometry={"origin": [WEST, SOUTH, 100.0]}, obstacle=[box | {"z": [155.0, 175.0]}]
        )
        assert case.obstacle[0].extents == ((100.0, 104.0), (40.0, 60.0), (155.0, 175.0))
        assert terrain(case).height == 250.0


class TestReleases:
    def test_a_volume_over_polygons_with_a_hole(self, build: Build, tmp_path: Path) -> None:
        outer, hole = (
            shapely.box(WEST + a, SOUTH + a, WEST + b, SOUTH + b)
            for a, b in ((20.0, 60.0), (30.0, 40.0))
        )
        write_polygons(tmp_path / "scar.gpkg", [outer.difference(hole)])
        [part] = build({"type": "polygon", "file": "scar.gpkg", "volume": 3000.0}).release
        beside = np.array([25.0, 35.0, 70.0])
        found = depth_at(part, WEST + beside, SOUTH + beside)
        np.testing.assert_allclose(found, [2.0, 0.0, 0.0])
        assert volume(part) == 3000.0

    def test_a_scar_is_taken_for_its_size(self, build: Build, tmp_path: Path) -> None:
        deep = np.full(GRID.shape, np.nan)
        deep[10:12, 4:8] = [[-1.0, -2.0, -2.0, -1.0], [-3.0, -4.0, -4.0, -3.0]]
        write_raster(tmp_path / "scar.asc", Raster(GRID, deep))
        scar = {"type": "raster", "file": "scar.asc", "place": "in-terrain"}
        [part] = build(scar).release
        assert volume(part) == 20.0 * CELL**2
        assert greatest_depth(part) == 4.0
        x, y = np.array([WEST + 27.0, WEST + 80.0]), np.array([SOUTH + 62.0, SOUTH + 62.0])
        np.testing.assert_array_equal(depth_at(part, x, y), [4.0, 0.0])

    def test_a_raster_and_a_polygon_overlap(self, build: Build, tmp_path: Path) -> None:
        write_raster(tmp_path / "deep.asc", Raster(GRID, np.full(GRID.shape, 0.5)))
        with pytest.raises(CaseError, match=r"overlaps release\.0 over 400 m2 at the same time"):
            build([RELEASE, {"type": "raster", "file": "deep.asc"}])

    def test_line_and_hydrograph_of_files(self, build: Build, tmp_path: Path) -> None:
        (tmp_path / "in.geojson").write_text(
            json.dumps({"type": "LineString", "coordinates": LINE})
        )
        (tmp_path / "in.csv").write_text(
            "time,discharge,concentration\n0,0,0.3\n10,50,0.3\n30,0,0.3\n"
        )
        entering = {"type": "hydrograph", "line": "in.geojson", "hydrograph": "in.csv"}
        [part] = build(entering | {"velocity": 5.0, "start": 3.0}).release
        assert isinstance(part, ResolvedHydrographRelease)
        assert part.line == tuple(map(tuple, LINE))
        assert part.hydrograph.discharge == (0.0, 50.0, 0.0)
        assert part.direction == 90.0  # to the east, down the slope
        assert volume(part) == 750.0

    def test_a_direction_may_be_given(self, build: Build) -> None:
        entering = {"type": "hydrograph", "line": LINE, "hydrograph": GRAPH, "velocity": 5.0}
        [part] = build(entering | {"direction": 70.0}).release
        assert part.direction == 70.0

    def test_a_zone_by_polygon_and_by_raster(self, build: Build, tmp_path: Path) -> None:
        classes = np.where(levels() > 250.0, 1.0, 2.0)
        write_raster(tmp_path / "classes.asc", Raster(GRID, classes))
        law = {"law": "coulomb", "angle": 30.0}
        low, square = build(
            zone=[
                {"name": "low", "raster": "classes.asc", "value": 2.0, "friction": law},
                {"name": "square", "corners": SQUARE, "friction": law},
            ]
        ).zone
        x, y = WEST + np.array([30.0, 200.0, 999.0]), np.full(3, SOUTH + 50.0)
        assert is_in_zone(low, x, y).tolist() == [False, True, False]
        assert is_in_zone(square, x, y).tolist() == [True, False, False]

    def test_pore_pressure_is_there_where_it_is_asked_for(self, build: Build) -> None:
        plain = initial_state(build()).particles
        assert plain.count > 0
        assert plain.pore_pressure.size == plain.relative_velocity.size == 0
        wet = initial_state(build(RELEASE | {"pore_pressure": 0.4, "pore_pressure_time": 8.0}))
        np.testing.assert_array_equal(wet.particles.pore_pressure, 0.4)
        np.testing.assert_array_equal(wet.particles.pore_pressure_rate, 0.125)


class TestSpeeds:
    def expected(self, case: ResolvedCase) -> float:
        return expected_speed(
            terrain(case), case.release, case.zone, case.walls.floor, case.gravity
        )

    def test_friction_holds_a_flow(self, build: Build) -> None:
        case, theta = build(), radians(ANGLE)
        held = sqrt(400.0 * 8.0 / 9.0 * (sin(theta) - 0.1 * sqrt(1.0 - sin(theta) ** 2)))
        assert self.expected(case) == pytest.approx(held, rel=1e-4)
        assert case.explicit_scheme.sound_speed == pytest.approx(6.0 * held, rel=1e-4)
        assert speeds(case) == pytest.approx((0.0, held), rel=1e-4)

    def test_a_dem_that_is_written_anew_is_read_anew(self, build: Build, tmp_path: Path) -> None:
        steep = self.expected(build())
        flat = 300.0 + 0.5 * (levels() - 300.0)

        def found(level: np.ndarray) -> float:
            write_raster(tmp_path / "dem.asc", Raster(GRID, level))
            place = {"origin": [WEST, SOUTH, 100.0], "upper_level": 400.0}
            return self.expected(build(geometry=place))

        assert found(levels()) == steep > found(flat)

    def test_sliding_is_held_by_the_drop_alone(self, build: Build) -> None:
        law = {"law": "coulomb", "angle": 10.0}
        found = self.expected(build(walls={"floor": {"friction": law}}))
        # from the cell before the release to the last one, and its depth; along from its end
        drop = 280.0 * tan(radians(ANGLE)) + 2.0 - 257.5 * tan(radians(10.0))
        assert found == pytest.approx(sqrt(2.0 * 9.81 * drop))

    def test_what_does_not_slide_collapses(self, build: Build) -> None:
        law = {"law": "coulomb", "angle": 35.0}
        found = self.expected(build(walls={"floor": {"friction": law}}))
        assert found == pytest.approx(sqrt(2.0 * 9.81 * 2.0))

    def test_a_given_speed_counts(self, build: Build) -> None:
        case = build(RELEASE | {"velocity": [30.0, 40.0]})
        assert case.explicit_scheme.sound_speed == pytest.approx(300.0)


class TestForecast:
    def test_particles_of_releases(self, build: Build) -> None:
        entering = {"type": "hydrograph", "line": LINE, "hydrograph": GRAPH, "velocity": 5.0}
        case = build([RELEASE, RELEASE | {"start": 10.0}, entering], particles={"spacing": 0.5})
        found = particle_estimate(case)
        assert (found["fluid"], found["inflow"]) == (6400.0, 6400.0 + 6000.0)
        times = np.linspace(0.0, 60.0, 6001)
        assert np.trapezoid([growth(case, t) for t in times], times) == pytest.approx(6000.0)

    def test_rows(self, build: Build) -> None:
        entering = {"type": "hydrograph", "line": LINE, "hydrograph": GRAPH, "velocity": 0.5}
        case = build([RELEASE | {"name": "scar"}, entering])
        assert rows_over_depths(case) == {"release.scar": 2, "release.1": 5}

    def test_a_flow_of_less_than_a_row_for_most_of_its_time_is_told(self, build: Build) -> None:
        # a row is 1 m over 20 m at 2 m/s: 40 m3/s
        long = {"time": [0.0, 10.0, 300.0], "discharge": [0.0, 79.0, 0.0]}
        flow = {"type": "hydrograph", "name": "flood", "line": LINE, "velocity": 2.0}
        flow["hydrograph"] = GRAPH | {"discharge": [0.0, 80.0, 80.0]}
        assert doubts(build(flow)) == []
        flow["hydrograph"] = long | {"concentration": [0.3] * 3}
        assert doubts(build(flow)) == []  # in the first minute
        [thin] = doubts(build(flow, time={"end": 400.0}))
        assert thin.startswith("release.flood: for 51% of the time in which it flows its discharge")

    def test_a_surface_finer_than_three_spacings_is_told(self, build: Build) -> None:
        assert doubts(build(geometry={"cell": 5.0})) == []
        deep, coarse = RELEASE | {"depth": 5.0}, {"spacing": 2.0}
        [fine] = doubts(build(deep, geometry={"cell": 5.0}, particles=coarse))
        assert fine.startswith("geometry.cell = 5 m: less than 3 spacings, 6 m")

    def test_doubts(self, build: Build, tmp_path: Path) -> None:
        assert doubts(build()) == []
        late = doubts(build(RELEASE | {"start": 60.0, "depth": 1.0}))
        assert [line.split(":")[0] for line in late] == ["release.0.start = 60 s", "release.0"]
        [bare] = doubts(build(walls={}))
        assert bare.startswith("walls.floor: no-slip, without a law of friction")
        write_raster(tmp_path / "feet.asc", Raster(GRID, levels() / 0.3048))
        [steep] = doubts(build(geometry={"dem": "feet.asc"}))
        assert steep.startswith("geometry.dem: half of the ground is steeper than 50 degrees")


class TestFiles:
    def refused(self, build: Build, **tables: Any) -> str:
        with pytest.raises(CaseError) as caught:
            build(**tables)
        [_, line] = str(caught.value).splitlines()
        return line.strip()

    def test_a_rotated_dem(self, build: Build, tmp_path: Path) -> None:
        with rasterio.open(
            tmp_path / "dem.tif",
            "w",
            driver="GTiff",
            width=60,
            height=24,
            count=1,
            dtype="float32",
            transform=Affine(4.9, 0.9, WEST, 0.9, -4.9, SOUTH + 120.0),
        ) as file:
            file.write(levels().astype(np.float32), 1)
        line = self.refused(build, geometry={"dem": "dem.tif"})
        assert line.startswith('geometry.dem = "dem.tif": is rotated against the map')

    def test_without_the_extra(
        self, build: Build, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        for name in ("rasterio", "rasterio.crs", "pyogrio"):
            monkeypatch.setitem(sys.modules, name, None)
        (tmp_path / "dem.tif").touch()
        install = 'which is not installed: pip install rasterio pyogrio (the extra "terrain")'
        assert self.refused(build, geometry={"dem": "dem.tif"}).endswith(install)
        release = {"type": "polygon", "file": "dem.asc", "depth": 1.0}
        assert self.refused(build, release=release).endswith(install)
        terrain(build())  # needs neither
