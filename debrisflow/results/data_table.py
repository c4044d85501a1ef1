"""A table of a run with its units: columns as arrays, and on request as pandas or xarray."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from debrisflow.errors import OutputError
from debrisflow.run.tables import Table

if TYPE_CHECKING:
    import pandas
    import xarray

PLACES = ("x", "y", "z")


class MissingColumnError(OutputError, KeyError):
    """A table has no column of the name that was asked for."""


class DataTable(dict[str, NDArray[np.float64]]):
    """The columns of a table by their names, each an (rows,) float64 array.

    Parameters
    ----------
    columns : dict of str to array
    units : dict of str to str
        By the names of the columns; one that is not named is a number without a unit.

    Attributes
    ----------
    units : dict of str to str
        Of each column; empty for a number without a unit.

    Examples
    --------
    >>> table = DataTable({"time": np.array([0.0, 0.1]), "steps": np.array([0, 7])}, {"time": "s"})
    >>> table["time"], table.units
    (array([0. , 0.1]), {'time': 's', 'steps': ''})
    """

    def __init__(self, columns: Table, units: Mapping[str, str]) -> None:
        super().__init__(columns)
        self.units = {name: units.get(name, "") for name in columns}

    def __missing__(self, name: str) -> NDArray[np.float64]:
        """Say that there is no column of a name: the file that was read may lack it."""
        raise MissingColumnError(f"no column {name} is in the table, but {', '.join(self)}")

    @property
    def index(self) -> tuple[str, ...]:
        """The columns that tell the rows apart: time, or place, or both."""
        places = tuple(name for name in PLACES if name in self)
        if "time" not in self:
            return places
        repeats = np.unique(self["time"]).size < self["time"].size
        return ("time", *places) if repeats else ("time",)

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a data frame, whose index is :attr:`index`.

        Its ``attrs["units"]`` are the units by column.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        frame = _imported("pandas", "to_pandas").DataFrame(dict(self)).set_index(list(self.index))
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Return the table as a data set, whose dimensions are :attr:`index`.

        Each variable and coordinate has its unit as the attribute ``units``.  A place and time
        without a row holds nan.

        Raises
        ------
        ImportError
            If xarray is not installed.
        """
        data = _imported("xarray", "to_xarray").Dataset.from_dataframe(self.to_pandas())
        for name, unit in self.units.items():
            data[name].attrs["units"] = unit
        return data


def _imported(package: str, asked_by: str) -> Any:
    """Return a package that is no requirement of this one."""
    try:
        return import_module(package)
    except ImportError as error:
        raise ImportError(
            f"{asked_by} needs {package}, which is not installed; "
            f"install it with: pip install {package}"
        ) from error
