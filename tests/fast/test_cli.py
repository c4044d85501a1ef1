"""The command line: what it prints, what it refuses and what it must not import."""

import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from debrisflow.case import case_schema
from debrisflow.cli import main
from tests.conftest import CHANNEL, TANK


class TestCommandLine:
    @pytest.mark.parametrize("command", ["check", "run"])
    def test_wrong_case_ends_with_2_and_writes_nothing(
        self, tank: Path, command: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.chdir(tank.parent)

        result = CliRunner().invoke(main, [command, "tank.toml", "--set", "time.ende=1"])

        assert result.exit_code == 2
        assert "time.ende = 1: unknown key; did you mean 'end'?" in result.stderr
        assert result.stdout == ""
        assert list(tank.parent.iterdir()) == [tank]

    def test_check_tells_what_will_run(self, tank: Path) -> None:
        result = CliRunner().invoke(main, ["check", str(tank), "--set", "time.end=2"])

        assert result.exit_code == 0, result.output
        assert "a column of water" in result.stdout
        assert "200 liquid" in result.stdout
        assert "n0 = 18.9764" in result.stdout
        assert "first step     0.000958 s" in result.stdout
        assert "21 particle files" in result.stdout

    def test_check_takes_less_than_a_second_and_no_solver(self, channel: Path) -> None:
        # Processor time, since the wall clock of a shared machine tells about its neighbors.
        script = (
            "import sys, time\n"
            "from debrisflow.cli import main\n"
            f"main(['check', {str(channel)!r}], standalone_mode=False)\n"
            "assert not {'numba', 'scipy', 'vtk', 'matplotlib', 'h5py'} & set(sys.modules)\n"
            "assert time.process_time() < 1.0, time.process_time()\n"
        )
        subprocess.run([sys.executable, "-c", script], check=True, timeout=60)

    def test_help_imports_nothing_heavy(self) -> None:
        script = (
            "import sys\n"
            "from debrisflow.cli import main\n"
            "main(['--help'], standalone_mode=False)\n"
            "assert not {'numba', 'numpy', 'scipy', 'vtk', 'pydantic'} & set(sys.modules)\n"
        )
        subprocess.run([sys.executable, "-c", script], check=True, timeout=60)

    @pytest.mark.parametrize(("share", "told"), [(0.0009, False), (0.012, True)])
    def test_bounces_off_walls_are_told_where_they_are_many(
        self, tank: Path, share: float, told: bool, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        figures = {"end_reason": "end", "time": 1.0, "steps": 2, "wall_seconds": 1.0}
        figures |= {"compile_seconds": 0.0, "through_wall": {}, "bounced_share": share}
        monkeypatch.setattr("debrisflow.run.simulation.simulate", lambda *_, **__: figures)

        result = CliRunner().invoke(main, ["run", str(tank)])

        assert ("1.2 % of the fluid particles bounced off a wall" in result.stderr) == told

    def test_schema(self) -> None:
        assert CliRunner().invoke(main, ["schema"]).stdout == case_schema()

    def test_info(self) -> None:
        result = CliRunner().invoke(main, ["info"])

        assert result.exit_code == 0, result.output
        for word in ("debrisflow", "python", "cores", "threading layer", "cache folder"):
            assert f"\n{word}" in f"\n{result.stdout}"


class TestInit:
    @pytest.fixture(autouse=True)
    def _templates(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        shipped = tmp_path / "shipped"
        shipped.mkdir()
        (shipped / "flume2d.toml").write_text("# kept\n" + CHANNEL)
        (shipped / "supply2d.toml").write_text('[inflow]\nhydrograph = "q.csv"\n')
        (shipped / "q.csv").write_text("time,discharge,concentration\n0,0.01,0\n")
        (shipped / "data").mkdir()
        (shipped / "data/wedge.obj").write_text("v 0 0 0\n")
        (shipped / "data/depths.csv").write_text("time,h.height\n0,0.1\n")
        (shipped / "release3d.toml").write_text(
            '# Compare: --reference data/depths.csv.\n[[fill]]\nfile = "data/wedge.obj"\n'
        )
        (shipped / "experiments").mkdir()
        (shipped / "experiments/lake.toml").write_text(
            '#:schema ../case.schema.json\ntitle = "a"\n'
        )
        (shipped / "experiments/lake.csv").write_text("time,front_all\n0,0.1\n")
        (shipped / "case.schema.json").write_text("{}")
        found = {path.stem: path for path in shipped.glob("*.toml")}
        found["experiments/lake"] = shipped / "experiments/lake.toml"
        monkeypatch.setattr("debrisflow.case.templates.templates", lambda: found)

    def test_comments_are_kept(self, tmp_path: Path) -> None:
        target = tmp_path / "new" / "mine.toml"

        result = CliRunner().invoke(main, ["init", str(target), "--template", "flume2d"])

        assert result.exit_code == 0, result.output
        assert target.read_text() == "# kept\n" + CHANNEL

    def test_hydrograph_goes_along(self, tmp_path: Path) -> None:
        target = tmp_path / "new" / "mine.toml"

        CliRunner().invoke(main, ["init", str(target), "--template", "supply2d"])

        there = ["case.schema.json", "mine.toml", "q.csv"]
        assert sorted(path.name for path in target.parent.iterdir()) == there

    def test_what_a_case_names_of_its_data_goes_along(self, tmp_path: Path) -> None:
        target = tmp_path / "new" / "mine.toml"

        CliRunner().invoke(main, ["init", str(target), "--template", "release3d"])

        there = ["depths.csv", "wedge.obj"]
        assert sorted(path.name for path in (target.parent / "data").iterdir()) == there

    def test_an_experiment_comes_with_its_measurements(self, tmp_path: Path) -> None:
        target = tmp_path / "new" / "mine.toml"

        result = CliRunner().invoke(main, ["init", str(target), "--template", "experiments/lake"])

        assert result.exit_code == 0, result.output
        there = ["case.schema.json", "lake.csv", "mine.toml"]
        assert sorted(path.name for path in target.parent.iterdir()) == there
        assert target.read_text().startswith("#:schema ./case.schema.json\n")

    def test_an_experiment_without_its_folder(self, tmp_path: Path) -> None:
        result = CliRunner().invoke(main, ["init", str(tmp_path / "x.toml"), "--template", "lake"])

        assert result.exit_code == 2
        assert "no template 'lake'; did you mean 'experiments/lake'?" in result.stderr

    def test_nothing_is_overwritten(self, tank: Path) -> None:
        result = CliRunner().invoke(main, ["init", str(tank)])

        assert result.exit_code == 3
        assert "is there already" in result.stderr
        assert tank.read_text() == TANK

    def test_unknown_template(self, tmp_path: Path) -> None:
        result = CliRunner().invoke(main, ["init", str(tmp_path / "x.toml"), "--template", "flume"])

        assert result.exit_code == 2
        assert "no template 'flume'; did you mean 'flume2d'?" in result.stderr
        assert "supply2d" in result.stderr
        assert not (tmp_path / "x.toml").exists()

    def test_help_lists_the_templates_with_their_titles(self) -> None:
        result = CliRunner().invoke(main, ["init", "--help"])

        assert result.exit_code == 0
        assert "supply2d" in result.output
        assert "flume2d a flume with a bed" in " ".join(result.output.split())
