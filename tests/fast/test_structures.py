"""Structures on a terrain, and the probes there: a pool behind a dam, of few particles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from debrisflow.case import dump_case, load_case
from debrisflow.neighbors.half_space import PULLED_BACK
from debrisflow.results.reader import Run
from debrisflow.run.simulation import simulate
from debrisflow.schemes.surfaces import elements_from
from debrisflow.space import mesh_pieces
from debrisflow.space.domain import WALL_NAMES
from debrisflow.space.ground import ground_of
from debrisflow.space.mesh_pieces import (
    area_vectors,
    faces_in_open,
    pieces_of,
    top_of_structures,
)
from debrisflow.space.scene import faces_of
from debrisflow.validation.at_rest.terrain_pool import (
    CREST,
    DAM,
    GRID,
    LEVEL,
    THICKNESS,
    normal_of,
    pool_case,
)

CASES = Path(__file__).parents[2] / "cases"

TURN, END = 20.0, 2.0
X, Y = GRID.west + DAM[0], GRID.south + DAM[1]
FACE = np.array([X, Y]) + 0.5 * THICKNESS * normal_of(TURN)
POOL = np.array([X, Y]) + 6.0 * normal_of(TURN)
PROBES = [
    {"type": "height", "name": "pool", "x": POOL[0], "y": POOL[1]},
    {"type": "height", "name": "crest", "x": X, "y": Y},
    {"type": "pressure", "name": "face", "wall": "dam", "x": FACE[0], "y": FACE[1], "z": LEVEL - 2},
    {"type": "pressure", "name": "bed", "wall": "floor", "x": POOL[0], "y": POOL[1], "z": 95.5},
    {"type": "section", "name": "section", "x": POOL[0]},
    {"type": "volume", "name": "box", "x": [GRID.west, X], "y": [GRID.south, Y], "z": [90, 103]},
    {"type": "point", "name": "point", "x": POOL[0], "y": POOL[1], "z": 98.0},
    {"type": "line", "name": "line", "start": [*POOL, 95.0], "end": [*POOL, 101.0]},
    {
        "type": "grid",
        "name": "grid",
        "x": [POOL[0], POOL[0]],
        "y": [Y - 4, Y + 4],
        "z": [95, 101],
    },
    {"type": "force", "name": "force", "wall": "dam"},
    {"type": "bands", "name": "bands", "wall": "dam", "bands": 4, "direction": [0.94, 0.342]},
    {"type": "dam", "name": "dam", "wall": "dam", "direction": [0.94, 0.342]},
]


def case_of(folder, **changes):
    probes = [{"interval": 0.5 * END, **probe} for probe in changes.pop("probes", PROBES)]
    return pool_case(folder, 1.0, TURN, end=changes.pop("end", END), probes=probes, **changes)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pool")
    simulate(case_of(folder), folder / "run")
    return Run(folder / "run")


def last(run, name):
    table = run.probe(name)
    return {column: table[column][-1] for column in table}


def test_the_top_of_structures_is_found_with_one_cut(tmp_path, monkeypatch):
    case = case_of(tmp_path, probes=[])
    (dam,) = case.obstacle
    higher = {"name": "tower", "z": (dam.z[0], dam.z[1] + 3.0), "turn": 0.0}
    higher |= {"x": (10.0, 14.0), "y": (10.0, 14.0)}
    case = case.model_copy(update={"obstacle": (dam, dam.model_copy(update=higher))})
    cuts = []
    monkeypatch.setattr(
        mesh_pieces, "pieces_of", lambda *given: cuts.append(1) or pieces_of(*given)
    )
    middle = [0.5 * sum(ends) for ends in (dam.x, dam.y)]
    assert top_of_structures(case, *middle) == pytest.approx(dam.z[1])
    assert top_of_structures(case, 12.0, 12.0) == pytest.approx(dam.z[1] + 3.0)
    assert top_of_structures(case, 1.0, 1.0) == -np.inf
    assert len(cuts) == 3


def test_a_base_below_the_origin_counts_as_one_in_the_ground(tmp_path):
    case = case_of(tmp_path, probes=[])
    (dam,) = case.obstacle
    deep = dam.model_copy(update={"z": (-500.0, dam.z[1])})
    text = dump_case(case.model_copy(update={"obstacle": (deep,)}))
    (tmp_path / "deep.toml").write_text(text)
    found = load_case(tmp_path / "deep.toml")
    assert found.obstacle == (deep,)
    faces, built = faces_in_open(found, "dam"), faces_in_open(case, "dam")
    high, low = (level[:, :, 2].max() for level in (faces, built))
    assert high == low
    assert faces[:, :, 2].min() == pytest.approx(built[:, :, 2].min(), abs=0.1)
    areas = [np.abs(area_vectors(each)).sum(axis=0) for each in (faces, built)]
    np.testing.assert_allclose(*areas, rtol=0.02)


def test_a_turned_box_has_one_outline(tmp_path):
    (dam,) = case_of(tmp_path, probes=[]).obstacle
    corners = np.unique(faces_of(dam)[:, :, :2].reshape(-1, 2).round(9), axis=0)
    np.testing.assert_allclose(corners, sorted(dam.corners_in_plan))
    back = np.array([dam.unturned((*corner, 1.0)) for corner in dam.corners_in_plan]).round(9)
    assert sorted(back.tolist()) == [[x, y, 1.0] for x in dam.x for y in dam.y]


def test_a_dam_is_closed_above_the_ground_and_has_nothing_below(tmp_path):
    case = case_of(tmp_path)
    elements = elements_from(*pieces_of(case, PULLED_BACK))
    total = (elements.area[:, None] * elements.normal).sum(axis=0)
    assert np.abs(total).max() < 0.01 * elements.area.sum()
    x, y, z = np.moveaxis(elements.corners, 2, 0)
    assert np.all(z > ground_of(case).surface.level(x, y) - 1e-9)
    faces = faces_in_open(case, "dam")
    # above the crest only where the ground rises through it
    level = ground_of(case).surface.level(faces[:, :, 0], faces[:, :, 1])
    assert np.all(faces[:, :, 2] <= np.maximum(level + 1e-9, CREST - case.terrain.origin[2]))
    # no slivers of sides far below: the base and what is open
    assert len(elements.area) < 2.5 * len(faces)
    assert np.linalg.norm(area_vectors(faces), axis=1).min() > 0.0


def test_heights_are_above_the_smooth_ground_or_a_structure(run):
    case = run.case
    local = POOL - case.terrain.origin[:2]
    level = ground_of(case).surface.level(local[:1], local[1:])[0] + case.terrain.origin[2]
    assert last(run, "pool")["filled_height"] == pytest.approx(LEVEL - level, rel=0.1)
    assert last(run, "pool")["height"] == pytest.approx(LEVEL - level, abs=0.8)
    assert last(run, "crest")["filled_height"] == 0.0


def test_pressures_on_a_turned_dam_and_on_the_ground(run):
    face, bed = last(run, "face"), last(run, "bed")
    assert face["pressure"] == pytest.approx(1000 * 9.81 * 2.0, rel=0.15)
    assert face["reaction"] == pytest.approx(face["pressure"], rel=0.25)
    assert bed["pressure"] == pytest.approx(1000 * 9.81 * 4.4, rel=0.15)
    assert bed["reaction"] == pytest.approx(bed["pressure"], rel=0.25)


def test_bands_share_out_the_force(run):
    table, force = run.probe("bands"), last(run, "force")
    rows = table["time"] == table["time"][-1]
    for axis in "xyz":
        total = table[f"force_{axis}"][rows].sum()
        assert total == pytest.approx(force[f"force_{axis}"], rel=1e-6, abs=1.0)
    pressure, low = table["pressure"][rows], table["lower"][rows] + run.case.terrain.origin[2]
    assert np.all(np.diff(pressure[low < LEVEL - 2.0]) < 0.0)
    assert pressure[-1] < 0.05 * pressure[0]
    assert np.all(table["pressure_least"][rows] <= pressure)
    assert np.all(pressure <= table["pressure_greatest"][rows])
    # of the face between the sides of the valley
    assert table["area"][rows][-1] > table["area"][rows][0]


def test_a_dam_holds_back_all_of_a_pool(run):
    dam, released = last(run, "dam"), 1177.0
    assert dam["trapped_volume"] == released
    assert dam["overtopped_volume"] == 0.0
    assert np.isnan(dam["overtopping_time"])


def test_flow_probes_see_the_pool(run):
    assert last(run, "point")["pressure"] == pytest.approx(1000 * 9.81 * 2.0, rel=0.2)
    line, box = run.probe("line"), last(run, "box")
    wet = line["wet"] == 1.0
    assert 0.4 < wet.mean() < 1.0
    assert 300.0 < box["volume"] < 800.0
    assert last(run, "section")["depth"] > 1.0
    assert any((run.folder / "probes").glob("grid*"))


def test_what_comes_over_a_dam_is_counted_from_the_first(tmp_path):
    dam = [probe for probe in PROBES if probe["name"] == "dam"]
    case = case_of(tmp_path, crest=98.5, end=2.5, probes=dam)
    summary = simulate(case, tmp_path / "run")
    found = last(Run(tmp_path / "run"), "dam")
    assert summary is not None
    assert 0.0 < found["overtopping_time"] < 2.5
    assert 5.0 < found["overtopped_volume"] < 400.0
    assert 300.0 < found["trapped_volume"] < 1177.0 - found["overtopped_volume"]


def test_no_face_of_a_dam_looks_into_it_where_the_ground_rises_along_its_side():
    case = load_case(CASES / "channelled_fan.toml")
    pieces, number, is_face = pieces_of(case, PULLED_BACK)
    for wall, box in enumerate(case.obstacle, start=len(WALL_NAMES)):
        own = pieces[(number == wall) & is_face][:, :, :3]
        middle = np.mean([box.x, box.y, box.z], axis=1)
        angle = np.radians(box.turn)
        along = np.array([np.cos(angle), np.sin(angle), 0.0])
        across = np.array([-np.sin(angle), np.cos(angle), 0.0])
        axes = np.array([along, across, [0.0, 0.0, 1.0]])
        normal = area_vectors(own) @ axes.T
        off = (own.mean(axis=1) - middle) @ axes.T
        side = np.argmax(np.abs(normal), axis=1)
        rows = np.arange(len(own))
        assert len(own) > 100
        assert np.all(normal[rows, side] * off[rows, side] > 0.0)
