"""A figure that is measured, what it is held to, and the verdict."""

from __future__ import annotations

from enum import StrEnum
from math import inf, isfinite, nan
from typing import Any, NamedTuple

PERCENT = "%"
"""Unit of a share, which is stored as such and shown times 100."""


class Verdict(StrEnum):
    """What is said of a row."""

    WITHIN = "within"
    KNOWN = "missed"
    MISSED = "missed, unexpected"
    STATED = "stated"


class Row(NamedTuple):
    """One measured figure.

    Attributes
    ----------
    measure : str
        What was measured, as "rms of the front".
    value : float
        In ``unit``; of ``%`` the share.
    unit : str
    low, high : float
        The limits; infinite where there is none.
    expected : float
        What the reference has; nan where the value is itself a distance from it.
    reason : str
        Of the limits: the scatter of the experiment, another code's error, the resolution.
    miss : str
        Why the limits are missed, as far as it is known, and what was tried; empty if they are
        expected to be held.
    worst : float
        How far outside the limits ``miss`` speaks of, in the unit of the value and on the side that
        is missed; what is farther out, or on the other side, is not expected.
    is_certain : bool
        Whether the miss is one on every processor; chaos decides elsewhere.
    is_conserved : bool
        Whether it says that nothing was lost or made, and is no distance from a reference; such
        rows are counted apart.
    """

    measure: str
    value: float
    unit: str = ""
    low: float = -inf
    high: float = inf
    expected: float = nan
    reason: str = ""
    miss: str = ""
    worst: float = nan
    is_certain: bool = True
    is_conserved: bool = False

    @property
    def is_within(self) -> bool:
        """Whether the value is within its limits; one that is not finite is not."""
        return isfinite(self.value) and self.low <= self.value <= self.high

    @property
    def has_limit(self) -> bool:
        """Whether the row is held to anything."""
        return isfinite(self.low) or isfinite(self.high)

    @property
    def verdict(self) -> Verdict:
        """What is said of the row.

        Examples
        --------
        >>> at_most("rms of the front", 0.113, 0.10, "two experiments", "%").verdict.value
        'missed, unexpected'
        """
        if not self.has_limit:
            return Verdict.STATED
        if self.is_within:
            return Verdict.WITHIN
        is_expected = self.high < self.value <= self.worst or self.worst <= self.value < self.low
        return Verdict.KNOWN if self.miss and is_expected else Verdict.MISSED

    def shown_value(self) -> str:
        """Return the value with its unit, and the one of the reference.

        Examples
        --------
        >>> near("arrival", 0.384, 0.402, "reading", margin=0.05, unit="s").shown_value()
        '0.384 s (0.402 s)'
        """
        known = f" ({shown(self.expected, self.unit)})" if isfinite(self.expected) else ""
        return shown(self.value, self.unit) + known

    def shown_limit(self) -> str:
        """Return the limits in words.

        Examples
        --------
        >>> at_most("rms of the front", 0.026, 0.04, "two experiments", "%").shown_limit()
        'at most 4 %'
        """
        low, high = shown(self.low, self.unit), shown(self.high, self.unit)
        if not self.has_limit:
            return ""
        if not isfinite(self.low):
            return f"at most {high}"
        if not isfinite(self.high):
            return f"at least {low}"
        return low if low == high else f"{shown(self.low, self.unit, False)} to {high}"


def shown(value: float, unit: str = "", with_unit: bool = True) -> str:
    """Return a value of three digits with its unit.

    Examples
    --------
    >>> shown(0.02604, "%"), shown(1234.0, "m3"), shown(0.0, "mm")
    ('2.6 %', '1,230 m3', '0 mm')
    """
    if not isfinite(value):
        text = "none" if value != value else str(value)
    else:
        text = _digits(100.0 * value if unit == PERCENT else value)
    return f"{text} {unit}" if unit and with_unit else text


def _digits(value: float) -> str:
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.0f}" if abs(rounded) >= 1000.0 else f"{rounded:g}"


def at_most(
    measure: str, value: float, most: float, reason: str, unit: str = "", **known: Any
) -> Row:
    """Return the row of an error, or of what must not be more.

    Parameters
    ----------
    measure, unit, reason : str
        As of :class:`Row`.
    value, most : float
    known
        ``expected``, ``miss``, ``worst`` and ``is_certain`` of :class:`Row`.
    """
    return Row(measure, float(value), unit, high=most, reason=reason, **known)


def at_least(
    measure: str, value: float, least: float, reason: str, unit: str = "", **known: Any
) -> Row:
    """Return the row of what must not be less; parameters as of :func:`at_most`."""
    return Row(measure, float(value), unit, low=least, reason=reason, **known)


def between(
    measure: str, value: float, low: float, high: float, reason: str, unit: str = "", **known: Any
) -> Row:
    """Return the row of what lies between two limits; parameters as of :func:`at_most`."""
    return Row(measure, float(value), unit, low, high, reason=reason, **known)


def near(
    measure: str,
    value: float,
    expected: float,
    reason: str,
    *,
    share: float = 0.0,
    margin: float = 0.0,
    unit: str = "",
    **known: Any,
) -> Row:
    """Return the row of what the reference has too.

    Parameters
    ----------
    measure, unit, reason : str
        As of :class:`Row`.
    value, expected : float
    share, margin : float
        By which it may differ: as a share of what is expected, or in the unit.
    known
        ``miss``, ``worst`` and ``is_certain`` of :class:`Row`.
    """
    off = margin + share * abs(expected)
    bounds = (float(expected) - off, float(expected) + off)
    return Row(measure, float(value), unit, *bounds, float(expected), reason, **known)


def conserved(measure: str, value: float, most: float, reason: str, unit: str = "") -> Row:
    """Return the row of what is lost or made, which exact conservation would not let happen."""
    return Row(measure, float(value), unit, high=most, reason=reason, is_conserved=True)


def energy_gained(greatest: float, most: float = 0.005, where: str = "") -> Row:
    """Return the row of the greatest energy of a closed flow, over that of its start."""
    measure = f"{where}energy gained at most / that of the start"
    reason = "nothing supplies energy; what is left to it is the error of a finite step"
    return conserved(measure, greatest - 1.0, most, reason, "%")


def none_of(measure: str, count: float, reason: str = "exact") -> Row:
    """Return the row of what must not happen at all, as particles that are lost."""
    return Row(measure, float(count), "", 0.0, 0.0, reason=reason, is_conserved=True)


def stated(measure: str, value: float, unit: str = "", expected: float = nan) -> Row:
    """Return the row of a figure that is held to nothing."""
    return Row(measure, float(value), unit, expected=float(expected))
