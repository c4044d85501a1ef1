"""Collapse of a low column of grains, against the outline that contact dynamics gave."""

from __future__ import annotations

from math import atan, degrees

import numpy as np
from numpy.typing import NDArray

from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, measured
from debrisflow.validation.files import REFERENCES
from debrisflow.validation.granular import heap3d
from debrisflow.validation.granular.heap3d import LENGTH, Heap
from debrisflow.validation.row import at_most, near, none_of, stated

Floats = NDArray[np.float64]
RATIO = 0.5  # a = H / L0
HALF_WIDTH = 60.85  # L0, diameters of the discs
STATIC, DYNAMIC, INERTIA = 0.32, 0.60, 0.4
"""Coefficients of friction and I0 of mu(I) by Lagree, Staron & Popinet 2011, who fitted them to
these simulations."""


def outline() -> tuple[Floats, Floats]:
    """Return distance from the middle and height, over L0, both halves in one, by distance."""
    x, height = np.loadtxt(REFERENCES / "staron_hinch_2005.csv", delimiter=",", skiprows=5).T
    order = np.argsort(np.abs(x))
    return np.abs(x)[order] / HALF_WIDTH, height[order] / HALF_WIDTH


def run(across: int) -> Heap:
    """Let a column of grains with the friction of the discs collapse."""
    changes = (
        "rheology.type=mu-i",
        f"rheology.dynamic_friction_angle={degrees(atan(DYNAMIC))}",
        f"rheology.inertia_number={INERTIA!r}",
        f"sediment.grain_diameter={LENGTH / HALF_WIDTH!r}",
    )
    return heap3d.run(RATIO, degrees(atan(STATIC)), across, changes=changes)


def measure(level: Level) -> Measured:
    """Return how far a heap is from the outline."""
    heap, (x, height) = run(round(level.across)), outline()
    place, top = (values / LENGTH for values in heap.outline())
    off = np.interp(x, place, top, right=0.0) - height
    edge = EDGE if level.across < 20 else ""
    error, spread = float(np.sqrt(np.mean(off**2)) / RATIO), float(x.max() - 1.0)
    return Measured(
        (
            near(
                "run-out (L - L0) / L0",
                heap.run_out(),
                spread,
                "chosen: as of the experiments with grains; halves of the outline differ by 2 %",
                share=0.15,
                unit="L0",
                miss=MISS,
                worst=0.58,
            ),
            at_most(
                "outline of the heap: rms / height of the column",
                error,
                0.05,
                "chosen: 0.3 spacings of the coarsest level; halves of the outline differ by 2 %",
                "%",
                miss=edge,
                worst=0.06,
                is_certain=not edge,  # by 1 % of the limit, on the one side or the other
            ),
            stated("end of what is deeper than L0 / 10", heap.body(), "L0", _body(x, height)),
            at_most(
                "mean displacement in the last 2 s",
                float(heap.moved().mean()),
                0.1,
                "at rest: less than a tenth of a spacing",
                "d0",
            ),
            none_of("particles through a wall", heap.through_wall),
        ),
        error,
        (
            Panel(
                "heap at rest",
                "x / L0",
                "z / L0",
                (
                    measured(x, height, "contact dynamics"),
                    computed(place[top > 0.0], top[top > 0.0]),
                ),
            ),
        ),
    )


def _body(x: Floats, height: Floats) -> float:
    """Return the end of what is deeper than L0 / 10, over L0, from the end of the column on."""
    return float(x[height > 0.1].max() - 1.0)


EDGE = "the thin end of the heap is too short, see the run-out; the body is within"
MISS = (
    "the outline ends in a thin layer of single discs, 0.4 L0 long, which particles as large as a "
    "twelfth of L0 do not have; what is deeper than L0 / 10 ends nearer to the outline. With one "
    "angle of friction, 25°, the run-out is 0.55 L0"
)
COMPARISONS = (
    Comparison(
        name="staron_hinch",
        title="Collapse of a low column of discs",
        group=Group.GRANULAR,
        compared="Outline and run-out of the heap at rest, a = 0.5.",
        reference=(
            "contact dynamics, no experiment: Staron & Hinch 2005, doi:10.1017/S0022112005006415"
        ),
        parameters=(
            "three dimensions, slab 11 spacings wide that repeats, μ(I) with μ from 0.32 to 0.60 "
            "and I0 = 0.4, grains of L0/61"
        ),
        calibrated=(
            "nothing here; μ(I) was fitted to these simulations by Lagrée, Staron & Popinet 2011, "
            "doi:10.1017/jfm.2011.335"
        ),
        levels=(
            Level(12, "L0/12", 18, is_quick=True),
            Level(20, "L0/20", 200),
            Level(28, "L0/28", 700),
        ),
        measure=measure,
        error="rms of the outline / height of the column",
        discussion=(
            "This is the lowest of three columns whose outlines are public; those with a = 1.42 "
            "and 6.26 are not computed. The outlines bear no times, so that only the last one, of "
            "the heap, is compared."
        ),
    ),
)
