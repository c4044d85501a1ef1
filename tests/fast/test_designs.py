"""Designs: what the members of each must be, and what a study is refused for."""

import numpy as np
import pytest
from scipy import stats

from debrisflow.errors import CaseError
from debrisflow.study.checks import problems_of
from debrisflow.study.designs import numbers_of, points_of
from debrisflow.study.tables import Study

UNIFORM = {"name": "volume", "key": "a", "distribution": "uniform", "low": 100.0, "high": 300.0}
NORMAL = {"name": "friction", "key": "b", "distribution": "normal", "mean": 20.0, "deviation": 2.0}
CUT = NORMAL | {"low": 17.0, "high": 21.0}
LOGNORMAL = {
    "name": "factor",
    "key": "c",
    "distribution": "lognormal",
    "median": 1.0,
    "deviation": 0.3,
}
TRIANGULAR = {
    "name": "ratio",
    "key": "d",
    "distribution": "triangular",
    "low": 0.0,
    "likely": 0.6,
    "high": 0.9,
}
WORDS = {"name": "dem", "key": "e", "distribution": "values", "values": ["a.asc", "b.asc", "c.asc"]}
ALL = [UNIFORM, NORMAL, LOGNORMAL, TRIANGULAR, WORDS]
GRID = {"type": "grid", "levels": 3}
LATIN = {"type": "latin-hypercube", "members": 256}
SOBOL = {"type": "sobol", "members": 256}
ONE = {"type": "one-at-a-time"}
MORRIS = {"type": "morris", "paths": 20}
SALTELLI = {"type": "saltelli", "samples": 32}


def study(parameters, design, **tables):
    return Study(title="t", case="case.toml", parameter=parameters, design=design, **tables)


def together(first, second, coefficient):
    return {"parameters": [first, second], "coefficient": coefficient}


def columns(parameters, design, **tables):
    """Return the values of each parameter as numbers, (members, parameters)."""
    one = study(parameters, design, **tables)
    points = points_of(one)
    assert all(list(point) == [parameter.name for parameter in one.parameter] for point in points)
    return np.column_stack([numbers_of(parameter, points) for parameter in one.parameter])


def shares(parameter, design, **tables):
    """Return the shares of the values of one continuous parameter below each of its values."""
    one = study([parameter], design, **tables)
    return one.parameter[0].law.cdf(numbers_of(one.parameter[0], points_of(one)))


@pytest.mark.parametrize("design", [LATIN, SOBOL], ids=lambda design: design["type"])
@pytest.mark.parametrize("parameter", [UNIFORM, NORMAL, CUT, LOGNORMAL, TRIANGULAR])
def test_values_follow_their_distribution(parameter, design):
    laws = {
        "volume": stats.uniform(100.0, 200.0),
        "friction": stats.norm(20.0, 2.0),
        "factor": stats.lognorm(0.3),
        "ratio": stats.triang(2.0 / 3.0, 0.0, 0.9),
    }
    law = stats.truncnorm(-1.5, 0.5, 20.0, 2.0) if parameter is CUT else laws[parameter["name"]]
    found = columns([parameter], design)[:, 0]

    # a stratified sample is nearer to its distribution than one member's share
    assert stats.ks_1samp(found, law.cdf).statistic <= 1.0 / 256


@pytest.mark.parametrize("design", [LATIN, SOBOL], ids=lambda design: design["type"])
def test_words_come_equally_often(design):
    names = [point["dem"] for point in points_of(study(ALL, design))]

    # a third of the strata, but for those at its two ends
    assert [names.count(word) for word in WORDS["values"]] == pytest.approx([256 / 3] * 3, abs=2)


def test_a_latin_hypercube_has_one_member_in_each_stratum():
    design = LATIN | {"members": 37}

    for parameter in (UNIFORM, NORMAL, TRIANGULAR):
        assert sorted((shares(parameter, design) * 37).astype(int)) == list(range(37))


