"""What the maps of a study cannot show of its case."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.case.words import format_extent
from debrisflow.errors import CaseError
from debrisflow.study.map_grid import grid_of
from debrisflow.study.quantities import cell_of
from debrisflow.study.tables import MapArea, Study


def expect_on_map(study: Study, case: ResolvedCase) -> None:
    """Refuse maps of a case without a map, and places beside it.

    Raises
    ------
    CaseError
    """
    if study.map:
        grid_of(case, study.area)
    for number, wanted in enumerate(study.quantity):
        if wanted.layer is None or wanted.at is None:
            continue
        own = grid_of(case, MapArea())
        if cell_of(own, wanted.at) is None:
            raise CaseError(
                f"quantity.{number}.at = [{wanted.at[0]:g}, {wanted.at[1]:g}] m: outside the map "
                f"of the case, {format_extent((own.west, own.south, own.east, own.north))}"
            )


def expect_told_apart(study: Study, case: ResolvedCase) -> None:
    """Refuse thresholds of the peak depth that the layers of a case cannot tell from dry.

    Raises
    ------
    CaseError
    """
    least = case.output.layer_depth
    for number, wanted in enumerate(study.map):
        low = [threshold for threshold in wanted.exceeds if threshold < least]
        if wanted.layer == "peak_depth" and low:
            raise CaseError(
                f"map.{number}.exceeds = {low[0]:g} m: depths up to output.layer_depth = "
                f"{least:g} m are not told from dry; take {least:g} m or more, or set "
                "output.layer_depth to less"
            )
