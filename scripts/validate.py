"""Print the figures of the README's tables of accuracy, from runs made now.

python scripts/validate.py [still] [viscous] [dam_break] [shear] [settling] [collapse]

All but ``collapse`` take about five minutes together; ``collapse``, with its fine spacing, as many.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

import click
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.validation import (
    collapse,
    dam_break,
    granular_shear,
    hydrostatic,
    settling,
    viscous,
)

TEMPERATURES = ("algebraic", "neighborhood", "fluctuation")
STILL = {
    "still water, 20 rows": ("hydrostatic2d", ()),
    "still water, 40 rows": ("hydrostatic2d", ("particles.spacing=0.005",)),
    "still water, a tenth of the step": ("hydrostatic2d", ("time.largest_step=1e-4",)),
    "still water, operators of the study": ("hydrostatic2d", ('scheme.form="study"',)),
    "two layers, 20 rows": ("hydrostatic_two_phase2d", ()),
    "two layers, 40 rows": ("hydrostatic_two_phase2d", ("particles.spacing=0.005",)),
    "two layers, coefficient (9)": ("hydrostatic_two_phase2d", ('scheme.interface="study"',)),
    "two layers, with drag": ("hydrostatic_two_phase2d", ("drag.law=wen-yu",)),
}


def print_still() -> None:
    """Print pressure, height and interface of water at rest."""
    for title, (name, overrides) in STILL.items():
        found = hydrostatic.run(name, overrides)
        click.echo(
            f"{title}: pressure {found.pressure_error:.2%}, noise {found.floor_noise:.2%}, "
            f"height {found.height - 1:+.2%}, interface {found.interface:.1f} rows, slopes "
            f"{found.slopes[0] / 9.81:.0f} g and {found.slopes[1] / 9.81:.0f} g, "
            f"{found.through_wall} through walls"
        )


def print_viscous() -> None:
    """Print the errors of viscous start-up."""
    for flow in ("poiseuille", "couette", "film"):
        errors = [
            viscous.error(flow, 20, u, (0.05, 0.1, 0.2, 0.5, 1.0)) for u in (1.25e-5, 1.25e-3)
        ]
        click.echo(f"{flow}, 20 rows: {errors[0]:.2%}; rows pass each other: {errors[1]:.2%}")


def print_dam_break() -> None:
    """Print front, height and energy of the dam break."""
    for across in (16, 32, 64):
        found = dam_break.run(across)
        shift, error = found.best_shift()
        z = np.interp([1.0, 2.0, 3.0], found.scaled_time, found.front / dam_break.WIDTH)
        click.echo(
            f"dam break, {across} across: front {found.front_error():.1%}, {error:.1%} at a shift "
            f"of {shift:.2f}, slope {found.slope():.3f} ({found.slope() / 1.32 - 1:+.1%}), height "
            f"{found.height_error():.3f} H0, energy {found.energy.max():.4f}, Z at T = 1, 2, 3: "
            f"{z.round(3).tolist()}"
        )
    splash = dam_break.run(32, end=2.0)
    click.echo(
        f"dam break, 32 across, 2 s: energy {splash.energy.max():.4f}, "
        f"{splash.state.through_wall.sum()} through walls, {splash.state.left.sum()} over the rim"
    )


def print_shear() -> None:
    """Print temperature and stress of grains in plane shear and the profile of a film of them."""
    theory = 0.4 * np.sqrt(15.0 * (1.0 - granular_shear.RESTITUTION) / np.pi)
    for name in TEMPERATURES:
        for rows in (10, 20, 40):
            found = granular_shear.plane_shear(rows, temperature=name)
            click.echo(
                f"plane shear, {name}, {rows} rows: T / balance {found.temperature_ratio:.4f}, "
                f"tau / p {found.stress_ratio:.4f} (theory of the balance {theory:.4f})"
            )
    for rows in (10, 20):
        film = granular_shear.film(rows)
        click.echo(
            f"film of grains, {rows} rows: greatest error "
            f"{np.abs(film.speed - film.exact).max():.2%} of the exact surface speed"
        )
    y, temperature, rate = granular_shear.discrete_elements()
    size = granular_shear.fitted_grain_over_gap()
    found = granular_shear.closure(rate, size)
    error = np.sqrt(np.mean((found - temperature) ** 2)) / temperature.mean()
    click.echo(
        f"discrete elements, d / H = {size:.3f} fitted: T of the closure over theirs at y / H = "
        f"{y.round(2).tolist()}: {(found / temperature).round(2).tolist()}; rms {error:.1%} of the "
        "mean T"
    )


def print_settling() -> None:
    """Print interface speed, bed and rest of settling columns."""
    columns = [(c, seed, "wen-yu", 0.01) for c in (0.1, 0.2, 0.3) for seed in (1, 2)]
    columns += [(0.3, 1, "gidaspow", 0.01), (0.3, 1, "wen-yu", 0.005)]
    for c, seed, law, spacing in columns:
        found = settling.run(c, seed, law, spacing)
        click.echo(
            f"settling, C0 = {c}, mix {seed}, {law}, d0 = {spacing} m: {found.speed:.4f} m/s, "
            f"{found.speed / settling.richardson_zaki(c):.2f} of Richardson & Zaki; bed C "
            f"{found.bed:.3f}, {found.bed_height:.3f} m; moved in 2 s {found.mean_displacement:.3f}"
            f" d0, at most {found.greatest_displacement:.2f}; nothing lost: {found.kept}"
        )


def print_collapse() -> None:
    """Print the pairs of A2 with and without stress, and what the temperatures cost."""
    for law, spacing in (("none", 0.01), ("none", 0.005), ("wen-yu", 0.01), ("wen-yu", 0.005)):
        for seed in (1, 2, 3, 4):
            changes = (f"drag.law={law}", f"particles.spacing={spacing}")
            pair = [collapse.run(stress, seed, changes) for stress in (True, False)]
            lags = [found.water - found.sediment for found in pair]
            layers = [[round(v, 2) for v in found.layering.values()] for found in pair]
            click.echo(
                f"A2, drag {law}, d0 = {spacing} m, mix {seed}: shift at 0.75 s "
                f"{pair[0].sediment - pair[1].sediment:+.4f} m; with / without: lag of the "
                f"sediment {lags[0]:.3f} / {lags[1]:.3f} m, layering at 0.75, 1.5, 2 s "
                f"{layers[0]} / {layers[1]}, energy {pair[0].energy:.4f} / {pair[1].energy:.4f}, "
                f"through walls {pair[0].through_wall} / {pair[1].through_wall}"
            )
    for name in TEMPERATURES:
        for spacing in (0.01, 0.005):
            changes = (
                f"collision_stress.granular_temperature={name}",
                f"particles.spacing={spacing}",
            )
            start = perf_counter()
            found = collapse.run(True, 1, changes, end=collapse.LAG_TIME)
            click.echo(
                f"A2, {name}, d0 = {spacing} m: mean step {found.step:.2e} s, "
                f"{perf_counter() - start:.1f} s to 0.75 s, sediment at {found.sediment:.3f} m"
            )


PARTS: dict[str, Callable[[], None]] = {
    "still": print_still,
    "viscous": print_viscous,
    "dam_break": print_dam_break,
    "shear": print_shear,
    "settling": print_settling,
    "collapse": print_collapse,
}


@click.command()
@click.argument("parts", nargs=-1, type=click.Choice(list(PARTS)))
def main(parts: tuple[str, ...]) -> None:
    """Print the figures of PARTS, or all."""
    for part in parts or PARTS:
        PARTS[part]()


if __name__ == "__main__":
    main()
