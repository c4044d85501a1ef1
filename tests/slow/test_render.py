"""Pictures of runs: what must be true of their pixels, and what is said where there are none."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from debrisflow.case import Case
from debrisflow.case.defaults import complete
from debrisflow.cli import main
from debrisflow.errors import OutputError
from debrisflow.particles.arrays import COLORED
from debrisflow.particles.record import Kind
from debrisflow.particles.start import initial_state
from debrisflow.results import open_run
from debrisflow.results.pictures import offscreen
from debrisflow.results.pictures.coloring import KIND_COLORS, channels, scale_of
from debrisflow.results.pictures.panels import (
    SOLID,
    PlanPanels,
    SidePanels,
    over_grid,
    straightened,
)
from debrisflow.results.pictures.render import DOTS, render
from debrisflow.results.pictures.sheet import CENTIMETERS_PER_INCH, WIDTH, Layout, Sheet
from debrisflow.results.pictures.views import Camera, PerspectiveView, SectionView, Tiles, Window
from debrisflow.run.folder import RunFolder
from debrisflow.space.scene import scene_of
from tests.building import tank3d_case

WHITE = [255, 255, 255]
RED, BLUE = [200, 0, 0], [0, 0, 200]


@pytest.fixture(scope="module")
def screen():
    """Skip where VTK has no driver to render with."""
    try:
        offscreen.require_offscreen()
    except OutputError as error:
        # pip installs VTK without a driver to draw with: on a system that has none nothing can be
        # drawn, and a failure would say nothing about debrisflow
        pytest.skip(f"no picture: {error}")


def with_arrays(frame, **changes):
    """Return a frame some of whose arrays are others."""
    return replace(frame, arrays=dict(frame.arrays) | changes)


def written(folder, case, frames=3):
    """Write a run in which the fluid moves by a spacing along x from frame to frame."""
    state = initial_state(case)
    p = state.particles
    with RunFolder.create(folder, case) as results:
        for k in range(frames):
            state.time = 0.1 * k
            p.velocity[p.fluid, 0] = 0.1 * k
            results.write_frame(state)
            p.position[p.fluid, 0] += case.particles.spacing
    return folder


@pytest.fixture(scope="module")
def two_phases():
    """Return a case: water beside sediment in a tank."""
    blocks = [
        {"type": "block", "x": x, "y": [0.0, 0.1], "material": material}
        for x, material in (([0.0, 0.1], "water"), ([0.1, 0.2], "sediment"))
    ]
    return complete(
        Case(
            title="two columns",
            particles={"spacing": 0.02},
            geometry={"type": "tank", "length": 0.4, "height": 0.3},
            fill=blocks,
            time={"end": 1.0},
            output={"interval": 0.1},
        )
    )


@pytest.fixture(scope="module")
def run(tmp_path_factory, two_phases):
    return written(tmp_path_factory.mktemp("two") / "run", two_phases)


@pytest.fixture(scope="module")
def tank_run(tmp_path_factory):
    box = {"type": "box", "name": "block", "x": [0.6, 0.7], "y": [0.2, 0.4], "z": [0.0, 0.3]}
    water = {
        "type": "block",
        "x": [0.0, 0.3],
        "y": [0.0, 0.6],
        "z": [0.0, 0.5],
        "material": "water",
    }
    case = tank3d_case(fill=[water], obstacle=[box])
    return written(tmp_path_factory.mktemp("three") / "run", case)


def tiles(places, colors, depth=0.0, square=False):
    """Return particles of a section; depth and square may be of all."""
    count = len(places)
    right, up = np.transpose(np.array(places, dtype=float))
    return Tiles(
        right,
        up,
        np.full(count, 1.0) * depth,
        np.array(colors, dtype=np.uint8),
        np.full(count, square),
    )


@pytest.mark.usefixtures("screen")
class TestSection:
    # 100 pixels a meter along x, 200 upward; rows run down
    window, pixels = Window(-1.0, 1.0, 0.0, 0.5), (200, 100)

    def view(self):
        return SectionView(self.window, self.pixels, 0.1)

    def test_a_particle_is_where_it_is_and_as_large_as_its_area(self):
        image = self.view().picture(tiles([(0.5, 0.4)], [RED]))
        inked = np.any(image != WHITE, axis=2)
        rows, columns = np.nonzero(inked)
        assert image.shape == (100, 200, 3)
        assert image[20, 150].tolist() == RED
        assert columns.mean() == pytest.approx(149.5, abs=0.6)
        assert rows.mean() == pytest.approx(19.5, abs=0.6)
        # d0^2 are 10 by 20 pixels; a polygon of 10 corners has 0.935 of its circle
        assert inked.sum() == pytest.approx(0.935 * 200.0, rel=0.06)

    def test_a_wall_fills_its_cell(self):
        image = self.view().picture(tiles([(-0.55, 0.25)], [BLUE], square=True))
        rows, columns = np.nonzero(np.all(image == BLUE, axis=2))
        assert (columns.min(), columns.max()) == (40, 49)
        assert (rows.min(), rows.max()) == (40, 59)

    def test_the_nearer_particle_covers_the_farther(self):
        for depth, color in (((1.0, 2.0), RED), ((2.0, 1.0), BLUE)):
            drawn = tiles([(0.0, 0.25), (0.0, 0.25)], [RED, BLUE], np.array(depth))
            assert self.view().picture(drawn)[50, 100].tolist() == color

    def test_a_second_picture_shows_nothing_of_the_first(self):
        view = self.view()
        view.picture(tiles([(0.5, 0.4)], [RED]))
        image = view.picture(tiles([(-0.5, 0.1)], [BLUE]))
        assert image[20, 150].tolist() == WHITE
        assert image[80, 50].tolist() == BLUE


@pytest.mark.usefixtures("screen")
def test_perspective_shows_a_particle_where_the_camera_sees_it():
    scene = scene_of(tank3d_case(), 1.0)
    up = np.array([0.0, 0.0, 1.0])
    camera = Camera.on(scene.corners, np.array([0.4, -1.0, 0.7]), up, 0.05)
    seen = camera.seen(scene.corners)
    half = np.tan(np.radians(12.0))
    assert np.abs(seen).max() == pytest.approx(0.9 * half, rel=1e-3)  # the margin, and nothing cut

    place = np.array([[0.3, 0.2, 0.45]])
    image = PerspectiveView(scene, camera, (400, 400), 0.1).picture(
        place, np.array([RED], dtype=np.uint8)
    )
    right, upward = camera.seen(place)[0] / half
    column, row = round(200 * (1.0 + right)), round(200 * (1.0 - upward))
    red, green, blue = image[row, column].astype(int)
    assert red > 150
    assert max(green, blue) < 40
    reds = np.argwhere((image[:, :, 0] > 120) & (image[:, :, 1] < 40))
    assert reds.mean(axis=0) == pytest.approx([row, column], abs=2.0)


@pytest.mark.usefixtures("screen")
def test_two_dimensions_give_a_page_and_an_animation_of_every_frame(run):
    page, animation = render(run)

    assert [file.name for file in (page, animation)] == ["side_kind.png", "side_kind.gif"]
    image = np.asarray(Image.open(page).convert("RGB"))
    assert image.shape[1] == pytest.approx(WIDTH / CENTIMETERS_PER_INCH * DOTS, abs=1)
    inked = {
        kind: np.all(image == channels(KIND_COLORS[kind]), axis=2).sum()
        for kind in (Kind.LIQUID, Kind.SEDIMENT)
    }
    assert min(inked.values()) > 1000
    assert np.all(image == channels(SOLID), axis=2).sum() > 1000  # the floor
    # as much water as sediment, but for the swatches of the legend, which are alike
    assert inked[Kind.LIQUID] == pytest.approx(inked[Kind.SEDIMENT], rel=0.1)
    with Image.open(animation) as frames:
        assert frames.n_frames == 3


@pytest.mark.usefixtures("screen")
def test_three_dimensions_give_perspective_plan_and_side(tank_run):
    files = render(tank_run, times=[0.0, 0.2])

    assert [file.name for file in files] == [
        "perspective_speed.png",
        "perspective_speed.gif",
        "plan_speed.png",
        "side_speed.png",
    ]
    assert not list((tank_run / "render").glob("*.unfinished"))
    with Image.open(files[1]) as frames:
        assert frames.n_frames == 3


@pytest.mark.usefixtures("screen")
@pytest.mark.parametrize("by", sorted(set(COLORED) - {"kind"}))
def test_every_field_can_be_asked_for_and_fills_a_window(run, by):
    window = "--view=0.1,0.3,-0.02,0.1"
    result = CliRunner().invoke(main, ["render", str(run), "--by", by, "--times", "0.1", window])

    assert result.exit_code == 0, result.output
    assert f"wrote {run / 'render' / f'side_{by}.png'}" in result.stdout


def test_one_percent_of_the_particles_may_be_beyond_the_scale(run):
    frame = open_run(run).frame()
    velocity = frame.velocity.copy()
    velocity[frame.fluid] = [1.0, 0.0, 0.0]
    velocity[0] = [50.0, 0.0, 0.0]
    # one of 50 is 2 %, so the frame counts three times as one at rest does
    calm = with_arrays(frame, velocity=np.zeros_like(velocity))
    scale = scale_of([with_arrays(frame, velocity=velocity), calm, calm, calm], "speed")
    assert (scale.low, scale.high, scale.greatest) == (0.0, 1.0, 50.0)
    assert scale.clipped


@pytest.mark.usefixtures("screen")
@pytest.mark.parametrize("by", ["concentration", "granular_temperature"])
def test_what_is_0_everywhere_is_not_drawn(tmp_path, by):
    folder = written(tmp_path / "run", tank3d_case(), frames=1)
    with pytest.raises(OutputError, match=f"holds no grains at these times, so that {by} is 0"):
        render(folder, by)


@pytest.mark.usefixtures("screen")
def test_the_first_frame_of_a_running_run_is_enough(tmp_path, two_phases):
    _, animation = render(written(tmp_path / "run", two_phases, frames=1))
    with Image.open(animation) as frames:
        assert frames.n_frames == 1


def test_contours_are_round_heights_up_to_the_deposit(tank_run):
    run = open_run(tank_run)
    frame = run.frame(0.0)
    heap = with_arrays(frame, kind=np.full_like(frame.kind, Kind.MIXTURE))
    plan = PlanPanels(run.case, [heap])
    np.testing.assert_allclose(plan.levels, [0.2, 0.3, 0.4])  # of 0.5 m, from two spacings on
    assert plan.remark == "contours: height of the deposit in cm"
    deposit = over_grid(plan.grid, plan.deposit(heap))
    np.testing.assert_allclose(deposit[0], 0.5, atol=0.005)  # x < 0.2 m; places scatter by that
    assert not deposit[-1].any()
    bare = PlanPanels(run.case, [with_arrays(heap, velocity=heap.velocity + 1.0)])
    assert bare.levels.size == 0
    assert bare.remark == ""


def test_the_command_offers_every_field():
    [by] = [option for option in main.commands["render"].params if option.name == "by"]
    assert list(by.type.choices) == list(COLORED)
    assert {"kind", "speed", "pressure", "concentration", "granular_temperature"} <= set(COLORED)


def test_flat_flumes_are_stretched_and_say_so(two_phases):
    flume = SidePanels(two_phases, Window(0.0, 7.0, -0.1, 0.2))
    assert flume.remark == "heights stretched 3 times"
    assert flume.aspect == pytest.approx(3 * 0.3 / 7.0)
    assert SidePanels(two_phases, Window(0.0, 0.4, 0.0, 0.2)).remark == ""


def test_a_run_out_is_straight_from_the_side():
    case = complete(
        Case(
            title="bend",
            particles={"spacing": 0.05},
            gravity={"slope": 15.0},
            geometry={"type": "channel", "length": 3.0, "height": 1.0, "runout_start": 1.0},
            inflow={"depth": 0.1, "velocity": 1.0},
            time={"end": 1.0},
            output={"interval": 1.0},
        )
    )
    bend = np.radians(15.0)
    x, level = np.array([0.5, 3.0]), np.array([0.3, 2.0 * np.tan(bend) + 0.2 / np.cos(bend)])
    np.testing.assert_allclose(straightened(case, x, level), [0.3, 0.2], atol=1e-12)


class TestMessages:
    @pytest.fixture
    def copy(self, run, tmp_path) -> Path:
        return shutil.copytree(run, tmp_path / "run", ignore=shutil.ignore_patterns("render"))

    def refused(self, *arguments):
        """Return exit code and message of a call that fails."""
        result = CliRunner().invoke(main, ["render", *map(str, arguments)])
        assert not isinstance(result.exception, OutputError)
        assert "Traceback" not in result.stderr
        return result.exit_code, result.stderr

    @pytest.mark.parametrize("probe", ["import os; os.abort()", "raise SystemExit(1)"])
    def test_no_driver(self, copy, monkeypatch, probe):
        monkeypatch.setattr(offscreen, "PROBE", probe)
        code, message = self.refused(copy)
        assert code == 3
        assert "libegl1" in message
        assert "libosmesa6" in message
        assert len(message.splitlines()) <= 3
        assert not (copy / "render").exists()

    def test_times_beyond_the_run(self, copy):
        code, message = self.refused(copy, "--times", "0,7")
        assert code == 3
        assert message.startswith("there is no frame at t = 7 s: ")
        assert message.strip().endswith("has 3 frames from 0 to 0.2 s")

    @pytest.mark.parametrize(
        ("option", "text", "told"),
        [
            ("--times", "soon", "soon is not a list of numbers"),
            ("--times", "0,nan", "0,nan is not a list of numbers"),
            ("--view", "0,1,0", "0,1,0 has 3 numbers where 4 are needed"),
            ("--view", "1,0,0,1", "an interval must end after it starts"),
            ("--by", "color", "is not one of"),
        ],
    )
    def test_wrong_options(self, copy, option, text, told):
        code, message = self.refused(copy, option, text)
        assert code == 2
        assert told in message

    def test_a_window_in_three_dimensions(self, tank_run):
        code, message = self.refused(tank_run, "--view", "0,1,0,1")
        assert code == 3
        assert "two dimensions" in message

    def test_no_run_and_no_frames(self, copy, tmp_path):
        assert "is no run folder" in self.refused(tmp_path)[1]
        (copy / "particles.pvd").unlink()
        code, message = self.refused(copy)
        assert code == 3
        assert "holds no frames yet" in message

    @pytest.mark.usefixtures("screen")
    def test_a_missing_and_a_damaged_frame(self, copy):
        frame = copy / "vtu" / "000001.vtu"
        frame.write_bytes(frame.read_bytes()[:-40])
        assert "000001.vtu is damaged" in self.refused(copy)[1]
        frame.unlink()
        assert "000001.vtu is missing" in self.refused(copy)[1]


def test_a_title_with_dollars_is_text():
    layout = Layout(columns=1, rows=1, width=10.0, height=5.0, left=1.0)
    sheet = Sheet(1, layout, 50, ("$\\frac{$", "$_$"))
    sheet.figure.canvas.draw()
