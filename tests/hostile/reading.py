"""The commands that read a run folder, as functions, and the files that they read."""

from contextlib import nullcontext
from pathlib import Path
from unittest.mock import patch

from debrisflow.case.probes.grid import GridProbe
from debrisflow.results import open_run
from debrisflow.results.hazard import hazard_map
from debrisflow.results.hazard_classes import read_classes
from debrisflow.results.report import report
from debrisflow.results.survey import survey_of
from debrisflow.results.terrain_report import terrain_report
from debrisflow.results.terrain_survey import TerrainSurvey
from debrisflow.run.checkpoint import load

DRAW = "debrisflow.results.postprocess.draw"
UNREAD = {".vtp", ".png", ".html", ".lock", ".geojson", ".gpkg"}  # written for other programs


def files_read(folder: Path) -> list[Path]:
    """Return the files of a run that are read, in a fixed order, one of those with numbers."""
    found = sorted(file for file in folder.rglob("*") if file.is_file())
    read = [file for file in found if file.suffix not in UNREAD and not _is_unread(file)]
    return [file for file in read if not file.stem.isdecimal() or int(file.stem) == 1]


def _is_unread(file: Path) -> bool:
    """Return whether a file is a style of a layer, for GIS programs, or a table of a report."""
    of_classes = file.name.startswith("class_")
    return (file.suffix == ".qml" or file.parent.name == "postprocess") and not of_classes


def kind_of(file: Path) -> str:
    """Return the kind of a file, as the figures are told apart by."""
    if file.suffix == ".csv" and file.parent.name in ("probes", "layers", "postprocess"):
        return f"{file.parent.name}/*.csv"
    if file.suffix == ".pvd" and file.parent.name == "probes":
        return "probes/*.pvd"
    return file.name if file.suffix in (".toml", ".json", ".csv", ".pvd") else f"*{file.suffix}"


def read_all(folder: Path, draws: bool = False) -> None:
    """Make the report of a run, with plots on request, and read what no report reads.

    Raises
    ------
    DebrisflowError
        What the commands say of a damaged folder.
    """
    with nullcontext() if draws else patch(DRAW, return_value=[]):
        run = open_run(folder)
        found = survey_of(run)
        if isinstance(found, TerrainSurvey):
            terrain_report(found)
            hazard_map(folder, read_classes("swiss"))
        else:
            report(found)
            _ = run.deposit
            run.surface()
    for probe in run.case.probe:
        if isinstance(probe, GridProbe):
            run.grid(probe.name)
        else:
            run.probe(probe.name)


def read_checkpoint(folder: Path) -> None:
    """Load the checkpoint of a run."""
    load(folder / "checkpoint.h5")
