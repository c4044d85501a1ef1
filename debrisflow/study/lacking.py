"""What the members of a study lack: layers of finished runs, quantities that none of them has."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from debrisflow.case.words import did_you_mean
from debrisflow.errors import OutputError
from debrisflow.results.layers import read_layer
from debrisflow.run.names import CASE
from debrisflow.study.maps.grid import TERRAIN
from debrisflow.study.member import shown_values
from debrisflow.study.outcome import DAMAGED, FINISHED
from debrisflow.study.results import Results
from debrisflow.study.tables import Study

MOST_TOLD = 20  # members


def without_damaged(results: Results) -> Results:
    """Return results in which a finished member counts as damaged if files of its run are gone.

    Parameters
    ----------
    results : Results
        Of a case on a terrain; those of others have no layers, and are returned as they are.
    """
    if not results.base.is_terrain:
        return results
    wanted, outcomes = _layers_of(results.study), []
    for member, outcome in zip(results.members, results.outcomes, strict=True):
        fault = _fault(member.folder, wanted) if outcome.state == FINISHED else ""
        if fault:
            message = f"{fault}; delete the folder {member.folder} and start the sweep again"
            outcome = outcome._replace(state=DAMAGED, message=message, answers={})
        outcomes.append(outcome)
    return Results(results.study, results.base, results.members, outcomes)


def damage(results: Results) -> OutputError | None:
    """Return the error that names the damaged members of a study, None if there is none."""
    found = [pair for pair in results.unfinished if pair[1].state == DAMAGED]
    if not found:
        return None
    lines = [
        f"  member {member.number} ({shown_values(member.values)}): {outcome.message}"
        for member, outcome in found[:MOST_TOLD]
    ]
    if len(found) > MOST_TOLD:
        lines.append(f"  and {len(found) - MOST_TOLD} more")
    later = ", and no calibration is made" if results.study.calibration else ""
    head = f"damaged members, {len(found)}, which are left out of figures and maps{later}:"
    return OutputError("\n".join([head, *lines]))


def lacking_quantities(results: Results) -> Iterator[str]:
    """Yield a warning for each quantity of the study that no finished member has."""
    known: dict[str, None] = {}
    for outcome in results.outcomes:
        known |= dict.fromkeys(outcome.answers)
    for wanted in results.study.quantity if results.finished else ():
        if np.isfinite(results.values_of(wanted.called)).any():
            continue
        if wanted.answer is None or wanted.answer in known:
            yield f"no finished member has a value of the quantity '{wanted.called}'"
            continue
        meant = did_you_mean(wanted.answer, known)
        yield (
            f"no run gives the answer '{wanted.answer}' that a quantity asks for"
            f"{meant or '; they give ' + ', '.join(known)}"
        )


def _layers_of(study: Study) -> list[str]:
    """Return the layers that the tables and maps of a study are made of."""
    asked = [one.layer for one in study.quantity if one.layer]
    if study.map:
        asked += [*(one.layer for one in study.map), TERRAIN]
    return list(dict.fromkeys(asked))


def _fault(folder: Path, layers: Sequence[str]) -> str:
    """Return what cannot be read of a run; nothing if all is there."""
    if layers and not (folder / CASE).is_file():
        return f"it has finished, but its {CASE} is gone"
    for name in layers:
        try:
            read_layer(folder, name)
        except OutputError as error:
            return f"it has finished, but its layer '{name}' cannot be read: {error}"
    return ""
