"""The perspective of a flow on a terrain: where particles are seen, and from where."""

import numpy as np
import pytest
from PIL import Image

from debrisflow.case.rasters import MapGrid, Raster
from debrisflow.results import open_run
from debrisflow.results.maps.layers import terrain_around
from debrisflow.results.pictures.coloring import Scale
from debrisflow.results.pictures.render import render
from debrisflow.results.pictures.sheet import Sheet, layout
from debrisflow.results.pictures.terrain import TerrainPanels, path_of, terrain_mesh
from debrisflow.results.pictures.views import OPENING
from debrisflow.space.scene import Scene
from tests.fan import GRID, fan_case, frame_at, terrain
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


def test_what_is_taken_out_of_the_terrain_lies_in_it(tmp_path):
    """So that it is seen: the ground is drawn without it."""
    case = fan_case(tmp_path, release={"place": "in-terrain"})
    folder = written(tmp_path / "run", case, frames=1)
    run = open_run(folder)
    drawn, given = terrain_around(run), Raster(LOCAL, terrain() - case.geometry.origin[2])
    frame = run.frame()
    row = ((LOCAL.north - frame.position[:, 1]) // LOCAL.cell).astype(int)
    column = (frame.position[:, 0] // LOCAL.cell).astype(int)
    lowered = (given.values - drawn.values)[row, column]
    assert 2.5 < np.median(lowered) < 4.5
    over = frame.position[:, 2] - drawn.values[row, column]
    assert over.min() > -3.0  # beside the scar, 4 m deep
    assert np.mean(over) > 1.0


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
    folder = written(tmp_path / "run", fan_case(tmp_path))
    page, animation = render(folder, by="speed")
    assert [file.name for file in (page, animation)] == [
        "perspective_speed.png",
        "perspective_speed.gif",
    ]
    with Image.open(animation) as frames:
        assert frames.n_frames == 3
