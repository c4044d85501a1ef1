"""Print the figures of three dimensions, parts of scripts/validate.py."""

from __future__ import annotations

from collections.abc import Callable

import click
import numpy as np

from debrisflow.validation.at_rest import still_ground as ground3d
from debrisflow.validation.at_rest import still_tank as still3d
from debrisflow.validation.dam_breaks import dam_break3d, dams3d, spheric
from debrisflow.validation.debris_flows import mixture_cube, usgs_flume, voellmy_slab
from debrisflow.validation.field import st_helens
from debrisflow.validation.granular import heap3d
from debrisflow.validation.viscous import deposit3d, film3d

STILL3D = {
    "d0 = 0.1 m, c = 22 m/s": ((), 1.0),
    "d0 = 0.05 m": (("particles.spacing=0.05",), 1.0),
    "c = 44 m/s": (("scheme.sound_speed=44.0",), 1.0),
    "0.2 m deep, d0 = 0.02 m": (still3d.shallow(), 0.2),
}


def print_still3d() -> None:
    """Print height, pressure and speed of water at rest in three dimensions."""
    for title, (changes, depth) in STILL3D.items():
        found = still3d.run(changes, depth)
        click.echo(
            f"still tank, {title}: mean height {found.drift:+.2%}, time-mean pressure, rms "
            f"{found.pressure_error:.3f} ({found.raw_pressure_error:.3f} with the offset), speed "
            f"{found.speed:.3f} m/s, {found.lost} lost"
        )


def print_dam_break3d() -> None:
    """Print front, height and energy of the dam breaks in a slab."""
    for experiment, spacings in dam_break3d.SPACINGS.items():
        for across in spacings:
            run = dam_break3d.run(across, experiment)
            for name, found in (("fixed depth", run), ("last column", run.by_last_column())):
                shift, error = found.best_shift(0.5)
                click.echo(
                    f"slab, n2 = {experiment.ratio}, {across} across, front by {name}: "
                    f"{found.front_error():.1%}, {error:.1%} at a shift of {shift:.2f}, slope "
                    f"{found.slope():.3f} ({found.slope() / experiment.slope - 1:+.1%}), height "
                    f"{found.height_error():.3f} H0, energy {found.energy.max():.4f}, Z at T = 1, "
                    f"2, 3: {found.places().round(3).tolist()}"
                )


def print_marin() -> None:
    """Print levels, arrivals and pressures of the dam break against a box."""
    measured = spheric.experiment()
    for spacing in spheric.SPACINGS:
        found = spheric.run(spacing, 6.0)
        click.echo(
            f"SPHERIC 2, d0 = {spacing:.4f} m, energy {found.energy:.4f}, {found.through_wall} "
            f"through walls, {found.over_rim} over the rim"
        )
        for name in spheric.GAUGES:
            errors = [100.0 * found.level_error(name, end) for end in (2.0, 6.0)]
            click.echo(f"  {name}: rms to 2 and 6 s {errors[0]:.1f} and {errors[1]:.1f} cm")
        for name in ("h3", "h2", "h1", "p1"):
            ours, theirs = found.arrival(name), spheric.arrival(measured, name)
            click.echo(f"  {name}: at {ours:.3f} s, measured {theirs:.3f} s")
        for name in spheric.PRESSURES[:4]:
            both = (name, f"reaction_{name}")
            fluid, wall = (found.impulse(which) / 1e3 for which in both)
            noise, shake = (found.scatter(which) / 1e3 for which in both)
            theirs = spheric.impulse(measured, name) / 1e3
            click.echo(
                f"  {name}: 0.4 to 1.2 s {fluid:.2f} kPa s by the fluid, {wall:.2f} by the "
                f"reaction, measured {theirs:.2f}; scatter {noise:.2f} and {shake:.2f} kPa"
            )


def print_cube() -> None:
    """Print front, spray and energy of the cube of mixture."""
    for concentration in (None, 0.4, 0.5):
        found = mixture_cube.run(concentration)
        click.echo(
            f"B1, C = {concentration or 'none'}: front {found.front:.2f} m, n < 0.8 n0 "
            f"{found.thin:.1%}, spray {found.spray:.2%}, energy {found.energy:.4f}, "
            f"{found.through_wall} through walls"
        )


