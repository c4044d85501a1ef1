"""Transport of concentration: the two shocks of a settling column, by Kynch's theory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.physics.drag import DragLaw, drag_coefficient
from debrisflow.schemes.records import drag_of
from debrisflow.validation.beds.settling import (
    HEIGHT,
    PACKING_LIMIT,
    column,
    concentration_profile,
    interface,
)
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, exact, points
from debrisflow.validation.marching import states
from debrisflow.validation.row import at_most, near, none_of

Floats = NDArray[np.float64]
START, SEED = 0.2, 1  # concentration, seeding
INTERVAL, END = 0.05, 1.8  # s
SHOWN = 0.5, 1.0, 1.5  # s, of the profiles
BETWEEN = 0.1, 0.7
"""Of the time in which the column settles: when the speeds of the shocks are measured."""


class Profiles(NamedTuple):
    """Concentrations in layers two spacings high.

    Attributes
    ----------
    time : (samples,) float64 array, s
    height : (layers,) float64 array, m
    concentration : (samples, layers) float64 array
    interface : (samples,) float64 array, m
    lost : int
        Particles of sediment that were lost or turned into water.
    """

    time: Floats
    height: Floats
    concentration: Floats
    interface: Floats
    lost: int


def settling_speed(c: float, drag: DragLaw, gravity: float = 9.81) -> float:
    """Return the speed at which sediment settles by the drag law itself, m/s.

    ``K u_r = (rho_s - rho_l) g`` gives the slip, and ``w = (1 - C) u_r`` where nothing flows on
    the whole.
    """
    slip = 0.1
    for _ in range(100):
        weight = (drag.grain_density - drag.density) * gravity
        slip = 0.5 * (slip + weight / drag_coefficient(c, slip, drag))
    return (1.0 - c) * slip


def kynch(height: Floats, time: float, speed: float) -> Floats:
    """Return the concentration by Kynch's theory: water, suspension and bed, between two shocks.

    The flux ``C w(C)`` is concave up to the packing limit, so that no other waves appear.
    """
    top = max(HEIGHT - speed * time, HEIGHT * START / PACKING_LIMIT)
    bed = min(START * speed / (PACKING_LIMIT - START) * time, HEIGHT * START / PACKING_LIMIT)
    return np.where(height < bed, PACKING_LIMIT, np.where(height < top, START, 0.0))


def run(spacing: float) -> Profiles:
    """Let a column settle."""
    series, profiles, counts = [], [], []
    for state in states(column(START, SEED, spacing, END), INTERVAL):
        height, profile = concentration_profile(state, spacing)
        series.append((state.time, interface(state, START, spacing)))
        profiles.append(profile)
        fluid = state.particles.fluid
        counts.append(int(np.count_nonzero(state.particles.sediment_fraction[fluid])))
    time, top = np.array(series).T
    return Profiles(time, height, np.array(profiles), top, abs(counts[-1] - counts[0]))


def bed_top(height: Floats, profile: Floats) -> float:
    """Return where the concentration falls to the mean of bed and suspension, from below, m."""
    middle = 0.5 * (START + PACKING_LIMIT)
    layer = height[1] - height[0]
    thin = np.flatnonzero(profile < middle)[0]
    if thin == 0:
        return 0.0
    part = (profile[thin - 1] - middle) / (profile[thin - 1] - profile[thin])
    return float(height[thin - 1] + part * layer)


def measure(level: Level) -> Measured:
    """Return the speeds of both shocks and the distance of the profiles from Kynch's."""
    spacing = HEIGHT / level.across
    found, speed = run(spacing), settling_speed(START, drag_of(column(START, SEED, spacing, END)))
    rise = START * speed / (PACKING_LIMIT - START)
    duration = HEIGHT * (1.0 - START / PACKING_LIMIT) / speed
    during = (found.time > BETWEEN[0] * duration) & (found.time < BETWEEN[1] * duration)
    bed = np.array([bed_top(found.height, profile) for profile in found.concentration])
    fall, grown = (
        float(np.polyfit(found.time[during], path[during], 1)[0]) for path in (found.interface, bed)
    )
    inside = found.height < HEIGHT
    theory = np.array([kynch(found.height, time, speed) for time in found.time])
    off = (found.concentration - theory)[:, inside][during]
    rms = float(np.sqrt(np.mean(off**2)) / PACKING_LIMIT)
    miss = COARSE if spacing > 0.01 else ""
    shake = "chosen: seedings differ by 10 %, and the speed is that of a law without their scatter"
    return Measured(
        (
            near(
                "speed of the interface",
                -fall,
                speed,
                shake,
                share=0.15,
                unit="m/s",
                miss=miss,
                worst=0.27,
                is_certain=not miss,
            ),
            near(
                "speed at which the bed rises",
                grown,
                rise,
                shake,
                share=0.20,
                unit="m/s",
                miss=miss,
                worst=0.17,
                is_certain=not miss,
            ),
            at_most(
                "concentration, all heights and times: rms / packing limit",
                rms,
                0.20,
                "chosen: shocks are two layers of two spacings wide, and a layer of 40 "
                "particles scatters by 0.06",
                "%",
            ),
            none_of("particles of sediment that were lost", found.lost),
        ),
        rms,
        tuple(_panels(found, bed, speed)),
    )


COARSE = (
    "the column is ten spacings wide and its bed ten high, so that a single seeding scatters by "
    "20 %; with half the spacing it is within"
)


def _panels(found: Profiles, bed: Floats, speed: float) -> list[Panel]:
    fine = np.linspace(0.0, HEIGHT, 241)
    shown = [
        Panel(
            f"concentration after {time:g} s",
            "concentration",
            "height (m)",
            (
                exact(kynch(fine, time, speed), fine, "Kynch"),
                computed(found.concentration[np.abs(found.time - time).argmin()], found.height),
            ),
        )
        for time in SHOWN
    ]
    rise = START * speed / (PACKING_LIMIT - START)
    end = HEIGHT * START / PACKING_LIMIT
    time = np.linspace(0.0, END, 61)
    return [
        *shown,
        Panel(
            "shocks",
            "t (s)",
            "height (m)",
            (
                exact(time, np.maximum(HEIGHT - speed * time, end), "Kynch"),
                exact(time, np.minimum(rise * time, end), ""),
                computed(found.time, found.interface),
                points(found.time, bed),
            ),
        ),
    ]


COMPARISONS = (
    Comparison(
        name="kynch",
        title="Transport of concentration in a settling column",
        group=Group.BEDS,
        compared=(
            "Profiles of the concentration in layers of two spacings, and the speeds of the "
            "falling interface and of the rising bed, while the column settles."
        ),
        reference=(
            "theory of shocks, Kynch 1952, doi:10.1039/TF9524800166, with the settling speed of "
            "the drag law itself"
        ),
        parameters=(
            "two dimensions, grains of 3 mm in water, C0 = 0.2, packing limit 0.55, drag of Wen & "
            "Yu, column 0.2 m wide and 0.6 m high"
        ),
        levels=(
            Level(30, "d0 = 20 mm", 3),
            Level(60, "d0 = 10 mm", 12, is_quick=True),
            Level(120, "d0 = 5 mm", 110),
        ),
        measure=measure,
        error="rms of the concentration / packing limit",
        discussion=(
            "The model transports concentration by the slip of the phases alone: it has no "
            "diffusion of sediment, so that there is no closed form of diffusion to compare with. "
            "The way of a grain is made by exchanges of places, whose scatter widens the shocks."
        ),
    ),
)
