"""Polystyrene that settles in silicone oil, against interfaces seen by magnetic resonance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.validation.beds.settling import concentration_profile, interface
from debrisflow.validation.cases import case_of
from debrisflow.validation.comparison import Comparison, Group, Level, Measured
from debrisflow.validation.curves import Panel, computed, measured
from debrisflow.validation.files import REFERENCES
from debrisflow.validation.marching import states
from debrisflow.validation.row import at_most, between, near, none_of, stated

Floats = NDArray[np.float64]
HEIGHT, CONCENTRATION = 0.054, 0.50  # m, of the suspension
OIL, POLYSTYRENE, VISCOSITY = 950.0, 1050.0, 0.020  # kg/m3, kg/m3, Pa s
GRAIN, PACKING_LIMIT = 290e-6, 0.64  # m; random close packing of spheres
FASTER = 200.0
"""How many times faster the grains settle than those of the experiment: they are larger by its
root.  Both are slow: the Reynolds number of a grain is 1e-4 and 0.5, and the drag linear within
1 %, so that nothing but the clock differs."""
END = 1320.0  # s of the experiment, in which it settles
FIRST, FREE = 172.0, 600.0  # s; from the first image on, and until when its speed is compared
SHOWN = 592.0, 1312.0  # s, of the measured profiles
INTERFACES, PROFILES = "pham_van_bang_2006.csv", "pham_van_bang_2006_profiles.csv"
SAMPLES, ALONG = 66, 16  # samples; spacings, after which the column repeats


class Settled(NamedTuple):
    """What a column did, by the clock of the experiment.

    Attributes
    ----------
    time, interface : (samples,) float64 array, s, m
    height : (layers,) float64 array, m
    concentration : (samples, layers) float64 array
    lost : int
        Particles of sediment that were lost or turned into oil.
    """

    time: Floats
    interface: Floats
    height: Floats
    concentration: Floats
    lost: int


def fall_speed(time: Floats, interface: Floats, end: float) -> float:
    """Return the speed of an interface from the first image to a time, m/s."""
    seen = (time >= FIRST) & (time <= end)
    return -float(np.polyfit(time[seen], interface[seen], 1)[0])


def bed(height: Floats, profile: Floats, top: float) -> float:
    """Return the concentration below 0.8 of the interface, without the lowest layer."""
    return float(profile[(height < 0.8 * top) & (height > height[0])].mean())


def table(name: str) -> Floats:
    """Return the columns of a reference: time, s, or height, m, and what was measured."""
    path = REFERENCES / name
    return np.loadtxt(path, delimiter=",", skiprows=4)


def column(spacing: float) -> ResolvedCase:
    """Return the case of a column without side walls."""
    width = ALONG * spacing
    block = {"x": (0.0, width), "y": (0.0, HEIGHT), "sediment_share": CONCENTRATION}
    return case_of(
        title="sedimentation of polystyrene in silicone oil",
        particles={"spacing": spacing},
        geometry={"type": "tank", "length": width, "height": 1.3 * HEIGHT, "periodic": True},
        fill=[{"type": "block", "material": "two-phase", **block}],
        water={"density": OIL, "viscosity": VISCOSITY},
        sediment={
            "density": POLYSTYRENE,
            "viscosity": VISCOSITY,
            "grain_diameter": GRAIN * float(np.sqrt(FASTER)),
            "packing_limit": PACKING_LIMIT,
        },
        drag={"law": "gidaspow"},
        time={"end": END / FASTER},
        output={"interval": END / FASTER},
    )


def run(spacing: float) -> Settled:
    """Let a column settle for as long as in the experiment."""
    series, profiles, count = [], [], None
    for state in states(column(spacing), END / FASTER / SAMPLES):
        height, profile = concentration_profile(state, spacing, HEIGHT)
        top = interface(state, CONCENTRATION, spacing, HEIGHT)
        series.append((state.time * FASTER, top))
        profiles.append(profile)
        rocks = int(np.count_nonzero(state.particles.sediment_fraction[state.particles.fluid]))
        count = rocks if count is None else count
    time, fallen = np.array(series).T
    assert count is not None
    return Settled(time, fallen, height, np.array(profiles), abs(rocks - count))


def measure(level: Level) -> Measured:
    """Return how a column settles beside the measured one."""
    found = run(HEIGHT / level.across)
    time, upper, _ = table(INTERFACES).T
    height, _, packed = table(PROFILES).T
    falling = time < END
    speed, whole = (1e6 * fall_speed(time, upper, end) for end in (FREE, END))
    own, own_whole = (1e6 * fall_speed(found.time, found.interface, end) for end in (FREE, END))
    off = np.interp(time[falling], found.time, found.interface) - upper[falling]
    return Measured(
        (
            near(
                "speed of the upper interface, 172 to 600 s",
                own,
                speed,
                "chosen: laws of hindered settling differ by more at this concentration, and the "
                "images resolve 0.8 mm of the 3 mm",
                share=0.15,
                unit="µm/s",
                miss=COARSE if level.across < 36 else "",
                worst=16.0,
            ),
            stated("the same, 172 to 1320 s", own_whole, "µm/s", whole),
            at_most(
                "height of the upper interface, 172 to 1320 s: rms",
                1e3 * float(np.sqrt(np.mean(off**2))),
                1.5,
                "chosen: twice the resolution of the images, 0.8 mm",
                "mm",
            ),
            between(
                "concentration of the bed at 1320 s",
                bed(found.height, found.concentration[-1], found.interface[-1]),
                0.59,
                0.61,
                "the measured bed from its foot to its top",
                expected=bed(height, packed, float(np.interp(SHOWN[1], time, upper))),
                miss=HELD,
                worst=0.56,
            ),
            none_of("particles of sediment that were lost", found.lost),
        ),
        abs(own / speed - 1.0),
        tuple(_panels(found)),
    )


COARSE = (
    "the border falls by a single spacing in this time, and grains settle by exchanges of places, "
    "of a spacing each, so that it waits until the first image and then falls"
)
HELD = (
    "places are no longer exchanged from 0.9 of the packing limit on, and the concentration around "
    "a particle scatters by 0.05 from place to place, so that parts of the column are held before "
    "the rest of it is packed; with a limit of 0.60 the bed has 0.55"
)


def _panels(found: Settled) -> list[Panel]:
    time, upper, _ = table(INTERFACES).T
    height, *profiles = table(PROFILES).T
    falling = computed(found.time, found.interface)
    panels = [Panel("upper interface", "t (s)", "height (m)", (measured(time, upper), falling))]
    for at, profile in zip(SHOWN, profiles, strict=True):
        own = found.concentration[np.abs(found.time - at).argmin()]
        curves = measured(profile, height), computed(own, found.height)
        axes = "concentration", "height (m)"
        panels.append(Panel(f"concentration after {at:.0f} s", *axes, curves))
    return panels


COMPARISONS = (
    Comparison(
        name="sedimentation_mri",
        title="Sedimentation of polystyrene in silicone oil",
        group=Group.BEDS,
        compared=(
            "Height of the border between clear oil and suspension, profiles of the concentration, "
            "and that of the bed when it has settled."
        ),
        reference=(
            "magnetic resonance images, Pham Van Bang, Lefrançois, Ovarlez & Bertrand 2006, 7th "
            "Int. Conf. on Hydroinformatics, Nice"
        ),
        parameters=(
            "two dimensions, without side walls; suspension 54 mm high, C0 = 0.50, ρ_s = 1050, ρ = "
            "950 kg/m³, 0.020 Pa s; drag of Gidaspow (Ergun at this concentration), packing limit "
            "0.64. Grains of 4.1 instead of 0.29 mm settle 200 times faster, and the clock runs as "
            "much faster: the drag is linear in both"
        ),
        levels=(
            Level(18, "18 rows", 11, is_quick=True),
            Level(36, "36 rows", 29),
            Level(72, "72 rows", 70),
        ),
        measure=measure,
        error="speed of the upper interface / measured - 1",
        discussion=(
            "The 1300 s of the experiment would take more than a million steps, which free surface "
            "and gravity limit, not the settling. Speeds are compared from the first image to 600 "
            "s, while both columns settle freely; to 1320 s the computed border falls less, since "
            "its bed is packed less and so is reached sooner. Ergun's law gives (1 - C) u_r = 6.9 "
            "µm/s at C = 0.50, Richardson & Zaki's exponent of 4.65 would give 9.1. No figure is "
            "made of the top of the bed: it differs from the suspension by 0.1 in concentration, "
            "as much as layers of particles scatter."
        ),
    ),
)
