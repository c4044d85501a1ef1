"""Force of still water on a dam with a dry side, and on a plate that is wet on both."""

from __future__ import annotations

from math import ceil
from typing import Any

from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.probed import Table, probed
from debrisflow.validation.row import near

GRAVITY, DENSITY = 9.81, 1000.0
DEPTH, END = 0.1, 2.0
PLATE_DEPTHS = 0.5, 0.25
"""m, on the two sides of the plate at the start."""
THIN = 0.5
"""Thickness of the second plate, spacings."""
FORCE = "force_on_dam"


def force_probe(interval: float) -> dict[str, Any]:
    """Return the probe of the force on a body named ``dam``."""
    return {
        "type": "force",
        "name": FORCE,
        "wall": "dam",
        "about": (0.0, 0.0, 0.0),
        "interval": interval,
    }


def late_force(rows: Table) -> float:
    """Return the mean force along x in the second half, N."""
    late = rows["time"] >= 0.5 * rows["time"][-1]
    return float(rows["force_x"][late].mean())


def backwater(rows: int) -> Table:
    """Return the force of still water on a dam.

    Water 0.1 m deep against a box across a tank of the same width, dry behind it.
    """
    spacing, width, dam = DEPTH / rows, DEPTH, 2.0 * DEPTH
    box = {"x": (dam, dam + 2.0 * spacing), "y": (0.0, width), "z": (0.0, 1.5 * DEPTH)}
    block = {"x": (0.0, dam), "y": (0.0, width), "z": (0.0, DEPTH)}
    high = 1.5 * DEPTH + 2.0 * spacing
    case = case_of(
        title="backwater of a dam",
        particles={"spacing": spacing},
        geometry={"type": "tank3d", "length": 3.0 * DEPTH, "width": width, "height": high},
        obstacle=[{"type": "box", "name": "dam", **box}],
        fill=[{"type": "block", "material": "water", **block}],
        scheme={"type": "explicit", "courant": 1.2},
        time={"end": END},
        output={"interval": END},
        probe=[force_probe(END / 1000)],
    )
    _, probes = probed(case)
    return probes[FORCE]


def plate(rows: int, thickness: float) -> float:
    """Return the mean force on a plate over that of the depths on its two sides.

    Water a number of rows deep on one side and half as deep on the other, at the start, of a plate
    that is ``thickness`` spacings thick, in a tank with smooth walls.
    """
    spacing = PLATE_DEPTHS[0] / rows
    width = edge = spacing * round(0.6 / spacing)  # else gaps beside the water would lower it
    end_of_tank = 2.0 * edge
    far = edge + thickness * spacing
    body = {"x": (edge, far), "y": (0.0, width), "z": (0.0, 0.8)}
    behind = edge + ceil(thickness) * spacing
    block = {"type": "block", "material": "water", "y": (0.0, width)}
    smooth = {"slip": "free-slip"}
    places = ((0.0, edge), (behind, end_of_tank))
    waters = zip(places, PLATE_DEPTHS, strict=True)
    case = case_of(
        title="plate in water",
        particles={"spacing": spacing},
        geometry={"type": "tank3d", "length": end_of_tank, "width": width, "height": 1.0},
        walls=dict.fromkeys(("floor", "left", "right", "front", "back"), smooth),
        obstacle=[{"type": "box", "name": "dam", **body, **smooth}],
        fill=[block | {"x": x, "z": (0.0, depth)} for x, depth in waters],
        scheme={"type": "explicit"},
        time={"end": END},
        output={"interval": END},
        probe=[force_probe(END / 100)],
    )
    _, probes = probed(case)
    spread = (end_of_tank - behind) / (end_of_tank - far)
    squares = PLATE_DEPTHS[0] ** 2 - (spread * PLATE_DEPTHS[1]) ** 2
    return late_force(probes[FORCE]) / (0.5 * DENSITY * GRAVITY * width * squares)


def measure(level: Level) -> Measured:
    """Return the forces at a number of rows."""
    rows = round(level.across)
    dry = backwater(rows)
    whole = 0.5 * DENSITY * GRAVITY * DEPTH**3
    force = late_force(dry) / whole
    thick, thin = plate(rows, 1.0), plate(rows, THIN)
    reason = "chosen: 3 %, which 1.5 % of the depth make: a sixth of a spacing at ten rows"
    found = (
        near("force on a dam, dry behind it / ½ ρ g h² b", force, 1.0, reason, share=0.03),
        near(
            "force on a plate wet on both sides, one spacing thick", thick, 1.0, reason, share=0.03
        ),
        near("the same, half a spacing thick", thin, 1.0, reason, share=0.03),
    )
    curves = exact([0.0, END], [1.0, 1.0]), computed(dry["time"], dry["force_x"] / whole)
    panel = Panel("force on the dam", "t (s)", "force / ½ ρ g h² b", curves)
    return Measured(found, max(abs(value - 1.0) for value in (force, thick, thin)), (panel,))


COMPARISONS = (
    Comparison(
        name="still_dam",
        title="Still water on a dam, and on a plate wet on both sides",
        group=Group.AT_REST,
        compared="Mean force along the flow from 1 to 2 s against that of the depths.",
        reference="closed form: hydrostatics",
        parameters=(
            "explicit scheme; dam across a tank, 0.1 m of water; plate across a tank with smooth "
            "walls, 0.5 and 0.25 m of water; the levels are rows over the greater depth"
        ),
        levels=(
            Level(10, "10 rows", 10, is_quick=True),
            Level(14, "14 rows", 40),
            Level(20, "20 rows", 130),
        ),
        measure=measure,
        error="greatest of the three errors of the force",
        discussion=(
            "The force is the sum of the reactions of the wall, not a pressure read from the fluid."
        ),
    ),
)
