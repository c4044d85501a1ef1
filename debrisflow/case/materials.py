"""What flows: the tables of water, sediment, their mixture and its strength, and its density."""

from __future__ import annotations

from typing import Literal

from debrisflow.case.fields import NONE, Interval, Table, quantity


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


class Strength(Table):
    """What grains and slurry resist by, beyond the viscosity of their phase, and turbulence.

    References
    ----------
    Jop, Forterre & Pouliquen 2006, doi:10.1038/nature04801 (mu-i; glass beads of 0.53 mm have
    friction angles of 20.9 and 32.76 degrees and the inertia number 0.279); O'Brien & Julien 1988,
    doi:10.1061/(ASCE)0733-9429(1988)114:8(877) (obrien-julien).
    """

    law: Literal["none", "coulomb", "mu-i", "bingham", "herschel-bulkley", "obrien-julien"] = (
        quantity(
            NONE,
            "coulomb: friction of the grains, p tan(friction_angle); "
            "mu-i: friction that grows with the inertia number of the shear; "
            "bingham: yield_stress, and the viscosity of the phase; "
            "herschel-bulkley: yield_stress + consistency rate^exponent; "
            "obrien-julien: yield_stress exp(yield_growth C) + consistency exp(viscosity_growth C) "
            "rate, the quadratic term of turbulence and dispersion left out; "
            "all on top of the viscosity of the phase",
            "none",
        )
    )
    friction_angle: float = quantity(
        "degree", "angle of internal friction, in mu-i that of the slowest shear", 35.0, gt=0, lt=90
    )
    dynamic_friction_angle: float | None = quantity(
        "degree", "angle of internal friction of the fastest shear, of mu-i", None, gt=0, lt=90
    )
    inertia_number: float = quantity(
        NONE,
        "I0 of mu-i, at which friction is halfway from the one angle to the other",
        0.279,
        gt=0,
    )
    saturated: bool = quantity(
        NONE,
        "whether water fills the pores up to the surface of the mixture: grains then carry the "
        "buoyant share C (rho_s - rho_l) / rho of the pressure; false: a dry granular mass, which "
        "carries all of it, and whose density is C rho_s",
        True,
    )
    yield_stress: float | None = quantity(
        "Pa", "stress up to which a slurry holds; in obrien-julien at C = 0", None, ge=0
    )
    yield_growth: float | None = quantity(
        NONE, "beta of obrien-julien: the yield stress grows as exp(beta C)", None, ge=0
    )
    consistency: float | None = quantity(
        "Pa s^n",
        "K of herschel-bulkley; in obrien-julien, with n = 1, the viscosity at C = 0",
        None,
        ge=0,
    )
    exponent: float | None = quantity(NONE, "n of herschel-bulkley", None, gt=0, le=2)
    viscosity_growth: float | None = quantity(
        NONE, "beta of obrien-julien: the viscosity grows as exp(beta C)", None, ge=0
    )
    mixing_length: float = quantity(
        "m",
        "greatest mixing length of the turbulent viscosity; over a rough floor "
        "kappa (y + roughness / 30) at a height y where that is less, in two dimensions",
        0.0,
        ge=0,
    )
    concentration_ramp: Interval = quantity(
        NONE,
        "concentrations between which the strength grows from 0 to full, but in obrien-julien; "
        "from half of the first on, grains weigh on those below",
        (0.20, 0.35),
    )
    smallest_shear_rate: float = quantity(
        "1/s", "shear rate below which the strength is viscous", 0.001, gt=0
    )
    largest_viscosity: float = quantity(
        "Pa s", "viscosity at which the strength is capped", 1.0e6, gt=0
    )


def pore_density(water: Water, strength: Strength) -> float:
    """Return the density of what fills the pores: water, or air, taken as 0 kg/m3."""
    return water.density if strength.saturated else 0.0


def bulk_density(
    concentration: float, water: Water, sediment: Sediment, strength: Strength
) -> float:
    """Return ``rho = C rho_s + (1 - C) rho_l`` of grains and what fills their pores, kg/m3."""
    pores = pore_density(water, strength)
    return pores + concentration * (sediment.density - pores)


def buoyant_share(
    concentration: float, water: Water, sediment: Sediment, strength: Strength
) -> float:
    """Return ``C (rho_s - rho_l) / rho``, the grains' share of the pressure at rest; 1 if dry."""
    pores = pore_density(water, strength)
    density = bulk_density(concentration, water, sediment, strength)
    return concentration * (sediment.density - pores) / density if density > 0.0 else 0.0
