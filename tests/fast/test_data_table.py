"""Tables of a run with their units, as arrays, data frames and data sets; frames whole."""

import sys

import numpy as np
import pytest
import pyvista

from debrisflow.errors import OutputError
from debrisflow.particles.arrays import ARRAYS
from debrisflow.results import open_run
from debrisflow.results.data_table import DataTable
from debrisflow.run.folder import RunFolder
from debrisflow.run.history import history_row, units
from debrisflow.run.probes import columns_of
from tests.recording import (
    cells,
    channel3d_case,
    channel_case,
    lattice_of,
    placed,
    record,
    sliding,
)

BUILDS = {2: channel_case, 3: channel3d_case}
NOTHING = np.zeros((0, 3))
PUSH = {"type": "force", "name": "push", "wall": "floor", "interval": 0.1}


def opened(folder, dimension):
    """Return a run of three frames with a probe of a force that has two samples."""
    case = BUILDS[dimension](probe=[PUSH])
    block = cells(case, *[range(8)] * dimension)
    record(folder, case, sliding(case, placed(case, block, velocity=1.0), [0.0, 0.1, 0.2]))
    with RunFolder.open(folder, case) as written:
        for time in (0.0, 0.1):
            written.write_probe(
                "push", time, [[time + 1.0] * len(columns_of(case.probe[0], dimension))]
            )
    return open_run(folder)


@pytest.fixture(params=[2, 3], scope="module")
def run(request, tmp_path_factory):
    return opened(tmp_path_factory.mktemp("tables") / "run", request.param)


def test_units_of_the_history_are_per_width_in_two_dimensions():
    for dimension, per in ((2, " per meter of width"), (3, "")):
        found = units(dimension)
        case = BUILDS[dimension]()
        particles = placed(case, cells(case, *[range(3)] * dimension))
        state = next(sliding(case, particles, [0.0]))
        assert set(found) == set(history_row(case, state, 0, lattice_of(case)))
        assert found["mass_in_liquid"] == f"kg{per}"
        for name in ("kinetic_energy", "potential_energy", "elastic_energy"):
            assert found[name] == f"J{per}"
        assert found["time"] == found["dt"] == "s"
        assert found["front_all"] == "m"
        assert found["sediment_volume_in"] == f"m3{per}"
        assert found["maximal_speed"] == "m/s"
        assert found["particles_in_liquid"] == found["step"] == found["least_density_ratio"] == ""


def test_every_table_knows_its_columns_units(run):
    for table in (run.history, run.deposit, run.maxima, run.probe("push")):
        assert isinstance(table, dict)
        assert list(table.units) == list(table)
    per = " per meter of width" if run.case.dimension == 2 else ""
    assert run.probe("push").units["impulse_x"] == f"N s{per}"
    assert run.deposit.units["deposit_height"] == run.deposit.units["x"] == "m"
    assert run.maxima.units["maximal_momentum_flux"] == "N/m"


def test_a_series_becomes_a_frame_with_the_time_as_its_index(run):
    for table in (run.history, run.probe("push")):
        frame = table.to_pandas()
        assert frame.index.name == "time"
        assert list(frame.columns) == [name for name in table if name != "time"]
        np.testing.assert_array_equal(frame.index, table["time"])
        for name in frame.columns:
            np.testing.assert_array_equal(frame[name], table[name])
        assert frame.attrs["units"] == table.units


def test_a_series_becomes_a_data_set_with_units(run):
    for table in (run.history, run.probe("push")):
        data = table.to_xarray()
        assert dict(data.sizes) == {"time": table["time"].size}
        assert {name: data[name].attrs["units"] for name in data.variables} == table.units
        for name in table:
            np.testing.assert_array_equal(data[name], table[name])
    assert float(run.probe("push").to_xarray().force_x.sel(time=0.1)) == 1.1


def test_rows_of_places_become_a_grid(run):
    places = ("x", "y")[: run.case.dimension - 1]
    assert run.deposit.to_xarray().deposit_height.dims == ("time", *places)
    assert run.maxima.to_xarray().maximal_depth.dims == places
    row = 3
    at = {name: run.deposit[name][row] for name in ("time", *places)}
    found = run.deposit.to_xarray().flow_height.sel(at)
    np.testing.assert_array_equal(found, run.deposit["flow_height"][row])


@pytest.mark.parametrize(("package", "method"), [("pandas", "to_pandas"), ("xarray", "to_xarray")])
def test_a_missing_package_is_told_with_its_command(monkeypatch, package, method):
    monkeypatch.setitem(sys.modules, package, None)
    table = DataTable({"time": np.zeros(1)}, {"time": "s"})
    with pytest.raises(ImportError, match=rf"{method} needs .*: pip install {package}$"):
        getattr(table, method)()


def test_a_probe_that_is_not_there_is_told(run, tmp_path):
    with pytest.raises(OutputError, match="has no probe 'pull', but push"):
        run.probe("pull")
    bare = record(
        tmp_path / "bare", case := channel_case(), sliding(case, placed(case, NOTHING), [0])
    )
    with pytest.raises(OutputError, match="has no probe 'pull', since its case has none"):
        open_run(bare).probe("pull")


def test_a_frame_holds_every_array_of_its_file(run):
    time, file = run.files[1]
    mesh = pyvista.read(file)
    frame = run.frame(time)
    assert set(frame.arrays) == set(mesh.point_data.keys()) >= {array.name for array in ARRAYS}
    for name in mesh.point_data:
        np.testing.assert_array_equal(getattr(frame, name), mesh.point_data[name])
        assert name in dir(frame)
    np.testing.assert_array_equal(frame.position, mesh.points)


def test_a_frame_also_holds_arrays_that_others_have_added(tmp_path):
    run = opened(tmp_path / "run", 2)
    time, file = run.files[0]
    mesh = pyvista.read(file)
    mesh.point_data["age"] = np.arange(mesh.n_points)
    mesh.save(file)
    np.testing.assert_array_equal(run.frame(time).age, np.arange(mesh.n_points))
