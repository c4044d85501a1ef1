"""The members of a study: their cases, and what their addresses depend on."""

import numpy as np
import pytest

from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.errors import CaseError
from debrisflow.study.member import Cases, members_of
from debrisflow.study.tables import Study

STUDY = {"title": "a slope", "design": {"type": "grid"}}
FRICTION = {"name": "friction", "key": "walls.floor.friction.coefficient"}
RANGE = {"distribution": "uniform", "low": 0.1, "high": 0.3}
CASE = """
title = "{title}"
[particles]
spacing = 1.0
[geometry]
type = "terrain"
dem = "slope.asc"
[[release]]
type = "hydrograph"
name = "gully"
line = [[2.0, 8.0], [2.0, 12.0]]
hydrograph = "hydrograph.csv"
velocity = 3.0
[walls.floor.friction]
law = "voellmy"
coefficient = 0.2
turbulence = 300.0
[mixture]
concentration = 0.5
viscosity = 1.0
[scheme]
type = "explicit"
[time]
end = 10.0
[output]
interval = 5.0
"""


@pytest.fixture
def written(tmp_path):
    """Return what writes a case on a slope with a hydrograph, both in files."""

    def write(title="a slope", steep=0.2, discharge=20.0):
        grid = MapGrid(0.0, 0.0, 1.0, 40, 20)
        levels = 50.0 - steep * np.arange(40.0) * np.ones((20, 1))
        write_raster(tmp_path / "slope.asc", Raster(grid, levels))
        rows = f"time,discharge,concentration\n0,0,0.5\n2,{discharge},0.5\n8,0,0.5\n"
        (tmp_path / "hydrograph.csv").write_text(rows)
        path = tmp_path / "case.toml"
        path.write_text(CASE.format(title=title))
        return path

    return write


def member(path, values, program="debrisflow 1", parameters=(), **tables):
    """Return the member of a study of a case at some values."""
    listed = list(parameters) or [FRICTION | RANGE]
    study = Study.model_validate(STUDY | {"case": str(path), "parameter": listed} | tables)
    return members_of(Cases(study), path.parent / "store", [values], program)[0]


def test_a_member_has_its_values_and_the_changes_of_all(written):
    found = member(written(), {"friction": 0.25}, set={"time": {"end": 8.0}})
    assert found.case.walls.floor.friction.coefficient == 0.25
    assert found.case.time.end == 8.0
    assert found.folder.name == found.digest[:16]


def test_factors_multiply_several_columns_of_a_hydrograph_in_a_file(written):
    key = "release.gully.hydrograph"
    factors = [
        {"name": "volume", "key": f"{key}.discharge", "is_factor": True, **RANGE},
        {"name": "duration", "key": "release.0.hydrograph.time", "is_factor": True, **RANGE},
    ]
    found = member(written(), {"volume": 1.5, "duration": 0.5}, parameters=factors)
    hydrograph = found.case.release[0].hydrograph
    assert hydrograph.discharge == (0.0, 30.0, 0.0)
    assert hydrograph.time == (0.0, 1.0, 4.0)


def test_a_factor_needs_a_number(written):
    law = {"name": "law", "key": "walls.floor.friction.law", "is_factor": True, **RANGE}
    with pytest.raises(CaseError, match=r"parameter.law.key = .*no number there"):
        member(written(), {"law": 2.0}, parameters=[law])


def test_a_value_that_no_case_may_have_is_told_with_the_member(written):
    with pytest.raises(CaseError, match=r"(?s)with friction = 7: .*must be less than 5"):
        member(written(), {"friction": 7.0})


def test_the_address_depends_on_values_files_and_program_alone(written, tmp_path):
    values = {"friction": 0.25}
    first = member(written(), values).digest
    assert member(written(title="another title"), values).digest == first
    others = {
        "value": member(written(), {"friction": 0.26}).digest,
        "terrain": member(written(steep=0.21), values).digest,
        "hydrograph": member(written(discharge=21.0), values).digest,
        "program": member(written(), values, program="debrisflow 2").digest,
        "change for all": member(written(), values, set={"time": {"end": 9.0}}).digest,
    }
    assert len({first, *others.values()}) == 6
    assert member(written(), values).digest == first
    moved = tmp_path / "moved"
    moved.mkdir()
    for file in ("slope.asc", "hydrograph.csv", "case.toml"):
        (tmp_path / file).rename(moved / file)
    assert member(moved / "case.toml", values).digest == first


def test_the_address_depends_on_the_coordinate_system_beside_a_grid(written, tmp_path):
    values = {"friction": 0.25}
    first = member(written(), values).digest
    local = 'LOCAL_CS["a quarry",UNIT["metre",1]]'
    path = written()
    (tmp_path / "slope.prj").write_text(local)
    assert member(path, values).digest != first
