"""A periodic layer of colliding grains: closed and without gravity, or a film on a slope.

Everything is rock: the concentration of the closure is its clipped value, 0.5.
"""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.validation.cases import case_of

HEIGHT, GRAIN, RESTITUTION, ROCK = 0.1, 0.01, 0.7, 2650.0
CONCENTRATION, PACKING = 0.5, 0.55
ALONG = 14
"""Spacings after which the layer repeats."""


def layer(
    rows: int, slope: float | None = None, wall_speed: float = 0.0, temperature: str = "algebraic"
) -> ResolvedCase:
    """Return a layer of grains: a film on a slope, or closed and without gravity.

    Parameters
    ----------
    rows : int
        Over the height of the layer.
    slope : float, degrees
        Without one the layer is closed.
    wall_speed : float, m/s
        Of its ceiling.
    temperature : str
        Law of the granular temperature.
    """
    spacing = HEIGHT / rows
    length = ALONG * spacing
    is_closed = slope is None
    return case_of(
        title="grains",
        particles={"spacing": spacing},
        gravity={"acceleration": 0.0} if is_closed else {"slope": slope},
        geometry={
            "type": "tank",
            "length": length,
            "height": HEIGHT if is_closed else 1.5 * HEIGHT,
            "ceiling": is_closed,
            "periodic": True,
        },
        fill=[{"type": "block", "x": (0.0, length), "y": (0.0, HEIGHT), "material": "sediment"}],
        water={"viscosity": 0.0},
        sediment={
            "viscosity": 0.0,
            "grain_diameter": GRAIN,
            "restitution": RESTITUTION,
            "packing_limit": PACKING,
        },
        collision_stress={
            "enabled": True,
            "granular_temperature": temperature,
            "largest_concentration": CONCENTRATION,
        },
        walls={"ceiling": {"velocity": (wall_speed, 0.0)}},
        time={"end": 10.0},
        output={"interval": 0.01},
    )


def balance(rate: float) -> float:
    """Return T, m2/s2, where production equals dissipation at a shear rate, 1/s."""
    return (GRAIN * rate) ** 2 / (15.0 * (1.0 - RESTITUTION))
