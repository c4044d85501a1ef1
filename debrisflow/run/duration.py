"""Times as people say them."""

from __future__ import annotations


def duration(seconds: float) -> str:
    """Return a time as people say it.

    Examples
    --------
    >>> [duration(s) for s in (0.4, 49.0, 200.0, 9000.0, 1.0e6)]
    ['1 s', '49 s', '3.3 min', '2.5 h', '12 days']
    """
    for unit, length, most in (("s", 1.0, 90.0), ("min", 60.0, 90.0), ("h", 3600.0, 48.0)):
        number = seconds / length
        if number < most:
            return (
                f"{number:.1f} {unit}"
                if unit != "s" and number < 10
                else f"{max(number, 1.0):.0f} {unit}"
            )
    return f"{seconds / 86400.0:.0f} days"
