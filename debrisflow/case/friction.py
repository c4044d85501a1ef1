"""The tables of friction along a wall, one for each law, chosen by ``law``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from debrisflow.case.fields import NONE, Table, quantity


class NoFriction(Table):
    """A wall along which the fluid slips freely."""

    law: Literal["none"] = quantity(NONE, "chooses this table")


class NoSlip(Table):
    """A wall that holds the fluid by its viscosity."""

    law: Literal["no-slip"] = quantity(NONE, "chooses this table")


class LogFriction(Table):
    """The law of the wall: the stress by the velocity at a height over a rough wall."""

    law: Literal["log"] = quantity(NONE, "chooses this table")
    roughness: float = quantity(
        "m", "equivalent sand roughness; of a smooth wall 3.3 nu / u*, some 0.03 mm", gt=0
    )


class ManningFriction(Table):
    """Manning's law for the mean velocity of a column: rho g n^2 u^2 / h^(1/3)."""

    law: Literal["manning"] = quantity(NONE, "chooses this table")
    coefficient: float = quantity("s/m^(1/3)", "Manning's n", gt=0, lt=1)


class CoulombFriction(Table):
    """Sliding friction: the stress up to which a wall holds is a share of what presses on it."""

    law: Literal["coulomb"] = quantity(NONE, "chooses this table")
    angle: float = quantity("degree", "angle of friction against the wall", gt=0, lt=80)
    pore_pressure: float = quantity(
        NONE, "share of what presses on the wall that the water in the pores bears", 0.0, ge=0, le=1
    )


class VoellmyFriction(Table):
    """Sliding friction and a drag by the mean velocity of a column: rho g u^2 / xi."""

    law: Literal["voellmy"] = quantity(NONE, "chooses this table")
    coefficient: float = quantity(NONE, "mu, the coefficient of sliding friction", ge=0, lt=5)
    turbulence: float = quantity("m/s2", "xi, the coefficient of turbulent friction", gt=0)
    pore_pressure: float = quantity(
        NONE, "share of what presses on the wall that the water in the pores bears", 0.0, ge=0, le=1
    )


Friction = Annotated[
    NoFriction | NoSlip | LogFriction | ManningFriction | CoulombFriction | VoellmyFriction,
    Field(discriminator="law"),
]
