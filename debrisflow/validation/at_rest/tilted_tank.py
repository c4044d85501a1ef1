"""Still water in a tank that stands askew: its surface is level, its walls are not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.choice import scheme_of
from debrisflow.space.domain import wall_names
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, exact, points
from debrisflow.validation.marching import advance
from debrisflow.validation.row import at_most, near, none_of

Floats = NDArray[np.float64]
TILT = 15.0  # degrees, by which the floor falls along x
LENGTH, DEPTH = 0.2, 0.1  # m, of the tank along its floor and of the water in its middle
GRAVITY, DENSITY = 9.81, 1000.0
ALONG, ACROSS = GRAVITY * np.sin(np.radians(TILT)), GRAVITY * np.cos(np.radians(TILT))
RISE = float(np.tan(np.radians(TILT)))  # of the surface over the floor
END = 2.0  # s
WALLS = "left", "right", "floor"


@dataclass
class Tilted:
    """What the water did in the second half of the time.

    Attributes
    ----------
    depth : float, m
        In the middle of the tank, by the number of particles.
    pressure_error : float
        Rms over particles and time, over the pressure in the deepest corner.
    surface : float, degrees
        Angle between the surface and the floor.
    force : dict of float, N/m
        Mean on each wall, along its normal.
    speed : float, m/s
        Rms.
    through_wall : int
        Particles.
    position, pressure : arrays, m, Pa
        Of the particles at the end.
    """

    depth: float
    pressure_error: float
    surface: float
    force: dict[str, float]
    speed: float
    through_wall: int
    position: Floats
    pressure: Floats


def tilted_case(rows: int) -> ResolvedCase:
    """Return the case, with water up to the highest place that its surface reaches."""
    spacing = DEPTH / rows
    height = 2.0 * DEPTH
    return case_of(
        title="still water in a tilted tank",
        particles={"spacing": spacing},
        gravity={"slope": TILT},
        geometry={"type": "tank", "length": LENGTH, "height": height, "ceiling": True},
        fill=[{"type": "block", "x": (0.0, LENGTH), "y": (0.0, 1.5 * DEPTH), "material": "water"}],
        # so that the forces on the walls are kept
        probe=[{"type": "force", "name": "push", "wall": "floor", "interval": END}],
        time={"end": END},
        output={"interval": END},
    )


def surface(x: Floats, depth: float) -> Floats:
    """Return the height of the level surface over the floor, m, for a depth in the middle."""
    level: Floats = depth + RISE * (x - 0.5 * LENGTH)
    return level


def hydrostatic(position: Floats, depth: float) -> Floats:
    """Return ``rho g`` times the vertical depth at places, (n, 2 or 3) array, Pa."""
    pressure: Floats = DENSITY * ACROSS * (surface(position[:, 0], depth) - position[:, 1])
    return pressure


def forces(depth: float) -> dict[str, float]:
    """Return the force of still water on each wall, N/m."""
    left, right = surface(np.array([0.0, LENGTH]), depth)
    weight = DENSITY * ACROSS
    return {
        "left": 0.5 * weight * left**2,
        "right": 0.5 * weight * right**2,
        "floor": weight * depth * LENGTH,
    }


def start(case: ResolvedCase) -> State:
    """Return the state at the start, without what lies above the surface."""
    state = initial_state(case)
    p = state.particles
    place = p.position[p.fluid]
    kept = np.flatnonzero(place[:, 1] < surface(place[:, 0], DEPTH))
    p.fluid_count = kept.size
    p.keep(kept, kept.size)
    return state


def surface_angle(position: Floats, spacing: float) -> float:
    """Return the angle of the surface with the floor, degrees, by the highest of each column."""
    count = round(LENGTH / (2.0 * spacing))
    column = np.clip((position[:, 0] / LENGTH * count).astype(int), 0, count - 1)
    highest = np.array([position[column == k, 1].max() for k in range(count)])
    rise = np.polyfit((np.arange(count) + 0.5) * LENGTH / count, highest, 1)[0]
    return float(np.degrees(np.arctan(rise)))


def run(rows: int) -> Tilted:
    """Let the water lie, and measure it."""
    case = tilted_case(rows)
    scheme, state = scheme_of(case), start(case)
    scheme.fill_number_density(state)
    p, spacing, names = state.particles, case.particles.spacing, wall_names(case)
    depth = p.fluid_count * spacing**2 / LENGTH
    deepest = float(DENSITY * ACROSS * surface(np.array([LENGTH]), depth)[0])
    errors, pushes, speeds, angles = [], [], [], []
    while state.time < END:
        advance(scheme, state, steps=1)
        if state.time > 0.5 * END:
            place, pressure = p.position[p.fluid], p.pressure[p.fluid]
            errors.append(np.mean((pressure - hydrostatic(place, depth)) ** 2))
            speeds.append(np.mean(np.sum(p.velocity[p.fluid] ** 2, axis=1)))
            angles.append(surface_angle(place, spacing))
            pushes.append(state.wall_force[:, :3].copy())
    push = np.mean(pushes, axis=0)
    left, right, floor = (push[names.index(name)] for name in WALLS)
    return Tilted(
        depth,
        float(np.sqrt(np.mean(errors)) / deepest),
        float(np.mean(angles)),
        {"left": -float(left[0]), "right": float(right[0]), "floor": -float(floor[1])},
        float(np.sqrt(np.mean(speeds))),
        int(state.through_wall.sum() + state.left.sum()),
        place.copy(),
        pressure.copy(),
    )


def measure(level: Level) -> Measured:
    """Return what the water did at a level."""
    rows = round(level.across)
    found = run(rows)
    row = float(np.degrees(np.arctan(DEPTH / rows / LENGTH)))
    known = forces(found.depth)
    sides = [
        near(
            f"force on the {name} wall" if name != "floor" else "force on the floor",
            found.force[name],
            known[name],
            "chosen: half a row of 10 makes 5 % of the force on the floor, 10 % on a side",
            share=0.03,
            unit="N/m",
        )
        for name in WALLS
    ]
    return Measured(
        (
            at_most(
                "rms error of the pressure / pressure in the deepest corner",
                found.pressure_error,
                {10: 0.04, 20: 0.02, 40: 0.012}[rows],
                f"resolution: half a row is {50.0 / rows:g} % of the depth in the middle",
                "%",
            ),
            near(
                "angle between surface and floor",
                found.surface,
                TILT,
                f"resolution: one row over the length of the tank is {row:.1f}°",
                margin=row,
                unit="°",
            ),
            *sides,
            at_most(
                "rms speed / √(g h)",
                found.speed / np.sqrt(GRAVITY * DEPTH),
                0.01,
                "chosen: a hundredth of the speed of a long wave",
                "%",
            ),
            none_of("particles through a wall or out of the tank", found.through_wall),
        ),
        found.pressure_error,
        _panels(found),
    )


def _panels(found: Tilted) -> tuple[Panel, ...]:
    depth = (surface(found.position[:, 0], found.depth) - found.position[:, 1]) * np.cos(
        np.radians(TILT)
    )
    seen = np.argsort(depth, kind="stable")
    line = np.array([0.0, 0.13])
    top = np.array([0.0, LENGTH])
    high = found.position[:, 1] > surface(found.position[:, 0], found.depth) - 0.012
    return (
        Panel(
            "pressure over depth",
            "vertical depth below the surface, m",
            "pressure, kPa",
            (
                exact(line, DENSITY * GRAVITY * line / 1e3),
                points(depth[seen], found.pressure[seen] / 1e3),
            ),
        ),
        Panel(
            "particles within 12 mm of the surface",
            "along the floor, m",
            "over the floor, m",
            (
                exact(top, surface(top, DEPTH), "level"),
                points(found.position[high, 0], found.position[high, 1]),
            ),
        ),
    )


COMPARISONS = (
    Comparison(
        name="tilted_tank",
        title="Still water in a tilted tank",
        group=Group.AT_REST,
        compared=(
            "Pressure of all particles against ρ g times the depth below the surface, the angle of "
            "the surface and the forces on floor and sides, from 1 to 2 s."
        ),
        reference="closed form",
        parameters=(
            "closed tank of 0.2 m by 0.2 m, its floor at 15° to the horizontal, water 0.1 m deep "
            "in the middle, two dimensions"
        ),
        levels=(
            Level(10, "10 rows", 2, is_quick=True),
            Level(20, "20 rows", 5, is_quick=True),
            Level(40, "40 rows", 30),
        ),
        measure=measure,
        error="rms error of the pressure / pressure in the deepest corner",
        discussion=(
            "The lattice of the start stands askew too, so that the surface begins as a staircase "
            "of particles; a scheme that took the pressure from heights over the floor would fail."
        ),
    ),
)
