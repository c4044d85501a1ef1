"""The free surface: still water, drops, overturning waves, walls that it ends at, its files."""

import numpy as np
import pytest
import pyvista
from click.testing import CliRunner

from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.particles.record import Kind
from debrisflow.particles.seeding import wall_particles
from debrisflow.results import open_run, surfaces
from debrisflow.results.frames import Frame
from debrisflow.results.surface_files import write_surfaces
from debrisflow.results.surfaces import free_surface
from debrisflow.run.folder import RunFolder
from tests.building import tank3d_case, tank_case
from tests.recording import cells, channel_case, placed, record, state_of

D0 = 0.01


def surface_of(case, position, kind=Kind.LIQUID):
    """Return the surface of particles in the walls of a case."""
    frame = Frame(0.0, position, {"kind": np.full(len(position), kind)})
    return free_surface(frame, case, wall_particles(case).position)


def corners(surface):
    """Return the places of the corners of each cell, (cells, corners, 3) array."""
    return surface.points[surface.cells]


def length(surface):
    first, second = np.moveaxis(corners(surface), 1, 0)
    return np.linalg.norm(second - first, axis=1).sum()


def disk(radius, middle, spacing=D0):
    """Return the points of a lattice within a circle, or a sphere in three dimensions."""
    axis = spacing * (np.arange(-40, 40) + 0.5)
    found = np.zeros((axis.size ** len(middle), 3))
    grid = np.meshgrid(*[axis] * len(middle), indexing="ij")
    found[:, : len(middle)] = np.stack(grid, axis=-1).reshape(-1, len(middle))
    found = found[np.linalg.norm(found, axis=1) < radius]
    found[:, : len(middle)] += middle
    return found


def test_the_surface_of_a_still_tank_is_its_level_from_wall_to_wall():
    case = tank_case(40, 20, "water")
    surface = surface_of(case, cells(case, range(40), range(20)))
    np.testing.assert_allclose(surface.points[:, 1], 0.2, atol=0.1 * D0)
    ends = surface.points[:, 0].min(), surface.points[:, 0].max()
    np.testing.assert_allclose(ends, (0.0, 0.4), atol=0.1 * D0)
    assert length(surface) == pytest.approx(0.4, rel=0.01)
    order = np.argsort(surface.points[:, 0])
    area = np.trapezoid(surface.points[order, 1], surface.points[order, 0])
    assert area == pytest.approx(0.4 * 0.2, rel=0.02)


def test_the_surface_of_a_still_tank_in_three_dimensions():
    case = tank3d_case(size=(1.0, 0.8, 1.0))
    surface = surface_of(case, cells(case, range(10), range(8), range(5)))
    np.testing.assert_allclose(surface.points[:, 2], 0.5, atol=0.01)
    a, b, c = np.moveaxis(corners(surface), 1, 0)
    normal = 0.5 * np.cross(b - a, c - a)
    assert np.abs(normal[:, 2]).sum() == pytest.approx(0.8, rel=0.02)  # corners are round
    volume = np.sum(np.abs(normal[:, 2]) * (a + b + c)[:, 2] / 3.0)
    assert volume == pytest.approx(0.8 * 0.5, rel=0.02)


@pytest.mark.parametrize("radius", [0.05, 0.1, 0.2])
def test_a_disk_has_its_circumference_and_area(radius):
    middle = np.array([0.31, 0.34])
    position = disk(radius, middle)
    surface = surface_of(tank_case(60, 40, "water"), position)
    same = np.sqrt(len(position) * D0**2 / np.pi)  # radius of a circle of as much matter
    assert length(surface) == pytest.approx(2.0 * np.pi * same, rel=0.03)
    first, second = np.moveaxis(corners(surface)[..., :2] - middle, 1, 0)
    doubled = np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    assert 0.5 * doubled.sum() == pytest.approx(len(position) * D0**2, rel=0.02)


def test_a_ball_has_its_volume():
    middle = np.array([1.5, 1.5, 1.5])
    position = disk(0.8, middle, 0.1)
    surface = surface_of(tank3d_case(size=(3.0, 3.0, 3.0)), position)
    a, b, c = np.moveaxis(corners(surface) - middle, 1, 0)
    volume = np.abs(np.einsum("ij,ij->i", a, np.cross(b, c))).sum() / 6.0
    assert volume == pytest.approx(len(position) * 0.1**3, rel=0.03)


def test_particles_in_disorder_have_one_surface_and_no_holes():
    case = tank_case(40, 20, "water")
    position = cells(case, range(40), range(20))
    position[:, :2] += np.random.default_rng(1).uniform(-0.25, 0.25, (len(position), 2)) * D0
    surface = surface_of(case, position)
    np.testing.assert_allclose(surface.points[:, 1], 0.2, atol=0.5 * D0)
    assert length(surface) == pytest.approx(0.4, rel=0.03)


