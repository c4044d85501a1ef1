"""How fast this machine computes: measured by each run, kept for the forecasts of later ones."""

from __future__ import annotations

import json
import os
import sys
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from debrisflow.case import ResolvedCase
from debrisflow.errors import OutputError
from debrisflow.run.atomic import replaced
from debrisflow.run.work import COST_OF_A_STEP

FILE = Path("debrisflow") / "rates.json"
SHORTEST = 2.0  # s; a shorter run tells more of its start than of its steps
LAST_RUN, TRIAL = "the last run of this kind here", "a trial of this case"


class Pace(NamedTuple):
    """What was computed in which wall time.

    Attributes
    ----------
    particle_steps : float
        Sum of the fluid particles over the steps.
    steps : float
    seconds : float, s
        Wall time without start-up and compiling.
    threads : int
    source : str
        Where it was measured, in words.
    """

    particle_steps: float
    steps: float
    seconds: float
    threads: int
    source: str = LAST_RUN

    def seconds_for(self, particles: float, steps: float) -> float:
        """Return the wall time, s, of a number of steps with a mean number of fluid particles.

        Examples
        --------
        >>> pace = Pace(particle_steps=1e6, steps=1e3, seconds=2.0, threads=1)
        >>> pace.seconds_for(1000, 5000)
        10.0
        """
        cost = self.particle_steps + COST_OF_A_STEP * self.steps
        return steps * (particles + COST_OF_A_STEP) * self.seconds / cost

    def __str__(self) -> str:
        """Return the rate and where it is from, in words."""
        threads = f"{self.threads} thread" + ("s" if self.threads > 1 else "")
        rate = self.particle_steps / self.seconds
        return f"{rate:.2g} particle-steps/s on {threads}, from {self.source}"


def remember(case: ResolvedCase, pace: Pace) -> None:
    """Keep the pace of a run for later forecasts; where it cannot be written, it is not kept."""
    if pace.seconds < SHORTEST or pace.steps < 1:
        return
    numbers = {name: value for name, value in pace._asdict().items() if name != "source"}
    with suppress(OutputError, OSError, RuntimeError):
        _file().parent.mkdir(parents=True, exist_ok=True)
        with replaced(_file()) as unfinished:
            kept = _kept() | {_kind(case): numbers}
            unfinished.write_text(json.dumps(kept, indent=2) + "\n", encoding="utf-8")


def last_pace(case: ResolvedCase) -> Pace | None:
    """Return the pace of the last run in the dimension and scheme of a case; None without one."""
    known: Any = _kept().get(_kind(case))
    try:
        pace = Pace(
            particle_steps=float(known["particle_steps"]),
            steps=float(known["steps"]),
            seconds=float(known["seconds"]),
            threads=int(known["threads"]),
        )
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    return pace if all(isfinite(number) and number > 0.0 for number in pace[:4]) else None


def _kind(case: ResolvedCase) -> str:
    return f"{case.dimension}D {case.scheme.type} {case.scheme.form}"


def _kept() -> dict[str, Any]:
    """Return what the file holds; nothing where it is missing, unreadable or damaged."""
    try:
        kept = json.loads(_file().read_text(encoding="utf-8"))
    except (OSError, ValueError, RuntimeError):  # the last where there is no home
        return {}
    return kept if isinstance(kept, dict) else {}


def _file() -> Path:
    """Return the file, in the folder that the platform has for what a program keeps."""
    given = Path(os.environ.get("XDG_STATE_HOME", ""))
    if given.is_absolute():
        return given / FILE
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return (Path(local) if local else Path.home() / "AppData" / "Local") / FILE
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / FILE
    return Path.home() / ".local" / "state" / FILE
