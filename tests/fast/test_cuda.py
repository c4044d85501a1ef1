"""Do the physics of a pair of particles compile for a GPU as they are: no GPU is needed for that.

Needs the extra ``cuda-check``.  A backend for GPUs would add loops, a cell sort and copies of the
arrays; these functions it would take over.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from numba import typeof, types

from debrisflow.neighbors.boundary import rebounded
from debrisflow.neighbors.lattice import reference
from debrisflow.physics.compressible import density_rate_at
from debrisflow.physics.granular_temperature import (
    capped_temperature,
    neighborhood_temperature_at,
)
from debrisflow.physics.kinetic_theory import Grains
from debrisflow.physics.operators import velocity_gradient_at
from tests.building import (
    Plane,
    acceleration_at,
    fluid_of,
    numbers_of,
    planes,
    random_patch,
    two_lists,
)

# with NVIDIA's compiler the extra takes 500 MB, which nobody has to install to run the tests
pytest.importorskip("numba_cuda", reason="numba-cuda is not installed: the extra cuda-check")
from numba import cuda
from numba.cuda import dispatcher, libdevice, ufuncs

CAPABILITY = (9, 0)
LATTICE = reference(3, 2.4, 1.0)
LENGTH = 9.0


@pytest.fixture(autouse=True)
def compiler(monkeypatch):
    """Let numba-cuda compile without a GPU, and tell it the NumPy functions it does not know."""
    device = SimpleNamespace(compute_capability=CAPABILITY)
    monkeypatch.setattr(dispatcher, "get_current_device", lambda: device)

    def as_function(function):
        def lower(context, builder, signature, arguments):
            return context.compile_internal(builder, function, signature, arguments)

        return {"d->d": lower}

    known = {
        np.sqrt: as_function(lambda x: math.sqrt(x)),
        np.rint: as_function(lambda x: libdevice.rint(x)),
        np.sign: as_function(lambda x: math.copysign(1.0, x) if x != 0.0 else 0.0),
    }
    for ufunc, loops in known.items():
        monkeypatch.setitem(ufuncs.ufunc_db(), ufunc, loops)


@pytest.fixture(params=["open", "periodic"])
def kinds(request):
    """Return the types of the arguments by name."""
    rng = np.random.default_rng(1)
    period = np.array([0.0, LENGTH * (request.param == "periodic"), 0.0])
    position = random_patch(3, 20, rng, LENGTH)
    arguments = {
        "fluid": fluid_of(20),
        "near": two_lists(position, LATTICE, period),
        "solid": planes(position, LATTICE, Plane()),
        "numbers": numbers_of(LATTICE),
        "grains": Grains(
            density=2650.0,
            diameter=0.01,
            restitution=0.8,
            packing_limit=0.55,
            largest_concentration=0.5,
        ),
    }
    return SimpleNamespace(**{name: typeof(value) for name, value in arguments.items()})


def compiled_for_gpu(function, *arguments):
    """Return the code of a function for a GPU, in PTX, and the type of what it returns."""
    code, result = cuda.compile(
        function.py_func, (types.int64, *arguments), device=True, abi="numba", cc=CAPABILITY
    )
    assert ".target sm_90" in code
    assert ".func" in code
    return code, result


VECTORS, SCALARS = types.float64[:, ::1], types.float64[::1]


@pytest.mark.parametrize(
    ("function", "results"),
    [(density_rate_at, 4), (acceleration_at, 12), (velocity_gradient_at, 9)],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_sums_over_neighbors_compile_for_a_gpu(kinds, function, results):
    arguments = (kinds.fluid, kinds.near, kinds.solid, kinds.numbers)
    if function is velocity_gradient_at:
        arguments = (VECTORS, kinds.near, kinds.solid)
    code, result = compiled_for_gpu(function, *arguments)
    assert result == types.UniTuple(types.float64, results)
    assert "sqrt.rn.f64" in code
    period = kinds.near.types[kinds.near.fields.index("period")]
    assert ("rint" in code or "cvt.rni.f64" in code) == (period is not types.none)


def test_agitation_contact_and_walls_compile_for_a_gpu(kinds):
    f, near, solid = types.float64, kinds.near, kinds.solid
    _, found = compiled_for_gpu(neighborhood_temperature_at, VECTORS, SCALARS, near)
    assert found == f
    _, found = compiled_for_gpu(rebounded, f, f, f, f, f, solid)
    assert found == types.UniTuple(f, 3)
    code, result = cuda.compile(
        capped_temperature.py_func,
        (f, f, f, f, kinds.grains),
        device=True,
        abi="numba",
        cc=CAPABILITY,
    )
    assert result == f
    assert ".target sm_90" in code
