"""The table of the greatest depth, speed and momentum flux of a run."""

from __future__ import annotations

from pathlib import Path

from debrisflow.case import ResolvedCase
from debrisflow.particles.maxima import Maxima
from debrisflow.run.tables import write_table
from debrisflow.space.plan_grid import FLOOR_WORDS, PLACE, PLACE_WORDS, cell_level, plan

COLUMNS = ("floor_level", "maximal_depth", "maximal_speed", "maximal_momentum_flux", "arrival_time")
UNITS = {
    "x": "m",
    "y": "m",
    "floor_level": "m",
    "maximal_depth": "m",
    "maximal_speed": "m/s",
    "maximal_momentum_flux": "N/m",
    "arrival_time": "s",
}
HEAD = (
    "greatest values from t = 0 until now, time = {time!r} s, in samples every {interval:g} s",
    "  (output.history_interval)",
    "{place}",
    "floor_level: m, of {floor}",
    "maximal_depth: m, greatest flow_height as deposit.csv defines it",
    "maximal_speed: m/s, greatest mean of the speeds of the particles up to that height",
    "maximal_momentum_flux: N/m, greatest integral of density times speed squared over the depth",
    "arrival_time: s, first sample at which the depth is more than half a spacing greater than at",
    "  t = 0; nan where it never is",
)


def write_maxima(path: Path, case: ResolvedCase, time: float, maxima: Maxima) -> None:
    """Write ``maxima.csv`` at a time, s; what was there is replaced."""
    grid, dimension = plan(case), case.dimension
    words = {"place": PLACE_WORDS[dimension], "floor": FLOOR_WORDS[dimension]}
    head = [line.format(time=time, interval=case.output.history_interval, **words) for line in HEAD]
    place = PLACE[dimension]
    values = (maxima.depth, maxima.speed, maxima.momentum_flux, maxima.arrival_time)
    columns = [getattr(grid, axis) for axis in place] + [cell_level(case, grid), *values]
    rows = ([float(v) for v in row] for row in zip(*columns, strict=True))
    write_table(path, (*place, *COLUMNS), head, rows)
