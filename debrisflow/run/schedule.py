"""Times at which an output is due."""

from __future__ import annotations

import math


class Schedule:
    """Times at which an output is due: the start, the whole multiples of an interval, the end.

    The times are multiples, not sums, and therefore do not drift.  A multiple that differs from the
    start or the end by rounding only is not a time of its own.

    Parameters
    ----------
    interval, start, end : float
        In s.

    Examples
    --------
    >>> schedule = Schedule(0.1, -0.15, 0.3)
    >>> schedule.next_after(-0.15), schedule.next_after(0.1), schedule.next_after(0.2)
    (-0.1, 0.2, 0.3)
    >>> schedule.is_due(-0.15), schedule.is_due(0.25), schedule.next_after(0.3)
    (True, False, inf)
    """

    def __init__(self, interval: float, start: float, end: float) -> None:
        self.interval, self.start, self.end = interval, start, end
        self._rounding = 1e-9 * interval

    def next_after(self, time: float) -> float:
        """Return the first due time later than a time, s; infinity from the end on."""
        if time < self.start - self._rounding:
            return self.start
        if time >= self.end - self._rounding:
            return math.inf
        multiple = (math.floor((time + self._rounding) / self.interval) + 1) * self.interval
        return multiple if multiple < self.end - self._rounding else self.end

    def is_due(self, time: float) -> bool:
        """Return whether a time, s, is a due time."""
        return abs(self.next_after(time - 2.0 * self._rounding) - time) <= self._rounding

    def passed_due(self, before: float, time: float) -> bool:
        """Return whether there is a due time after ``before``, s, and not after ``time``, s."""
        return self.next_after(before) <= time + self._rounding
