"""Print the figures of the README's table of accuracy, from runs made now (about two minutes).

python scripts/validate.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import click
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.validation import dam_break, hydrostatic, viscous

STILL = {
    "still water, 20 rows": ("hydrostatic2d", ()),
    "still water, 40 rows": ("hydrostatic2d", ("particles.spacing=0.005",)),
    "still water, a tenth of the step": ("hydrostatic2d", ("time.largest_step=1e-4",)),
    "still water, operators of the study": ("hydrostatic2d", ('scheme.form="study"',)),
    "two layers, 20 rows": ("hydrostatic_two_phase2d", ()),
    "two layers, 40 rows": ("hydrostatic_two_phase2d", ("particles.spacing=0.005",)),
    "two layers, coefficient (9)": ("hydrostatic_two_phase2d", ('scheme.interface="study"',)),
}


@click.command()
def main() -> None:
    """Print the figures."""
    for title, (name, overrides) in STILL.items():
        found = hydrostatic.run(name, overrides)
        click.echo(
            f"{title}: pressure {found.pressure_error:.2%}, noise {found.floor_noise:.2%}, "
            f"height {found.height - 1:+.2%}, interface {found.interface:.1f} rows, slopes "
            f"{found.slopes[0] / 9.81:.0f} g and {found.slopes[1] / 9.81:.0f} g, "
            f"{found.through_wall} through walls"
        )
    for flow in ("poiseuille", "couette", "film"):
        errors = [
            viscous.error(flow, 20, u, (0.05, 0.1, 0.2, 0.5, 1.0)) for u in (1.25e-5, 1.25e-3)
        ]
        click.echo(f"{flow}, 20 rows: {errors[0]:.2%}; rows pass each other: {errors[1]:.2%}")
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


if __name__ == "__main__":
    main()
