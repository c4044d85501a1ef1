"""Forces on dams, and what they hold back: still water, a jet, a debris flow in a flume."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np

from debrisflow.case import Case, ResolvedCase
from debrisflow.case.defaults import complete
from debrisflow.run.measures import particle_volume
from debrisflow.validation.cases import case_of
from debrisflow.validation.files import CASES
from debrisflow.validation.probed import Table, probed

CASE = CASES / "check_dam3d.toml"
GRAVITY, DENSITY = 9.81, 1000.0
WINGS = {"left_wing": (0.0, 0.02), "right_wing": (0.05, 0.07)}  # m, beside a slit


def mean_force(rows: Table, start: float) -> float:
    """Return the mean force along x from a time on, N."""
    return float(rows["force_x"][rows["time"] >= start].mean())


def backwater(rows: int = 10, end: float = 2.0) -> float:
    """Return the mean force of still water on a dam over ``rho g h^2 b / 2``, in the second half.

    Water a depth h = 0.1 m against a box across a tank of the same width, dry behind it.
    """
    depth = width = 0.1
    spacing = depth / rows
    dam = 2.0 * depth
    box = {"x": (dam, dam + 2.0 * spacing), "y": (0.0, width), "z": (0.0, 1.5 * depth)}
    block = {"x": (0.0, dam), "y": (0.0, width), "z": (0.0, depth)}
    case = case_of(
        title="backwater of a dam",
        particles={"spacing": spacing},
        geometry={
            "type": "tank3d",
            "length": 3.0 * depth,
            "width": width,
            "height": 1.5 * depth + 2.0 * spacing,
        },
        obstacle=[{"type": "box", "name": "dam", **box}],
        fill=[{"type": "block", "material": "water", **block}],
        scheme={"type": "explicit", "courant": 1.2},
        time={"end": end},
        output={"interval": end},
        probe=[_force("dam", end / 1000)],
    )
    _, probes = probed(case)
    expected = 0.5 * DENSITY * GRAVITY * depth**2 * width
    return mean_force(probes["force_on_dam"], 0.5 * end) / expected


def wet_plate(thickness: float = 1.0, end: float = 2.0) -> float:
    """Return the mean force on a plate wet on both sides over that of the two depths.

    Water 10 and 5 rows deep at the start on both sides of a plate that is ``thickness`` spacings
    thick, in a tank with smooth walls; the force is that of the second half.
    """
    spacing, width, edge, end_of_tank = 0.05, 0.6, 0.6, 1.2
    plate = {"x": (edge, edge + thickness * spacing), "y": (0.0, width), "z": (0.0, 0.8)}
    behind = edge + np.ceil(thickness) * spacing
    waters = [((0.0, edge), 0.5), ((behind, end_of_tank), 0.25)]
    block = {"type": "block", "material": "water", "y": (0.0, width)}
    smooth = {"slip": "free-slip"}
    tank = {"type": "tank3d", "length": end_of_tank, "width": width, "height": 1.0}
    case = case_of(
        title="plate in water",
        particles={"spacing": spacing},
        geometry=tank,
        walls=dict.fromkeys(("floor", "left", "right", "front", "back"), smooth),
        obstacle=[{"type": "box", "name": "dam", **plate, **smooth}],
        fill=[block | {"x": x, "z": (0.0, depth)} for x, depth in waters],
        scheme={"type": "explicit"},
        time={"end": end},
        output={"interval": end},
        probe=[_force("dam", end / 100)],
    )
    _, probes = probed(case)
    spread = (end_of_tank - behind) / (end_of_tank - plate["x"][1])
    squares = waters[0][1] ** 2 - (spread * waters[1][1]) ** 2
    expected = 0.5 * DENSITY * GRAVITY * width * squares
    return mean_force(probes["force_on_dam"], 0.5 * end) / expected


def jet(rows: int = 5, end: float = 1.6, speed: float = 1.0) -> float:
    """Return the mean force of a jet, turned upwards, over ``rho Q u``, in the second half.

    A jet a = 0.05 m thick and 4 spacings wide on a smooth floor without gravity; a smooth box
    6 a from its mouth and 6 a high closes the channel.
    """
    thickness = 0.05
    spacing = thickness / rows
    reach, width = 6.0 * thickness, 4 * spacing
    box = {"x": (reach, reach + 2.0 * spacing), "y": (0.0, width), "z": (0.0, reach)}
    smooth = {"slip": "free-slip"}
    case = case_of(
        title="jet against a dam",
        particles={"spacing": spacing},
        gravity={"acceleration": 0.0},
        geometry={
            "type": "channel3d",
            "length": reach + 4.0 * spacing,
            "width": width,
            "height": reach,
        },
        obstacle=[{"type": "box", "name": "dam", "slip": "free-slip", **box}],
        walls={"floor": smooth, "front": smooth, "back": smooth},
        inflow={"depth": thickness, "velocity": speed},
        scheme={"type": "explicit", "courant": 1.2, "sound_speed": 15.0 * speed},
        time={"end": end},
        output={"interval": end},
        probe=[_force("dam", end / 1000)],
    )
    _, probes = probed(case)
    expected = DENSITY * thickness * width * speed**2
    return mean_force(probes["force_on_dam"], 0.5 * end) / expected


def _force(wall: str, interval: float) -> dict[str, Any]:
    about = (0.0, 0.0, 0.0)
    name = f"force_on_{wall}"
    return {"type": "force", "name": name, "wall": wall, "about": about, "interval": interval}


@dataclass
class CheckDam:
    """What a dam in the flume did.

    Attributes
    ----------
    entered, trapped, passed, left, below : int
        Particles that entered, that are upstream of the dam's face at the end, that passed it, and
        of those the ones that left the space and the ones still in it.
    through_wall : int
    most_trapped : float, m3
        Greatest volume held at a time.
    peak_force, peak_moment : float, N, N m
        Along x, and of that about the foot of the dam.
    impulse : float, N s
        Along x, at the end.
    overtopped : float, s
        Time at which the first particle was 1 cm behind the dam; nan if none was.
    """

    entered: int
    trapped: int
    passed: int
    left: int
    below: int
    through_wall: int
    most_trapped: float
    peak_force: float
    peak_moment: float
    impulse: float
    overtopped: float


def build(slit: bool, overrides: dict[str, Any]) -> ResolvedCase:
    """Return the shipped case, with a slit 3 cm wide if asked for; overrides replace tables."""
    data = tomllib.loads(CASE.read_text()) | overrides
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


def check_dam(slit: bool, overrides: dict[str, Any] | None = None) -> CheckDam:
    """Run the shipped flume with a closed dam, or with one that has a slit."""
    case = build(slit, overrides or {})
    summary, probes = probed(case)
    names = tuple(WINGS) if slit else ("force",)
    force, moment, impulse = (
        np.sum([probes[name][column] for name in names], axis=0)
        for column in ("force_x", "moment_y", "impulse_x")
    )
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
        most_trapped=float(probes["trapped"]["volume"].max()),
        peak_force=float(force.max()),
        peak_moment=float(moment.max()),
        impulse=float(impulse[-1]),
        overtopped=float(wet[0]) if wet.size else np.nan,
        **counts,
    )
