"""Wall time by phase of a step."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

from debrisflow._jit import COMPILATIONS


class Clock(dict[str, float]):
    """Seconds of wall time by the name of a phase.

    Examples
    --------
    >>> seconds = Clock()
    >>> with seconds.of("motion"):
    ...     pass
    >>> list(seconds)
    ['motion']
    """

    @contextmanager
    def of(self, phase: str) -> Iterator[None]:
        """Add the time that is spent inside to a phase, without that of compiling kernels."""
        start = perf_counter() - COMPILATIONS.seconds
        try:
            yield
        finally:
            self[phase] = self.get(phase, 0.0) + perf_counter() - COMPILATIONS.seconds - start
