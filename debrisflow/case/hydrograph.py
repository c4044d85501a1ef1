"""Hydrographs: from a CSV file put into the case, so that it stands alone, and checked."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from debrisflow.case.problems import Problem, Problems
from debrisflow.case.releases import Hydrograph
from debrisflow.case.series import UnreadableSeriesError, read_series

KEY = "inflow.hydrograph"


def inline_hydrograph(data: dict[str, object], folder: Path) -> list[Problem]:
    """Replace the name of a hydrograph file by its contents.

    Parameters
    ----------
    data : dict
        The case as read from TOML; changed in place.
    folder : Path
        Folder of the case file, in which the name is looked up.

    Returns
    -------
    list of Problem
        What kept the file from being read; then the name stays where it was.
    """
    inflow = data.get("inflow")
    name = inflow.get("hydrograph") if isinstance(inflow, dict) else None
    if not isinstance(inflow, dict) or not isinstance(name, str):
        return []
    try:
        inflow["hydrograph"] = read_series(folder / name, tuple(Hydrograph.model_fields))
    except OSError as error:
        return [Problem(KEY, f"cannot be read: {(error.strerror or str(error)).lower()}", name)]
    except UnreadableSeriesError as error:
        return [Problem(KEY, str(error), name)]
    return []


def faults_of(graph: Hydrograph, key: str) -> Problems:
    """Yield what is wrong with a hydrograph: it has a value for every time, and times increase.

    Parameters
    ----------
    graph : Hydrograph
    key : str
        Its dotted key in the case.
    """
    for name in ("discharge", "concentration"):
        count = len(getattr(graph, name))
        if count != len(graph.time):
            yield Problem(
                f"{key}.{name}", f"must have a value for each time, {len(graph.time)}, not {count}"
            )
    if not graph.time:
        yield Problem(f"{key}.time", "is empty")
    elif graph.time[0] > 0:
        yield Problem(f"{key}.time.0", "the first time must be 0 or before", graph.time[0])
    for k, (before, after) in enumerate(pairwise(graph.time), start=1):
        if after <= before:
            yield Problem(
                f"{key}.time.{k}", f"must be later than the one before, {before:g} s", after
            )
    for name in ("discharge", "concentration"):
        for k, value in enumerate(getattr(graph, name)):
            if value < 0:
                yield Problem(f"{key}.{name}.{k}", "must be at least 0", value)
