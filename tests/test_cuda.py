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

from debrisflow.neighbors.lattice import reference
from debrisflow.physics import agitation, compressible
from debrisflow.physics.kinetic_theory import Grains
from tests.building import fluid_of, near_of, numbers_of, random_patch, solid_of

pytest.importorskip("numba_cuda", reason="numba-cuda is not installed: the extra cuda-check")
from numba import cuda
from numba.cuda import dispatcher, libdevice, ufuncs
from numba.cuda.cudadrv import nvvm

pytestmark = pytest.mark.skipif(
    not nvvm.is_available(),
    reason="numba-cuda is installed without its toolkit, whose NVVM compiles to PTX",
)
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
    """Return the types of the arguments: fluid, solid, near, numbers, grains."""
    rng = np.random.default_rng(1)
    period = np.array([0.0, LENGTH * (request.param == "periodic"), 0.0])
    fluid, solid = (build(random_patch(3, 20, rng, LENGTH)) for build in (fluid_of, solid_of))
    near, grains = near_of(fluid, solid, LATTICE, period), Grains(2650.0, 0.01, 0.8, 0.55, 0.5)
    return tuple(map(typeof, (fluid, solid, near, numbers_of(LATTICE), grains)))


def compiled_for_gpu(function, *arguments):
    """Return the code of a function for a GPU, in PTX, and the type of what it returns."""
    code, result = cuda.compile(
        function.py_func, (types.int64, *arguments), device=True, abi="numba", cc=CAPABILITY
    )
    assert ".target sm_90" in code
    assert ".func" in code
    return code, result


@pytest.mark.parametrize(
    ("function", "results"),
    [
        (compressible.density_rate_at, 3),
        (compressible.acceleration_at, 7),
        (agitation.velocity_gradient_at, 9),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_sums_over_neighbors_compile_for_a_gpu(kinds, function, results):
    code, result = compiled_for_gpu(function, *kinds[:4])
    assert result == types.UniTuple(types.float64, results)
    assert "sqrt.rn.f64" in code
    assert ("rint" in code or "cvt.rni.f64" in code) == (kinds[2].types[-1] is not types.none)


def test_agitation_contact_and_walls_compile_for_a_gpu(kinds):
    fluid, solid, near, numbers, grains = kinds
    f, pair = types.float64, fluid.types[0]
    assert compiled_for_gpu(agitation.agitation_at, fluid, near, numbers)[1] == f
    assert compiled_for_gpu(compressible.bounce_at, f, f, f, *kinds[:4])[1] == types.UniTuple(f, 3)
    found = compiled_for_gpu(compressible.is_inside_wall_at, pair, solid, near, numbers)[1]
    assert found == types.boolean
    code, result = cuda.compile(
        agitation.capped_temperature.py_func,
        (f, f, grains, numbers),
        device=True,
        abi="numba",
        cc=CAPABILITY,
    )
    assert result == f
    assert ".target sm_90" in code
