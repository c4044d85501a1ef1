"""What a sweep would compute: members, hours and disk space, before it starts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil
from typing import Any

from debrisflow.case.memory import size
from debrisflow.run.duration import duration
from debrisflow.run.forecast import forecast
from debrisflow.run.pace import last_pace
from debrisflow.study.outcome import read_outcome
from debrisflow.study.sweep import Sweep


def plan_figures(sweep: Sweep, workers: int) -> dict[str, Any]:
    """Return how many members there are and what they need.

    Parameters
    ----------
    sweep : Sweep
    workers : int
        That there are; no more are used than members are left.

    Returns
    -------
    dict
        ``members``, ``known``: how many are computed already, ``further``: runs of a calibration
        beyond the design; ``workers``; ``seconds``: wall time of a member, from those that are
        computed or the pace of the last run of this kind here, None where there is neither;
        ``wall_seconds``, of all that is left; ``memory``, of all workers, and ``disk``, bytes.
    """
    known = {}
    for member in sweep.members:
        outcome = read_outcome(member.folder)
        if outcome is not None:
            known[member.digest] = outcome.seconds
    left = len({one.digest for one in sweep.members} - known.keys())
    calibration = sweep.study.calibration
    further = (
        max(calibration.runs - len(sweep.members), 0) + calibration.predictive if calibration else 0
    )
    base = forecast(sweep.cases.base, last_pace(sweep.cases.base))
    count = max(min(workers, sweep.most_at_once), 1)
    expected = base.wall_time[1] if base.wall_time else None
    seconds = sum(known.values()) / len(known) if known else expected
    return {
        "title": sweep.study.title,
        "members": len(sweep.members),
        "known": len(sweep.members) - left,
        "further": further,
        "workers": count,
        "seconds": seconds,
        "wall_seconds": None if seconds is None else seconds * ceil((left + further) / count),
        "memory": base.memory * count,
        "disk": base.disk * (left + further),
    }


def plan_lines(found: Mapping[str, Any]) -> Iterator[str]:
    """Yield what :func:`plan_figures` returned as lines."""
    yield found["title"]
    known = f", of which {found['known']} are computed already" if found["known"] else ""
    yield f"{'members':<12}{found['members']}{known}"
    if found["further"]:
        yield f"{'further':<12}up to {found['further']} runs of the calibration"
    if found["seconds"] is None:
        yield f"{'wall time':<12}unknown: nothing of this kind has run here yet"
    else:
        yield (
            f"{'wall time':<12}{duration(found['wall_seconds'])}, {found['workers']} at a time, "
            f"{duration(found['seconds'])} each"
        )
    yield f"{'memory':<12}{size(found['memory'])}"
    yield f"{'disk':<12}{size(found['disk'])}"
