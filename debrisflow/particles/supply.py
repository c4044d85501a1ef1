"""The supply: its velocity and concentration, and the columns that wait behind x = 0."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.resolved import UnsteadyInflow
from debrisflow.particles.matter import reference_density, set_fraction, set_material
from debrisflow.particles.record import Kind, Particles, blank
from debrisflow.space.domain import wall_layers
from debrisflow.space.fills import inflow_section


def supply(case: ResolvedCase, time: float) -> tuple[float, float]:
    """Return velocity, m/s, and sediment concentration of the supply at a time.

    The velocity gives the discharge through the section of whole particles that stands for the
    supply.  Nothing is supplied before t = 0.
    """
    inflow = case.inflow
    if inflow is None or time < 0.0:
        return 0.0, 0.0
    if isinstance(inflow, UnsteadyInflow):
        h = inflow.hydrograph
        discharge = float(np.interp(time, h.time, h.discharge))
        concentration = float(np.interp(time, h.time, h.concentration))
    else:
        discharge, concentration = inflow.discharge, inflow.concentration
    section = inflow_section(case)
    cells = section.wide * section.high
    return discharge / (cells * case.particles.spacing ** (case.dimension - 1)), concentration


def supply_column(case: ResolvedCase, number: int, x: float, sediment: float) -> Particles:
    """Return a column of waiting supply at x that fills the section, and its sediment.

    In two dimensions whole particles are rock.  Their rows are drawn with the column's number as
    seed, so that a resumed run draws the same.  In three dimensions, where it is a slab, every
    particle carries the same part of the sediment and is compressed by those above it,

        s = (rho / rho0) g_n (h - z) / c^2

    with the component of gravity g_n normal to the floor and the depth h of the supply.

    Parameters
    ----------
    case : ResolvedCase
    number : int
        Columns before this one since the start.
    x : float, m
    sediment : float
        Volume of sediment in the column, in particles; a whole number in two dimensions.
    """
    d0, section = case.particles.spacing, inflow_section(case)
    column = blank(section.wide * section.high)
    column.position[:, 0] = x
    column.position[:, case.dimension - 1] = np.tile(
        (np.arange(section.high) + 0.5) * d0, section.wide
    )
    if case.dimension == 3:
        y = (section.first + np.arange(section.wide) + 0.5) * d0
        column.position[:, 1] = np.repeat(y, section.high)
        set_fraction(column, slice(None), sediment / column.count, case)
        _compress_supply(column, case, section.high * d0)
    else:
        set_material(column, slice(None), Kind.LIQUID, case)
        rng = np.random.default_rng([case.particles.seed, number])
        drawn = rng.permutation(column.count)[: int(sediment)]
        set_material(column, drawn, Kind.SEDIMENT, case)
    column.kind[:] = Kind.INFLOW
    return column


def _compress_supply(column: Particles, case: ResolvedCase, depth: float) -> None:
    gradient = max(-case.gravity.components[1], 0.0) / case.explicit_scheme.sound_speed**2
    heavy = column.density / reference_density(case)
    column.compression[:] = gradient * heavy * (depth - column.position[:, 2])


def supplied_sediment(case: ResolvedCase, columns: int) -> float:
    """Return the volume of sediment that the first columns owe at t = 0, in particles."""
    section = inflow_section(case)
    return supply(case, 0.0)[1] * section.wide * section.high * columns


def whole_sediment(case: ResolvedCase, owed: float) -> float:
    """Return how much of the sediment owed a column can hold: in two dimensions whole particles."""
    return owed if case.dimension == 3 else float(int(owed))


def first_columns(case: ResolvedCase) -> list[Particles]:
    """Return the columns that wait behind x = 0 at the start, the foremost first."""
    d0, layers = case.particles.spacing, wall_layers(case)
    due = [whole_sediment(case, supplied_sediment(case, n)) for n in range(layers + 1)]
    return [supply_column(case, n, -(n + 0.5) * d0, due[n + 1] - due[n]) for n in range(layers)]
