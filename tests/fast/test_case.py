"""The case file: read, changed, completed and written."""

import json
import tomllib
from pathlib import Path

import pytest

from debrisflow.case import Case, case_schema, dump_case, load_case
from debrisflow.case.defaults import complete
from debrisflow.case.rheology import Bingham, NoStrength
from debrisflow.case.tables import Inflow
from debrisflow.errors import CaseError
from tests.conftest import CHANNEL, TANK


def reloaded(case: Case, folder: Path) -> Case:
    path = folder / "dumped.toml"
    path.write_text(dump_case(case))
    return load_case(path)


class TestCompletion:
    @pytest.mark.parametrize(
        ("form", "choices"),
        [
            ("stable", ("sum", "symmetric", "asymmetry", 1.5 * (0.01 / 9.81) ** 0.5)),
            ("study", ("cmps", "study", "density", 0.0)),
        ],
    )
    def test_scheme_follows_its_form(
        self, tank: Path, form: str, choices: tuple[str, str, str, float]
    ) -> None:
        scheme = load_case(tank, [f"scheme.form={form}"]).scheme

        chosen = (
            scheme.gradient,
            scheme.interface,
            scheme.free_surface,
            scheme.density_relaxation,
        )
        assert chosen[:3] == choices[:3]
        assert chosen[3] == pytest.approx(choices[3])

    def test_a_stated_choice_stays(self, tank: Path) -> None:
        scheme = load_case(tank, ["scheme.form=study", "scheme.gradient=sum"]).scheme

        assert (scheme.gradient, scheme.interface) == ("sum", "study")

    def test_step_of_gravity(self, tank: Path) -> None:
        step = load_case(tank).time.largest_step

        assert step == pytest.approx(0.03 * (0.01 / 9.81) ** 0.5)

    def test_step_of_viscosity(self, tank: Path) -> None:
        assert load_case(tank, ["water.viscosity=100"]).time.largest_step == pytest.approx(2e-4)

    def test_step_without_gravity(self, tank: Path) -> None:
        assert load_case(tank, ["gravity.acceleration=0"]).time.largest_step == 0.01

    def test_intervals(self, tank: Path) -> None:
        output = load_case(tank).output

        assert (output.deposit_interval, output.history_interval) == (0.1, 0.01)

    def test_bed_ends_at_the_weir(self, channel: Path) -> None:
        assert load_case(channel).geometry.bed_end == 3.92

    @pytest.mark.parametrize("given", ["discharge=0.02", "velocity=0.5"])
    def test_supply(self, channel: Path, given: str) -> None:
        inflow = load_case(channel, [f"inflow.{given}"]).inflow

        assert inflow is not None
        assert (inflow.discharge, inflow.velocity) == pytest.approx((0.02, 0.5))

    def test_gravity_along_a_slope(self, channel: Path) -> None:
        along, across = load_case(channel).gravity.components

        assert along == pytest.approx(9.81 * 0.2588190451)
        assert across == pytest.approx(-9.81 * 0.9659258263)

    @pytest.mark.parametrize("path", sorted(Path(__file__).parents[2].glob("cases/*.toml")))
    def test_completing_a_completed_case_changes_nothing(self, path: Path) -> None:
        case = load_case(path)

        again = complete(case)

        assert again == case
        assert [type(table) for _, table in again] == [type(table) for _, table in case]

    def test_a_supply_without_numbers_is_no_case(self, channel: Path) -> None:
        case = load_case(channel, ["inflow.velocity=0.5"])
        open_case = Case(**(dict(case) | {"inflow": Inflow(depth=0.04)}))

        with pytest.raises(CaseError, match="inflow: missing: give a discharge"):
            complete(open_case)
        unread = Inflow(depth=0.04, hydrograph="q.csv")
        with pytest.raises(CaseError, match=r"inflow\.hydrograph: a file"):
            complete(Case(**(dict(case) | {"inflow": unread})))

    def test_a_case_has_one_of_the_schemes(self, tank: Path) -> None:
        case = load_case(tank)

        assert case.semi_implicit_scheme is case.scheme
        with pytest.raises(TypeError, match="not explicit"):
            _ = case.explicit_scheme


