"""A flow that is computed and compared with an experiment or a closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from math import nan
from typing import NamedTuple

from debrisflow.validation.curves import Panel
from debrisflow.validation.row import Row


class Group(StrEnum):
    """What kind of flow it is, in the order of the page."""

    AT_REST = "At rest"
    VISCOUS = "Viscous flows"
    DAM_BREAKS = "Dam breaks and impact"
    BEDS = "Beds"
    GRANULAR = "Granular flows"
    DEBRIS_FLOWS = "Debris flows"
    FIELD = "Field"


class Level(NamedTuple):
    """How finely a comparison is computed.

    Attributes
    ----------
    across : float
        Particle spacings along the length that matters: a depth, the width of a column.
    label : str
        As "20 rows" or "d0 = 10 mm".
    seconds : float
        Processor time that it takes, about, on one core, without compilation.
    is_quick : bool
        Whether it belongs to the quick set.
    """

    across: float
    label: str
    seconds: float
    is_quick: bool = False


class Measured(NamedTuple):
    """What came out at one level.

    Attributes
    ----------
    rows : tuple of Row
    error : float
        The one by which levels are compared, a share; nan without.
    panels : tuple of Panel
    """

    rows: tuple[Row, ...]
    error: float = nan
    panels: tuple[Panel, ...] = ()


@dataclass(frozen=True)
class Comparison:
    """A flow, its reference, and how to measure it.

    Attributes
    ----------
    name : str
        By which it is asked for.
    title : str
    group : Group
    compared : str
        What is compared with what, and how; a sentence or two.
    reference : str
        Authors, year, DOI; of a closed form its source.
    parameters : str
        Of the computation, those that matter.
    levels : tuple of Level
        From the coarsest on; three where the error has an order, or where it is told that it has
        none.
    measure : callable
        Computes a level.
    calibrated : str
        What was fitted, and to what.
    error : str
        What ``Measured.error`` is; empty without one.
    discussion : str
        What an expert should know: limits of the experiment, traps, why rows are missed.
    """

    name: str
    title: str
    group: Group
    compared: str
    reference: str
    parameters: str
    levels: tuple[Level, ...]
    measure: Callable[[Level], Measured]
    calibrated: str = "nothing"
    error: str = ""
    discussion: str = ""

    def level(self, label: str) -> Level:
        """Return a level by its label.

        Raises
        ------
        KeyError
            If there is none.
        """
        return {level.label: level for level in self.levels}[label]
