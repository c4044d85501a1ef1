"""What the maps of a study cannot show of its case."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.errors import CaseError
from debrisflow.study.tables import Study


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
