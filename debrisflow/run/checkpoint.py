"""Checkpoints: the whole state of a run in one HDF5 file; a resumed run repeats its bits."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from debrisflow.errors import OutputError
from debrisflow.particles.layers import Layers
from debrisflow.particles.maxima import Maxima
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.atomic import replaced

# the records in a state, by the names of its fields
PARTS: dict[str, type[Any]] = {"particles": Particles, "maxima": Maxima, "layers": Layers}
SUMS = "sums"
NOT_KEPT = {"wall_force", "patches", "patch_force"}  # what each step, or who reads it, finds anew


def save(path: Path, state: State) -> None:
    """Write a state; an earlier checkpoint is replaced when the new one is complete.

    Arrays become data sets and scalars attributes, under the names of the records' fields; records
    and the sums of the probes become groups.
    The older HDF5 format and gzip make the file readable by VTK.

    Parameters
    ----------
    path : Path
    state : State
    """
    with (
        replaced(path) as unfinished,
        h5py.File(unfinished, "w", libver=("earliest", "v110")) as file,
    ):
        _put(file, state)


def load(path: Path) -> State:
    """Return the state that a checkpoint holds.

    Raises
    ------
    OutputError
        If the file is missing, damaged, or holds other fields than a state has now.
    """
    try:
        with h5py.File(path, "r") as file:
            parts = {name: part(**_taken(_group(file, name), part)) for name, part in PARTS.items()}
            sums = {name: array[()] for name, array in _group(file, SUMS).items()}
            return State(**parts, sums=sums, **_taken(file, State))
    except FileNotFoundError as error:
        raise OutputError(f"there is no checkpoint {path}") from error
    except KeyError as error:
        raise OutputError(
            f"{path} was written by another version of debrisflow and cannot be continued: "
            f"{error.args[0]}; start the run again with: debrisflow run"
        ) from error
    except OSError as error:
        raise OutputError(f"{path} is damaged: {error}") from error


def _put(group: h5py.Group, record: State | Particles | Maxima | Layers) -> None:
    for field in fields(record):
        if field.name in NOT_KEPT:
            continue
        value = getattr(record, field.name)
        if field.name in PARTS:
            _put(group.create_group(field.name), value)
        elif field.name == SUMS:
            sums = group.create_group(SUMS)
            for name, array in value.items():
                sums.create_dataset(name, data=array)
        elif isinstance(value, np.ndarray):
            group.create_dataset(field.name, data=value, compression="gzip")
        else:
            group.attrs[field.name] = value


def _group(file: h5py.File, name: str) -> h5py.Group:
    if name not in file:
        raise KeyError(f"it lacks {name}")
    return file[name]


def _taken(group: h5py.Group, record: type[Any]) -> dict[str, Any]:
    """Return the arrays and scalars of a group; a missing one is an error, never a default."""
    arrays = {name: item[()] for name, item in group.items() if isinstance(item, h5py.Dataset)}
    found = arrays | {name: value.item() for name, value in group.attrs.items()}
    expected = {field.name for field in fields(record)} - PARTS.keys() - {SUMS} - NOT_KEPT
    for names, word in ((expected - found.keys(), "lacks"), (found.keys() - expected, "has")):
        if names:
            raise KeyError(f"it {word} {', '.join(sorted(names))}")
    return found
