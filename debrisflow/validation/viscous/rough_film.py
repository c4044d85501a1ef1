"""A turbulent film over a rough floor, against its profile, and a sheet over a smooth one."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.particles.start import initial_state
from debrisflow.physics.turbulence import KARMAN
from debrisflow.schemes.choice import scheme_of
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import case_of, endless_channel
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact, points
from debrisflow.validation.marching import advance
from debrisflow.validation.row import Row, at_most, near, stated

Floats = NDArray[np.float64]
SLOPE, GRAVITY = 15.0, 9.81
STEADY = (4.0, 5.0, 6.0)  # s
SHEET_SPEED, SHEET_SPACING = 3.0, 0.01  # m/s, m


class Turbulent(NamedTuple):
    """A film: its depth, the roughness of its floor, and the greatest mixing length, m."""

    depth: float
    roughness: float
    mixing_length: float

    def profile(self) -> tuple[Floats, Floats]:
        """Return heights, m, and the speed of the steady film at them, m/s.

        ``l du/dy = u* sqrt(1 - y / h)``, l the lesser of the mixing length and ``kappa (y + z0)``,
        ``z0 = k_s / 30``, u = 0 at the floor, ``u* = sqrt(g h sin(slope))``.
        """
        count = 100_000
        y = (np.arange(count) + 0.5) * self.depth / count
        length = np.minimum(self.mixing_length, KARMAN * (y + self.roughness / 30.0))
        friction_speed = np.sqrt(GRAVITY * self.depth * np.sin(np.radians(SLOPE)))
        rise = friction_speed * np.sqrt(1.0 - y / self.depth) / length
        return y, (np.cumsum(rise) - 0.5 * rise) * self.depth / count

    def mean_speed(self) -> float:
        """Return the mean of the profile, m/s."""
        return float(self.profile()[1].mean())


FINE, COARSE = Turbulent(0.026, 0.003, 0.004), Turbulent(0.026, 0.095, 0.0095)


class Film(NamedTuple):
    """What a film did: mean speed along the floor, rms speed across, and all at the end.

    Attributes
    ----------
    speed, across : float, m/s
    height, velocity : (n,) float64 array, m, m/s
        Of the particles at the end, the velocity along the floor.
    """

    speed: float
    across: float
    height: Floats
    velocity: Floats


def build(dimension: int, rows: int, film: Turbulent) -> ResolvedCase:
    """Return the case of a film, periodic along x, in three dimensions between smooth sides."""
    depth, roughness, mixing_length = film
    spacing, rheology = depth / rows, {"type": "coulomb", "mixing_length": mixing_length}
    if dimension == 2:
        layer, rough = {"y": [0.0, depth], "material": "water"}, {"roughness": roughness}
        return endless_channel(spacing, SLOPE, [layer], walls={"floor": rough}, rheology=rheology)
    size = {"length": 12.0 * spacing, "width": 8.0 * spacing}
    block = {"x": (0.0, size["length"]), "y": (0.0, size["width"]), "z": (0.0, depth)}
    smooth = {"slip": "free-slip"}
    floor = {"friction": {"law": "log", "roughness": roughness}}
    return case_of(
        title="turbulent film",
        particles={"spacing": spacing},
        gravity={"slope": SLOPE},
        geometry={"type": "channel3d", "periodic": True, "height": 4.0 * depth, **size},
        walls={"floor": floor, "front": smooth, "back": smooth},
        fill=[{"type": "block", "material": "water", **block}],
        rheology=rheology,
        scheme={"type": "explicit", "courant": 1.2, "sound_speed": 15.0},
        time={"end": STEADY[-1]},
        output={"interval": STEADY[-1]},
    )


def run(rows: int, film: Turbulent, dimension: int = 2) -> Film:
    """Return what a film ``rows`` particles deep did once it was steady."""
    case = build(dimension, rows, film)
    scheme, state = scheme_of(case), initial_state(case)
    p, found = state.particles, []
    for until in STEADY:
        advance(scheme, state, until=until)
        velocity = p.velocity[p.fluid]
        across = np.sqrt(np.mean(np.sum(velocity[:, 1:] ** 2, axis=1)))
        found.append((velocity[:, 0].mean(), across))
    speed, across = np.mean(found, axis=0)
    height = p.position[p.fluid, dimension - 1]
    return Film(float(speed), float(across), height.copy(), velocity[:, 0].copy())


class Sheet(NamedTuple):
    """What a sheet lost to the floor, and how it moved across.

    Attributes
    ----------
    drag : float, N/m2
        Mean over the time.
    across : float, m/s
        Rms over its second half.
    time, loss : (n,) float64 array, s, m/s
        The speed that it lost until then.
    """

    drag: float
    across: float
    time: Floats
    loss: Floats


def slide(rows: int, speed: float = SHEET_SPEED, spacing: float = SHEET_SPACING) -> Sheet:
    """Return what a sheet of water did that slides over a level, smooth floor for a second."""
    layer = {"y": [0.0, rows * spacing], "material": "water", "velocity": [speed, 0.0]}
    case = endless_channel(spacing, 0.0, [layer], walls={"floor": {"slip": "free-slip"}})
    scheme, state = SemiImplicit(case), initial_state(case)
    p, across, loss = state.particles, [], []
    time = np.arange(1, 21) / 20.0
    for until in time:
        advance(scheme, state, until=until)
        across.append(np.sqrt(np.mean(p.velocity[p.fluid, 1] ** 2)))
        loss.append(speed - p.velocity[p.fluid, 0].mean())
    drag = case.water.density * rows * spacing * loss[-1] / time[-1]
    return Sheet(float(drag), float(np.mean(across[10:])), time, np.array(loss))


def measure_film(dimension: int, level: Level) -> Measured:
    """Return how fast both films were with as many rows."""
    rows = round(level.across)
    films = {"k_s = 3 mm": (FINE, _limit_fine), "k_s = 95 mm": (COARSE, _limit_coarse)}
    found = {name: run(rows, film, dimension) for name, (film, _) in films.items()}
    shares = {name: each.speed / films[name][0].mean_speed() for name, each in found.items()}
    figures: list[Row] = []
    for name, (_, limit) in films.items():
        most, reason, miss, worst = limit(dimension, rows)
        measure = f"{name}: mean speed / that of the profile"
        figures.append(
            near(measure, shares[name], 1.0, reason, margin=most, miss=miss, worst=worst)
        )
        calm = "chosen: 1 % of the speed of the faster film; noise exchanges momentum"
        across = 1e3 * found[name].across
        figures.append(at_most(f"{name}: rms speed across", across, 30.0, calm, "mm/s"))
    panels = tuple(_film_panel(name, films[name][0], each) for name, each in found.items())
    return Measured(tuple(figures), abs(shares["k_s = 3 mm"] - 1.0), panels)


def _limit_fine(dimension: int, rows: int) -> tuple[float, str, str, float]:
    reason = "chosen: within the lowest of four rows the speed rises by 0.9 of its mean"
    if dimension == 2:
        return (0.10 if rows == 1 else 0.05), reason, "", np.nan
    miss = (
        "One row moves as the law of the wall says for half the depth under the stress on the "
        "floor; the mean of the profile is less."
    )
    return 0.06, reason, miss if rows == 1 else "", 1.12


def _limit_coarse(dimension: int, rows: int) -> tuple[float, str, str, float]:
    reason = "chosen: no law of the wall is known for k_s of four times the depth"
    if rows == 1:
        miss = "The law of the wall, used for one row, at a k_s of four times the depth."
        return 0.12, reason, miss, 1.28
    miss = "Cause not known; the law of the wall is used far beyond its roughness."
    return 0.10, reason, miss if dimension == 3 and rows == 8 else "", 1.15


def _film_panel(name: str, film: Turbulent, found: Film) -> Panel:
    y, u = film.profile()
    return Panel(
        f"{name}, after {STEADY[-1]:g} s",
        "speed, m/s",
        "height, mm",
        (exact(u, 1e3 * y, "profile"), points(found.velocity, 1e3 * found.height)),
    )


def measure_sheet(level: Level) -> Measured:
    """Return what a sheet lost to a smooth floor."""
    found = slide(round(level.across))
    turbulent = 0.5 * 1000.0 * 0.003 * SHEET_SPEED**2
    return Measured(
        (
            near(
                "drag of the floor",
                found.drag,
                0.0,
                f"chosen: under 1 % of that of a smooth plate, ½ ρ c_f u² = {turbulent:.3g} N/m²",
                margin=0.1,
                unit="N/m²",
            ),
            at_most(
                "rms speed across",
                1e3 * found.across,
                25.0,
                "chosen: 1 % of the speed",
                "mm/s",
            ),
            stated("speed lost in 1 s", 1e3 * float(found.loss[-1]), "mm/s", 0.0),
        ),
        panels=(
            Panel(
                "speed lost",
                "time, s",
                "speed lost, mm/s",
                (exact([0.0, 1.0], [0.0, 0.0], "none"), computed(found.time, 1e3 * found.loss)),
            ),
        ),
    )


_shared = partial(
    Comparison,
    group=Group.VISCOUS,
    compared=(
        "Mean speed of two films over rough floors from 4 to 6 s after their start from rest, "
        "against that of the steady profile; 1, 2, 4 and 8 rows of particles in the depth."
    ),
    reference=(
        "profile of the mixing length l = min(l_m, κ (y + k_s / 30)) under the linear stress: "
        "Prandtl 1925, doi:10.1002/zamm.19250050212; the law of the wall over sand roughness: "
        "Nikuradse 1933"
    ),
    error="error of the mean speed, k_s = 3 mm",
)
_FILMS = "26 mm deep on 15°; k_s = 3 mm with l_m = 4 mm, and 95 mm with 9.5 mm"
_ROWS = (
    "The levels are rows in the depth, since the question is how few are enough. The law of the "
    "wall stands for the whole of the lowest row, within which the speed rises by 0.8 of its mean "
    "even at 8 rows. A roughness of 95 mm under 26 mm, of the size that is fitted in `flume2d`, is "
    "beyond what the law of the wall is known for: there the formula alone is tested."
)
COMPARISONS = (
    _shared(
        name="log_film2d",
        title="Turbulent films over rough floors",
        parameters=f"{_FILMS}; two dimensions, semi-implicit",
        levels=(
            Level(1, "1 row", 4, is_quick=True),
            Level(2, "2 rows", 7, is_quick=True),
            Level(4, "4 rows", 18),
            Level(8, "8 rows", 50),
        ),
        measure=partial(measure_film, 2),
        discussion=_ROWS,
    ),
    _shared(
        name="log_film3d",
        title="Turbulent films over rough floors, three dimensions",
        parameters=f"{_FILMS}; weakly compressible, c = 15 m/s, friction law `log`",
        levels=(
            Level(1, "1 row", 9),
            Level(2, "2 rows", 10, is_quick=True),
            Level(4, "4 rows", 33),
            Level(8, "8 rows", 130),
        ),
        measure=partial(measure_film, 3),
        discussion=_ROWS,
    ),
    Comparison(
        name="smooth_floor",
        title="A sheet that slides over a smooth floor",
        group=Group.VISCOUS,
        compared="Speed that a sheet of water loses in 1 s to a level floor without friction.",
        reference="closed form: none is lost",
        parameters="spacing of 10 mm, 3 m/s, two dimensions, semi-implicit",
        levels=(
            Level(2, "2 rows", 1, is_quick=True),
            Level(6, "6 rows", 1, is_quick=True),
            Level(12, "12 rows", 1, is_quick=True),
        ),
        measure=measure_sheet,
        discussion=(
            "The levels are depths of the same spacing: what is asked is whether a floor that is a "
            "surface holds particles back that slide along it, as rows of wall particles do. "
            "There is no error whose order could be observed."
        ),
    ),
)
