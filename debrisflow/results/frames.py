"""The particle files of a run as arrays."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyvista
from numpy.typing import NDArray

from debrisflow.errors import OutputError
from debrisflow.particles.arrays import ARRAYS
from debrisflow.run.measures import is_fluid

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Frame:
    """The particles of one file; walls only in the form study of two dimensions.

    Each array of the file is an attribute under its name in the file, those of
    :data:`debrisflow.particles.arrays.ARRAYS` among them: ``frame.velocity`` is
    ``frame.arrays["velocity"]``.

    Attributes
    ----------
    time : float, s
    position : (n, 3) array, m
    arrays : dict
        (n,) or (n, 3) array by name.
    """

    time: float
    position: Floats
    arrays: Mapping[str, NDArray[Any]]

    def __getattr__(self, name: str) -> NDArray[Any]:
        """Return an array by its name."""
        # a copy asks for its attributes before it has any
        arrays: Mapping[str, NDArray[Any]] = self.__dict__.get("arrays", {})
        if name in arrays:
            return arrays[name]
        raise AttributeError(f"the particle files hold no {name}, but {', '.join(arrays)}")

    def __dir__(self) -> list[str]:
        """Return the names of all attributes, the arrays among them."""
        return [*super().__dir__(), *self.arrays]

    @property
    def fluid(self) -> NDArray[np.bool_]:
        """Return which particles are fluid: neither walls nor inflow particles."""
        return is_fluid(self.kind)

    @property
    def speed(self) -> Floats:
        """Return the magnitude of the velocities, (n,) array, m/s."""
        return magnitude(self.velocity)

    def of(self, rows: NDArray[np.bool_]) -> Frame:
        """Return some of the particles."""
        arrays = {name: array[rows] for name, array in self.arrays.items()}
        return Frame(self.time, self.position[rows], arrays)


def magnitude(vector: NDArray[Any]) -> Floats:
    """Return the lengths of vectors, (n,) array."""
    length: Floats = np.linalg.norm(vector, axis=1)
    return length


def read_frame(time: float, file: Path) -> Frame:
    """Return the particles of a file.

    Raises
    ------
    OutputError
        If it is missing or damaged.
    """
    mesh = read_mesh(file)
    try:
        needed = [array.name for array in ARRAYS if not array.optional]
        others = [name for name in mesh.point_data if name not in needed]
        arrays = {name: np.asarray(mesh.point_data[name]) for name in (*needed, *others)}
        return Frame(time, np.asarray(mesh.points), arrays)
    except KeyError as error:
        raise OutputError(f"{file} is damaged: VTK cannot read its arrays") from error


def read_mesh(file: Path) -> pyvista.DataSet:
    """Return what a file of VTK holds.

    Raises
    ------
    OutputError
        If it is missing or damaged.
    """
    _must_be_whole(file)
    try:
        catcher = pyvista.VtkErrorCatcher(raise_errors=True, send_to_logging=False)
        with warnings.catch_warnings(), catcher:
            # pyvista also warns about the errors that the catcher raises
            warnings.simplefilter("ignore")
            return pyvista.read(file)
    except (RuntimeError, ValueError) as error:
        raise OutputError(f"{file} is damaged: VTK cannot read its arrays") from error


def _must_be_whole(file: Path) -> None:
    # VTK prints messages of its own about a truncated file, so this is checked first
    if not file.is_file():
        raise OutputError(f"{file} is missing, although the run lists it as one of its frames")
    with file.open("rb") as stream:
        stream.seek(max(0, file.stat().st_size - 64))
        if b"</VTKFile>" not in stream.read():
            raise OutputError(f"{file} is damaged: it is cut off before its end")