class TestRoundTrip:
    @pytest.mark.parametrize("text", [TANK, CHANNEL], ids=["tank", "channel"])
    @pytest.mark.parametrize(
        "changes",
        [
            [],
            ["scheme.form=study"],
            ["gravity.vector=[1, -9]"],
            ["water.viscosity=100"],
            ["particles.effective_radius=2.1"],
            ["rheology.type=coulomb", "drag.law=gidaspow", "water.viscosity=100"],
        ],
        ids=" ".join,
    )
    def test_same_case(self, tmp_path: Path, text: str, changes: list[str]) -> None:
        path = tmp_path / "case.toml"
        path.write_text(text)
        case = load_case(path, changes)

        again = reloaded(case, tmp_path)

        assert again == case
        assert dump_case(again) == dump_case(case)

    @pytest.mark.parametrize("supply", ["velocity=0.3", "discharge=0.017", "hydrograph=q.csv"])
    def test_same_supply(self, channel: Path, supply: str) -> None:
        channel.with_name("q.csv").write_text("time,concentration,discharge\n0,0.1,0.02\n3,0,0\n")
        case = load_case(channel, [f"inflow.{supply}"])
        channel.with_name("q.csv").unlink()

        assert reloaded(case, channel.parent) == case

    def test_nothing_is_left_open(self, channel: Path) -> None:
        left_open = {
            f"{name}.{key}"
            for name, table in load_case(channel)
            if name != "fill" and name != "title"
            for key, value in table
            if value is None
        }

        assert left_open == {
            "gravity.vector",
            "geometry.runout_start",
            "inflow.across",
            "inflow.hydrograph",
            "collision_stress.concentration",
            "output.checkpoint_interval",
            "output.layer_interval",
            "time.stop_energy",
        }

    @pytest.mark.parametrize("path", sorted(Path(__file__).parents[2].glob("cases/*.toml")))
    def test_shipped_cases(self, path: Path, tmp_path: Path) -> None:
        case = load_case(path)

        assert reloaded(case, tmp_path) == case


@pytest.mark.parametrize(("name", "distance"), [("still_tank3d", 0.0), ("heap3d", 0.8)])
def test_grains_collide_and_water_does_not_unless_told(name: str, distance: float) -> None:
    path = Path(__file__).parents[2] / "cases" / f"{name}.toml"

    assert load_case(path).explicit_scheme.collision_distance == distance
    told = load_case(path, ["scheme.collision_distance=0.5"])
    assert told.explicit_scheme.collision_distance == 0.5


# as it stood in the case file of every run folder, without the fields that have no default
FORMER = """
[strength]
law = "LAW"
friction_angle = 35.0
inertia_number = 0.279
saturated = true
mixing_length = 0.004
concentration_ramp = [0.2, 0.35]
smallest_shear_rate = 0.001
largest_viscosity = 1000000.0
"""


class TestFormerRheology:
    @pytest.mark.parametrize(
        ("law", "numbers"),
        [
            ("none", {}),
            ("coulomb", {}),
            ("mu-i", {"dynamic_friction_angle": 40.0}),
            ("bingham", {"yield_stress": 30.0}),
            ("herschel-bulkley", {"yield_stress": 30.0, "consistency": 5.0, "exponent": 0.4}),
            (
                "obrien-julien",
                {
                    "yield_stress": 0.0181,
                    "yield_growth": 25.7,
                    "consistency": 0.0036,
                    "viscosity_growth": 22.1,
                },
            ),
        ],
    )
    def test_a_resolved_case_of_before_loads(
        self, tank: Path, law: str, numbers: dict[str, float]
    ) -> None:
        own = "".join(f"{name} = {value}\n" for name, value in numbers.items())
        tank.write_text(tank.read_text() + FORMER.replace("LAW", law) + own)

        case = load_case(tank)

        assert case.rheology.model_dump().items() >= ({"type": law} | numbers).items()
        assert case.rheology.mixing_length == 0.004
        assert f'type = "{law}"' in dump_case(case)
        assert "law = " not in dump_case(case).partition("[rheology]")[2]
        assert reloaded(case, tank.parent).model_dump() == case.model_dump()

    @pytest.mark.parametrize("name", ["law", "type"])
    @pytest.mark.parametrize("former", [True, False])
    def test_the_law_is_changed_by_both_of_its_names(
        self, tank: Path, name: str, former: bool
    ) -> None:
        written = 'law = "coulomb"' if former else 'type = "coulomb"'
        tank.write_text(tank.read_text() + f"[strength]\n{written}\nmixing_length = 0.01\n")

        case = load_case(tank, [f"strength.{name}=bingham", "strength.yield_stress=20"])

        assert case.rheology == Bingham(type="bingham", yield_stress=20.0, mixing_length=0.01)

    def test_a_law_is_switched_off_with_its_numbers_left_in_the_file(self, tank: Path) -> None:
        tank.write_text(tank.read_text() + '[rheology]\ntype = "coulomb"\nfriction_angle = 28.0\n')

        assert load_case(tank, ["rheology.type=none"]).rheology == NoStrength()
        with pytest.raises(CaseError, match="a dry mass needs friction"):
            load_case(tank, ["rheology.type=none", "rheology.saturated=false"])


class TestHydrograph:
    def test_file_becomes_a_table(self, channel: Path) -> None:
        channel.with_name("q.csv").write_text(
            "# a comment\nconcentration, time, discharge\n\n0.1, 0, 0.02\n0.2, 5, 0.03\n"
        )

        inflow = load_case(channel, ["inflow.hydrograph=q.csv"]).inflow

        assert inflow is not None
        assert inflow.hydrograph is not None
        assert not isinstance(inflow.hydrograph, str)
        assert inflow.hydrograph.time == (0.0, 5.0)
        assert inflow.hydrograph.discharge == (0.02, 0.03)
        assert inflow.hydrograph.concentration == (0.1, 0.2)


