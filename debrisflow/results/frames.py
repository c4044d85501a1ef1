"""The particle files of a run as arrays."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyvista
from numpy.typing import NDArray

from debrisflow.errors import OutputError
from debrisflow.run.measures import is_fluid

Floats = NDArray[np.float64]
WITHOUT_FIELDS = ("time", "position")


class Frame(NamedTuple):
    """The particles of one file; in three dimensions without the walls.

    Attributes
    ----------
    time : float, s
    position, velocity : (n, 3) array, m, m/s
    kind : (n,) int array
        See :class:`debrisflow.particles.record.Kind`.
    pressure : (n,) array, Pa
    density : (n,) array, kg/m3
    number_density, concentration, sediment_fraction : (n,) array
    granular_temperature : (n,) array, m2/s2
    id : (n,) int array
        Number by which a particle is known from frame to frame.
    """

    time: float
    position: Floats
    velocity: Floats
    kind: NDArray[np.integer]
    pressure: Floats
    density: Floats
    number_density: Floats
    concentration: Floats
    sediment_fraction: Floats
    granular_temperature: Floats
    id: NDArray[np.integer]

    @property
    def fluid(self) -> NDArray[np.bool_]:
        """Return which particles flow or may flow: no wall and no waiting supply."""
        return is_fluid(self.kind)

    @property
    def speed(self) -> Floats:
        """Return the magnitude of the velocities, (n,) array, m/s."""
        speed: Floats = np.linalg.norm(self.velocity, axis=1)
        return speed

    def of(self, rows: NDArray[np.bool_]) -> Frame:
        """Return some of the particles."""
        arrays = (name for name in self._fields if name != "time")
        return self._replace(**{name: getattr(self, name)[rows] for name in arrays})


def read_frame(time: float, file: Path) -> Frame:
    """Return the particles of a file.

    Raises
    ------
    OutputError
        If it is missing or damaged.
    """
    _must_be_whole(file)
    try:
        catcher = pyvista.VtkErrorCatcher(raise_errors=True, send_to_logging=False)
        with warnings.catch_warnings(), catcher:
            warnings.simplefilter("ignore")  # pyvista warns of what the catcher raises
            mesh = pyvista.read(file)
        fields = [name for name in Frame._fields if name not in WITHOUT_FIELDS]
        arrays = {name: np.asarray(mesh.point_data[name]) for name in fields}
        return Frame(time, np.asarray(mesh.points), **arrays)
    except (RuntimeError, KeyError, ValueError) as error:
        raise OutputError(f"{file} is damaged: VTK cannot read its arrays") from error


def _must_be_whole(file: Path) -> None:
    # VTK prints its own lines on a file that was cut off, so that is found out before
    if not file.is_file():
        raise OutputError(f"{file} is missing, although the run lists it as one of its frames")
    with file.open("rb") as stream:
        stream.seek(max(0, file.stat().st_size - 64))
        if b"</VTKFile>" not in stream.read():
            raise OutputError(f"{file} is damaged: it is cut off before its end")
