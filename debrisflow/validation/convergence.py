"""How the error falls with the spacing."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import isfinite, log
from typing import NamedTuple

import numpy as np

FEWEST = 3
LEAST_FALL = 0.8
"""Of the finest error to the coarsest, from which on nothing is said to fall."""


class Step(NamedTuple):
    """One level: spacings across, error (a share), processor time, s."""

    label: str
    across: float
    error: float
    seconds: float


class Convergence(NamedTuple):
    """The errors of the levels and what they say.

    Attributes
    ----------
    steps : tuple of Step
        From coarse to fine.
    order : float
        p of ``error ~ spacing^p`` by least squares; nan where there is none.
    """

    steps: tuple[Step, ...]
    order: float

    def in_words(self) -> str:
        """Return the order, or that there is none and why."""
        errors = [step.error for step in self.steps]
        if len(errors) < FEWEST:
            return f"no order: {len(errors)} of the three spacings that it needs were computed"
        if isfinite(self.order):
            return f"observed order {self.order:.1f}"
        if not falls(errors):
            return "no order: the error does not fall with every spacing"
        return (
            "no order: the error hardly falls, so that what is left is not due to the spacing, "
            "but to the model, the reference or the way of measuring"
        )


def falls(errors: Sequence[float]) -> bool:
    """Return whether each error is less than the one before."""
    return all(fine < coarse for coarse, fine in pairwise(errors))


def convergence(steps: Sequence[Step]) -> Convergence:
    """Return the observed order of levels.

    Levels without an error are left out.  There is an order only where the error falls from each
    level to the next, and by a fifth in all.

    Examples
    --------
    >>> steps = [Step("", across, across**-2.0, 1.0) for across in (10, 20, 40)]
    >>> convergence(steps).in_words()
    'observed order 2.0'
    """
    known = sorted((step for step in steps if isfinite(step.error)), key=lambda step: step.across)
    errors = [step.error for step in known]
    order = np.nan
    if len(known) >= FEWEST and falls(errors) and 0.0 < errors[-1] < LEAST_FALL * errors[0]:
        across = [log(step.across) for step in known]
        order = -float(np.polyfit(across, np.log(errors), 1)[0])
    return Convergence(tuple(known), order)
