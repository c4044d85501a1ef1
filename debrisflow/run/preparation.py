"""Compiles the kernels in advance, by short runs of the shipped cases."""

from __future__ import annotations

from collections.abc import Iterator

from debrisflow._jit import COMPILATIONS
from debrisflow.case import load_case
from debrisflow.case.templates import templates
from debrisflow.particles.state import initial_state
from debrisflow.run.loop import SCHEMES

STEPS = 2  # only the second step checks whether the neighbor lists are out of date
# for choices that no shipped case makes
VARIANTS: dict[str, tuple[tuple[str, ...], ...]] = {
    "flume2d": (
        ("scheme.form='study'",),
        ("collision_stress.granular_temperature='neighborhood'",),
        ("collision_stress.granular_temperature='fluctuation'",),
    )
}


def compile_kernels() -> Iterator[tuple[str, float]]:
    """Compile the kernels that the shipped cases and some variants of them need.

    Kernels that are in the cache already are only read.

    Yields
    ------
    (str, float)
        The case that was run, and the wall time in which its kernels were compiled, s.
    """
    for name, path in sorted(templates().items()):
        for changes in ((), *VARIANTS.get(name, ())):
            before = COMPILATIONS.seconds
            case = load_case(path, changes)
            scheme, state = SCHEMES[case.scheme.type](case), initial_state(case)
            scheme.fill_number_density(state)
            for _ in range(STEPS):
                dt = scheme.stable_dt(state)
                scheme.step(state, dt)
                state.time, state.step = state.time + dt, state.step + 1
            yield " ".join((name, *changes)), COMPILATIONS.seconds - before
