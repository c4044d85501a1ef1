"""What a dam in a flume holds back, closed and with a slit: a ledger to the last particle."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np

from debrisflow.case import Case, ResolvedCase
from debrisflow.case.defaults import complete
from debrisflow.run.measures import particle_volume
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed
from debrisflow.validation.files import CASES
from debrisflow.validation.probed import Table, probed
from debrisflow.validation.row import none_of, stated

CASE = CASES / "check_dam3d.toml"
WINGS = {"left_wing": (0.0, 0.02), "right_wing": (0.05, 0.07)}  # m, beside a slit
WIDTH = 0.07
"""Of the flume, m."""
DAMS = {"closed": False, "slit": True}


@dataclass
class CheckDam:
    """What a dam in the flume did.

    Attributes
    ----------
    entered, trapped, passed, left, below : int
        Particles that entered, that are upstream of the dam's face at the end, that passed it, and
        of those the ones that left the space and the ones still in it.
    through_wall : int
    held : Table
        Volume upstream over time, m3.
    overtopped : float, s
        Time at which the first particle was 1 cm behind the dam; nan if none was.
    """

    entered: int
    trapped: int
    passed: int
    left: int
    below: int
    through_wall: int
    held: Table
    overtopped: float

    @property
    def unaccounted(self) -> int:
        """Particles by which the ledger fails, and those that went through a wall."""
        entered = abs(self.entered - self.trapped - self.passed)
        return entered + abs(self.passed - self.below - self.left) + self.through_wall


def build(slit: bool, spacing: float) -> ResolvedCase:
    """Return the shipped case at a spacing, with a slit 3 cm wide if asked for."""
    data: dict[str, Any] = tomllib.loads(CASE.read_text()) | {"particles": {"spacing": spacing}}
    if slit:
        (dam,) = data["obstacle"]
        data["obstacle"] = [dam | {"name": name, "y": list(y)} for name, y in WINGS.items()]
        force = next(probe for probe in data["probe"] if probe["type"] == "force")
        others = [probe for probe in data["probe"] if probe is not force]
        data["probe"] = [force | {"name": name, "wall": name} for name in WINGS] + others
    below = {"name": "below", "type": "volume", "interval": 0.01}
    shape, face = data["geometry"], data["obstacle"][0]["x"][0]
    space = {"x": [face, shape["length"]], "y": [0.0, shape["width"]], "z": [0.0, shape["height"]]}
    data["probe"] = [*data["probe"], below | space]
    return complete(Case.model_validate(data))


def run(slit: bool, spacing: float) -> CheckDam:
    """Run the shipped flume with a closed dam, or with one that has a slit."""
    case = build(slit, spacing)
    summary, probes = probed(case)
    volume = particle_volume(case)
    behind = probes["behind"]
    wet = behind["time"][behind["volume"] > 0.5 * volume]
    counts = {
        name: round(probes[name]["volume"][-1] / volume) for name in ("trapped", "passed", "below")
    }
    return CheckDam(
        entered=sum(summary["entered"].values()),
        left=sum(summary["left"].values()),
        through_wall=sum(summary["through_wall"].values()),
        held=probes["trapped"],
        overtopped=float(wet[0]) if wet.size else np.nan,
        **counts,
    )


def measure(level: Level) -> Measured:
    """Return the ledgers of both dams at a level."""
    rows, curves = [], []
    for name, slit in DAMS.items():
        found = run(slit, WIDTH / level.across)
        rows += [
            none_of(f"{name} dam: particles unaccounted for", found.unaccounted),
            stated(f"{name} dam: held at the end / entered", found.trapped / found.entered, "%"),
        ]
        curves.append(computed(found.held["time"], 1e6 * found.held["volume"], name))
    panel = Panel("volume upstream of the dam", "t (s)", "volume (cm³)", tuple(curves))
    return Measured(tuple(rows), panels=(panel,))


COMPARISONS = (
    Comparison(
        name="check_dam",
        title="Check dam in a flume, closed and with a slit: ledger",
        group=Group.DAM_BREAKS,
        compared="Particles that entered, are held, have passed, are below and have left.",
        reference="closed form: conservation of volume",
        parameters="check_dam3d.toml; the slit is 3 of 7 cm wide",
        levels=(Level(7, "d0 = 10 mm", 9, is_quick=True), Level(14, "d0 = 5 mm", 120)),
        measure=measure,
        discussion=(
            "A ledger is exact at any spacing, so that there is no order and two spacings do. How "
            "much a dam holds is stated: nobody has measured it in this flume."
        ),
    ),
)