class TestOverrides:
    def test_numbers_words_and_lists(self, tank: Path) -> None:
        case = load_case(
            tank,
            [
                "particles.spacing = 0.005",
                "scheme.form=study",
                'title="two words"',
                "fill.0.x=[0, 0.1]",
                "fill.0.y.1=0.2",
                "walls.left.slip=free-slip",
            ],
        )

        assert case.particles.spacing == 0.005
        assert case.scheme.form == "study"
        assert case.title == "two words"
        assert case.fill[0].x == (0.0, 0.1)
        assert case.fill[0].y == (0.0, 0.2)
        assert case.walls.left.slip == "free-slip"

    def test_an_entry_with_a_name_is_found_by_it(self, tank: Path) -> None:
        gauges = [
            f'[[probe]]\nname = "{name}"\ntype = "height"\nx = 0.1\ninterval = 1.0\n'
            for name in "ab"
        ]
        tank.write_text(tank.read_text() + "".join(gauges))

        case = load_case(tank, ["probe.b.size=0.05", "probe.0.size=0.06"])

        assert [probe.size for probe in case.probe] == [0.06, 0.05]
        with pytest.raises(CaseError, match=r"no such entry; there are 2, .* by name 'a' or 'b'"):
            load_case(tank, ["probe.c.size=0.05"])

    def test_the_key_of_an_error_is_one_that_can_be_set(self, tank: Path) -> None:
        gauge = '[[probe]]\nname = "p1"\ntype = "height"\nx = 0.9\ninterval = 1.0\n'
        tank.write_text(tank.read_text() + gauge)

        with pytest.raises(CaseError, match=r"^.*\n  probe\.p1\.x = 0\.9 m: outside the tank"):
            load_case(tank)
        assert load_case(tank, ["probe.p1.x=0.1"]).probe[0].x == 0.1

    def test_one_way_of_gravity_replaces_the_other(self, channel: Path) -> None:
        case = load_case(channel, ["gravity.vector=[0, -9.81]"])

        assert case.gravity.components == (0.0, -9.81)

    @pytest.mark.parametrize(
        ("override", "line"),
        [
            ("sediment.grain_diametr=1", "unknown key; did you mean 'grain_diameter'?"),
            ("particles.spacing.x=1", "particles.spacing.x = 1: unknown key"),
            ("fill.3.x=[0, 1]", "fill.3: no such entry; there are 1, counted from 0"),
            ("fill.first.x=[0, 1]", "fill.first: no such entry"),
            ("time.end=2s", 'time.end = "2s" s: must be a number'),
            ("time.end=1\nstep = 2", "time.end = "),
            ("time.end", "--set time.end: must be KEY=VALUE"),
        ],
    )
    def test_wrong_ones_are_told(self, tank: Path, override: str, line: str) -> None:
        with pytest.raises(CaseError, match="1 error\n") as caught:
            load_case(tank, [override])

        assert line in str(caught.value)


class TestUnreadableFiles:
    def test_syntax_error_tells_its_line(self, tank: Path) -> None:
        tank.write_text("title = 'x'\nspacing 0.01\n")

        with pytest.raises(CaseError, match=r"tank\.toml: is not valid TOML: .*line 2"):
            load_case(tank)

    def test_absent(self, tmp_path: Path) -> None:
        with pytest.raises(CaseError, match=r"no\.toml: cannot be read: no such file"):
            load_case(tmp_path / "no.toml")

    def test_not_text(self, tank: Path) -> None:
        tank.write_bytes(b"title = '\xff'")

        with pytest.raises(CaseError, match="UTF-8"):
            load_case(tank)


class TestSchema:
    def test_every_quantity_has_unit_and_description(self) -> None:
        schema = json.loads(case_schema())

        for name, table in schema["$defs"].items():
            assert table["description"], name
            assert table["additionalProperties"] is False
            for key, field in table["properties"].items():
                if key != "type" and "$ref" not in field:
                    assert field["description"], (name, key)
                    assert "unit" in field, (name, key)

    def test_editors_see_the_unit(self) -> None:
        spacing = json.loads(case_schema())["$defs"]["Particles"]["properties"]["spacing"]

        assert spacing["description"].endswith("[m]")

    def test_references_resolve(self) -> None:
        text = case_schema()
        schema = json.loads(text)

        used = {part.split('"')[0] for part in text.split('"$ref": "#/$defs/')[1:]}
        assert used <= set(schema["$defs"])
        assert used

    def test_a_rheology_completes_by_its_law(self) -> None:
        schema = json.loads(case_schema())
        options = schema["properties"]["rheology"]
        mapping = options["discriminator"]["mapping"]

        assert {option["$ref"] for option in options["oneOf"]} == set(mapping.values())
        fields = {
            law: set(schema["$defs"][ref.rpartition("/")[2]]["properties"])
            for law, ref in mapping.items()
        }
        assert fields["none"] == {"type", "mixing_length"}
        assert "yield_stress" in fields["bingham"]
        assert "friction_angle" not in fields["bingham"]

    def test_null_is_not_offered(self) -> None:
        assert "null" not in case_schema()


def test_dumped_case_is_toml_with_a_head(tank: Path) -> None:
    text = dump_case(load_case(tank))

    assert text.startswith("# Resolved case")
    assert tomllib.loads(text)["particles"]["spacing"] == 0.01