@pytest.mark.parametrize("design", [LATIN, SOBOL], ids=lambda design: design["type"])
def test_correlations_are_those_of_the_normal_scores(design):
    parameters = [UNIFORM, NORMAL, TRIANGULAR]
    pairs = [together("ratio", "volume", -0.6), together("friction", "ratio", 0.3)]
    laws = [one.law for one in study(parameters, design).parameter]
    wanted = [[1.0, 0.0, -0.6], [0.0, 1.0, 0.3], [-0.6, 0.3, 1.0]]
    correlations = []
    for seed in range(64):
        found = columns(parameters, design | {"seed": seed}, correlation=pairs)
        below = [law.cdf(values) for law, values in zip(laws, found.T, strict=True)]
        correlations.append(np.corrcoef(stats.norm.ppf(below)))
        for values in below:
            assert stats.ks_1samp(values, stats.uniform.cdf).pvalue > 0.01

    # that of one sample of 256 scatters by 1 / 16, the mean of 64 by 1 / 128
    assert np.mean(correlations, axis=0) == pytest.approx(np.array(wanted), abs=3 / 128)


def test_a_correlated_latin_hypercube_stays_one():
    one = study([UNIFORM, NORMAL], LATIN, correlation=[together("volume", "friction", 0.9)])
    values = numbers_of(one.parameter[1], points_of(one))

    strata = (one.parameter[1].law.cdf(values) * 256).astype(int)
    assert sorted(strata) == list(range(256))


@pytest.mark.parametrize("pairs", [[], [together("volume", "friction", 0.5)]])
def test_a_sobol_sequence_is_continued_by_a_longer_one(pairs):
    few, many = (
        points_of(study([UNIFORM, NORMAL], SOBOL | {"members": n}, correlation=pairs))
        for n in (24, 48)
    )

    assert (len(few), len(many)) == (24, 48)
    assert many[:24] == few


@pytest.mark.parametrize("design", [LATIN, SOBOL, MORRIS, SALTELLI], ids=lambda one: one["type"])
def test_a_seed_gives_the_same_members_and_another_one_others(design):
    first, again, other = (points_of(study(ALL, design | {"seed": seed})) for seed in (3, 3, 4))

    assert first == again
    assert first != other
    assert points_of(study(ALL, design)) == points_of(study(ALL, design | {"seed": 0}))


def test_a_grid_has_every_combination_with_both_ends():
    points = points_of(study([UNIFORM, NORMAL, WORDS], GRID))

    assert len({tuple(point.values()) for point in points}) == len(points) == 3 * 3 * 3
    assert {point["volume"] for point in points} == {100.0, 200.0, 300.0}
    assert sorted({point["friction"] for point in points}) == pytest.approx(
        [20.0 - 2.5758 * 2.0, 20.0, 20.0 + 2.5758 * 2.0], abs=1e-3
    )
    assert {point["dem"] for point in points} == set(WORDS["values"])


@pytest.mark.parametrize("parameter", [LOGNORMAL, NORMAL | {"low": 0.0}])
def test_the_end_of_a_range_is_no_bound_that_is_never_reached(parameter):
    found = columns([parameter], GRID)[:, 0]

    median = 1.0 if parameter is LOGNORMAL else 20.0
    assert found[1] == pytest.approx(median)
    assert 0.4 * median < found[0] < median < found[2] < 2.2 * median


def test_one_at_a_time_moves_each_parameter_from_the_medians():
    base, *others = points_of(study([UNIFORM, LOGNORMAL, WORDS], ONE))

    assert base == {"volume": 200.0, "factor": 1.0, "dem": "b.asc"}
    moved = [{name for name in base if point[name] != base[name]} for point in others]
    assert moved == [{"volume"}, {"volume"}, {"factor"}, {"factor"}, {"dem"}, {"dem"}]
    assert [others[0]["volume"], others[1]["volume"]] == pytest.approx([110.0, 290.0])
    assert [others[4]["dem"], others[5]["dem"]] == ["a.asc", "c.asc"]


def test_a_path_of_morris_moves_one_parameter_at_a_time_by_the_same_share():
    parameters = [UNIFORM, TRIANGULAR, LOGNORMAL]
    found = columns(parameters, MORRIS).reshape(20, 4, 3)
    steps = np.diff(found, axis=1) != 0.0

    assert (steps.sum(axis=2) == 1).all()  # one in each step
    assert (steps.sum(axis=1) == 1).all()  # each once in a path
    assert {*np.unique(found[..., 0].round(9))} == {100.0, 166.666666667, 233.333333333, 300.0}
    assert np.abs(np.diff(found[..., 0], axis=1)).max(axis=1) == pytest.approx(200.0 * 2 / 3)
    assert np.isfinite(found).all()


