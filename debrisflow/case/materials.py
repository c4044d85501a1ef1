"""What flows: the tables of water, sediment and their mixture, and its density."""

from __future__ import annotations

from typing import Any

from debrisflow.case.fields import NONE, Table, quantity
from debrisflow.case.rheology import FrictionalStrength, Rheology


class Water(Table):
    """The liquid phase."""

    density: float = quantity("kg/m3", "density of water", 1000.0, gt=0)
    viscosity: float = quantity("Pa s", "dynamic viscosity of water", 1.0e-3, ge=0)


class Sediment(Table):
    """The solid phase: grains of rock."""

    density: float = quantity("kg/m3", "density of the rock", 2650.0, gt=0)
    viscosity: float = quantity("Pa s", "dynamic viscosity of sediment particles", 1.0e-3, ge=0)
    grain_diameter: float = quantity("m", "mean grain diameter", 3.0e-3, gt=0)
    restitution: float = quantity(
        NONE, "coefficient of restitution between grains", 0.7, ge=0, lt=1
    )
    packing_limit: float = quantity(
        NONE, "greatest volumetric concentration of a packing", 0.55, gt=0, lt=1
    )


class Mixture(Table):
    """One kind of particle that stands for sediment and water together."""

    concentration: float = quantity(
        NONE, "volumetric sediment concentration of a mixture particle", 0.5, ge=0, lt=1
    )
    viscosity: float = quantity("Pa s", "dynamic viscosity of the mixture", 1.0e-3, ge=0)


def pore_pressure_share() -> Any:
    """Return the field of the share of what presses on a mass that its pore water bears."""
    return quantity(
        NONE,
        "share that the water in the pores bears of what presses the mass on a wall and its grains "
        "on each other; friction has the rest",
        0.0,
        ge=0,
        le=1,
    )


def pore_pressure_decay() -> Any:
    """Return the field of the time in which that share decays."""
    return quantity(
        "s",
        "time in which that share falls to 1/e, from t = 0 or the release on; it does not fall if "
        "left out",
        None,
        gt=0,
    )


def pore_density(water: Water, rheology: Rheology) -> float:
    """Return the density of what fills the pores: water, or air, taken as 0 kg/m3."""
    is_dry = isinstance(rheology, FrictionalStrength) and not rheology.saturated
    return 0.0 if is_dry else water.density


def bulk_density(
    concentration: float, water: Water, sediment: Sediment, rheology: Rheology
) -> float:
    """Return ``rho = C rho_s + (1 - C) rho_l`` of grains and what fills their pores, kg/m3."""
    pores = pore_density(water, rheology)
    return pores + concentration * (sediment.density - pores)
