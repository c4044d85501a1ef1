"""A pool of water at rest behind a dam on a terrain: its force, and where all of it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, build_case
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.particles.start import initial_state
from debrisflow.particles.state import State
from debrisflow.schemes.choice import scheme_of
from debrisflow.space.domain import wall_names
from debrisflow.space.ground import Surface, ground_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact
from debrisflow.validation.marching import advance
from debrisflow.validation.row import Row, at_most, between, near, none_of

Floats = NDArray[np.float64]
GRID = MapGrid(5000.0, 7000.0, 1.0, 70, 48)
SLOPE, BENT = 0.12, 0.035  # fall along the valley, curvature across it, 1/m
DAM, LENGTH, THICKNESS = (44.0, 24.0), 44.0, 4.0  # middle, across the valley, along it, m
LEVEL, CREST = 100.0, 103.0  # m, of the pool and of the dam
DEEPEST = 5.0  # m, about, at the dam
DENSITY, GRAVITY = 1000.0, 9.81
TURNED, LOW_CREST = 20.0, 98.5  # degrees of the dam in plan; m, of one that water flows over
FINE = 0.05  # m, of the places at which volume and pressure are summed


@dataclass
class Pool:
    """What a pool behind a dam did.

    Attributes
    ----------
    force, moment : float, N, N m
        Mean of the last third: against the dam across its face, and about the level of the pool
        in its face.
    expected_force, expected_moment : float, N, N m
        Of still water of the same volume over the smooth ground.
    aside : float, N
        Mean force along the face.
    speed : float, m/s
        Mean of the particles at the end.
    released, in_front, passed, left, through : int
        Particles: all, and at the end those upstream of the dam, those below it, those that went
        over an edge of the terrain, and those lost through ground or dam.
    time, push : (n,) float64 array, s, N
        Force across the face, of each step.
    """

    force: float
    moment: float
    expected_force: float
    expected_moment: float
    aside: float
    speed: float
    released: int
    in_front: int
    passed: int
    left: int
    through: int
    time: Floats
    push: Floats

    @property
    def missing(self) -> int:
        """Particles that are neither before the dam, nor below it, nor over an edge."""
        return self.released - self.in_front - self.passed - self.left


def pool_case(
    folder: Path,
    spacing: float,
    turn: float,
    crest: float = CREST,
    end: float = 9.0,
    probes: Sequence[dict[str, Any]] = (),
) -> ResolvedCase:
    """Return the case of a pool; its files are written into a folder."""
    x, y = GRID.cell * (np.arange(GRID.columns) + 0.5), GRID.cell * (np.arange(GRID.rows) + 0.5)
    level = np.add.outer(BENT * (y - DAM[1]) ** 2, LEVEL - DEEPEST - SLOPE * (x - DAM[0]))
    x, y = np.meshgrid(x, y)
    upstream, _ = _from_face(x, y, turn)
    depth = np.where(upstream > 0.0, np.maximum(LEVEL - level, 0.0), 0.0)
    for name, values in (("dem", level), ("pool", depth)):
        write_raster(folder / f"{name}.asc", Raster(GRID, values[::-1].copy()))
    (a, b), half = DAM, (0.5 * THICKNESS, 0.5 * LENGTH)
    return build_case(
        {
            "title": "pool behind a dam",
            "particles": {"spacing": spacing},
            "geometry": {"type": "terrain", "dem": "dem.asc"},
            "release": [{"type": "raster", "file": "pool.asc", "material": "water"}],
            "obstacle": [
                {
                    "type": "box",
                    "name": "dam",
                    "x": [GRID.west + a - half[0], GRID.west + a + half[0]],
                    "y": [GRID.south + b - half[1], GRID.south + b + half[1]],
                    "z": [LEVEL - 2.0 * DEEPEST, crest],
                    "turn": turn,
                }
            ],
            "probe": [{"type": "force", "name": "push", "wall": "dam", "interval": end}, *probes],
            "scheme": {"type": "explicit", "sound_speed": 70.0},
            "time": {"end": end},
            "output": {"interval": end},
        },
        folder=folder,
    )


def _from_face(x: Floats, y: Floats, turn: float) -> tuple[Floats, Floats]:
    """Return distances upstream of the face of the dam, and along it from its middle, m."""
    across, along = normal_of(turn), np.array([-normal_of(turn)[1], normal_of(turn)[0]])
    dx, dy = x - DAM[0], y - DAM[1]
    return dx * across[0] + dy * across[1] - 0.5 * THICKNESS, dx * along[0] + dy * along[1]


def normal_of(turn: float) -> Floats:
    """Return the unit vector in plan out of the upstream face."""
    return -np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])


def still_water(volume: float, turn: float, ground: Surface, base: float) -> tuple[float, ...]:
    """Return the level of a pool of a volume, m, its force, N, and moment about that level, N m."""
    x, y = np.meshgrid(*(np.arange(0.5 * FINE, GRID.cell * n, FINE) for n in GRID.shape[::-1]))
    upstream, along = _from_face(x, y, turn)
    held = (upstream > 0.0) & (np.abs(along) < 0.5 * LENGTH)
    floor = ground.level(x[held], y[held]) + base
    low, high = LEVEL - DEEPEST, LEVEL + DEEPEST
    for _ in range(40):
        middle = 0.5 * (low + high)
        is_less = np.maximum(middle - floor, 0.0).sum() * FINE**2 < volume
        low, high = (middle, high) if is_less else (low, middle)
    s = np.arange(-0.5 * LENGTH, 0.5 * LENGTH, FINE)
    normal = normal_of(turn)
    face = np.array(DAM)[:, None] + 0.5 * THICKNESS * normal[:, None]
    place = face + s * np.array([-normal[1], normal[0]])[:, None]
    depth = np.maximum(low - ground.level(*place) - base, 0.0)
    weight = DENSITY * GRAVITY * FINE
    return low, float(weight * (0.5 * depth**2).sum()), float(weight * (depth**3 / 3.0).sum())


def run_pool(
    folder: Path, spacing: float, turn: float, crest: float = CREST, end: float = 9.0
) -> Pool:
    """Return what a pool did up to an end, s."""
    case = pool_case(folder, spacing, turn, crest, end)
    scheme, state = scheme_of(case), initial_state(case)
    scheme.fill_number_density(state)
    number, time, pushes = wall_names(case).index("dam"), [], []
    while state.time < end:
        advance(scheme, state, steps=1)
        time.append(state.time)
        pushes.append(state.wall_force[number].copy())
    return _found(case, state, np.array(time), np.array(pushes), turn)


def _found(case: ResolvedCase, state: State, time: Floats, pushes: Floats, turn: float) -> Pool:
    push = pushes[time > case.time.end * 2.0 / 3.0].mean(axis=0)
    p, normal, base = state.particles, normal_of(turn), case.terrain.origin[2]
    place = p.position[p.fluid]
    upstream, _ = _from_face(place[:, 0], place[:, 1], turn)
    in_front = int(np.count_nonzero(upstream > 0.0))
    volume = in_front * case.particles.spacing**3
    level, force, moment = still_water(volume, turn, ground_of(case).surface, base)
    face = np.array([*(np.array(DAM) + 0.5 * THICKNESS * normal), level - base])
    along = np.array([-normal[1], normal[0], 0.0])
    lever = push[3:] - np.cross(face, push[:3])
    return Pool(
        force=float(-push[:2] @ normal),
        moment=float(abs(lever @ along)),
        expected_force=force,
        expected_moment=moment,
        aside=float(push[:2] @ along[:2]),
        speed=float(np.linalg.norm(p.velocity[p.fluid], axis=1).mean()),
        released=int(state.released.sum()),
        in_front=in_front,
        passed=int(np.count_nonzero(upstream <= 0.0)),
        left=int(state.left.sum()),
        through=int(state.through_wall.sum()),
        time=time,
        push=-pushes[:, :2] @ normal,
    )


def measure(level: Level) -> Measured:
    """Return what pools did at a level: straight and turned, and one that flows over."""
    spacing = DEEPEST / level.across
    with TemporaryDirectory() as name:
        folder = Path(name)
        turned = run_pool(folder, spacing, TURNED)
        straight = run_pool(folder, spacing, 0.0)
        over = run_pool(folder, spacing, TURNED, crest=LOW_CREST)
    held = _rows(turned, f", turned by {TURNED:g}°") + _rows(straight, "")
    strays = sum(each.passed + each.left + each.through for each in (turned, straight))
    return Measured(
        (
            *held,
            none_of("particles that left the pools", strays),
            none_of("particles missing when it flows over the dam", over.missing + over.through),
        ),
        max(abs(each.force / each.expected_force - 1.0) for each in (turned, straight)),
        (_panel(turned),),
    )


def _rows(found: Pool, where: str) -> list[Row]:
    return [
        near(
            f"force on the dam over that of still water{where}",
            found.force / found.expected_force,
            1.0,
            "chosen: 3 % of the force are 1.2 % of the depth, an eighth of a row at most",
            margin=0.03,
        ),
        near(
            f"moment about the level of the pool, likewise{where}",
            found.moment / found.expected_moment,
            1.0,
            "chosen: 5 % of the moment are 1.4 % of the depth, a seventh of a row at most",
            margin=0.05,
        ),
        between(
            f"force along the dam over that across it{where}",
            found.aside / found.force,
            -0.03,
            0.03,
            "chosen: as much as is left to the force across it; nothing pushes along a dam",
            "%",
        ),
        at_most(
            f"mean speed at the end{where}",
            found.speed,
            0.1,
            "chosen: a hundredth of the speed of free fall through the depth, 10 m/s",
            "m/s",
        ),
    ]


def _panel(found: Pool) -> Panel:
    # the bursts of single steps are averaged over a third of a second
    window = np.arange(0.0, found.time[-1] + 0.1, 1.0 / 3.0)
    of_step = np.digitize(found.time, window)
    seen = np.unique(of_step)
    time, push = (
        np.array([values[of_step == k].mean() for k in seen]) for values in (found.time, found.push)
    )
    return Panel(
        f"dam turned by {TURNED:g}°",
        "time, s",
        "force / that of still water",
        (exact([0.0, found.time[-1]], [1.0, 1.0]), computed(time, push / found.expected_force)),
    )


COMPARISONS = (
    Comparison(
        name="terrain_pool",
        title="A pool behind a dam on a terrain",
        group=Group.AT_REST,
        compared=(
            "Force of the water on the dam and its moment, mean over 6 to 9 s, against those of "
            "still water of the same volume over the same ground; where all particles are."
        ),
        reference="closed form, ∫ ½ ρ g h² ds along the face of the dam",
        parameters=(
            "valley that falls by 12 %, pool 5 m deep at a dam 44 m long across it, also turned by "
            "20°, c = 70 m/s, weakly compressible"
        ),
        levels=(
            Level(5, "5 rows", 12, is_quick=True),
            Level(7, "7 rows", 50),
            Level(10, "10 rows", 200),
        ),
        measure=measure,
        error="greatest error of the forces on the dam",
        discussion=(
            "The level of the pool is that of the volume of its particles. The moment is a little "
            "low, because some of the thrust at the foot of the dam is taken up by the ground."
        ),
    ),
)