def test_an_overturning_wave_has_three_levels_at_one_place():
    case = tank_case(60, 40, "water")
    position = cells(case, range(60), range(40))
    x, y = position[:, 0], position[:, 1]
    water = y < 0.05
    wave = (x < 0.15) & (y < 0.25) | (x < 0.3) & (y > 0.17) & (y < 0.25)  # a lip over air
    surface = surface_of(case, position[water | wave])
    first, second = np.moveaxis(corners(surface), 1, 0)
    crossing = (first[:, 0] - 0.2212) * (second[:, 0] - 0.2212) < 0.0
    levels = np.sort(0.5 * (first + second)[crossing, 1])
    np.testing.assert_allclose(levels, [0.05, 0.17, 0.25], atol=0.1 * D0)


def test_the_surface_goes_through_the_end_of_a_period():
    case = tank3d_case(size=(1.0, 0.8, 1.0), geometry={"periodic": True})
    position = cells(case, range(10), range(8), range(5))
    position[:, 1] -= 0.33  # the same water, a part of it before the period
    surface = surface_of(case, position)
    np.testing.assert_allclose(surface.points[:, 2], 0.5, atol=0.01)
    ends = surface.points[:, 1].min(), surface.points[:, 1].max()
    np.testing.assert_allclose(ends, (0.0, 0.8), atol=1e-12)


def test_the_surface_ends_at_an_obstacle():
    box = {"type": "box", "name": "pier", "x": [0.4, 0.6], "y": [0.0, 0.8], "z": [0.0, 0.9]}
    block = {"type": "block", "y": [0.0, 0.8], "z": [0.0, 0.5], "material": "water"}
    fill = [block | {"x": [0.0, 0.4]}, block | {"x": [0.6, 1.0]}]
    case = tank3d_case(size=(1.0, 0.8, 1.0), obstacle=[box], fill=fill)
    position = cells(case, range(10), range(8), range(5))
    dry = (position[:, 0] < 0.4) | (position[:, 0] > 0.6)
    surface = surface_of(case, position[dry])
    np.testing.assert_allclose(surface.points[:, 2], 0.5, atol=0.02)
    inside = np.abs(surface.points[:, 0] - 0.5) < 0.1 - 0.02
    assert not inside.any()


def test_no_water_has_no_surface_and_supply_has_one_from_the_inlet_on(tmp_path):
    case = channel_case(
        inflow={"depth": 0.1, "velocity": 1.0},
        geometry={"type": "channel", "length": 1.0, "height": 0.5},
    )
    assert len(surface_of(case, np.zeros((0, 3))).cells) == 0
    assert surface_of(case, np.zeros((0, 3))).mesh.n_points == 0
    supply = surface_of(case, cells(case, range(-5, 10), range(5)))
    level = supply.points[supply.points[:, 0] < 0.1]
    np.testing.assert_allclose(level[:, 1], 0.1, atol=0.006)  # up a little at the inlet's edge
    assert level[:, 0].min() == pytest.approx(0.0, abs=1e-12)


def test_points_far_from_the_origin_keep_their_digits():
    case = channel_case(length=1001.0)
    position = cells(case, range(50_000, 50_030), range(10))
    surface = surface_of(case, position)
    inner = surface.points[np.abs(surface.points[:, 0] - 1000.3) < 0.2]
    np.testing.assert_allclose(inner[:, 1], 0.2, atol=0.002)
    # between nodes 0.01 m apart; numbers of single precision are 0.00006 m apart there
    np.testing.assert_allclose(inner[:, 0], np.round(inner[:, 0], 2), atol=1e-5)


def test_a_surface_that_needs_too_many_nodes_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(surfaces, "MOST_NODES", 1000)
    run = open_run(waves(tmp_path / "run"))
    with pytest.raises(OutputError, match=r"needs a grid of .* nodes .*, at most 1e\+03"):
        write_surfaces(run)


def waves(path):
    """Write a run of two frames in which water rises, and return its folder."""
    case = channel_case()
    states = [
        state_of(case, placed(case, cells(case, range(50), range(n))), 0.1 * n) for n in (4, 6)
    ]
    return record(path, case, states)


def test_surfaces_of_all_frames_are_written_for_paraview_and_removed_with_the_run(tmp_path):
    path = waves(tmp_path / "run")
    result = CliRunner().invoke(main, ["postprocess", str(path), "--surface"])
    assert result.exit_code == 0, result.output
    assert f"wrote {path / 'postprocess' / 'surface.pvd'}" in result.output
    series = pyvista.get_reader(path / "postprocess" / "surface.pvd")
    assert series.time_values == pytest.approx([0.4, 0.6])
    for number, level in enumerate((0.08, 0.12)):
        mesh = pyvista.read(path / "postprocess" / "surface" / f"{number:06d}.vtp")
        assert mesh.points[:, 1].max() == pytest.approx(level, abs=0.002)
    surface = open_run(path).surface(0.4)
    assert surface.points[:, 1].max() == pytest.approx(0.08, abs=0.002)
    assert surface.cells.shape[1] == 2
    RunFolder.create(path, channel_case(), overwrite=True).close()
    assert not (path / "postprocess").exists()
