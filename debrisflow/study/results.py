"""The results of a study as tables: members by quantities, layers by members."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.run.layers import LAYERS
from debrisflow.study.member import Member
from debrisflow.study.outcome import FINISHED, Figure, Outcome
from debrisflow.study.quantities import quantities_of
from debrisflow.study.tables import Study

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]


class Results:
    """What the members of a study gave.

    Parameters
    ----------
    study : Study
    base : ResolvedCase
        That all members start from.
    members : sequence of Member
    outcomes : sequence of Outcome
        Of each member.

    Attributes
    ----------
    study, base, members, outcomes
    """

    def __init__(
        self,
        study: Study,
        base: ResolvedCase,
        members: Sequence[Member],
        outcomes: Sequence[Outcome],
    ) -> None:
        self.study, self.base = study, base
        self.members, self.outcomes = list(members), list(outcomes)

    @property
    def finished(self) -> list[Member]:
        """The members that have all results."""
        return [
            one
            for one, outcome in zip(self.members, self.outcomes, strict=True)
            if outcome.state == FINISHED
        ]

    @property
    def unfinished(self) -> list[tuple[Member, Outcome]]:
        """The members that have no results, and why."""
        pairs = zip(self.members, self.outcomes, strict=True)
        return [(one, outcome) for one, outcome in pairs if outcome.state != FINISHED]

    @property
    def folders(self) -> list[Path]:
        """The folders of the finished members."""
        return [one.folder for one in self.finished]

    @cached_property
    def figures(self) -> list[dict[str, Figure]]:
        """The quantities of each member by name; empty for one without results."""
        return [
            quantities_of(self.study, one.folder, outcome) if outcome.state == FINISHED else {}
            for one, outcome in zip(self.members, self.outcomes, strict=True)
        ]

    @cached_property
    def units(self) -> dict[str, str]:
        """The quantities with their units, in the order in which they are shown."""
        found: dict[str, str] = {}
        for row in self.figures:
            for name, figure in row.items():
                found[name] = found.get(name) or figure.unit
        return found

    def values_of(self, quantity: str) -> Floats:
        """Return a quantity of all members, (members,) array; nan where there is none."""
        missing = Figure(np.nan, "")
        return np.array([row.get(quantity, missing).value for row in self.figures])

    @property
    def table(self) -> xarray.Dataset:
        """The members by their values and quantities, each with its unit as ``units``."""
        import xarray

        inputs = {
            one.name: ("member", np.array([member.values[one.name] for member in self.members]))
            for one in self.study.parameter
        }
        found = {
            name: ("member", self.values_of(name), {"units": unit})
            for name, unit in self.units.items()
        }
        states = ("member", np.array([outcome.state for outcome in self.outcomes]))
        numbers = [one.number for one in self.members]
        return xarray.Dataset(inputs | found | {"state": states}, coords={"member": numbers})

    def layer(self, name: str) -> xarray.DataArray:
        """Return a layer of all finished members, read when it is computed.

        Parameters
        ----------
        name : str
            Of :data:`debrisflow.run.layers.LAYERS`.

        Returns
        -------
        xarray.DataArray
            Over ``member``, ``y`` from north to south and ``x``, m, on the grid of the maps; 0
            where nothing flowed, inf of the arrival.

        Raises
        ------
        OutputError
            If no member is finished.
        """
        import dask.array
        import xarray
        from dask.delayed import delayed

        from debrisflow.results.flow_path import centers
        from debrisflow.study.maps.grid import grid_of, layer_on

        grid = grid_of(self.base, self.study.area)
        parts = [
            dask.array.from_delayed(delayed(layer_on)(folder, grid, name), grid.shape, float)
            for folder in self.folders
        ]
        x, y = centers(grid)
        numbers = [one.number for one in self.finished]
        coords = {"member": numbers, "y": y, "x": x}
        unit = {"units": LAYERS[name].unit}
        return xarray.DataArray(dask.array.stack(parts), coords, ("member", "y", "x"), name, unit)