def test_a_block_of_saltelli_exchanges_one_parameter_at_a_time():
    found = columns([UNIFORM, NORMAL, TRIANGULAR], SALTELLI).reshape(32, 5, 3)

    for k in range(3):
        assert (found[:, k + 1, k] == found[:, 4, k]).all()
        others = np.delete(found, k, axis=2)
        assert (others[:, k + 1] == others[:, 0]).all()


@pytest.mark.parametrize("design", [GRID, LATIN, SOBOL, ONE, MORRIS, SALTELLI])
def test_one_parameter_is_enough(design):
    found = columns([NORMAL], design)

    assert np.isfinite(found).all()
    assert len(np.unique(found)) > 1
    assert not problems_of(study([NORMAL], design))


def scenarios(tmp_path, text):
    path = tmp_path / "rows.csv"
    path.write_text(text, encoding="utf-8")
    return points_of(study([UNIFORM, WORDS], {"type": "scenarios", "file": str(path)}))


def test_scenarios_are_the_rows_of_a_file(tmp_path):
    text = "# of the office\nscenario,dem, volume\nsmall,a.asc,120\n\n100 years,c.asc,3e2\n"

    assert scenarios(tmp_path, text) == [
        {"volume": 120.0, "dem": "a.asc"},
        {"volume": 300.0, "dem": "c.asc"},
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty; its first line must name the parameters"),
        ("volume,dem\n", "has no rows below its header"),
        ("volume\n120\n", "has no column 'dem', but each parameter needs one"),
        ("volume,dem,dem\n120,a.asc,b.asc\n", "has two columns 'dem'"),
        (
            "volume,dem,volum\n120,a.asc,1\n",
            "column 'volum': no parameter has this name, and only 'scenario' may hold words for "
            "the reader; did you mean 'volume'?",
        ),
        ("volume,dem\n120\n", "line 2: has 1 values, but the header has 2"),
        ("volume,dem\n120,a.asc\nx,a.asc\n", "line 3, column 'volume': 'x' is not a number"),
        (
            "volume,dem\n\n400,a.asc\n",
            "line 3, column 'volume': 400 is not within the bounds of its distribution, 100 to 300",
        ),
        (
            "volume,dem\n120,a.as\n",
            "line 2, column 'dem': must be 'a.asc', 'b.asc' or 'c.asc', not 'a.as'; "
            "did you mean 'a.asc'?",
        ),
    ],
)
def test_a_wrong_file_of_scenarios_is_refused(tmp_path, text, message):
    with pytest.raises(CaseError) as caught:
        scenarios(tmp_path, text)

    assert str(caught.value) == f"{tmp_path / 'rows.csv'}: {message}"


def test_a_file_of_scenarios_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "rows.csv"
    path.write_bytes(b"\xff\xfe\x00")
    one = study([UNIFORM], {"type": "scenarios", "file": str(path)})
    gone = study([UNIFORM], {"type": "scenarios", "file": str(tmp_path / "gone.csv")})

    with pytest.raises(CaseError, match="is not a text file in UTF-8"):
        points_of(one)
    with pytest.raises(CaseError, match="cannot be read: No such file"):
        points_of(gone)


