"""What a run folder tells: numbers, plots, pictures and pages from it, and never from a solver."""

from debrisflow.results.reader import Run, open_run

__all__ = ["Run", "open_run"]
