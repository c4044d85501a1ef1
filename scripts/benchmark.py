"""Measure the wall time of a whole step of a dam break.

    python scripts/benchmark.py [NAME ...] [--threads 1,2] [--json] [--peer] [--write-docs]

Names: dam2d_2k, dam2d_20k (the default), dam2d_100k, dam2d_200k, sweep (all of them),
dam2d_20k_late (the same column from t = 0.3 s), and in three dimensions dam3d_50k, dam3d_50k_wide
(influence radius 2.4 instead of 2.1 spacings) and dam3d_300k.  A step includes everything that a
run does between two outputs: neighbor lists, sorting, the set-up of the multigrid hierarchy and all
terms.  Kernels are compiled before the clock starts.  Each phase of the step is also given as a
ratio to the neighbor lists of the same run, which is about the same on any machine, so that a phase
that has become slower shows.  ``--write-docs`` puts the table into ``docs/performance.md``.

In three dimensions the memory per particle, walls included, is measured too: resident memory of a
fresh process after the steps less that after a tiny run.  With ``--peer`` each run in three
dimensions takes turns with one of the same dam break in SPlisHSPlasH, which is installed from the
package index into a throw-away environment.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from math import log
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter

import click
from benchmark_peer import environment, measure_peer
from llvmlite.binding import get_host_cpu_name

from debrisflow._jit import set_threads
from debrisflow.case import shapes, tables
from debrisflow.case.defaults import complete
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.explicit import Explicit
from debrisflow.schemes.semi_implicit import SemiImplicit

STEPS = {2: SemiImplicit.REFRESH, 3: 2 * Explicit.REFRESH}
"""Whole periods, in each of which lists are sorted and the multigrid hierarchy is built once."""
TINY = 0.05
LATE = 0.3
SPACING = {
    "dam2d_2k": 0.0158,
    "dam2d_20k": 0.005,
    "dam2d_100k": 0.00224,
    "dam2d_200k": 0.00158,
}
SWEEP = tuple(SPACING)
YARDSTICK = "neighbors"  # the phase to which the others are compared
DOCS = Path(__file__).parents[1] / "docs" / "performance.md"
BEGIN, END = "<!-- benchmark:begin -->", "<!-- benchmark:end -->"
IN_THREE = {"dam3d_50k": (0.01, 2.1), "dam3d_50k_wide": (0.01, 2.4), "dam3d_300k": (0.0055, 2.1)}


def dam_break(spacing: float) -> tables.Case:
    """Return a column of about 1.0 m by 0.5 m in a tank of 2.0 m by 1.0 m."""
    wide, high = round(1.0 / spacing) * spacing, round(0.5 / spacing) * spacing
    return complete(
        tables.Case(
            title="dam break",
            particles=tables.Particles(spacing=spacing),
            geometry=shapes.Tank(type="tank", length=2.0 * wide, height=2.0 * high),
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


def median_of(results: list[dict[str, object]]) -> dict[str, object]:
    """Return the result with the median of the seconds per step."""
    return sorted(results, key=lambda result: result["seconds_per_step"])[len(results) // 2]


def measure_side_by_side(name: str, threads: int, repeats: int, peer: Path) -> dict[str, object]:
    """Return the result of a benchmark with the peer's beside it; their runs take turns."""
    case, ours, theirs = case_of(name), [], []
    for _ in range(repeats):
        ours.append(measure(name, threads, 1))
        theirs.append(measure_peer(peer, case, threads, STEPS[3]))
    return median_of(ours) | {"peer": median_of(theirs)}


