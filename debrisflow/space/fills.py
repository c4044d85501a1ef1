"""The lattice points of fills, and the section of the supply (NumPy only)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, shapes, tables
from debrisflow.case.bodies import MeshFill
from debrisflow.case.regions import extent_across, recess, surface_of
from debrisflow.case.triangles import cells_inside
from debrisflow.errors import CaseError
from debrisflow.space.domain import cells_along

Floats = NDArray[np.float64]


def fill(block: tables.AnyFill, case: ResolvedCase) -> Floats:
    """Return the lattice points inside a fill as (n, 3) positions, m."""
    d0 = case.particles.spacing
    if isinstance(block, MeshFill):
        return (cells_inside(surface_of(block), d0).astype(float) + 0.5) * d0
    if isinstance(block, tables.Block):
        extents = [block.x, block.y, block.z][: case.dimension]
    else:
        hollow = recess(case.geometry, case.particles)
        if hollow is None:
            raise CaseError("fill: a bed needs a recess, a bed_thickness greater than 0")
        extents = list(zip(hollow.lower, hollow.upper, strict=True))
    ends = [(cells_along(e[0], d0), cells_along(e[1], d0)) for e in extents if e is not None]
    axes = [np.arange(*end) + 0.5 for end in ends]
    position = np.zeros((int(np.prod([axis.size for axis in axes])), 3))
    for k, points in enumerate(np.meshgrid(*axes, indexing="ij")):
        position[:, k] = points.ravel() * d0
    return position


class Opening(NamedTuple):
    """The cells of the section through which the supply enters.

    Attributes
    ----------
    first : int
        First cell across the channel.
    wide, high : int
        Number of cells across, 1 in two dimensions, and upward.
    """

    first: int
    wide: int
    high: int


def inflow_section(case: ResolvedCase) -> Opening:
    """Return the section of the supply, which stands on the floor; no cells without a supply."""
    if case.inflow is None:
        return Opening(first=0, wide=0, high=0)
    d0 = case.particles.spacing
    high = max(1, cells_along(case.inflow.depth, d0))
    if not isinstance(case.geometry, shapes.Channel3D):
        return Opening(first=0, wide=1, high=high)
    first, last = (cells_along(y, d0) for y in extent_across(case.inflow, case.geometry))
    return Opening(first=first, wide=last - first, high=high)
