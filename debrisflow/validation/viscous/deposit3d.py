"""A block of Bingham slurry that collapses on a flat floor: the shape in which it stops.

A slab of three dimensions, the floor no-slip, the walls free-slip.  At rest the floor carries the
yield stress all along, so that

    h^2 = 2 tau0 (x_f - x) / (rho g)                    if it is shallow,
    h^2 - pi tau0 h / (rho g) = 2 tau0 (x_f - x) / (rho g)

to the next order, by the yield stress along the layer, which stretched until it stopped.  The
second ends in a step of ``pi tau0 / (rho g)``.  At x = 0 the first is 8 % lower than the second for
a yield stress of 60 Pa, and 4 % for the 30 Pa here, whose deposit is shallow.

References
----------
Liu & Mei 1989, Slow spreading of a sheet of Bingham fluid on an inclined plane, Journal of Fluid
Mechanics 207: 505-529, doi:10.1017/S0022112089002685.
Dubash, Balmforth, Slim & Cochard 2009, What is the final shape of a viscoplastic slump?, Journal
of Non-Newtonian Fluid Mechanics 158: 91-100.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.marching import states
from debrisflow.validation.row import Row, at_most
from debrisflow.validation.viscous.film3d import DENSITY

Floats = NDArray[np.float64]
SIDE, LENGTH = 0.1, 0.6  # m, of the block and of the tank
ACROSS = 11  # spacings; there the slab repeats
YIELD, VISCOSITY = 30.0, 2.0  # Pa, Pa s; weak enough for a shallow deposit
LENGTH_SCALE = YIELD / (DENSITY * 9.81)  # m, tau0 / (rho g)
END = 3.0  # s; it comes to rest ever more slowly, and at 2 s still creeps by 1.5 mm
WINDOW = 0.02  # m, over which the depth is taken


@dataclass
class Deposit:
    """A deposit by windows along x, and what it still did.

    Attributes
    ----------
    x, depth : (windows,) float64 array, m
        Middle of a window and volume in it over its base.
    speed : float, m/s
        Greatest of a particle at the end.
    crept : float, m
        How far the front went in the last fifth of the time.
    """

    x: Floats
    depth: Floats
    speed: float
    crept: float

    def error(self, front: float, step: float = 0.0) -> float:
        """Return the rms error of the depth in the closed form at x = 0, for a front at x_f, m.

        Over the windows that the deposit or the closed form covers.
        """
        exact = closed_form(self.x, front, step)
        covered = (exact > 0.0) | (self.depth > 0.0)
        error = (self.depth - exact)[covered] / closed_form(np.zeros(1), front, step)[0]
        return float(np.sqrt(np.mean(error**2)))

    def fitted_front(self, step: float = 0.0) -> float:
        """Return the x_f of least error, m."""
        tried = np.arange(0.5, 1.5, 0.0025) * front_by_volume(step)
        return float(tried[np.argmin([self.error(front, step) for front in tried])])


STEP = np.pi * LENGTH_SCALE  # m, the depth at the front, to second order


def closed_form(x: Floats, front: float, step: float = 0.0) -> Floats:
    """Return the depth at rest, m, that ends at x_f in a step; 0 is the shallow limit."""
    half, distance = 0.5 * step, front - x
    square = half**2 + 2.0 * LENGTH_SCALE * np.maximum(distance, 0.0)
    depth: Floats = np.where(distance > 0.0, half + np.sqrt(square), 0.0)
    return depth


def front_by_volume(step: float = 0.0) -> float:
    """Return the x_f, m, of the volume of the block."""
    fronts = np.linspace(0.5 * LENGTH, LENGTH, 1001)
    x = np.linspace(0.0, LENGTH, 2001)
    volumes = [np.trapezoid(closed_form(x, front, step), x) for front in fronts]
    return float(np.interp(SIDE**2, volumes, fronts))


def build(spacing: float, end: float, viscosity: float = VISCOSITY) -> ResolvedCase:
    """Return the case of the block."""
    width = ACROSS * spacing
    block = {"x": (0.0, SIDE), "y": (0.0, width), "z": (0.0, SIDE)}
    smooth = {"slip": "free-slip"}
    return case_of(
        title="deposit of a Bingham slurry, a slab",
        particles={"spacing": spacing},
        geometry={
            "type": "tank3d",
            "periodic": True,
            "length": LENGTH,
            "width": width,
            "height": 1.5 * SIDE,
        },
        walls={"left": smooth, "right": smooth},
        fill=[{"type": "block", "material": "mixture", **block}],
        mixture={"viscosity": viscosity},
        rheology={"type": "bingham", "yield_stress": YIELD},
        scheme={"type": "explicit", "courant": 1.2},
        time={"end": end},
        output={"interval": end},
    )


def run(spacing: float, end: float = END, viscosity: float = VISCOSITY) -> Deposit:
    """Let the block collapse until it is at rest and return its shape."""
    case = build(spacing, end, viscosity)
    fronts = []
    for state in states(case, end / 50):
        p = state.particles
        x = p.position[p.fluid, 0]
        fronts.append((state.time, float(np.quantile(x, 0.995))))
    time, front = np.array(fronts).T
    crept = front[-1] - np.interp(0.8 * end, time, front)
    speed = float(np.linalg.norm(p.velocity[p.fluid], axis=1).max())
    middle = np.arange(0.5 * WINDOW, LENGTH, WINDOW)
    return Deposit(middle, window_depth(x, spacing), speed, float(crept))


def window_depth(x: Floats, spacing: float) -> Floats:
    """Return the depth in each window, m, of particles that are a spacing long."""
    edges = np.arange(0.0, LENGTH + 0.5 * WINDOW, WINDOW)
    behind = np.clip((edges[:, None] - x) / spacing + 0.5, 0.0, 1.0).sum(axis=1)
    depth: Floats = np.diff(behind) * spacing**2 / (ACROSS * WINDOW)
    return depth


def measure(level: Level) -> Measured:
    """Return how far the deposit is from both closed forms at a level."""
    found = run(SIDE / level.across)
    figures = [row for name, step in FORMS.items() for row in _rows(name, step, found)]
    figures.append(
        at_most(
            "way of the front in the last 0.6 s",
            1e3 * found.crept,
            1.0,
            "chosen: a hundredth of the side of the block",
            "mm",
            miss=CREEPS if level.across == 20 else "",
            worst=1.25,
        )
    )
    error = found.error(front_by_volume(STEP), STEP)
    return Measured(tuple(figures), error, (_panel(found),))


def _rows(name: str, step: float, found: Deposit) -> list[Row]:
    reason = "chosen: a third of a row of the deposit; the closed forms differ by 4 % at the wall"
    errors = {
        "front by volume": found.error(front_by_volume(step), step),
        "front fitted": found.error(found.fitted_front(step), step),
    }
    return [
        at_most(f"{name}: rms error of the depth / that at the wall, {of}", error, 0.1, reason, "%")
        for of, error in errors.items()
    ]


def _panel(found: Deposit) -> Panel:
    x = np.linspace(0.0, LENGTH, 121)
    lines = [
        exact(x, 1e3 * closed_form(x, front_by_volume(step), step), name)
        for name, step in FORMS.items()
    ]
    return Panel(
        f"depth at rest, after {END:g} s",
        "x, m",
        "depth, mm",
        (*lines, computed(found.x, 1e3 * found.depth)),
    )


CREEPS = (
    "A Bingham slurry comes to rest as 1 / t, Matson & Hogg 2007, J. Non-Newtonian Fluid Mech. "
    "142: 79-94; the finer, the longer its front creeps."
)
FORMS = {"shallow limit": 0.0, "next order": STEP}
COMPARISONS = (
    Comparison(
        name="bingham_deposit3d",
        title="A block of Bingham slurry that collapses and comes to rest",
        group=Group.VISCOUS,
        compared=(
            "Depth along the deposit against both closed forms, with the front where the volume "
            "puts it and where it fits best."
        ),
        reference=(
            "h² = 2 τ0 (x_f - x) / (ρ g), Liu & Mei 1989, doi:10.1017/S0022112089002685; next "
            "order: Dubash, Balmforth, Slim & Cochard 2009, J. Non-Newtonian Fluid Mech. 158: "
            "91-100"
        ),
        parameters=(
            "block of 0.1 m by 0.1 m, a slab 11 spacings wide that repeats; yield stress 30 Pa, "
            "viscosity 2 Pa s; floor no-slip, weakly compressible"
        ),
        levels=(
            Level(10, "10 rows", 10, is_quick=True),
            Level(14, "14 rows", 20),
            Level(20, "20 rows", 60),
        ),
        measure=measure,
        error="next order: rms error of the depth / that at the wall, front by volume",
        discussion=(
            "Dubash et al. find their own experiments not in particularly good agreement with the "
            "theory. The closed forms hold for slow spreading over a long slope of the surface; "
            "the block starts as high as it is long and its inertia is not small. The deposit is "
            "three rows deep at the wall with the coarsest spacing, and its front one row."
        ),
    ),
)
