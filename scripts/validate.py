"""Print the figures of the README's tables of accuracy, from runs made now.

python scripts/validate.py [still] [viscous] [dam_break] [shear] [settling] [collapse] [bed] [flume]
                           [fine_flume] [short_flume] [still3d] [dam_break3d] [marin] [cube] [heap]
                           [film3d] [deposit3d] [dams] [ground3d] [st_helens] [impact] [jet]
                           [moving] [usgs] [slab]

``fine_flume``, ``usgs`` and ``st_helens`` take about an hour, ``marin`` and ``heap`` half an hour,
``collapse`` and ``flume`` about ten minutes, the others five or less each.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from itertools import product
from pathlib import Path
from time import perf_counter

import click
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from validate_in_three import IN_THREE

from debrisflow.validation.at_rest import still_water as hydrostatic
from debrisflow.validation.beds import endless_bed, settling
from debrisflow.validation.dam_breaks import dam_break, moving_walls, plate_jet
from debrisflow.validation.dam_breaks import zhou as impact
from debrisflow.validation.debris_flows import collapse, flume
from debrisflow.validation.granular import granular_shear
from debrisflow.validation.viscous import rough_film
from debrisflow.validation.viscous import start_up as viscous
from tests.slow import bed_controls as controls

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
    for dimension, film in product((2, 3), ((0.026, 0.095, 0.0095), (0.026, 0.003, 0.004))):
        exact, counts = rough_film.mean_speed(*film), (1, 2, 4, 8)
        films = [rough_film.run(rows, *film, dimension) for rows in counts]
        found = [f"{each.speed / exact - 1.0:+.1%}, {1e3 * each.across:.0f} mm/s" for each in films]
        click.echo(
            f"turbulent film in {dimension} dimensions, {film[0]} m deep, roughness {film[1]} m, "
            f"mixing length {film[2]} m: mean speed in 1, 2, 4, 8 rows against {exact:.3f} m/s: "
            f"{', '.join(found)}"
        )


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


def print_impact() -> None:
    """Print depths, arrivals and pressures of the dam break against a wall."""
    measured = impact.experiment()
    for spacing in (0.02, 0.01):
        found = impact.run(spacing)
        time = found.series["time"]
        click.echo(f"impact, d0 = {spacing} m: energy {found.energy:.4f}, {found.lost} lost")
        for name in impact.GAUGES:
            ours, theirs = (
                impact.arrival(*series, impact.WET)
                for series in ((time, found.series[name]), measured[name].T)
            )
            error = 100.0 * found.level_error(name)
            click.echo(f"  {name}: rms {error:.1f} cm; at {ours:.3f} s, measured {theirs:.3f} s")
        for name in ("p2", "reaction_p2"):
            raw = found.series[name]
            calm = impact.smoothed(time, raw)
            click.echo(
                f"  {name}: at {impact.arrival(time, calm, impact.PRESSED):.3f} s, mean over "
                f"{impact.PLATEAU} s {impact.mean(time, raw, *impact.PLATEAU) / 1e3:.2f} kPa, "
                f"first peak {raw[time < impact.FIRST].max() / 1e3:.2f} kPa"
            )
        theirs = impact.mean(*measured["p2"].T, *impact.PLATEAU)
        click.echo(f"  measured: mean {theirs / 1e3:.2f} kPa")


def print_jet() -> None:
    """Print thrust and pressure of a jet on a plate, beside potential flow."""
    for dimension, rows in ((2, 4), (2, 8), (2, 16), (3, 8)):
        found = plate_jet.run(dimension, rows)
        click.echo(
            f"jet on a plate, {dimension} dimensions, {rows} rows: thrust {found.thrust:.3f} of "
            f"rho Q u; pressure by the reaction in steps of half the thickness "
            f"{found.pressure.round(3).tolist()}, potential flow "
            f"{found.expected.round(3).tolist()}; by the fluid at the foot {found.by_fluid:.2f}"
        )


def print_moving() -> None:
    """Print fronts behind gates, the discharge under one, a bore and a standing wave."""
    for speed in (None, 64.0, 16.0, 4.0, 1.0):
        told = "no gate" if speed is None else f"gate at {speed:g} m/s"
        front = moving_walls.front_after(speed)
        click.echo(f"{told}: front {front / 0.01:.1f} spacings from the wall after 0.25 s")
    for rows in (4, 8):
        found = moving_walls.sluice(rows)
        click.echo(
            f"sluice, {rows} rows over the opening: discharge over that of the orifice "
            f"{found.drawn:.3f} while it is drawn, {found.open:.3f} open"
        )
    for rows in (10, 20):
        wave = moving_walls.bore(rows)
        click.echo(f"bore, {rows} rows: depth behind it {wave.depth:.4f}, path {wave.path:.3f}")
    for rows in (15, 30):
        swings = moving_walls.swing(rows).round(2).tolist()
        click.echo(f"standing wave, {rows} rows: amplitude by half periods {swings}")


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
            f"settling, C0 = {c}, seed {seed}, {law}, d0 = {spacing} m: {found.speed:.4f} m/s, "
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
                f"A2, drag {law}, d0 = {spacing} m, seed {seed}: shift at 0.75 s "
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


def print_bed() -> None:
    """Print the slope at which an endless bed slides, and how deep it yields under a flow."""
    for angle in (30.0, 35.0):
        for spacing in (0.02, 0.01):
            limit = endless_bed.limit_slope(angle)
            moved = [
                f"{off:+.1f}: {endless_bed.rest(limit + off, angle, spacing).mean:.3g}"
                for off in (-1.0, -0.5, 0.5, 1.0)
            ]
            click.echo(
                f"endless bed, {angle:.0f} degrees, d0 = {spacing} m, limit slope {limit:.2f}; "
                f"mean displacement in 2 s, d0, by degrees from it: {', '.join(moved)}"
            )
    for angle in (35.0, 40.0):
        for depth, water_rows in ((0.02, 4), (0.02, 6), (0.02, 8), (0.04, 8)):
            spacing = depth / water_rows
            expected = endless_bed.yield_depth(15.0, angle, depth)
            bed_rows = int(1.5 * expected / spacing) + 3
            found = endless_bed.moving_depth(15.0, angle, spacing, bed_rows, water_rows, 2.0)
            click.echo(
                f"yield under {depth} m of water in {water_rows} rows, {angle:.0f} degrees: "
                f"{found:.4f} m, Takahashi {expected:.4f} m ({found / expected - 1:+.0%})"
            )
    moved = endless_bed.rest(15.0, 35.0, 0.02, scheme=controls.FrictionBeforeProjection).mean
    click.echo(f"friction before the projection, 15 degrees: {moved:.2f} d0 in 2 s")


def describe(title: str, found: flume.Flume, times: tuple[float, ...] = (6.0, 7.0, 8.0)) -> None:
    """Print what a run of flume2d did."""
    first, last = found.arrival(2.0), found.arrival(6.9)
    lines = [
        f"{title}: front at 2 m {first:.2f} s, 2 to 6.9 m {last - first:.2f} s; bed moved in 2 s "
        f"{found.moved(0.0, 2.0).mean():.3f} d0, at most {found.moved(0.0, 2.0).max():.2f}; supply "
        f"{found.supplied:.4f} m2; upstream half lost {found.eroded():.0%}; "
        f"{found.through_wall} through walls"
    ]
    for time in times:
        if time in found.frames:
            shares = found.concentrations(time)
            text = ", ".join(f"{name} {share:.2f}" for name, share in shares.items())
            lines.append(f"  C at {time:g} s: {text}")
    if last + 0.5 <= found.time[-1]:
        error, depth, speed = found.profile_error(last, last + 0.5)
        lines.append(
            f"  profile at 6.86 to 6.94 m: rms {error:.3f} to the dilatant, depth {depth:.3f} m, "
            f"u_s {speed:.2f} m/s"
        )
    click.echo("\n".join(lines))


def print_flume() -> None:
    """Print the figures of A1 at its spacing, and the controls."""
    for seed in (1, 2, 3, 4):
        describe(f"A1, seed {seed}", flume.run("flume2d", (f"particles.seed={seed}",)))
    for seed in (1, 2):
        changes = (f"particles.seed={seed}", "time.largest_step=0.001")
        describe(f"A1, seed {seed}, half the step", flume.run("flume2d", changes))
    dry = flume.run("flume2d", supply_until=0.0)
    click.echo(f"A1 without supply: upstream half lost {dry.eroded():.1%} in 10 s")
    describe("A1, drag none", flume.run("flume2d", ("drag.law=none",)))
    describe(
        "A1, load of the grains as a share of the pressure",
        flume.run("flume2d", scheme=controls.ShareOfPressure),
    )
    off = flume.run("flume2d", end=16.5, supply_until=5.5)
    depths = flume.still_depths(off, 16.5, np.arange(2.0, 7.1, 0.5))
    click.echo(
        f"A1, supply off at 5.5 s: the deposit moved {off.rested(10.5, 12.5).mean():.3f} d0 from "
        f"10.5 to 12.5 s, {off.rested(12.5, 14.5).mean():.3f} d0 from 12.5 to 14.5 s and "
        f"{off.rested(14.5, 16.5).mean():.3f} d0 from 14.5 to 16.5 s; its depth "
        f"by half meters from 2 m: {depths.round(3).tolist()} m"
    )
    found = flume.deposit("flume_deposit2d")
    click.echo(
        f"flume_deposit2d: sediment moved in the last 2 s {found.moved.mean():.3f} d0, at most "
        f"{found.moved.max():.2f}; {found.on_runout:.0%} of it on the run-out, "
        f"{found.depth:.3f} m deep, surface at {found.slope:.1f} degrees"
    )


def print_fine_flume() -> None:
    """Print the figures of A1 at half and a quarter of its spacing."""
    for seed in (1, 2, 3, 4):
        changes = ("particles.spacing=0.01", f"particles.seed={seed}")
        describe(f"A1, d0 = 0.01 m, seed {seed}", flume.run("flume2d", changes))
    describe("A1, d0 = 0.005 m", flume.run("flume2d", ("particles.spacing=0.005",), end=8.5))


def print_short_flume() -> None:
    """Print the figures of A3 at two spacings."""
    for spacing in (0.005, 0.0025):
        found = flume.run(
            "bed_erosion2d",
            (f"particles.spacing={spacing}",),
            frames=(1.03, 2.03),
            width=0.05,
            depth=0.002,
        )
        front = np.interp([1.03, 2.03, 3.5], found.time, found.front).round(2)
        arrivals = [round(found.arrival(x), 2) for x in (0.3, 0.5, 0.7, 0.9)]
        left = found.left[-1]
        click.echo(
            f"A3, d0 = {spacing} m: front at 1.03, 2.03, 3.5 s {front.tolist()} m; 0.3, 0.5, 0.7 "
            f"and 0.9 m at {arrivals} s; bed moved {found.moved(0.0, 0.2).max():.2f} d0 in 0.2 s; "
            f"sediment of what left by 3.5 s {left[1] / max(left.sum(), 1):.2f} "
            f"(Takahashi 0.376); {found.through_wall} through walls"
        )
    off = flume.run("bed_erosion2d", end=9.0, width=0.05, depth=0.002, supply_until=2.0)
    depths = flume.still_depths(off, 9.0, np.arange(0.1, 1.0, 0.2))
    click.echo(
        f"A3, supply off at 2 s: moved at 7 to 9 s {off.rested(7.0, 9.0).mean():.3f} d0, depth of "
        f"sediment by 0.2 m from 0.1 m: {depths.round(3).tolist()} m"
    )


PARTS: dict[str, Callable[[], None]] = {
    "still": print_still,
    "viscous": print_viscous,
    "dam_break": print_dam_break,
    "impact": print_impact,
    "jet": print_jet,
    "moving": print_moving,
    "shear": print_shear,
    "settling": print_settling,
    "collapse": print_collapse,
    "bed": print_bed,
    "flume": print_flume,
    "fine_flume": print_fine_flume,
    "short_flume": print_short_flume,
    **IN_THREE,
}


@click.command()
@click.argument("parts", nargs=-1, type=click.Choice(list(PARTS)))
def main(parts: tuple[str, ...]) -> None:
    """Print the figures of PARTS, or all."""
    for part in parts or PARTS:
        PARTS[part]()


if __name__ == "__main__":
    main()
