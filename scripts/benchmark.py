"""Measure the wall time of a whole step of a dam break.

    python scripts/benchmark.py [NAME ...] [--threads 1,2] [--json]

Names: dam2d_2k, dam2d_20k (the default), dam2d_100k, dam2d_200k, sweep (all of them),
dam2d_20k_late (the same column from t = 0.3 s), and in three dimensions dam3d_50k, dam3d_50k_wide
(influence radius 2.4 instead of 2.1 spacings) and dam3d_300k.  A step includes everything that a
run does between two outputs: neighbor lists, sorting, the set-up of the multigrid hierarchy and all
terms.  Kernels are compiled before the clock starts.
"""

from __future__ import annotations

import json
import statistics
from collections import Counter
from math import log
from time import perf_counter

import click

from debrisflow._jit import set_threads
from debrisflow.case import tables
from debrisflow.case.defaults import complete
from debrisflow.explicit import Explicit
from debrisflow.schemes import SemiImplicit
from debrisflow.state import State, initial_state

STEPS = {2: 12, 3: 80}
LATE = 0.3
SPACING = {
    "dam2d_2k": 0.0158,
    "dam2d_20k": 0.005,
    "dam2d_100k": 0.00224,
    "dam2d_200k": 0.00158,
}
SWEEP = tuple(SPACING)
IN_THREE = {"dam3d_50k": (0.01, 2.1), "dam3d_50k_wide": (0.01, 2.4), "dam3d_300k": (0.0055, 2.1)}


def dam_break(spacing: float) -> tables.Case:
    """Return a column of about 1.0 m by 0.5 m in a tank of 2.0 m by 1.0 m."""
    wide, high = round(1.0 / spacing) * spacing, round(0.5 / spacing) * spacing
    return complete(
        tables.Case(
            title="dam break",
            particles=tables.Particles(spacing=spacing),
            geometry=tables.Tank(type="tank", width=2.0 * wide, height=2.0 * high),
            fill=(tables.Block(type="block", x=(0.0, wide), y=(0.0, high), material="water"),),
            time=tables.Time(end=1.0),
            output=tables.Output(interval=0.1),
        )
    )


def dam_break_in_three(spacing: float, radius: float) -> tables.Case:
    """Return a column of about 0.5 x 0.5 x 0.2 m in a tank of 1.6 x 0.8 x 0.4 m."""
    sides = (0.5, 0.5, 0.2, 1.6, 0.8, 0.4)
    long, wide, high, *tank = (round(side / spacing) * spacing for side in sides)
    block = {"type": "block", "x": (0.0, long), "y": (0.0, wide), "z": (0.0, high)}
    return complete(
        tables.Case(
            title="dam break",
            particles={"spacing": spacing, "effective_radius": radius},
            geometry=dict(zip(("length", "width", "height"), tank, strict=True))
            | {"type": "tank3d"},
            fill=[block | {"material": "water"}],
            time={"end": 1.0},
            output={"interval": 0.1},
        )
    )


def case_of(name: str) -> tables.Case:
    """Return the case of a benchmark."""
    if name in IN_THREE:
        return dam_break_in_three(*IN_THREE[name])
    return dam_break(SPACING[name.removesuffix("_late")])


def scheme_of(case: tables.Case) -> SemiImplicit | Explicit:
    """Return a fresh scheme for a case."""
    return Explicit(case) if case.dimension == 3 else SemiImplicit(case)


def take_steps(scheme: SemiImplicit | Explicit, state: State, count: int) -> None:
    """Take steps of the greatest stable length."""
    for _ in range(count):
        dt = scheme.stable_dt(state)
        scheme.step(state, dt)
        state.time += dt
        state.step += 1


def measure(name: str, threads: int, repeats: int) -> dict[str, object]:
    """Return seconds per step, its split and the size of one benchmark; the median of repeats."""
    set_threads(threads)
    late = name.endswith("_late")
    case = case_of(name)
    warm = scheme_of(case)
    take_steps(warm, initial_state(case), 2)
    samples, split = [], Counter[str]()
    steps = 2 * warm.REFRESH if late else STEPS[case.dimension]
    state, scheme = initial_state(case), scheme_of(case)
    while late and state.time < LATE:
        take_steps(scheme, state, scheme.REFRESH)
    for _ in range(repeats):
        if not late:
            state, scheme = initial_state(case), scheme_of(case)
        scheme.seconds.clear()
        start = perf_counter()
        take_steps(scheme, state, steps)
        samples.append((perf_counter() - start) / steps)
        split.update(scheme.seconds)
    return {
        "seconds_per_step": statistics.median(samples),
        "particles": state.particles.count,
        "fluid": state.particles.fluid_count,
        "split": {phase: t / steps / repeats for phase, t in split.items()},
    }


def growth(results: dict[str, dict[str, dict[str, object]]], threads: str) -> float | None:
    """Return the exponent with which seconds per step grow from the least to the greatest case."""
    sized = sorted(
        (int(r[threads]["fluid"]), float(r[threads]["seconds_per_step"]))
        for name, r in results.items()
        if name in SWEEP and name != "dam2d_2k"
    )
    if len(sized) < 2:
        return None
    (n0, t0), (n1, t1) = sized[0], sized[-1]
    return log(t1 / t0) / log(n1 / n0)


@click.command()
@click.argument("names", nargs=-1)
@click.option("--threads", default="1,2", show_default=True, help="Numbers of threads.")
@click.option("--repeats", default=3, show_default=True, help="Runs of which the median counts.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON only.")
def main(names: tuple[str, ...], threads: str, repeats: int, as_json: bool) -> None:
    """Measure NAMES (dam2d_20k if none is given)."""
    wanted = [
        n for name in names or ("dam2d_20k",) for n in (SWEEP if name == "sweep" else (name,))
    ]
    known = {*SPACING, *(f"{name}_late" for name in SPACING), *IN_THREE}
    if unknown := set(wanted) - known:
        raise click.UsageError(f"unknown: {', '.join(unknown)}; known: {', '.join(sorted(known))}")
    results: dict[str, dict[str, dict[str, object]]] = {}
    for name in wanted:
        results[name] = {}
        for count in threads.split(","):
            result = measure(name, int(count), repeats)
            results[name][count] = result
            if not as_json:
                click.echo(
                    f"{name}, {count} threads: {result['seconds_per_step']:.4f} s a step, "
                    f"{result['fluid']} fluid of {result['particles']} particles"
                )
                for phase, seconds in result["split"].items():
                    click.echo(f"    {phase:<22} {seconds:.4f} s")
    if as_json:
        click.echo(json.dumps(results, indent=2))
        return
    for count in threads.split(","):
        if (exponent := growth(results, count)) is not None:
            click.echo(f"{count} threads: seconds per step grow as N^{exponent:.2f} above 20,000")


if __name__ == "__main__":
    main()