def print_heap() -> None:
    """Print run-out, rest and shape of heaps of dry grains."""
    runs = [
        (ratio, heap3d.ANGLE + off, across)
        for ratio, across in heap3d.ACROSS.items()
        for off in (-5.0, 0.0, 5.0)
    ]
    for ratio, angle, across in [*runs, *((1.0, heap3d.ANGLE, n) for n in (10, 16, 20))]:
        found = heap3d.run(ratio, angle, across)
        moved, law = found.moved(), heap3d.lube(ratio)
        click.echo(
            f"column, a = {ratio}, {angle:.1f} degrees, d0 = L0/{across}: run-out "
            f"{found.run_out():.2f} L0, {found.run_out() / law - 1.0:+.0%} to {law:.2f} L0, deeper "
            f"than L0 / 10 up to {found.body():.2f} L0; front at rest from {found.stopped():.2f} s "
            f"on; moved in the last 2 s {moved.mean():.3f} d0, at most {moved.max():.2f}; height "
            f"at the wall {found.height():.2f} H, slope "
            f"{found.slope():.1f} degrees, volume {found.volume() - 1.0:+.1%}, inside "
            f"{found.loose():.1%} under 0.93 n0, energy {found.energy.max():.4f}, "
            f"{found.through_wall} through walls"
        )


FILMS = {
    "Bingham, tau0 a quarter of the bed stress": (film3d.bingham(0.25), (10, 20, 30)),
    "Bingham, half": (film3d.bingham(0.5), (10, 20, 30)),
    "Herschel-Bulkley, n = 0.5, a quarter": (film3d.herschel_bulkley(0.25), (10, 20)),
}


def print_film3d() -> None:
    """Print the errors of films of slurry, and how far one below yield moves."""
    for title, (slurry, row_counts) in FILMS.items():
        for rows in row_counts:
            found = film3d.run(slurry, rows)
            click.echo(
                f"film, {title}, {rows} rows: rms {found.rms:.1%}, greatest "
                f"{np.abs(found.error).max():.1%} of the exact speed of the plug, "
                f"{found.surface:.3f} m/s"
            )
    moved = film3d.displacement(1.3)
    click.echo(
        f"film, tau0 1.3 times the bed stress: moved in 2 s {moved.mean():.4f} d0, at most "
        f"{moved.max():.4f}"
    )


def print_deposit3d() -> None:
    """Print how far the deposit of a block of slurry is from the closed forms."""
    for spacing in (0.01, 0.005):
        found = deposit3d.run(spacing)
        for title, step in (("shallow limit", 0.0), ("next order", deposit3d.STEP)):
            fronts = {
                "x_f by volume": deposit3d.front_by_volume(step),
                "x_f fitted": found.fitted_front(step),
            }
            errors = [
                f"{name} {x:.3f} m, rms {found.error(x, step):.1%}" for name, x in fronts.items()
            ]
            click.echo(f"deposit, d0 = {spacing} m, {title}: {'; '.join(errors)}")
        click.echo(
            f"deposit, d0 = {spacing} m: front crept {found.crept / spacing:.2f} d0 in the last "
            f"0.4 s, fastest particle {found.speed:.4f} m/s"
        )


def print_dams() -> None:
    """Print forces on dams, and what closed and slit dams hold back in the flume of B3."""
    for rows in (10, 20):
        click.echo(f"backwater, {rows} rows: force {dams3d.backwater(rows):.3f} of the closed form")
    for thickness in (1.0, 0.5):
        share = dams3d.wet_plate(thickness)
        click.echo(f"plate {thickness} d0 thick in water: force {share:.3f} of the closed form")
    for rows in (5, 8):
        click.echo(f"jet, {rows} rows: force {dams3d.jet(rows):.3f} of rho Q u")
    for spacing in (0.01, 0.005):
        for slit in (False, True):
            found = dams3d.check_dam(slit, {"particles": {"spacing": spacing}})
            click.echo(
                f"{'slit' if slit else 'closed'} dam, d0 = {spacing} m: {found.entered} entered, "
                f"{found.trapped} trapped, {found.passed} passed, of those {found.left} left and "
                f"{found.below} below, {found.through_wall} through walls; most trapped "
                f"{1e6 * found.most_trapped:.0f} cm3, peak force {found.peak_force:.2f} N, moment "
                f"{found.peak_moment:.3f} N m, impulse {found.impulse:.3f} N s, first behind the "
                f"dam at {found.overtopped:.3f} s"
            )


