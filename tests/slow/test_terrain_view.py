"""The perspective of a flow on a terrain: where particles are seen, and from where."""

import numpy as np
import pytest
from PIL import Image

from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.results.pictures.coloring import Scale
from debrisflow.results.pictures.render import render
from debrisflow.results.pictures.sheet import Sheet, layout
from debrisflow.results.pictures.terrain import TerrainPanels, path_of, terrain_mesh
from debrisflow.results.pictures.views import OPENING
from debrisflow.space.scene import Scene
from tests.building import tank3d_case
from tests.fan import GRID, frame_at, terrain, write_layers
from tests.slow.test_render import screen, written

LOCAL = GRID._replace(west=0.0, south=0.0)
NOTHING_AROUND = Scene([], [], [], [])
__all__ = ["screen"]  # a fixture


def test_the_mesh_is_as_high_as_the_terrain_where_its_cells_are():
    rough = Raster(LOCAL, terrain())
    mesh = terrain_mesh(rough)
    x, y, z = np.asarray(mesh.points).T
    row = np.rint((LOCAL.north - y) / LOCAL.cell - 0.5).astype(int)
    column = np.rint(x / LOCAL.cell - 0.5).astype(int)
    assert z == pytest.approx(rough.values[row, column], abs=1e-3)
    # a slope to the north-west is bright, one to the south-east dark
    shade = np.asarray(mesh["shade"])[:, 0]
    assert shade.std() > 10.0


def test_cells_without_a_level_are_left_out():
    levels = np.ones((6, 6))
    levels[2, 2] = np.nan
    mesh = terrain_mesh(Raster(MapGrid(0.0, 0.0, 1.0, 6, 6), levels))
    assert mesh.cast_to_unstructured_grid().n_points == 36
    hidden = np.asarray(mesh["vtkGhostType"])
    assert np.flatnonzero(hidden).tolist() == [3 * 6 + 2]  # row 3 from the south


def test_the_eye_is_downstream_and_sees_all():
    frames = [frame_at(0), frame_at(90)]
    panels = TerrainPanels(Raster(LOCAL, terrain()), NOTHING_AROUND, frames, 1.0)
    flow = path_of(LOCAL, frames)
    assert flow.direction[1] < -0.9  # to the south
    position = np.concatenate([frame.position for frame in frames])
    middle = position.mean(axis=0)
    assert (panels.camera.position - middle)[:2] @ flow.direction > 0.0
    half = np.tan(np.radians(0.5 * OPENING))
    assert np.abs(panels.camera.seen(position)).max() < half


@pytest.mark.usefixtures("screen")
def test_a_particle_is_seen_where_it_stands_on_the_ground():
    frames = [frame_at(0), frame_at(90)]
    panels = TerrainPanels(Raster(LOCAL, terrain()), NOTHING_AROUND, frames, 1.0)
    sheet = Sheet(1, layout(1, panels.aspect, panels.room), 100, ("", ""))
    axes = sheet.panel(0)
    # the deposit alone: as yellow as the scale ends
    panels.draw(axes, frames[1], Scale("speed", -2.0, -1.0), sheet.pixels)
    image = sheet.image()[::-1]
    place = frames[1].position[np.argmin(np.abs(frames[1].position[:, 1] - 200.0))]
    column, row = axes.transData.transform(panels.camera.seen(place[None])[0])
    red, green, blue = image[int(row), int(column)].astype(int)
    assert red - blue > 100
    assert green - blue > 60
    panels.close()


@pytest.mark.usefixtures("screen")
def test_a_run_on_a_terrain_gives_a_page_and_an_animation(tmp_path):
    folder = written(tmp_path / "run", tank3d_case())
    write_layers(folder)
    page, animation = render(folder, by="speed")
    assert [file.name for file in (page, animation)] == [
        "perspective_speed.png",
        "perspective_speed.gif",
    ]
    with Image.open(animation) as frames:
        assert frames.n_frames == 3