FIGURE = {"type": "figure", "quantity": "runout", "value": 100.0, "error": 5.0}
RUNOUT = {"name": "runout", "answer": "runout_length"}


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (
            {"parameter": [UNIFORM, NORMAL | {"name": "volume"}]},
            'parameter.1.name = "volume": is the name of parameter.0 too; choose another',
        ),
        (
            {"parameter": [UNIFORM, NORMAL | {"key": ["x", "a"]}]},
            "parameter.1.key = \"a\": 'volume' sets it too; leave one out",
        ),
        (
            {"parameter": [UNIFORM, NORMAL | {"key": "a.b"}]},
            "parameter.1.key = \"a.b\": is a part of a, which 'volume' sets; leave one out",
        ),
        (
            {"parameter": [UNIFORM | {"key": ["a.b", "c", "c"]}]},
            "parameter.0.key = \"c\": 'volume' sets it too; leave one out",
        ),
        (
            {"parameter": [UNIFORM | {"low": 400.0}]},
            "parameter.0.low = 400.0: must be less than high, 300",
        ),
        (
            {"parameter": [NORMAL | {"low": 2.0, "high": 2.0}]},
            "parameter.0.low = 2.0: must be less than high, 2",
        ),
        (
            {"parameter": [TRIANGULAR | {"likely": -0.5}]},
            "parameter.0.likely = -0.5: must lie from low to high, 0 to 0.9",
        ),
        (
            {"parameter": [UNIFORM, WORDS | {"values": ["a.asc"]}]},
            'parameter.1.values = ["a.asc"]: must be two or more; set a single one for all under '
            "[set]",
        ),
        (
            {"parameter": [UNIFORM, WORDS | {"values": [0.5, 1.0, 0.5]}]},
            "parameter.1.values.2 = 0.5: stands in the list before; leave one out",
        ),
        (
            {"correlation": [together("volume", "frction", 0.5)]},
            "correlation.0.parameters: no parameter is named 'frction'; did you mean 'friction'?",
        ),
        (
            {"correlation": [together("volume", "dem", 0.5)]},
            "correlation.0.parameters: 'dem' has a list of values, which are in no order; leave "
            "it out",
        ),
        (
            {"correlation": [together("volume", "volume", 0.5)]},
            'correlation.0.parameters = ["volume", "volume"]: must be two parameters',
        ),
        (
            {
                "correlation": [
                    together("volume", "friction", 0.5),
                    together("friction", "volume", 0.4),
                ]
            },
            'correlation.1.parameters = ["friction", "volume"]: have a correlation already; leave '
            "one out",
        ),
        (
            {
                "correlation": [
                    together("volume", "friction", 0.9),
                    together("friction", "ratio", 0.9),
                    together("volume", "ratio", -0.9),
                ]
            },
            "correlation: no parameters can go together like this: the coefficients contradict "
            "each other (their matrix is not positive definite); bring the largest nearer to 0",
        ),
        *(
            (
                {"design": design, "correlation": [together("volume", "friction", 0.5)]},
                f"correlation: the design '{design['type']}' sets parameters independently of each "
                "other; leave correlations out, or use 'latin-hypercube' or 'sobol'",
            )
            for design in (GRID, ONE, MORRIS, SALTELLI)
        ),
        (
            {"design": ONE | {"shares": [0.9, 0.1]}},
            "design.shares = [0.9, 0.1]: must be two shares from 0 to 1, the lower one first",
        ),
        (
            {"design": SALTELLI | {"samples": 100}},
            "design.samples = 100: must be a power of two: 64 or 128",
        ),
        (
            {"design": GRID | {"levels": 100}},
            "design: gives 300,000,000 members; at most 1,000,000 are possible",
        ),
        (
            {"quantity": [RUNOUT, RUNOUT | {"answer": "fall_height"}]},
            'quantity.1.name = "runout": is the name of quantity.0 too; choose another',
        ),
        (
            {"quantity": [{"name": "nothing"}]},
            "quantity.0: needs either an answer, or a layer and the place at which it is read",
        ),
        (
            {"quantity": [{"layer": "arrival"}]},
            "quantity.0.at: missing: place on the map at which the layer is read",
        ),
        (
            {"quantity": [RUNOUT | {"at": [0.0, 1.0]}]},
            "quantity.0.at = [0.0, 1.0]: has no effect on an answer; leave it out",
        ),
        (
            {"map": [{"layer": "arrivals", "quantiles": [0.5]}]},
            "map.0.layer = \"arrivals\": must be 'peak_depth', 'peak_speed', "
            "'peak_momentum_flux', 'peak_pressure', 'arrival', 'duration', 'deposit', "
            "'final_depth', 'release' or 'terrain'; did you mean 'arrival'?",
        ),
        (
            {"map": [{"layer": "peak_depth", "before": [60.0]}]},
            "map.0.before = [60.0]: times are of the layer 'arrival' only, and this is "
            "'peak_depth'",
        ),
        (
            {"map": [{"layer": "peak_depth", "quantiles": [0.5, 1.0]}]},
            "map.0.quantiles = [0.5, 1.0]: must be shares between 0 and 1, both left out",
        ),
        (
            {"map": [{"layer": "peak_depth"}]},
            "map.0: asks for nothing; give exceeds or quantiles, or leave it out",
        ),
        (
            {"map": [{"layer": "arrival", "before": [-1.0]}]},
            "map.0.before.0 = -1.0: must be at least 0",
        ),
        (
            {"map": [{"layer": "peak_depth", "exceeds": [-0.5, 0.5]}]},
            "map.0.exceeds.0 = -0.5: must be at least 0",
        ),
        (
            {"map": [{"layer": "peak_depth", "exceeds": [0.5, 1.0, 0.5]}]},
            "map.0.exceeds.2 = 0.5: the list has it before; leave one out",
        ),
        (
            {
                "map": [
                    {"layer": "peak_depth", "exceeds": [0.5], "quantiles": [0.5]},
                    {"layer": "peak_speed", "exceeds": [0.5]},
                    {"layer": "peak_depth", "exceeds": [1.0, 0.5000001]},
                ]
            },
            "map.2.exceeds.1 = 0.5000001: map.0 asks for it before; leave one out",
        ),
        (
            {"parameter": [UNIFORM | {"name": "state"}]},
            'parameter.0.name = "state": is a column of the table of members; choose another',
        ),
        (
            {"quantity": [RUNOUT | {"name": "member"}]},
            'quantity.0.name = "member": is a column of the table of members; choose another',
        ),
        (
            {"quantity": [RUNOUT, RUNOUT | {"name": "ratio"}]},
            'quantity.1.name = "ratio": is the name of parameter.3 too; choose another',
        ),
        (
            {"parameter": [UNIFORM | {"name": "runout_length"}]},
            'parameter.0.name = "runout_length": is the name of an answer of each run too; choose '
            "another",
        ),
        (
            {"observation": [FIGURE | {"quantity": "runnout"}], "quantity": [RUNOUT]},
            'observation.0.quantity = "runnout": no [[quantity]] has this name; did you mean '
            "'runout'?",
        ),
        ({"area": {"x": [5.0, 2.0]}}, "area.x = [5.0, 2.0]: must increase"),
        (
            {"parameter": [UNIFORM], "calibration": {"runs": 300}},
            "calibration: needs an [[observation]] that the runs are compared with",
        ),
        (
            {
                "quantity": [RUNOUT],
                "observation": [FIGURE],
                "calibration": {"runs": 300},
                "parameter": [UNIFORM, WORDS],
            },
            'parameter.1.distribution = "values": a parameter that is calibrated must be able to '
            "have any value of a range",
        ),
        (
            {
                "quantity": [RUNOUT],
                "observation": [FIGURE],
                "calibration": {"runs": 40},
                "parameter": [UNIFORM],
            },
            "calibration.runs = 40: must be at least design.members, 256",
        ),
        (
            {
                "quantity": [RUNOUT],
                "observation": [FIGURE],
                "calibration": {"runs": 40},
                "parameter": [UNIFORM],
                "design": GRID,
            },
            "design.type = \"grid\": a calibration needs 'latin-hypercube' or 'sobol'",
        ),
    ],
)
def test_a_study_that_contradicts_itself_is_told_so(tables, message):
    tables = {"parameter": ALL, "design": LATIN} | tables

    assert [str(problem) for problem in problems_of(Study(title="t", case="c", **tables))] == [
        message
    ]


def test_a_study_in_order_has_no_problems():
    one = study(
        [UNIFORM, NORMAL],
        LATIN,
        correlation=[together("volume", "friction", -0.99)],
        quantity=[RUNOUT, {"layer": "arrival", "at": [1.0, 2.0]}],
        map=[{"layer": "arrival", "before": [60.0]}, {"layer": "peak_depth", "quantiles": [0.5]}],
        area={"x": [0.0, 10.0]},
        observation=[FIGURE],
        calibration={"runs": 300, "held_out": {"x": [0.0, 5.0]}},
    )

    assert problems_of(one) == []
