"""Cases that comparisons start from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from debrisflow.case import Case, ResolvedCase
from debrisflow.case.defaults import complete


def case_of(**tables: Any) -> ResolvedCase:
    """Return the case of tables given as a case file would hold them."""
    return complete(Case(**tables))


def endless_channel(
    spacing: float, slope: float, layers: Sequence[dict[str, Any]], **tables: Any
) -> ResolvedCase:
    """Return a case: layers, as blocks without x, in a channel that repeats every 20 spacings."""
    length = 20 * spacing
    block = {"type": "block", "x": [0.0, length]}
    return case_of(
        title="endless channel",
        particles={"spacing": spacing},
        gravity={"slope": slope},
        geometry={"type": "channel", "length": length, "height": 0.5, "periodic": True},
        fill=[block | layer for layer in layers],
        time={"end": 10.0},
        output={"interval": 1.0},
        **tables,
    )
