"""The tables of parameters that vary, one for each distribution."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict
from scipy import stats

from debrisflow.case.fields import NAME_PATTERN, NONE, Series, Table, quantity

Floats = NDArray[np.float64]
Value = float | str
"""Of a parameter: a number, or a word, as the name of a law or of a file."""
Values = dict[str, Value]
"""Of the parameters, by their names."""


class Parameter(Table):
    """A quantity of the case that differs between members."""

    name: str = quantity(NONE, "by which the other tables know it", pattern=NAME_PATTERN)
    key: str | Annotated[tuple[str, ...], Strict(False), Field(min_length=1)] = quantity(
        NONE, "dotted key of the case, as after --set; a list of keys that all get the value"
    )
    is_factor: bool = quantity(
        NONE, "whether it multiplies what the case has there, a number or a list of numbers", False
    )

    @property
    def keys(self) -> tuple[str, ...]:
        """The dotted keys."""
        return (self.key,) if isinstance(self.key, str) else self.key


class Continuous(Parameter):
    """A parameter that may have any value of an interval."""

    @property
    def law(self) -> Any:
        """The distribution, as :mod:`scipy.stats` has it: ``ppf``, ``logpdf``, ``support``."""
        raise NotImplementedError

    @property
    def range(self) -> tuple[float, float]:
        """The values between which 99 in 100 lie; the bounds of uniform and triangular ones."""
        low, high = self.law.ppf([0.005, 0.995])
        return float(low), float(high)

    def at(self, share: float) -> float:
        """Return the value below which a share of all lies.

        Examples
        --------
        >>> Uniform(name="mu", key="x", distribution="uniform", low=0.25, high=0.75).at(0.5)
        0.5
        """
        return float(self.law.ppf(share))


class Uniform(Continuous):
    """Any value of a range, all equally likely."""

    distribution: Literal["uniform"] = quantity(NONE, "chooses this table")
    low: float = quantity(NONE, "least value")
    high: float = quantity(NONE, "greatest value")

    @property
    def law(self) -> Any:
        """The distribution."""
        return stats.uniform(self.low, self.high - self.low)

    @property
    def range(self) -> tuple[float, float]:
        """The bounds."""
        return self.low, self.high


class Normal(Continuous):
    """Values around a mean; within bounds if they are given."""

    distribution: Literal["normal"] = quantity(NONE, "chooses this table")
    mean: float = quantity(NONE, "mean, before it is cut to the bounds")
    deviation: float = quantity(NONE, "standard deviation, before it is cut", gt=0)
    low: float | None = quantity(NONE, "least value; none if left out", None)
    high: float | None = quantity(NONE, "greatest value; none if left out", None)

    @property
    def law(self) -> Any:
        """The distribution."""
        low = -np.inf if self.low is None else (self.low - self.mean) / self.deviation
        high = np.inf if self.high is None else (self.high - self.mean) / self.deviation
        return stats.truncnorm(low, high, self.mean, self.deviation)


class LogNormal(Continuous):
    """Values whose logarithm is normal."""

    distribution: Literal["lognormal"] = quantity(NONE, "chooses this table")
    median: float = quantity(NONE, "half of all values are below it", gt=0)
    deviation: float = quantity(
        NONE, "standard deviation of the natural logarithm; 0.3 is about 30 %", gt=0, lt=5
    )

    @property
    def law(self) -> Any:
        """The distribution."""
        return stats.lognorm(self.deviation, scale=self.median)


class Triangular(Continuous):
    """Values between bounds, most of them near a likely one."""

    distribution: Literal["triangular"] = quantity(NONE, "chooses this table")
    low: float = quantity(NONE, "least value")
    likely: float = quantity(NONE, "most likely value")
    high: float = quantity(NONE, "greatest value")

    @property
    def law(self) -> Any:
        """The distribution."""
        span = self.high - self.low
        return stats.triang((self.likely - self.low) / span, self.low, span)

    @property
    def range(self) -> tuple[float, float]:
        """The bounds."""
        return self.low, self.high


class Choice(Parameter):
    """One of some values, all equally likely."""

    distribution: Literal["values"] = quantity(NONE, "chooses this table")
    values: Series | Annotated[tuple[str, ...], Strict(False)] = quantity(
        NONE, "the values, two or more: numbers, or words", min_length=1
    )

    def at(self, share: float) -> Value:
        """Return the value below which a share of all lies, in the order in which they stand.

        Examples
        --------
        >>> words = ("a.asc", "b.asc")
        >>> Choice(name="dem", key="geometry.dem", distribution="values", values=words).at(0.7)
        'b.asc'
        """
        return self.values[min(int(share * len(self.values)), len(self.values) - 1)]


AnyParameter = Annotated[
    Uniform | Normal | LogNormal | Triangular | Choice, Field(discriminator="distribution")
]
