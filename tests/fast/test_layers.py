"""Layers of a map: volume is kept, cells are right, files say what they hold."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pyogrio
import pytest
import rasterio

from debrisflow._jit import set_threads
from debrisflow.case import rasters, vectors
from debrisflow.case.rasters import MapGrid, read_raster
from debrisflow.particles.layers import no_layers
from debrisflow.particles.record import Particles, blank
from debrisflow.run.layer_recorder import LayerRecorder
from debrisflow.run.layers import (
    LAYERS,
    DepthFrames,
    Origin,
    layer_files,
    polygons_of,
    write_layers,
)

UTM = rasterio.crs.CRS.from_epsg(32610).to_wkt()
GRID = MapGrid(500_000.0, 5_100_000.0, 2.0, 30, 20, UTM)
ORIGIN = Origin(64 * "0", 1.0, 0.05, 12.5)


def particles(
    position: np.ndarray, velocity: object = (0.0, 0.0, 0.0), density: float = 2000.0
) -> Particles:
    found = blank(len(position))
    found.fluid_count = len(position)
    found.position[:], found.velocity[:], found.density[:] = position, velocity, density
    return found


def scattered(count: int = 4000, grid: MapGrid = GRID) -> Particles:
    rng = np.random.default_rng(5)
    place = rng.uniform(0.0, 1.0, (count, 3)) * (grid.columns * grid.cell, grid.rows * grid.cell, 5)
    return particles(place, rng.normal(0.0, 3.0, (count, 3)))


@pytest.mark.parametrize("cell", [0.4, 1.0, 2.0, 7.0])
@pytest.mark.parametrize("spacing", [0.5, 1.0])
def test_all_volume_on_the_map_is_in_its_cells(cell: float, spacing: float) -> None:
    grid = GRID._replace(cell=cell)
    depth = LayerRecorder(grid, spacing, 0.05).depth(scattered(grid=grid))
    assert depth.sum() * cell**2 == pytest.approx(4000 * spacing**3, rel=1e-12)


def test_what_is_beyond_the_map_does_not_count() -> None:
    recorder = LayerRecorder(GRID, 1.0, 0.05)
    beyond = [[-0.1, 5.0, 0.0], [60.1, 5.0, 0.0], [5.0, -0.1, 0.0], [5.0, 40.1, 0.0]]
    assert recorder.depth(particles(np.array(beyond))).sum() == 0.0
    layers = no_layers(*recorder.depth(particles(np.zeros((0, 3)))).shape)
    recorder.add_step(layers, particles(np.zeros((0, 3))), 1.0, 1.0)
    assert not layers.peak_depth.any()


@pytest.mark.parametrize(("cell", "ripple"), [(0.8, 1e-12), (1.6, 0.015)])
def test_a_uniform_layer_has_its_depth(cell: float, ripple: float) -> None:
    # exact where the square is a multiple of the spacing wide
    middles = np.arange(0.25, 20.0, 0.5)
    place = np.stack(np.meshgrid(middles, middles, [0.25, 0.75, 1.25]), axis=-1).reshape(-1, 3)
    grid = MapGrid(0.0, 0.0, cell, 12, 12)
    depth = LayerRecorder(grid, 0.5, 0.05).depth(particles(place))
    np.testing.assert_allclose(depth[1:-1, 1:-1], 1.5, rtol=ripple)


def test_a_particle_in_the_middle_of_a_wide_cell_is_there_alone() -> None:
    grid = MapGrid(0.0, 0.0, 10.0, 4, 3)
    depth = LayerRecorder(grid, 2.0, 0.05).depth(particles(np.array([[25.0, 15.0, 3.0]])))
    expected = np.zeros((4, 3))
    expected[2, 1] = 8.0 / 100.0
    np.testing.assert_allclose(depth, expected, atol=1e-15)


def test_a_flow_along_a_row_of_wide_cells_stays_in_it() -> None:
    grid = MapGrid(0.0, 0.0, 10.0, 4, 3)
    across = np.array([[5.0, y, 0.5] for y in np.arange(11.5, 19.0, 1.0)])
    depth = LayerRecorder(grid, 1.0, 0.05).depth(particles(across))
    assert depth[:, [0, 2]].max() == 0.0
    assert depth[0, 1] == pytest.approx(8 * 1.0 / 100.0)


def test_products_are_those_of_a_step_not_of_maxima() -> None:
    grid = MapGrid(0.0, 0.0, 1.0, 1, 1)
    recorder, layers = LayerRecorder(grid, 0.5, 0.05), no_layers(1, 1)
    many, few = np.full((8, 3), 0.5), np.full((2, 3), 0.5)
    recorder.add_step(layers, particles(many, (1.0, 0.0, 0.0)), 1.0, 0.5)
    recorder.add_step(layers, particles(few, (0.0, 2.4, 3.2)), 1.5, 0.5)
    found = {name: float(value[0, 0]) for name, value in vars(layers).items()}
    assert found == pytest.approx(
        {
            "peak_depth": 1.0,
            "peak_speed": 4.0,
            "peak_momentum_flux": 4.0,  # 0.25 m, (4 m/s)^2; and not 1 m
            "peak_pressure": 32.0,
            "arrival": 1.0,
            "duration": 1.0,
        }
    )


def test_a_mixture_of_densities_has_the_speed_of_its_momentum() -> None:
    recorder, layers = LayerRecorder(MapGrid(0.0, 0.0, 1.0, 1, 1), 0.5, 0.05), no_layers(1, 1)
    both = particles(np.full((2, 3), 0.5), [[3.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    both.density[:] = 1000.0, 2000.0
    recorder.add_step(layers, both, 1.0, 0.5)
    assert layers.peak_speed[0, 0] == pytest.approx(1.0)
    assert layers.peak_pressure[0, 0] == pytest.approx(1.5)


def test_only_what_is_deeper_than_the_threshold_arrives() -> None:
    recorder, layers = LayerRecorder(MapGrid(0.0, 0.0, 1.0, 1, 1), 0.5, 0.2), no_layers(1, 1)
    for time, count in ((1.0, 1), (2.0, 2), (3.0, 1), (4.0, 3)):
        recorder.add_step(layers, particles(np.full((count, 3), 0.5), (9.0, 0, 0)), time, 1.0)
        assert (layers.peak_speed[0, 0] > 0.0) == (time > 1.0)
    assert (layers.arrival[0, 0], layers.duration[0, 0]) == (2.0, 2.0)


def test_bits_do_not_depend_on_threads() -> None:
    found = []
    try:
        for threads in (1, 2):
            assert set_threads(threads) == threads
            layers = no_layers(GRID.columns, GRID.rows)
            LayerRecorder(GRID, 1.0, 0.05).add_step(layers, scattered(), 1.0, 0.1)
            found.append(b"".join(value.tobytes() for value in vars(layers).values()))
    finally:
        set_threads(1)
    assert found[0] == found[1]


def recorded() -> tuple[LayerRecorder, Particles]:
    """Return particles on the cell in the third column and second row from the south-west."""
    place = np.full((6, 3), (5.0, 3.0, 1.0))
    return LayerRecorder(GRID, 1.0, 0.05), particles(place, (3.0, 0.0, 4.0))


def test_a_release_on_a_known_cell_appears_on_that_cell(tmp_path: Path) -> None:
    recorder, flow = recorded()
    layers = no_layers(GRID.columns, GRID.rows)
    recorder.add_step(layers, flow, 12.5, 0.5)
    deposit = recorder.depth(flow, slower_than=0.05)
    others = {"deposit": deposit, "final_depth": recorder.depth(flow)}
    files = write_layers(tmp_path / "layers", GRID, layers, others, ORIGIN)
    assert all(file.is_file() for file in files)
    assert {file.suffix for file in files} == {".tif", ".qml", ".geojson", ".gpkg"}
    assert sorted(layer_files(tmp_path / "layers")) == sorted(files)
    with rasterio.open(tmp_path / "layers" / "peak_depth.tif") as file:
        assert (file.crs.to_epsg(), file.nodata, file.dtypes) == (32610, -9999.0, ("float32",))
        assert file.transform == rasterio.Affine(2.0, 0.0, GRID.west, 0.0, -2.0, GRID.north)
        row, column = file.index(GRID.west + 5.0, GRID.south + 3.0)
        values = file.read(1, masked=True)
        assert (values.count(), values[row, column]) == (1, 1.5)
        tags = file.tags()
    assert tags["unit"] == "m"
    assert tags["threshold"] == "0.05 m"
    assert tags["particle_spacing"] == "1 m"
    assert tags["case_sha256"] == ORIGIN.case
    speed = read_raster(tmp_path / "layers" / "peak_speed.tif").plan
    assert speed[2, 1] == 5.0
    assert np.isnan(np.delete(speed, 2, axis=0)).all()
    whole = vectors.read_polygons(tmp_path / "layers" / "extent.geojson").shapes
    assert [shape.bounds for shape in whole] == [(500_004.0, 5_100_002.0, 500_006.0, 5_100_004.0)]
    info = pyogrio.read_info(tmp_path / "layers" / "extent.gpkg")
    assert (info["crs"], info["features"], list(info["fields"])) == (
        "EPSG:32610",
        1,
        ["area_m2", "deeper_than_m"],
    )
    assert deposit.sum() == 0.0


def test_the_page_of_the_layers_has_all_of_them() -> None:
    page = (Path(__file__).parents[2] / "docs" / "terrain_outputs.md").read_text(encoding="utf-8")
    for name, layer in LAYERS.items():
        assert f"| `{name}` | {layer.unit} | " in page
    assert f"| `release` | m | {LAYERS['release'].meaning}" in page


def test_styles_are_xml_with_a_class_for_all_values(tmp_path: Path) -> None:
    recorder, flow = recorded()
    layers = no_layers(GRID.columns, GRID.rows)
    recorder.add_step(layers, flow, 12.5, 0.5)
    terrain = np.linspace(1000.0, 1200.0, GRID.columns * GRID.rows).reshape(30, 20)
    write_layers(tmp_path, GRID, layers, {"terrain": terrain}, ORIGIN)
    for file in tmp_path.glob("*.qml"):
        shader = ElementTree.parse(file).getroot().find(".//colorrampshader")
        assert shader is not None
        items = shader.findall("item")
        limits = [float(item.get("value", "nan")) for item in items]
        assert limits == sorted(limits)
        assert limits[-1] == (1200.0 if file.stem == "terrain" else np.inf)
        assert all(LAYERS[file.stem].unit in item.get("label", "") for item in items)


def test_without_the_extra_there_are_grids_in_text_and_geojson(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> None:
        raise rasters.UnreadableRasterError(rasters.INSTALL)

    def no_vectors() -> None:
        raise vectors.UnreadableVectorsError(vectors.INSTALL)

    monkeypatch.setattr(rasters, "_rasterio", missing)
    monkeypatch.setattr(vectors, "_pyogrio", no_vectors)
    layers = no_layers(GRID.columns, GRID.rows)  # that nothing has reached
    files = write_layers(tmp_path, GRID, layers, {}, ORIGIN)
    assert {file.suffix for file in files} == {".asc", ".prj", ".qml", ".geojson"}
    assert (tmp_path / "peak_depth.asc").read_text().splitlines()[6].split()[0] == "-9999"
    assert sorted(layer_files(tmp_path)) == sorted(files)


def test_an_extent_of_nothing_is_written(tmp_path: Path) -> None:
    layers = no_layers(GRID.columns, GRID.rows)
    write_layers(tmp_path, GRID, layers, {}, ORIGIN)
    assert pyogrio.read_info(tmp_path / "extent.gpkg")["features"] == 0


def test_outlines_keep_holes_and_part_at_corners() -> None:
    grid = MapGrid(0.0, 0.0, 1.0, 5, 3)
    chosen = np.array([[1, 1, 1, 0, 0], [1, 0, 1, 0, 0], [1, 1, 1, 0, 1]], dtype=bool)
    chosen[0, 3] = False
    ring, alone = polygons_of(grid, chosen)
    assert (ring.area, len(ring.interiors), len(ring.exterior.coords)) == (8.0, 1, 5)
    assert alone.bounds == (4.0, 0.0, 5.0, 1.0)
    assert len(polygons_of(grid, np.eye(3, 5, dtype=bool))) == 3


def test_frames_of_depth_are_continued_and_cut(tmp_path: Path) -> None:
    frames, depth = DepthFrames(tmp_path, GRID), np.ones((30, 20))
    for time in (0.0, 1.0, 2.0):
        frames.write(time * depth, ORIGIN._replace(time=time))
    frames.close()
    frames = DepthFrames(tmp_path, GRID)
    frames.truncate_after(1.0)
    frames.write(7.0 * depth, ORIGIN._replace(time=1.5))
    frames.close()
    assert sorted(file.name for file in tmp_path.glob("*.tif")) == [
        f"depth_00000{k}.tif" for k in range(3)
    ]
    assert read_raster(tmp_path / "depth_000002.tif").values[0, 0] == 7.0
    assert (tmp_path / "depth.csv").read_text().splitlines()[-1] == "1.5,2"
    assert len(list(layer_files(tmp_path))) == 4


def test_the_page_names_every_layer_with_unit_and_meaning() -> None:
    page = (Path(__file__).parents[2] / "docs" / "terrain_outputs.md").read_text(encoding="utf-8")
    for name, layer in LAYERS.items():
        assert f"| `{name}` | {layer.unit} | " in page
    assert f"| `release` | m | {LAYERS['release'].meaning}" in page
