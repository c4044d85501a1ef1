"""A miss that is known: why, and at which levels and how far."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple


class Known(NamedTuple):
    """Why rows are missed, for the levels at which they are.

    Attributes
    ----------
    why : str
    worst : mapping
        By the label of a level, in the unit of the row, as of
        :class:`~debrisflow.validation.row.Row`.
    uncertain : collection of str
        Labels of the levels at which the row is missed on some processors only.
    """

    why: str
    worst: Mapping[str, float]
    uncertain: Collection[str] = ()

    def at(self, label: str) -> dict[str, Any]:
        """Return what a row at a level is told of it; nothing where it is not missed.

        Examples
        --------
        >>> early = Known("there is no gate", {"d0 = 5 mm": 0.12})
        >>> early.at("d0 = 5 mm")["worst"], early.at("d0 = 10 mm")
        (0.12, {})
        """
        if label not in self.worst:
            return {}
        is_certain = label not in self.uncertain
        return {"miss": self.why, "worst": self.worst[label], "is_certain": is_certain}
