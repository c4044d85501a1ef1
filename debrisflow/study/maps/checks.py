"""Checks of the maps that a study asks for."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.case.problems import Problem, Problems
from debrisflow.case.words import did_you_mean, either, format_extent
from debrisflow.errors import CaseError
from debrisflow.run.layers import LAYERS
from debrisflow.study.maps.grid import grid_of
from debrisflow.study.names import ARRIVAL
from debrisflow.study.quantities import cell_of
from debrisflow.study.tables import Map, MapArea, Study

GIVEN = ("release", "terrain")  # layers that are no results


def map_problems(study: Study) -> Problems:
    """Yield what is wrong with the maps that a study asks for."""
    for k, wanted in enumerate(study.map):
        yield from _map(f"map.{k}", wanted)
    yield from _repeated(study)


def layer_problems(key: str, layer: str) -> Problems:
    """Yield that there is no such layer."""
    if layer not in LAYERS:
        yield Problem(key, f"must be {either(LAYERS)}{did_you_mean(layer, LAYERS)}", layer)


def _map(key: str, wanted: Map) -> Problems:
    yield from layer_problems(f"{key}.layer", wanted.layer)
    if wanted.layer in GIVEN:
        message = "is given, not found by a run; choose a layer of the flow"
        yield Problem(f"{key}.layer", message, wanted.layer)
    if wanted.exceeds and wanted.layer == ARRIVAL:
        message = "of the arrival state times with before, up to which the flow arrives"
        yield Problem(f"{key}.exceeds", message, wanted.exceeds)
    if wanted.before and wanted.layer != ARRIVAL:
        message = f"times are of the layer '{ARRIVAL}' only, and this is '{wanted.layer}'"
        yield Problem(f"{key}.before", message, wanted.before)
    if not all(0.0 < share < 1.0 for share in wanted.quantiles):
        message = "must be shares between 0 and 1, both left out"
        yield Problem(f"{key}.quantiles", message, wanted.quantiles)
    if not (wanted.exceeds or wanted.before or wanted.quantiles):
        name = "before" if wanted.layer == ARRIVAL else "exceeds"
        yield Problem(key, f"asks for nothing; give {name} or quantiles, or leave it out")
    for name, values in (("exceeds", wanted.exceeds), ("before", wanted.before)):
        for k, value in enumerate(values):
            if value < 0.0:
                yield Problem(f"{key}.{name}.{k}", "must be at least 0", value)


def _repeated(study: Study) -> Problems:
    """Yield what is asked for twice: its files would have one name."""
    seen: dict[tuple[str, str, str], int] = {}
    for k, wanted in enumerate(study.map):
        for name in ("exceeds", "before", "quantiles"):
            for place, value in enumerate(getattr(wanted, name)):
                first = seen.get((wanted.layer, name, f"{value:g}"))
                seen.setdefault((wanted.layer, name, f"{value:g}"), k)
                if first is not None:
                    where = "the list has" if first == k else f"map.{first} asks for"
                    message = f"{where} it before; leave one out"
                    yield Problem(f"map.{k}.{name}.{place}", message, value)


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
