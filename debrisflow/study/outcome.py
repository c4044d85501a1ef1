"""What became of a member: its figures, or why there are none; kept in the folder of its run."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, NonNegativeFloat, ValidationError

from debrisflow.errors import OutputError
from debrisflow.run.atomic import made, replaced
from debrisflow.run.reading import text_of

FILE = "member.json"
FINISHED, FAILED, STOPPED, DAMAGED = "finished", "failed", "stopped", "damaged"
"""States: all results are there; its case or flow cannot be computed; something else stopped it,
as a full disk, so that it is tried again; what it left cannot be read any more."""


class Figure(NamedTuple):
    """An answer of a run: its value, nan where the run gives none, with its unit."""

    value: float
    unit: str


class Outcome(NamedTuple):
    """What became of a member.

    Attributes
    ----------
    state : str
        ``FINISHED``, ``FAILED``, ``STOPPED`` or ``DAMAGED``.
    message : str
        Why it did not finish.
    answers : dict of Figure by name
        As in ``postprocess/answers.csv``.
    seconds : float, s
        Wall time of its computation; of the last part if it was interrupted.
    """

    state: str
    message: str
    answers: dict[str, Figure]
    seconds: float

    @property
    def is_kept(self) -> bool:
        """Whether it would come out the same again."""
        return self.state != STOPPED


class _File(BaseModel):
    """What the file holds."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False)

    state: Literal["finished", "failed"]
    message: str
    answers: dict[str, tuple[float | None, str]]
    seconds: NonNegativeFloat


def write_outcome(folder: Path, outcome: Outcome) -> None:
    """Write what became of a member into the folder of its run.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    answers = {
        name: (one.value if isfinite(one.value) else None, one.unit)
        for name, one in outcome.answers.items()
    }
    content = outcome._asdict() | {"answers": answers}
    with replaced(made(folder) / FILE) as unfinished:
        unfinished.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", "utf-8")


def read_outcome(folder: Path) -> Outcome | None:
    """Return what became of a member; None if it is not yet computed.

    Raises
    ------
    OutputError
        If the file is damaged.
    """
    file = folder / FILE
    if not file.is_file():
        return None
    try:
        found = _File.model_validate_json(text_of(file))
    except (ValidationError, ValueError) as error:
        raise OutputError(
            f"{file} is damaged; delete this file and start the sweep again, which writes it anew"
        ) from error
    answers = {
        name: Figure(float("nan") if value is None else value, unit)
        for name, (value, unit) in found.answers.items()
    }
    return Outcome(found.state, found.message, answers, found.seconds)
