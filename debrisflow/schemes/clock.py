"""Wall time by phase, of a step and of a run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

from debrisflow._jit import COMPILATIONS


class Clock(dict[str, float]):
    """Seconds of wall time by the name of a phase, without those of compiling kernels.

    A phase inside another one counts for itself alone, so that the phases add up to the time
    that they take together.

    Examples
    --------
    >>> seconds = Clock()
    >>> with seconds.of("motion"):
    ...     pass
    >>> list(seconds)
    ['motion']
    """

    def __init__(self) -> None:
        super().__init__()
        self._inner = 0.0  # of the phases inside the present one
        self._start, self._compiled = perf_counter(), COMPILATIONS.seconds

    @property
    def compile_seconds(self) -> float:
        """Wall time since the start in which kernels were compiled, s."""
        return COMPILATIONS.seconds - self._compiled

    @property
    def seconds(self) -> float:
        """Wall time since the start without that in which kernels were compiled, s."""
        return perf_counter() - self._start - self.compile_seconds

    @contextmanager
    def of(self, phase: str) -> Iterator[None]:
        """Add the time that is spent inside to a phase."""
        before, self._inner = self._inner, 0.0
        start = self.seconds
        try:
            yield
        finally:
            spent = self.seconds - start
            self[phase] = self.get(phase, 0.0) + spent - self._inner
            self._inner = before + spent