def resident_bytes() -> int:
    """Return the resident memory of this process; the greatest so far where there is no /proc."""
    statm = Path("/proc/self/statm")
    if statm.exists():
        return int(statm.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    import resource

    greatest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return greatest if sys.platform == "darwin" else 1024 * greatest


def added_bytes(name: str, threads: int) -> float:
    """Return by how much a benchmark's run raises the memory of this process, bytes a particle."""
    set_threads(threads)
    tiny = dam_break_in_three(TINY, IN_THREE[name][1])
    take_steps(scheme_of(tiny), initial_state(tiny), 3)
    idle = resident_bytes()
    case = case_of(name)
    state, scheme = initial_state(case), scheme_of(case)
    take_steps(scheme, state, STEPS[3])
    return (resident_bytes() - idle) / state.particles.count


def bytes_per_particle(name: str, threads: int) -> float:
    """Return the memory of a benchmark in three dimensions, measured in a fresh process."""
    # what the tables of the set-up took for a moment goes back to the system, and not to the steps
    os.environ["MALLOC_MMAP_THRESHOLD_"] = "131072"
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh:
        return fresh.submit(added_bytes, name, threads).result()


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


def ratios_of(split: dict[str, float]) -> dict[str, float]:
    """Return the seconds of each phase over those of the neighbor lists."""
    return {phase: seconds / split[YARDSTICK] for phase, seconds in split.items()}


def table_lines(results: dict[str, dict[str, dict[str, object]]]) -> list[str]:
    """Return the results as a table in Markdown."""
    lines = [
        f"Seconds of wall time a step on the processor that LLVM calls {get_host_cpu_name()}; the "
        "phases are given as multiples of the time of the neighbor lists in the same run.",
        "",
        "| benchmark | threads | fluid particles | s a step | neighbor lists, s | other phases |",
        "|---|---|---|---|---|---|",
    ]
    for name, runs in results.items():
        for threads, result in runs.items():
            split = result["split"]
            ratios = ratios_of(split)
            others = (f"{phase} {x:.2f}" for phase, x in ratios.items() if phase != YARDSTICK)
            cells = (
                f"`{name}`",
                threads,
                f"{result['fluid']:,}",
                f"{result['seconds_per_step']:.4f}",
                f"{split[YARDSTICK]:.4f}",
                ", ".join(others),
            )
            lines.append(f"| {' | '.join(cells)} |")
    return lines


def write_docs(results: dict[str, dict[str, dict[str, object]]], page: Path = DOCS) -> None:
    """Put the table of the results between its markers in a page, which is made if need be."""
    text = page.read_text(encoding="utf-8") if page.is_file() else "# Performance\n"
    if BEGIN not in text or END not in text:
        text = f"{text.rstrip()}\n\n{BEGIN}\n{END}\n"
    before, rest = text.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    table = "\n".join(table_lines(results))
    page.parent.mkdir(exist_ok=True)
    page.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")


def report(name: str, threads: str, result: dict[str, object]) -> None:
    """Print the result of a benchmark."""
    click.echo(
        f"{name}, {threads} threads: {result['seconds_per_step']:.4f} s a step, "
        f"{result['fluid']} fluid of {result['particles']} particles"
    )
    ratios = ratios_of(result["split"])
    for phase, seconds in result["split"].items():
        click.echo(f"    {phase:<22} {seconds:.4f} s {ratios[phase]:7.2f} x {YARDSTICK}")
    if "bytes_per_particle" in result:
        click.echo(f"    {'memory':<22} {result['bytes_per_particle']:.0f} bytes a particle")
    if peer := result.get("peer"):
        share = result["seconds_per_step"] / peer["seconds_per_step"]
        click.echo(
            f"    pysplishsplash {peer['version']}: {peer['seconds_per_step']:.4f} s a step, "
            f"{peer['fluid']} fluid of {peer['particles']} particles; ours takes {share:.2f} of it"
        )


def wanted_of(names: tuple[str, ...], with_peer: bool) -> list[str]:
    """Return the benchmarks that the words of the command line mean."""
    names = names or ("dam3d_50k" if with_peer else "dam2d_20k",)
    wanted = [n for name in names for n in (SWEEP if name == "sweep" else (name,))]
    known = {*SPACING, *(f"{name}_late" for name in SPACING), *IN_THREE}
    known = set(IN_THREE) if with_peer else known
    if unknown := set(wanted) - known:
        given = " with --peer" if with_peer else ""
        raise click.UsageError(
            f"unknown{given}: {', '.join(unknown)}; known: {', '.join(sorted(known))}"
        )
    return wanted


@click.command()
@click.argument("names", nargs=-1)
@click.option("--threads", default="1,2", show_default=True, help="Numbers of threads.")
@click.option("--repeats", default=3, show_default=True, help="Runs of which the median counts.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON only.")
@click.option(
    "--peer", "with_peer", is_flag=True, help="Run SPlisHSPlasH in turns (3D cases only)."
)
@click.option("--write-docs", "in_docs", is_flag=True, help=f"Put the table into {DOCS.name}.")
def main(
    names: tuple[str, ...],
    threads: str,
    repeats: int,
    as_json: bool,
    with_peer: bool,
    in_docs: bool,
) -> None:
    """Measure NAMES (dam2d_20k if none is given, dam3d_50k with --peer)."""
    results: dict[str, dict[str, dict[str, object]]] = {}
    wanted = wanted_of(names, with_peer)
    with environment() if with_peer else nullcontext() as peer:
        for name in wanted:
            results[name] = {}
            for count in threads.split(","):
                if peer:
                    result = measure_side_by_side(name, int(count), repeats, peer)
                else:
                    result = measure(name, int(count), repeats)
                if name in IN_THREE:
                    result["bytes_per_particle"] = bytes_per_particle(name, int(count))
                results[name][count] = result
                if not as_json:
                    report(name, count, result)
    if in_docs:
        write_docs(results)
    if as_json:
        click.echo(json.dumps(results, indent=2))
        return
    for count in threads.split(","):
        if (exponent := growth(results, count)) is not None:
            click.echo(f"{count} threads: seconds per step grow as N^{exponent:.2f} above 20,000")


if __name__ == "__main__":
    main()
