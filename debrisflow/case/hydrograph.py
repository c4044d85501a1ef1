"""A hydrograph from a CSV file, put into the case as a table so that the case stands alone."""

from __future__ import annotations

from pathlib import Path

from debrisflow.case.problems import Problem
from debrisflow.case.series import UnreadableSeriesError, read_series
from debrisflow.case.tables import Hydrograph

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
