"""Maps over the members of a study, against counting by hand."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.image import imread

from debrisflow.case.rasters import MapGrid, Raster, read_raster, write_raster
from debrisflow.errors import CaseError, OutputError
from debrisflow.results.maps.looks import Scale
from debrisflow.run.folder import RunFolder
from debrisflow.study.checks import problems_of
from debrisflow.study.maps import files as map_files
from debrisflow.study.maps import pictures as map_pictures
from debrisflow.study.maps.checks import expect_told_apart
from debrisflow.study.maps.convergence import convergence
from debrisflow.study.maps.files import write_maps
from debrisflow.study.maps.grid import grid_of, layer_on
from debrisflow.study.maps.pictures import LIMITS, PROBABILITY, place_in_order
from debrisflow.study.maps.shares import known_on, quantiles, shares_arrived, shares_over
from debrisflow.study.tables import Map, MapArea, Study
from tests.building import tank3d_case
from tests.terrain_recording import GRID, SOUTH, WEST, sloping_case

COUNT = 8
OFF = (slice(0, 2), slice(0, 3))  # cells without a terrain
UTM = (
    'PROJCS["WGS 84 / UTM zone %dN",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,'
    '298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],'
    'PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],'
    'PARAMETER["central_meridian",%d],PARAMETER["scale_factor",0.9996],'
    'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1]]'
)


def on_terrain(folders, grid, found):
    """Return a map, nan where no member has a terrain, as it is written."""
    (values,) = found
    return np.where(known_on(folders, grid), values, np.nan)


def exceedance(folders, grid, layer, threshold):
    return on_terrain(folders, grid, shares_over(folders, grid, layer, (threshold,)))


def arrival_probability(folders, grid, before):
    return on_terrain(folders, grid, shares_arrived(folders, grid, (before,)))


def quantile_map(folders, grid, layer, share):
    return on_terrain(folders, grid, quantiles(folders, grid, layer, (share,)))


def write_member(folder, depth, arrival=None, grid=GRID, off=True):
    """Write the layers of a run: nan where the flow did not come, as a run leaves them."""
    (folder / "layers").mkdir(parents=True, exist_ok=True)
    terrain = np.full(grid.shape, 100.0)
    if off:
        terrain[OFF] = np.nan
    arrival = np.where(depth > 0.0, 30.0, np.nan) if arrival is None else arrival
    known = {"peak_depth": depth, "arrival": arrival, "peak_speed": 4.0 * depth}
    for name, values in (known | {"terrain": terrain}).items():
        shown = values if name == "terrain" else np.where(depth > 0.0, values, np.nan)
        write_raster(folder / "layers" / f"{name}.asc", Raster(grid, shown))


def member_depths():
    """Return depths of members, m: of a core that all reach, and of cells that some reach.

    They are multiples of 1/64 m, which files hold exactly.
    """
    random = np.random.default_rng(3)
    depths = np.where(
        random.random((COUNT, *GRID.shape)) < 0.4, random.gamma(2.0, 0.4, (COUNT, *GRID.shape)), 0.0
    )
    depths[:, 3:5, 5:15] = 2.0 + random.random((COUNT, 2, 10))  # the core
    depths[:, :, 20:] = 0.0  # reached by none
    depths[:, *OFF] = 0.0
    return np.round(64.0 * depths) / 64.0


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    top = tmp_path_factory.mktemp("members")
    found = [top / f"m{number}" for number in range(COUNT)]
    for number, (folder, depth) in enumerate(zip(found, member_depths(), strict=True)):
        write_member(folder, depth, arrival=10.0 * number + 5.0 * depth)
    return found


def read(folder, name):
    return read_raster(folder / "layers" / f"{name}.asc").values


class TestByHand:
    @pytest.mark.parametrize("threshold", [0.1, 0.5, 2.2])
    def test_exceedance_is_the_count_of_members_over_their_number(self, folders, threshold):
        found = exceedance(folders, GRID, "peak_depth", threshold)
        depths = [read(folder, "peak_depth") for folder in folders]
        for row in range(GRID.rows):
            for column in range(GRID.columns):
                if row < 2 and column < 3:
                    assert math.isnan(found[row, column])
                    continue
                count = 0
                for depth in depths:
                    if depth[row, column] > threshold:  # never where it is nan
                        count += 1
                assert found[row, column] == count / COUNT

    def test_it_is_one_in_the_common_core_and_zero_outside_the_union(self, folders):
        found = exceedance(folders, GRID, "peak_depth", 0.5)
        depths = member_depths()
        core, union = (depths > 0.5).all(axis=0), (depths > 0.5).any(axis=0)
        on_terrain = np.isfinite(found)
        assert core.sum() >= 20
        assert (found[core] == 1.0).all()
        assert (found[~union & on_terrain] == 0.0).all()
        between = found[union & ~core]
        assert ((between > 0.0) & (between < 1.0)).all()
        assert np.array_equal(~on_terrain.ravel(), np.isnan(read(folders[0], "terrain")).ravel())

    def test_the_flow_has_arrived_in_as_many_members_as_are_not_later(self, folders):
        found = arrival_probability(folders, GRID, before=45.0)
        times = [read(folder, "arrival") for folder in folders]
        for row, column in np.argwhere(np.isfinite(found)):
            count = sum(1 for time in times if time[row, column] <= 45.0)
            assert found[row, column] == count / COUNT
        assert 0.0 < np.nanmean(found) < 1.0
        later = arrival_probability(folders, GRID, before=1e9)
        assert np.array_equal(later, exceedance(folders, GRID, "peak_depth", 0.0), equal_nan=True)

    @pytest.mark.parametrize("share", [0.01, 0.125, 0.3, 0.5, 0.9, 1.0])
    def test_quantiles_are_those_of_numpy_with_dry_members_as_zero(self, folders, share):
        found = quantile_map(folders, GRID, "peak_depth", share)
        expected = np.quantile(member_depths(), share, axis=0, method="inverted_cdf")
        known = np.isfinite(found)
        assert known.sum() == GRID.rows * GRID.columns - 6
        assert np.array_equal(found[known], expected[known])
        # which is the definition: not exceeded by that share, and the least such value
        below = (member_depths() <= found).sum(axis=0) / COUNT
        strictly_below = (member_depths() < found).sum(axis=0) / COUNT
        assert (below[known] >= share).all()
        assert (strictly_below[known] < share).all()

    def test_the_quantile_of_the_arrival_is_when_that_share_has_arrived(self, folders):
        found = quantile_map(folders, GRID, "arrival", 0.5)
        half = arrival_probability(folders, GRID, 1e9) >= 0.5
        assert np.array_equal(np.isfinite(found), half)
        times = np.array([read(folder, "arrival") for folder in folders])
        row, column = 3, 7
        assert found[row, column] == sorted(times[:, row, column])[COUNT // 2 - 1]
        assert np.isinf(found[7, 23])

    @pytest.mark.parametrize("cells", [1, 7, 50])
    def test_in_blocks_they_are_the_same_as_in_one_piece(self, folders, cells):
        whole = quantiles(folders, GRID, "peak_depth", (0.5, 0.9))
        parts = quantiles(folders, GRID, "peak_depth", (0.5, 0.9), block=8 * COUNT * cells)
        assert np.array_equal(parts, whole)

    def test_of_no_member_there_is_no_map(self):
        with pytest.raises(OutputError, match="no finished member"):
            exceedance([], GRID, "peak_depth", 0.5)
        with pytest.raises(OutputError, match="no finished member"):
            quantile_map([], GRID, "peak_depth", 0.5)

    def test_a_layer_that_a_member_lacks_is_named(self, folders):
        with pytest.raises(OutputError, match=r"has no layer 'deposit'; it has peak_depth"):
            exceedance(folders, GRID, "deposit", 0.5)


class TestOnOtherCells:
    FINE = MapGrid(WEST + 3.0, SOUTH - 2.0, 1.5, 70, 30)

    @pytest.mark.parametrize("cell", [0.75, 1.5, 2.0, 4.0, 5.0])
    def test_volumes_stay_what_they_are(self, tmp_path, cell):
        depth = np.random.default_rng(1).gamma(2.0, 0.5, self.FINE.shape)
        depth[:, ::3] = 0.0
        write_member(tmp_path, depth, grid=self.FINE, off=False)
        written = np.nan_to_num(read(tmp_path, "peak_depth"))
        count = math.ceil(130.0 / cell), math.ceil(70.0 / cell)
        grid = MapGrid(WEST - 1.3, SOUTH - 4.1, cell, *count)
        found = layer_on(tmp_path, grid, "peak_depth")
        volume = written.sum() * self.FINE.cell**2
        assert found.sum() * cell**2 == pytest.approx(volume, rel=1e-8)
        assert found[0, 0] == 0.0  # beyond its terrain

    def test_of_four_cells_in_one_the_mean_the_greatest_and_the_first_count(self, tmp_path):
        fine = MapGrid(WEST, SOUTH, 2.5, 4, 2)
        depth = np.array([[2.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]])
        arrival = np.array([[40.0, 0.0, 0.0, 0.0], [20.0, 0.0, 0.0, 0.0]])
        write_member(tmp_path, depth, arrival, fine, off=False)
        grid = MapGrid(WEST, SOUTH, 5.0, 2, 1)
        assert layer_on(tmp_path, grid, "peak_depth").tolist() == [[0.75, 0.0]]
        assert layer_on(tmp_path, grid, "peak_speed").tolist() == [[8.0, 0.0]]
        assert layer_on(tmp_path, grid, "arrival").tolist() == [[20.0, np.inf]]

    def test_larger_cells_give_their_value_to_the_cells_within(self, tmp_path):
        coarse = MapGrid(WEST, SOUTH, 10.0, 2, 1)
        write_member(tmp_path, np.array([[1.5, 0.0]]), np.array([[7.0, 0.0]]), coarse, off=False)
        grid = MapGrid(WEST, SOUTH, 5.0, 4, 2)
        expected = {"peak_depth": (1.5, 0.0), "peak_speed": (6.0, 0.0), "arrival": (7.0, np.inf)}
        for name, (wet, dry) in expected.items():
            found = layer_on(tmp_path, grid, name)
            assert found.tolist() == [[wet, wet, dry, dry]] * 2

    def test_a_member_with_another_cell_counts_as_the_others(self, folders, tmp_path):
        """And one with a smaller terrain is dry beyond it."""
        fine = MapGrid(WEST + 20.0, SOUTH, 2.5, 40, 16)
        depth = np.full(fine.shape, 0.8)
        depth[:, ::2] = 0.0  # half of each cell: 0.4 m
        write_member(tmp_path, depth, grid=fine, off=False)
        before = exceedance(folders, GRID, "peak_depth", 0.39) * COUNT
        found = exceedance([*folders, tmp_path], GRID, "peak_depth", 0.39) * (COUNT + 1)
        added = np.zeros(GRID.shape)
        added[:, 4:] = 1.0
        known = np.isfinite(before)
        np.testing.assert_allclose((found - before)[known], added[known], atol=1e-12)
        none = exceedance([*folders, tmp_path], GRID, "peak_depth", 0.41) * (COUNT + 1)
        same = exceedance(folders, GRID, "peak_depth", 0.41) * COUNT
        np.testing.assert_allclose(none[known], same[known], atol=1e-12)

    def test_where_any_member_has_a_terrain_the_map_has_data(self, folders, tmp_path):
        write_member(tmp_path, np.zeros(GRID.shape), off=False)
        assert np.isfinite(exceedance([*folders, tmp_path], GRID, "peak_depth", 0.5)).all()

    def test_a_member_in_another_system_is_refused(self, tmp_path):
        write_member(tmp_path, np.ones(GRID.shape), grid=GRID._replace(crs=UTM % (54, 141)))
        with pytest.raises(OutputError, match="another coordinate reference system"):
            layer_on(tmp_path, GRID._replace(crs=UTM % (53, 135)), "peak_depth")


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    return sloping_case(tmp_path_factory.mktemp("case"))


class TestGrid:
    def test_it_is_the_map_of_the_case_if_nothing_is_said(self, case):
        assert grid_of(case, MapArea()) == GRID

    def test_an_extent_is_widened_to_the_cells_of_the_map(self, case):
        area = MapArea(x=(WEST + 12.0, WEST + 41.0), y=(SOUTH + 10.0, SOUTH + 25.0))
        assert grid_of(case, area)[:5] == (WEST + 10.0, SOUTH + 10.0, 5.0, 7, 3)

    def test_cells_of_another_size_begin_at_the_corner(self, case):
        assert grid_of(case, MapArea(cell=7.0))[:5] == (WEST, SOUTH, 7.0, 18, 6)
        area = MapArea(cell=2.0, x=(WEST + 1.0, WEST + 6.0))
        assert grid_of(case, area)[:5] == (WEST + 1.0, SOUTH, 2.0, 3, 20)

    @pytest.mark.parametrize(
        ("area", "message"),
        [
            (MapArea(x=(0.0, 10.0)), "does not lie on the map of the case"),
            (MapArea(y=(SOUTH + 40.0, SOUTH + 50.0)), "does not lie on the map of the case"),
            (MapArea(cell=0.001), "take larger cells"),
        ],
    )
    def test_what_cannot_be_a_map_is_refused(self, case, area, message):
        with pytest.raises(CaseError, match=message):
            grid_of(case, area)

    def test_without_a_terrain_there_is_no_map(self):
        with pytest.raises(CaseError, match="on a terrain only"):
            grid_of(tank3d_case(), MapArea())


class TestConvergence:
    def test_it_follows_the_members_by_hand(self, tmp_path):
        """Of two cells, one reached by members 0, 1, 2 and 5, the other by all but member 0."""
        grid = MapGrid(WEST, SOUTH, 5.0, 3, 1)
        folders = [tmp_path / str(number) for number in range(10)]
        for number, folder in enumerate(folders):
            depth = [1.0 * (number in (0, 1, 2, 5)), 1.0 * (number != 0), 0.0]
            write_member(folder, np.array([depth]), grid=grid, off=False)
        first, second, third = convergence(folders, grid, "peak_depth", 0.5)
        assert (first.members, second.members, third.members) == (4, 8, 10)
        assert math.isnan(first.greatest_change)
        # probabilities: 3/4, 3/4; then 4/8, 7/8; then 4/10, 9/10
        assert second.greatest_change == pytest.approx(0.25)
        assert second.mean_change == pytest.approx((0.25 + 0.125) / 2)
        assert third.greatest_change == pytest.approx(0.1)
        assert third.mean_change == pytest.approx((0.1 + 0.025) / 2)
        assert second.greatest_error == pytest.approx(math.sqrt(0.25 / 8))
        assert second.mean_error == pytest.approx(
            (math.sqrt(0.25 / 8) + math.sqrt(7 / 8 * 1 / 8 / 8)) / 2
        )
        assert [part.area_half for part in (first, second, third)] == [50.0, 50.0, 25.0]
        assert third.area_tenth == 50.0
        # with this probability ten members all miss the cell once in twenty times
        assert (1.0 - third.unseen) ** 10 == pytest.approx(0.05)

    def test_where_nothing_is_reached_nothing_changes(self, folders):
        parts = convergence(folders, GRID, "peak_depth", 99.0)
        assert [part.members for part in parts] == [4, 8]
        assert parts[-1].greatest_change == 0.0
        assert parts[-1].area_tenth == 0.0


def study_of(design="latin-hypercube"):
    designs = {
        "latin-hypercube": {"type": "latin-hypercube", "members": COUNT},
        "one-at-a-time": {"type": "one-at-a-time"},
        "saltelli": {"type": "saltelli", "samples": 2},
    }
    friction = {"name": "mu", "key": "walls.floor.friction.coefficient", "low": 0.1, "high": 0.2}
    wanted = [
        {"layer": "peak_depth", "exceeds": [0.1, 1.5], "quantiles": [0.9]},
        {"layer": "arrival", "before": [60.0], "quantiles": [0.1]},
    ]
    return Study.model_validate(
        {
            "title": "friction",
            "case": "case.toml",
            "parameter": [{"distribution": "uniform"} | friction],
            "design": designs[design],
            "map": wanted,
        }
    )


@pytest.fixture(scope="module")
def runs(folders):
    """Return the folders; the first has a case, with a threshold of 0.2 m."""
    case = sloping_case(folders[0].parent, output={"interval": 1.0, "layer_depth": 0.2})
    with RunFolder.create(folders[0].parent / "with_case", case) as run:
        path = run.path
    for file in (folders[0] / "layers").iterdir():
        (path / "layers").mkdir(exist_ok=True)
        (path / "layers" / file.name).write_bytes(file.read_bytes())
    return [path, *folders[1:]]


class TestFiles:
    def test_each_map_is_a_raster_with_a_style_and_a_picture(self, runs, tmp_path):
        written = write_maps(study_of(), runs, GRID, tmp_path / "study" / "maps")
        names = [
            "peak_depth_over_0.1m",
            "peak_depth_over_1.5m",
            "peak_depth_quantile_0.9",
            "arrival_before_60s",
            "arrival_quantile_0.1",
        ]
        expected = {f"{name}.{ending}" for name in names for ending in ("tif", "qml", "png")}
        for name in names[:2]:
            expected |= {f"{name}_convergence.{ending}" for ending in ("csv", "png")}
        assert {file.name for file in written} == expected
        folder = written[0].parent
        assert folder == tmp_path / "study" / "maps"
        assert sorted(folder.iterdir()) == sorted(written)
        grid, values = read_raster(folder / "peak_depth_over_1.5m.tif")
        assert grid[:5] == GRID[:5]
        expected_values = exceedance(runs, GRID, "peak_depth", 1.5)
        assert np.array_equal(values, expected_values, equal_nan=True)  # eighths are exact
        quantile = read_raster(folder / "peak_depth_quantile_0.9.tif").values
        assert np.array_equal(quantile, quantile_map(runs, GRID, "peak_depth", 0.9), equal_nan=True)
        assert imread(folder / "arrival_quantile_0.1.png").shape[0] > 400

    def test_the_raster_says_what_it_is_and_what_could_be_told(self, runs, tmp_path):
        """Depths up to 0.2 m have no data in the layers: a threshold of 0.1 m is one of 0.2 m."""
        import rasterio

        write_maps(study_of(), runs, GRID, tmp_path)
        titles = {}
        for name in ("peak_depth_over_0.1m", "peak_depth_over_1.5m", "arrival_quantile_0.1"):
            with rasterio.open(tmp_path / f"{name}.tif") as file:
                titles[name] = file.tags()["meaning"]
                assert file.tags()["members"] == str(COUNT)
        assert titles == {
            "peak_depth_over_0.1m": "Probability that the peak flow depth exceeds 0.2 m; 8 members",
            "peak_depth_over_1.5m": "Probability that the peak flow depth exceeds 1.5 m; 8 members",
            "arrival_quantile_0.1": "Time by which the flow of 10 % of 8 members has arrived",
        }
        style = (tmp_path / "peak_depth_over_1.5m.qml").read_text()
        assert 'label="50 to 75 %"' in style
        assert 'min="0" max="0" percentTransparent="100"' in style

    def test_a_share_at_a_limit_has_the_color_of_the_picture_in_the_style(self, runs, tmp_path):
        write_maps(study_of(), runs, GRID, tmp_path)
        root = ElementTree.fromstring((tmp_path / "peak_depth_over_1.5m.qml").read_text())
        items = [(float(item.get("value")), item.get("color")) for item in root.iter("item")]
        bounds = 100.0 * np.array([0.0, *LIMITS, 1.0])
        colors, norm = Scale(bounds, PROBABILITY).map_and_norm  # as the picture has them
        counts = [(k, count) for count in (8, 20, 100, 1000) for k in range(1, count + 1)]
        for k, count in [*counts, (949_999, 1_000_000), (250_000, 1_000_000)]:
            # QGIS: the first class whose value is not less than that of the cell, in 32 bits
            styled = next(color for value, color in items if np.float32(k / count) <= value)
            assert styled == to_hex(colors(norm(100.0 * k / count))), (k, count)

    def test_without_rasterio_the_rasters_are_text(self, runs, tmp_path, monkeypatch):
        monkeypatch.setattr(map_files, "has_rasterio", lambda: False)
        written = write_maps(study_of(), runs, GRID, tmp_path)
        assert sum(file.suffix == ".asc" for file in written) == 5
        assert not [file for file in written if file.suffix == ".tif"]
        values = read_raster(tmp_path / "peak_depth_over_1.5m.asc").values
        assert np.array_equal(values, exceedance(runs, GRID, "peak_depth", 1.5), equal_nan=True)

    def test_members_that_are_no_sample_give_shares_and_no_convergence(self, runs, tmp_path):
        import rasterio

        written = write_maps(study_of("one-at-a-time"), runs, GRID, tmp_path)
        assert not [file for file in written if "convergence" in file.name]
        with rasterio.open(tmp_path / "peak_depth_over_1.5m.tif") as file:
            title = file.tags()["meaning"]
        assert title == "Share of members whose peak flow depth exceeds 1.5 m; 8 members"

    def test_members_that_share_values_have_no_standard_error(self, runs, tmp_path, monkeypatch):
        """Of a Saltelli design, whose blocks differ in one parameter: shares are probabilities."""
        drawn = {}

        def kept(ground, layer, text, words):
            drawn[text.title.partition(";")[0]] = " ".join(text.source)
            return Figure()

        monkeypatch.setattr(map_pictures, "draw_map", kept)
        written = write_maps(study_of("saltelli"), runs, GRID, tmp_path / "saltelli")
        title = "Probability that the peak flow depth exceeds 1.5 m"
        assert not [file for file in written if "convergence" in file.name]
        assert "standard error" not in drawn[title]
        assert "no probability" not in drawn[title]
        write_maps(study_of(), runs, GRID, tmp_path / "random")
        assert "standard error is up to 18 percentage points" in drawn[title]

    @pytest.mark.parametrize(
        ("share", "members", "message"),
        [
            (0.9, 8, "value of member 8 of 8 in increasing order, the greatest of them; this "),
            (0.1, 8, "value of member 1 of 8 in increasing order, the least of them; this "),
            (0.9, 99, "member 90 of 99 in increasing order. Beyond it lie 9 of them; this "),
            (0.1, 99, "member 10 of 99 in increasing order. Beyond it lie 9 of them; this "),
        ],
    )
    def test_a_quantile_says_which_member_it_is(self, share, members, message):
        assert message + "share needs at least 100 members." in place_in_order(share, members)
        assert place_in_order(share, 100).endswith("of 100 in increasing order.")

    def test_a_map_of_quantiles_says_so(self, runs, tmp_path, monkeypatch):
        lines = []
        monkeypatch.setattr(
            map_pictures, "draw_map", lambda *given: lines.append(given[2].source) or Figure()
        )
        write_maps(study_of("one-at-a-time"), runs, GRID, tmp_path)
        quantiles_of = [line for source in lines for line in source if "increasing order" in line]
        assert quantiles_of == [place_in_order(0.9, COUNT), place_in_order(0.1, COUNT)]

    def test_a_threshold_that_cannot_be_told_is_refused_beforehand(self, tmp_path):
        case = sloping_case(tmp_path, output={"interval": 1.0, "layer_depth": 0.2})
        with pytest.raises(CaseError, match=r"exceeds = 0.1 m: .*take 0.2 m or more"):
            expect_told_apart(study_of(), case)
        told = case.model_copy(
            update={"output": case.output.model_copy(update={"layer_depth": 0.1})}
        )
        assert expect_told_apart(study_of(), told) is None

    @pytest.mark.parametrize(
        ("entry", "key"),
        [
            ({"layer": "arrival", "exceeds": [10.0]}, "map.0.exceeds"),
            ({"layer": "terrain", "quantiles": [0.5]}, "map.0.layer"),
            ({"layer": "release", "quantiles": [0.5]}, "map.0.layer"),
            ({"layer": "peak_depth", "before": [10.0]}, "map.0.before"),
        ],
    )
    def test_a_map_that_means_nothing_is_refused(self, entry, key):
        study = study_of()
        wanted = (Map.model_validate(entry),)
        (problem,) = problems_of(study.model_copy(update={"map": wanted}))
        assert problem[0] == key
        assert problems_of(study) == []

    def test_of_no_member_there_are_none(self, tmp_path):
        with pytest.raises(OutputError, match="no finished member"):
            write_maps(study_of(), [], GRID, tmp_path / "maps")
        assert not (tmp_path / "maps").exists()
