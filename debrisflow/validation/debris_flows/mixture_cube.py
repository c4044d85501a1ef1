"""Collapse of a cube of debris mixture in a tank (B1): leaks, energy, front, spray."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import load_case
from debrisflow.neighbors.lattice import reference
from debrisflow.run.measures import FRONT_SHARE
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, points
from debrisflow.validation.debris_flows.sources import STUDY
from debrisflow.validation.files import CASES
from debrisflow.validation.marching import energy, states
from debrisflow.validation.row import Row, at_most, energy_gained, none_of, stated

Floats = NDArray[np.float64]
CASE = CASES / "dam_break3d.toml"
SIDE = 2.0
"""Of the cube, m."""
FRONT_TIME = 0.8
"""When the flows are compared, s: before the fronts reach the far walls."""
THIN, SPRAY = 0.8, 0.4
"""Number densities, over that of the lattice, of thin flow and of spray."""
FRONT_HEIGHT = 3.0
"""Of the thin front, spacings; what is higher and alone is in the air."""
ENDS = {None: 0.85, 0.4: 0.85, 0.5: 2.0}
"""When the runs end, s, by concentration."""
SAMPLE = 0.01
"""Time between two rows of the record, s."""
HELD = (
    "what stands of the cube is held back by its grains, at 0.1 m and finer; none of it is in the "
    "air"
)


class Cube(NamedTuple):
    """What a collapse did.

    Attributes
    ----------
    time, fronts : (n,) float64 array, s, m
        x behind which 99.5 % of the particles lie.
    front : float, m
        The same at 0.8 s.
    thin : float
        Share of the particles with n < 0.8 n0 then.
    height : float, m
        Greatest z of a particle then.
    spray : float
        Share of the particles with n < 0.4 n0 higher than the thin front, three rows, then: 0.3 is
        one particle on a surface.
    energy : float
        Greatest kinetic, potential and elastic energy over that at the start.
    through_wall : int
    """

    time: Floats
    fronts: Floats
    front: float
    thin: float
    height: float
    spray: float
    energy: float
    through_wall: int


def run(concentration: float | None, spacing: float = 0.1) -> Cube:
    """Let the cube collapse, with the stress of grains of a concentration or, if None, without.

    Without stress the mixture has the density of a concentration of 0.4.
    """
    changes = [
        f"mixture.concentration={concentration or 0.4!r}",
        f"time.end={ENDS[concentration]!r}",
        f"particles.spacing={spacing!r}",
    ]
    if concentration is None:
        changes.append("collision_stress.enabled=false")
    case = load_case(CASE, changes)
    n0 = reference(3, case.particles.effective_radius, spacing).number_density
    start = greatest = height = spray = front = thin = 0.0
    time, fronts = [], []
    for state in states(case, SAMPLE):
        p = state.particles
        total = energy(case, state)
        start, greatest = start or total, max(greatest, total)
        x, z, n = p.position[p.fluid, 0], p.position[p.fluid, 2], p.number_density[p.fluid]
        time.append(state.time)
        fronts.append(float(np.quantile(x, FRONT_SHARE, method="inverted_cdf")))
        if state.time >= FRONT_TIME and front == 0.0:
            front, height = fronts[-1], float(z.max())
            spray = float(np.mean((z > FRONT_HEIGHT * spacing) & (n < SPRAY * n0)))
            thin = float(np.mean(n < THIN * n0))
    lost = int(state.through_wall.sum())
    return Cube(
        np.array(time), np.array(fronts), front, thin, height, spray, greatest / start, lost
    )


def measure(level: Level) -> Measured:
    """Return the collapses of water, and of two concentrations, at a level."""
    found = {concentration: run(concentration, SIDE / level.across) for concentration in ENDS}
    free, dilute, dense = found[None], found[0.4], found[0.5]
    rows = (
        at_most(
            "front at 0.8 s, C = 0.4 less without stress",
            dilute.front - free.front,
            0.0,
            "grains that collide resist the spreading",
            "m",
        ),
        at_most(
            "front at 0.8 s, C = 0.5 less C = 0.4",
            dense.front - dilute.front,
            -0.2,
            "the more grains the more they resist; chosen: two spacings of 0.1 m",
            "m",
        ),
        *_spray_rows(found, level),
        energy_gained(max(one.energy for one in found.values())),
        none_of("particles through a wall", sum(one.through_wall for one in found.values())),
        *(stated(f"front at 0.8 s, {_named(c)}", one.front, "m") for c, one in found.items()),
    )
    return Measured(rows, panels=_panels(found))


def _named(concentration: float | None) -> str:
    return "without stress" if concentration is None else f"C = {concentration}"


def _spray_rows(found: dict[float | None, Cube], level: Level) -> tuple[Row, ...]:
    free = found[None]
    rows: list[Row] = []
    none = "stress that resists throws nothing out; chosen: what single particles make up"
    for concentration in (0.4, 0.5):
        one, of = found[concentration], _named(concentration)
        miss = HELD if concentration == 0.5 and level.across >= 20 else ""
        rows += [
            at_most(
                f"greatest height at 0.8 s, {of} over without stress",
                one.height / free.height,
                1.05,
                "grains throw nothing up; chosen: half a spacing on the height",
                miss=miss,
                worst=1.07,
                is_certain=not miss,
            ),
            at_most(
                f"particles with n < 0.8 n0, {of} less without stress",
                one.thin - free.thin,
                0.01,
                none,
                "%",
            ),
            at_most(
                f"particles in the air over the front, {of} less without stress",
                one.spray - free.spray,
                0.001,
                none,
                "%",
            ),
        ]
    return tuple(rows)


def _panels(found: dict[float | None, Cube]) -> tuple[Panel, ...]:
    at = [concentration or 0.0 for concentration in found]
    fronts = [one.front for one in found.values()]
    return (
        *(
            Panel(f"front, {_named(c)}", "t (s)", "x (m)", (computed(one.time, one.fronts),))
            for c, one in found.items()
        ),
        Panel("front at 0.8 s", "C (0: without stress)", "x (m)", (points(at, fronts),)),
    )


COMPARISONS = (
    Comparison(
        name="mixture_cube",
        title="Collapse of a cube of debris mixture in a tank (B1)",
        group=Group.DEBRIS_FLOWS,
        compared=(
            "How far the front has come at 0.8 s, and what is in the air, with the stress of "
            "colliding grains at C = 0.4 and 0.5 and without. The study's results of this case are "
            "lost, so that nothing is held to a figure of it; what must hold by theory is that the "
            "denser is the slower, and that grains which resist throw nothing up."
        ),
        reference=(f"{STUDY}, case B1; stress of Ding & Gidaspow 1990, doi:10.1002/aic.690360404"),
        parameters=(
            "`cases/dam_break3d.toml`: cube of 2 m in a tank of 6 m, speed of sound 22 m/s; "
            "grains of 30 mm, which the study does not state: with 3 mm the stress changes nothing"
        ),
        levels=(
            Level(10, "0.2 m", 1),
            Level(20, "0.1 m", 14, is_quick=True),
            Level(30, "0.067 m", 90),
        ),
        measure=measure,
        discussion=(
            "The study's speed of sound is 3.5 times that of a free fall from the top of the cube, "
            "so that the mixture is compressed by 4 % at rest. There is no error to have an order."
        ),
    ),
)
