"""Compiles the kernels in advance, by short runs of the shipped cases."""

from __future__ import annotations

from pathlib import Path

from debrisflow._jit import COMPILATIONS
from debrisflow.case import load_case
from debrisflow.case.templates import templates
from debrisflow.particles.start import initial_state
from debrisflow.run.trial import take_step
from debrisflow.schemes.choice import scheme_of

STEPS = 2  # only the second step checks whether the neighbor lists are out of date
# for choices that no shipped case makes; each rheological law has kernels of its own
LAWS: tuple[tuple[str, ...], ...] = (
    ("rheology.type='mu-i'", "rheology.dynamic_friction_angle=45.0"),
    ("rheology.type='bingham'", "rheology.yield_stress=30.0"),
    (
        "rheology.type='herschel-bulkley'",
        "rheology.yield_stress=30.0",
        "rheology.consistency=5.0",
        "rheology.exponent=0.5",
    ),
    (
        "rheology.type='obrien-julien'",
        "rheology.yield_stress=1.0",
        "rheology.yield_growth=10.0",
        "rheology.consistency=0.01",
        "rheology.viscosity_growth=10.0",
    ),
)
VARIANTS: dict[str, tuple[tuple[str, ...], ...]] = {
    "dam_break3d": (
        (
            "collision_stress.enabled=true",
            "collision_stress.granular_temperature='neighborhood'",
        ),
    ),
    "flume3d": LAWS,
    "flume2d": (
        *LAWS,
        ("scheme.form='study'",),
        ("collision_stress.granular_temperature='neighborhood'",),
        ("collision_stress.granular_temperature='fluctuation'",),
    ),
}


def short_runs() -> dict[str, tuple[Path, tuple[str, ...]]]:
    """Return the case files to run with the changes to them, by a name for each run."""
    return {
        " ".join((name, *changes)): (path, changes)
        for name, path in templates().items()
        for changes in ((), *VARIANTS.get(name, ()))
    }


def compile_kernels(path: Path, changes: tuple[str, ...]) -> float:
    """Take two steps of a case, and return the wall time in which kernels were compiled, s.

    Kernels that are in the cache already are only read.
    """
    before = COMPILATIONS.seconds
    case = load_case(path, changes)
    scheme, state = scheme_of(case), initial_state(case)
    scheme.fill_number_density(state)
    for _ in range(STEPS):
        take_step(scheme, state)
    return COMPILATIONS.seconds - before
