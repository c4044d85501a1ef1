"""The particle files of a run as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from debrisflow.errors import OutputError
from debrisflow.particles.arrays import ARRAYS, OutputArray
from debrisflow.particles.record import Kind
from debrisflow.results.vtk_file import read_points
from debrisflow.run.measures import is_fluid

Floats = NDArray[np.float64]
LAST_KIND = max(Kind)


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
        If it is missing or damaged: its arrays cannot be unpacked, one is missing or of another
        kind than the table of them says, or a place is no number.
    """
    found = read_points(file)
    if found.position is None:
        raise OutputError(f"{file} is damaged: it holds no particles")
    arrays: dict[str, NDArray[Any]] = {}
    for array in ARRAYS:
        values = found.arrays.get(array.name)
        if values is None and array.optional:
            continue
        if values is None:
            raise OutputError(f"{file} is damaged: it has no array {array.name}")
        arrays[array.name] = _checked(file, array, values)
    others = {name: values for name, values in found.arrays.items() if name not in arrays}
    position = found.position.astype(np.float64, copy=False)
    if not np.isfinite(position).all():
        raise OutputError(f"{file} is damaged: a particle is nowhere")
    return Frame(time, position, arrays | others)


def _checked(file: Path, array: OutputArray, values: NDArray[Any]) -> NDArray[Any]:
    """Return the values of an array if they are of its kind."""
    components = values.shape[1] if values.ndim > 1 else 1
    kinds = "f" if np.dtype(array.storage).kind == "f" else "iu"
    if components != array.components or values.dtype.kind not in kinds:
        raise OutputError(f"{file} is damaged: its array {array.name} is of another kind")
    if array.name == "kind" and values.size and not 0 <= values.min() <= values.max() <= LAST_KIND:
        raise OutputError(f"{file} is damaged: a particle is of no kind that there is")
    return values
