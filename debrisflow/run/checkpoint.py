"""Checkpoints: the whole state of a run in one HDF5 file; a resumed run repeats its bits."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Iterator, Mapping
from dataclasses import fields
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from debrisflow.case.content import Content, changes
from debrisflow.errors import OutputError
from debrisflow.particles.layers import Layers
from debrisflow.particles.maxima import Maxima
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run.atomic import flush, replaced
from debrisflow.run.names import CHECKPOINT, CHECKPOINT_BEFORE

LOG = logging.getLogger(__name__)
# the records in a state, by the names of its fields
PARTS: dict[str, type[Any]] = {"particles": Particles, "maxima": Maxima, "layers": Layers}
SUMS = "sums"
ORIGIN = "origin"
CHECKSUM = "sha256"
# what each step, or who reads it, finds anew
NOT_KEPT = {"wall_force", "patches", "patch_force", "escaped"}
NUMBERS = "biuf"  # kinds of arrays: no objects, no references, no text
DEEPEST = 32  # of tables within tables, of a case
GREATEST_COMPRESSION = 1100.0  # of gzip: 1032
FREE = ("time.end", "time.stop_energy", "output.checkpoint_")
"""Starts of the keys that may differ in a run that goes on: what was computed stays the same."""


class Origin(NamedTuple):
    """What a state was computed by, and from.

    Attributes
    ----------
    program : str
        The program and what its machine code comes from.
    processor : str
        For which the machine code was made.
    content : str
        JSON of :func:`debrisflow.case.content.content_of`.
    """

    program: str
    processor: str
    content: str

    def changes(self, now: Origin) -> list[str]:
        """Return what is not as it was, a line each; none if the run can go on to the same bits."""
        found = []
        if now.program != self.program:
            found.append(f"the program: {self.program}, now {now.program}")
        before: Content = json.loads(self.content)
        case = changes(before, json.loads(now.content))
        return found + [line for line in case if not line.startswith(FREE)]


class Checkpoint(NamedTuple):
    """What a file holds."""

    state: State
    origin: Origin


class Checkpoints:
    """The last two checkpoints of a run: if one is damaged there is the other.

    Parameters
    ----------
    folder : Path
        Of the run.
    """

    def __init__(self, folder: Path) -> None:
        self.last, self.before = folder / CHECKPOINT, folder / CHECKPOINT_BEFORE
        self._is_last_sound = True

    def load(self) -> Checkpoint | None:
        """Return the last checkpoint, or the one before if that is damaged; None without any.

        Raises
        ------
        OutputError
            If all that there are are damaged, or hold other fields than a state has now.
        """
        there = [path for path in (self.last, self.before) if path.exists()]
        errors: list[OutputError] = []
        for path in there:
            try:
                found = load(path)
            except OutputError as error:
                errors.append(error)
                self._is_last_sound = self._is_last_sound and path != self.last
                continue
            if errors:
                time = f"{found.state.time:g} s"
                LOG.warning("%s; the run goes on from %s, at t = %s", errors[0], path, time)
            return found
        if errors:
            lines = [*map(str, errors), "to start the run again: debrisflow run CASE --overwrite"]
            raise OutputError("\n".join(lines))
        return None

    def save(self, state: State, origin: Origin) -> None:
        """Write a state; the last checkpoint becomes the one before, which is dropped."""
        with replaced(self.last) as unfinished:
            _write(unfinished, state, origin)
            flush(unfinished)  # there is one on the disk before another is dropped
            if self.last.exists() and self._is_last_sound:
                os.replace(self.last, self.before)
        self._is_last_sound = True


def save(path: Path, state: State, origin: Origin) -> None:
    """Write a state; an earlier checkpoint is replaced when the new one is complete.

    Arrays become data sets and scalars attributes, under the names of the records' fields; records,
    the sums of the probes and the origin become groups.
    The older HDF5 format and gzip make the file readable by VTK.

    Parameters
    ----------
    path : Path
    state : State
    origin : Origin
    """
    with replaced(path) as unfinished:
        _write(unfinished, state, origin)


def load(path: Path) -> Checkpoint:
    """Return what a checkpoint holds.

    Raises
    ------
    OutputError
        If the file is missing, damaged, or holds other fields than a state has now.
    """
    try:
        with h5py.File(path, "r") as file:
            size = path.stat().st_size
            parts = {
                name: part(**_taken(_group(file, name), part, size)) for name, part in PARTS.items()
            }
            group = _group(file, SUMS)
            sums = {name: _array(group, name, size) for name in group}
            state = State(**parts, sums=sums, **_taken(file, State, size))
            kept = dict(_group(file, ORIGIN).attrs)
        origin = Origin(*(str(kept[name]) for name in Origin._fields))
        if kept[CHECKSUM] != _checksum(state, origin):
            raise OutputError(f"{path} is damaged: its contents do not have its checksum")
        _must_be_comparable(origin)
        return Checkpoint(state, origin)
    except FileNotFoundError as error:
        raise OutputError(f"there is no checkpoint {path}") from error
    except KeyError as error:
        raise OutputError(
            f"{path} was written by another version of debrisflow and cannot be continued: "
            f"{error.args[0]}; start the run again with: debrisflow run"
        ) from error
    except (OSError, ValueError, TypeError, AttributeError, RuntimeError, MemoryError) as error:
        raise OutputError(f"{path} is damaged: {error}") from error


def _must_be_comparable(origin: Origin) -> None:
    """Check that what a state was computed from can be compared with a case."""
    content = json.loads(origin.content)
    if not _is_shallow(content, DEEPEST):
        raise ValueError("its origin is nested too deep")
    changes(content, {})


def _is_shallow(part: Any, depth: int) -> bool:
    parts = part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()
    return depth > 0 and all(_is_shallow(one, depth - 1) for one in parts)


def _write(path: Path, state: State, origin: Origin) -> None:
    """Write a file as a whole: HDF5 is not quiet about files that did not fit on the disk."""
    content = BytesIO()
    with h5py.File(content, "w", libver=("earliest", "v110")) as file:
        _put(file, state)
        kept = file.create_group(ORIGIN)
        kept.attrs.update(origin._asdict() | {CHECKSUM: _checksum(state, origin)})
    path.write_bytes(content.getbuffer())


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


def _checksum(state: State, origin: Origin) -> str:
    """Return the SHA-256 of all that a checkpoint holds, whatever order and form the file has."""
    sha = sha256(json.dumps(origin).encode())
    for name, value in sorted(_values(state, "")):
        array = np.asarray(value)
        sha.update(f"{name} {array.dtype} {array.shape}".encode())
        sha.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)
    return sha.hexdigest()


def _values(record: Any, place: str) -> Iterator[tuple[str, Any]]:
    """Yield the arrays and scalars of a record with their names."""
    for field in fields(record):
        value, name = getattr(record, field.name), f"{place}{field.name}"
        if field.name in NOT_KEPT:
            continue
        if field.name in PARTS:
            yield from _values(value, f"{name}/")
        elif field.name == SUMS:
            yield from ((f"{name}/{key}", array) for key, array in value.items())
        else:
            yield name, value


def _group(file: h5py.File, name: str) -> h5py.Group:
    if name not in file:
        raise KeyError(f"it lacks {name}")
    _check_link(file, name)
    if not isinstance(file[name], h5py.Group):
        raise OSError(f"{name} is no group")
    return file[name]


def _taken(group: h5py.Group, record: type[Any], size: int) -> dict[str, Any]:
    """Return the arrays and scalars of a group; a missing one is an error, never a default."""
    held = {name for name in group if name not in PARTS.keys() | {SUMS, ORIGIN}}
    known = held | set(group.attrs)
    expected = {field.name for field in fields(record)} - PARTS.keys() - {SUMS} - NOT_KEPT
    for names, word in ((expected - known, "lacks"), (known - expected, "has")):
        if names:
            raise KeyError(f"it {word} {', '.join(sorted(names))}")
    scalars = {name: _scalar(name, value) for name, value in group.attrs.items()}
    return scalars | {name: _array(group, name, size) for name in held}


def _scalar(name: str, value: Any) -> Any:
    if not isinstance(value, np.generic) or value.dtype.kind not in NUMBERS:
        raise OSError(f"{name} is no number")
    return value.item()


def _array(group: h5py.Group, name: str, size: int) -> np.ndarray[Any, Any]:
    """Return an array that lies in the file itself, and that a file of a size can hold.

    A file from others may refer to other files, or claim more numbers than there is memory for.
    """
    _check_link(group, name)
    data = group[name]
    if not isinstance(data, h5py.Dataset) or data.dtype.kind not in NUMBERS:
        raise OSError(f"{name} is no array of numbers")
    if data.is_virtual or data.external or data.maxshape != data.shape:
        raise OSError(f"{name} does not lie in the file")
    if h5py.h5o.get_info(data.id).rc != 1:
        raise OSError(f"{name} has several names, so that it would be read several times")
    if data.nbytes > GREATEST_COMPRESSION * min(size, data.id.get_storage_size()):
        raise OSError(f"{name} is larger than the file can hold")
    return np.asarray(data[()])


def _check_link(group: h5py.Group, name: str) -> None:
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise OSError(f"{name} refers to something else")


def check_fits(state: State, start: State) -> None:
    """Check that a state can be one of the case whose state at the start is given.

    Kernels trust the sizes of arrays, so that a state of another case would be read beyond them.

    Raises
    ------
    OutputError
    """
    held, wanted = state.particles, start.particles
    groups = held.fluid_count, held.inflow_count, held.wall_count
    numbers = {held.count}
    if wanted.count == 0:  # as long as arrays that the particles of this case do not have
        numbers.add(0)
    wrong = [
        *_misfits(held, wanted, rows={wanted.count: numbers}),
        *_misfits(state.maxima, start.maxima),
        *_misfits(state.layers, start.layers),
        *_misfits(state, start),
    ]
    if min(groups) < 0 or sum(groups) > held.count:
        wrong.append("groups of particles")
    if not np.all(np.isfinite(held.position)):
        wrong.append("position")
    if wrong:
        raise OutputError(
            f"the checkpoint does not fit the case: {', '.join(wrong)}; "
            "start the run again with: debrisflow run"
        )


def _misfits(held: Any, wanted: Any, rows: Mapping[int, set[int]] | None = None) -> Iterator[str]:
    """Yield the names of arrays of a record whose types or shapes are not those of another one.

    Parameters
    ----------
    held, wanted : records of the same type
    rows : mapping of int to set of int, optional
        The numbers of rows that may be held where another one is wanted: of all particles.
    """
    for field in fields(wanted):
        one, other = getattr(held, field.name), getattr(wanted, field.name)
        if not isinstance(other, np.ndarray) or field.name in NOT_KEPT:
            continue
        numbers = (rows or {}).get(len(other), {len(other)})
        shapes = {(number, *other.shape[1:]) for number in numbers}
        if not isinstance(one, np.ndarray) or one.dtype != other.dtype or one.shape not in shapes:
            yield field.name
