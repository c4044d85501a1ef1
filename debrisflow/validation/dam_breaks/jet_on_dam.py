"""A jet along a floor that a dam turns upwards: its thrust."""

from __future__ import annotations

from debrisflow.validation.at_rest.still_dam import DENSITY, FORCE, force_probe, late_force
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.probed import Table, probed
from debrisflow.validation.row import near

THICKNESS, SPEED, END = 0.05, 1.0, 1.2
REACH = 6.0 * THICKNESS


def run(rows: int) -> Table:
    """Return the force of a jet so many rows thick.

    A jet 4 spacings wide on a smooth floor without gravity; a smooth box 6 thicknesses from its
    mouth and as high closes the channel, so that what leaves has no momentum along the floor.
    """
    spacing = THICKNESS / rows
    width, smooth = 4 * spacing, {"slip": "free-slip"}
    box = {"x": (REACH, REACH + 2.0 * spacing), "y": (0.0, width), "z": (0.0, REACH)}
    length = REACH + 4.0 * spacing
    case = case_of(
        title="jet against a dam",
        particles={"spacing": spacing},
        gravity={"acceleration": 0.0},
        geometry={"type": "channel3d", "length": length, "width": width, "height": REACH},
        obstacle=[{"type": "box", "name": "dam", **smooth, **box}],
        walls={"floor": smooth, "front": smooth, "back": smooth},
        inflow={"depth": THICKNESS, "velocity": SPEED},
        scheme={"type": "explicit", "courant": 1.2, "sound_speed": 15.0 * SPEED},
        time={"end": END},
        output={"interval": END},
        probe=[force_probe(END / 1000)],
    )
    _, probes = probed(case)
    return probes[FORCE]


def measure(level: Level) -> Measured:
    """Return the thrust at a number of rows."""
    rows = round(level.across)
    found = run(rows)
    whole = DENSITY * THICKNESS * (4 * THICKNESS / rows) * SPEED**2
    thrust = late_force(found) / whole
    reason = "chosen: 5 %, the momentum along the floor of a jet turned by 87 instead of 90 degrees"
    row = near("thrust / ρ Q u", thrust, 1.0, reason, share=0.05)
    curves = exact([0.0, END], [1.0, 1.0]), computed(found["time"], found["force_x"] / whole)
    panel = Panel("thrust on the dam", "t (s)", "force / ρ Q u", curves)
    return Measured((row,), abs(thrust - 1.0), (panel,))


COMPARISONS = (
    Comparison(
        name="jet_on_dam",
        title="Jet on a floor, turned up by a dam",
        group=Group.DAM_BREAKS,
        compared="Mean thrust from 0.6 to 1.2 s against the momentum that the jet brings.",
        reference="closed form: momentum, ρ Q u",
        parameters=(
            "explicit scheme, no gravity, walls that slip freely, inflow 0.05 m thick at 1 m/s, "
            "four spacings wide"
        ),
        levels=(
            Level(5, "5 rows", 3),
            Level(8, "8 rows", 9, is_quick=True),
            Level(12, "12 rows", 30),
        ),
        measure=measure,
        error="error of the thrust",
    ),
)
