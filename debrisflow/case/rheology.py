"""The tables of rheology, one for each law, chosen by ``type``.

A law is its table here and its record and formulas in ``debrisflow/physics/rheology/NAME.py``,
where NAME is the type with ``_`` for ``-``.  What that file calls ``law`` makes the record; its
arguments have the names of the fields of the table.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field

from debrisflow.case.fields import NONE, Interval, Table, quantity


class Rheology(Table):
    """What every law has: the turbulence beside it."""

    type: str
    mixing_length: float = quantity(
        "m",
        "greatest mixing length of the turbulent viscosity; over a rough floor "
        "kappa (y + roughness / 30) at a height y where that is less",
        0.0,
        ge=0,
    )

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """Yield each field that contradicts others of the table, with what is wrong."""
        yield from ()

    def summary(self) -> str:
        """Return the law and the number that matters most."""
        return self.type


class NoStrength(Rheology):
    """No strength: what flows resists by the viscosity of its phase alone, without turbulence."""

    type: Literal["none"] = "none"


class YieldingStrength(Rheology):
    """A strength, on top of the viscosity of the phase."""

    smallest_shear_rate: float = quantity(
        "1/s", "shear rate below which the strength is viscous", 0.001, gt=0
    )
    largest_viscosity: float = quantity(
        "Pa s", "viscosity at which the strength is capped", 1.0e6, gt=0
    )


class RampedStrength(YieldingStrength):
    """A strength that is there from some concentration on."""

    concentration_ramp: Interval = quantity(
        NONE,
        "concentrations between which the strength grows from 0 to full; "
        "from half of the first on, grains weigh on those below",
        (0.20, 0.35),
    )


class FrictionalStrength(RampedStrength):
    """A strength that grows with the pressure between the grains."""

    friction_angle: float = quantity(
        "degree", "angle of internal friction, in mu-i that of the slowest shear", 35.0, gt=0, lt=90
    )
    saturated: bool = quantity(
        NONE,
        "whether water fills the pores up to the surface of the mixture: grains then carry the "
        "buoyant share C (rho_s - rho_l) / rho of the pressure; false: a dry granular mass, which "
        "carries all of it, and whose density is C rho_s",
        True,
    )

    def summary(self) -> str:
        """Return the law and its friction angle."""
        return f"{self.type} φ = {self.friction_angle:g}°"


class SlurryStrength(YieldingStrength):
    """A strength that does not depend on the pressure between the grains."""

    yield_stress: float = quantity(
        "Pa", "stress up to which a slurry holds; in obrien-julien at C = 0", ge=0
    )

    def summary(self) -> str:
        """Return the law and its yield stress."""
        return f"{self.type} τ0 = {self.yield_stress:g} Pa"


class Coulomb(FrictionalStrength):
    """Friction of the grains, p tan(friction_angle)."""

    type: Literal["coulomb"]


class MuI(FrictionalStrength):
    """Friction of the grains that grows with the inertia number of the shear.

    References
    ----------
    Jop, Forterre & Pouliquen 2006, doi:10.1038/nature04801 (glass beads of 0.53 mm have friction
    angles of 20.9 and 32.76 degrees and the inertia number 0.279).
    """

    type: Literal["mu-i"]
    dynamic_friction_angle: float = quantity(
        "degree", "angle of internal friction of the fastest shear, of mu-i", gt=0, lt=90
    )
    inertia_number: float = quantity(
        NONE,
        "I0 of mu-i, at which friction is halfway from the one angle to the other",
        0.279,
        gt=0,
    )

    def contradictions(self) -> Iterator[tuple[str, str]]:
        """Yield the friction of fast shear where it is not the greater one."""
        if self.dynamic_friction_angle <= self.friction_angle:
            message = f"must be greater than rheology.friction_angle = {self.friction_angle:g}"
            yield "dynamic_friction_angle", message


class Bingham(SlurryStrength, RampedStrength):
    """A slurry that holds up to its yield stress, and then flows by the viscosity of its phase."""

    type: Literal["bingham"]


class HerschelBulkley(SlurryStrength, RampedStrength):
    """A slurry that resists by yield_stress + consistency rate^exponent."""

    type: Literal["herschel-bulkley"]
    consistency: float = quantity("Pa s^n", "K of herschel-bulkley", ge=0)
    exponent: float = quantity(NONE, "n of herschel-bulkley", gt=0, le=2)


class OBrienJulien(SlurryStrength):
    """A mud that thickens with its concentration C, and has strength at any C above 0.

    It resists by yield_stress exp(yield_growth C) + consistency exp(viscosity_growth C) rate; the
    quadratic term of turbulence and dispersion is left out.

    References
    ----------
    O'Brien & Julien 1988, doi:10.1061/(ASCE)0733-9429(1988)114:8(877).
    """

    type: Literal["obrien-julien"]
    yield_growth: float = quantity(
        NONE, "beta of obrien-julien: the yield stress grows as exp(beta C)", ge=0
    )
    consistency: float = quantity("Pa s", "viscosity at C = 0 of obrien-julien", ge=0)
    viscosity_growth: float = quantity(
        NONE, "beta of obrien-julien: the viscosity grows as exp(beta C)", ge=0
    )


AnyTable = NoStrength | Coulomb | MuI | Bingham | HerschelBulkley | OBrienJulien
LAWS: tuple[type[Rheology], ...] = get_args(AnyTable)


def owners(name: str) -> tuple[str, ...]:
    """Return the types of the laws that have a field.

    Examples
    --------
    >>> owners("saturated")
    ('coulomb', 'mu-i')
    """
    return tuple(_type_of(table) for table in LAWS if name in table.model_fields)


def _type_of(table: type[Rheology]) -> str:
    return str(get_args(table.model_fields["type"].annotation)[0])


def _as_now(data: Any) -> Any:
    """Return a table as it is written now, without fields of other laws.

    A table with fields but no law is left as it is, and refused: its numbers would mean nothing.
    Former files state the fields of all laws.  A field of another law is left out where it has its
    default.  With 'none', by which a law is switched off, it is left out whatever its value is;
    only a dry mass, which would change the density, stays and is refused.
    """
    if not isinstance(data, dict):
        return data
    data = dict(data) or {"type": "none"}
    own = {_type_of(table): table for table in LAWS}.get(str(data.get("type")))
    if own is None:
        return data
    for name in set(data) - set(own.model_fields):
        defaults = [
            table.model_fields[name].default for table in LAWS if name in table.model_fields
        ]
        value = tuple(data[name]) if isinstance(data[name], list) else data[name]
        ignored = own is NoStrength and name != "saturated"
        if defaults and (ignored or value in defaults):
            del data[name]
    return data


AnyRheology = Annotated[Annotated[AnyTable, Field(discriminator="type")], BeforeValidator(_as_now)]