def print_ground3d() -> None:
    """Print how still water lies over grounds that are not level."""
    for name in ground3d.SHAPES:
        found = ground3d.run(name)
        click.echo(
            f"still water over a ground, {name}: speed {1e3 * found.speed:.0f} mm/s, mean current "
            f"{1e3 * found.current:.1f} mm/s, time-mean pressure {found.pressure_error:.1%}, drift "
            f"{found.drift:+.2%}, {found.lost} lost, {found.inside} in the ground"
        )


def print_st_helens() -> None:
    """Print how well the landslide near Mount St. Helens is reproduced: blind, then fitted."""
    runs = {"blind, d0 = 2 m": st_helens.BLIND}
    runs |= {f"d0 = {d0:g} m": st_helens.of_spacing(d0) for d0 in st_helens.SPACINGS}
    for title, changes in runs.items():
        found = st_helens.run(changes)
        score, end = found.score, found.summary
        cells = [int(score[name]) for name in ("hits", "misses", "false_alarms")]
        risen, still = score["deposit_volume_observed"], score["deposit_volume_simulated"]
        click.echo(
            f"St. Helens, {title}: CSI {score['csi']:.3f}; hits, misses, false alarms {cells}; "
            f"run-out {score['runout_error']:+.1f} % along the path, "
            f"{score['reach_simulated']:.0f} m straight ({score['reach_error']:+.1f} %); of "
            f"{risen:.0f} m3 that rose "
            f"{found.thick:.0f} deeper than 0.3 m, {still:.0f} of it at rest"
        )
        click.echo(
            f"  {end['end_reason']} at {end['time']:.0f} s, {end['particles']} particles, "
            f"{end['steps']} steps, {end['wall_seconds']:.0f} s; ledger "
            f"{'kept' if found.is_balanced else 'broken'}, nearest to the ground "
            f"{found.nearest:.2f} d0"
        )


def print_usgs() -> None:
    """Print arrivals and depths in the flume of the USGS, measured and computed."""
    runs = {f"measured, {sand}": usgs_flume.measured(sand) for sand in usgs_flume.TABLES}
    cases = {f"d0 = {d0} m": (f"particles.spacing={d0}",) for d0 in usgs_flume.SPACINGS}
    cases |= {"smooth bed": usgs_flume.SMOOTH, "smooth bed, xi of concrete": usgs_flume.CONCRETE}
    for title, found in (*runs.items(), *((t, usgs_flume.run(c)) for t, c in cases.items())):
        seen = ", ".join(
            f"{probe} {one.mean:.2f} s (1 cm {one.first:.2f} s) {one.peak:.3f} m"
            for probe, one in found.items()
        )
        click.echo(f"flume of the USGS, {title}: {seen}; {usgs_flume.front_speed(found):.1f} m/s")


def print_slab() -> None:
    """Print the run-out of a slab by Voellmy's law over its number of rows."""
    for rows in voellmy_slab.ROWS:
        found = voellmy_slab.run(rows)
        click.echo(
            f"slab, {rows} rows: front {found.front:.1f} m, half {found.middle:.1f} m behind the "
            f"bend, there at {found.arrival:.1f} s, {found.speed:.1f} m/s at most, at rest after "
            f"{found.time:.1f} s, {found.lost} lost"
        )


IN_THREE: dict[str, Callable[[], None]] = {
    "still3d": print_still3d,
    "dam_break3d": print_dam_break3d,
    "marin": print_marin,
    "cube": print_cube,
    "heap": print_heap,
    "film3d": print_film3d,
    "deposit3d": print_deposit3d,
    "dams": print_dams,
    "ground3d": print_ground3d,
    "st_helens": print_st_helens,
    "usgs": print_usgs,
    "slab": print_slab,
}
