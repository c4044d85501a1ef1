"""The summary of a run, ``summary.json``, read and checked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, NonNegativeFloat, NonNegativeInt, ValidationError

from debrisflow.errors import OutputError
from debrisflow.run.reading import text_of

Counts = dict[str, NonNegativeInt]


class _Summary(BaseModel):
    """What of a summary is read later; more may stand in it."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False, extra="allow")

    title: str | None = None
    end_reason: str | None = None
    time: float | None = None
    steps: NonNegativeInt | None = None
    wall_seconds: NonNegativeFloat | None = None
    compile_seconds: NonNegativeFloat | None = None
    wall_seconds_by_phase: dict[str, NonNegativeFloat] | None = None
    particle_steps_per_second: NonNegativeFloat | None = None
    seconds_per_step: NonNegativeFloat | None = None
    threads: NonNegativeInt | None = None
    threading_layer: str | None = None
    particles: NonNegativeInt | None = None
    entered: Counts | None = None
    left: Counts | None = None
    through_wall: Counts | None = None
    bounced_share: float | None = None
    energy_share: float | None = None
    versions: dict[str, str] | None = None


def checked_summary(file: Path) -> dict[str, Any]:
    """Return the contents of a summary; empty if there is none.

    Raises
    ------
    OutputError
        If the file is damaged, or a value in it is of another kind than a run writes.
    """
    if not file.exists():
        return {}
    try:
        found = json.loads(text_of(file))
        _Summary.model_validate(found)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or "it"
        raise OutputError(f"{file} is damaged: {place:.100}: {first['msg']}") from error
    except RecursionError as error:
        raise OutputError(f"{file} is damaged: it is too deep") from error
    except ValueError as error:
        raise OutputError(f"{file} is damaged: {error}") from error
    summary: dict[str, Any] = {key: value for key, value in found.items() if value is not None}
    return summary
