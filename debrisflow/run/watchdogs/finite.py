"""Values that are no finite numbers."""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.errors import DivergedError
from debrisflow.particles.place import moment, named_particle
from debrisflow.particles.state import State

ASKED = (
    "position",
    "velocity",
    "pressure",
    "density",
    "number_density",
    "sediment_fraction",
    "concentration",
    "granular_temperature",
    "pore_pressure",
    "grain_pressure",
    "collision_pressure",
    "compression",
)


def check_finite(case: ResolvedCase, state: State) -> None:
    """Raise if a value of a fluid particle is not finite.

    Raises
    ------
    DivergedError
    """
    p = state.particles
    for name in ASKED:
        values = getattr(p, name)
        if len(values) != p.count:
            continue  # the case does not have it
        values = values[p.fluid]
        if np.isfinite(values.sum()):
            continue
        rows = np.isfinite(values) if values.ndim == 1 else np.isfinite(values).all(axis=1)
        row = int(np.argmin(rows))
        if rows[row]:
            continue  # finite numbers whose sum is not: the bounds of density and energy tell
        count, words = int(np.count_nonzero(~rows)), name.replace("_", " ")
        others = f", as have {count - 1} others" if count > 1 else ""
        raise DivergedError(
            f"{moment(state)}, {named_particle(case, state, row)} has the {words} "
            f"{values[row]}{others}",
            f"the term that finds the {words} divided by zero or overflowed there: particles on "
            "top of each other, or a value of the case far out of its range",
            "look at the place in the particles at the failure, check the units of what stands "
            "there, and try half of time.largest_step",
        )
