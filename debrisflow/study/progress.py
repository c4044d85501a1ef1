"""What a sweep shows while it goes on: one bar over its members, or lines of JSON."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Any, Self

from tqdm import tqdm

from debrisflow.errors import shown
from debrisflow.run.bar import BAR, bar
from debrisflow.study.member import Member, shown_values
from debrisflow.study.outcome import FINISHED, Outcome


class Bar:
    """Shows how many members are over, and those without results in lines above.

    Parameters
    ----------
    members : int
        How many there are.
    is_quiet : bool
        Show the lines only.
    """

    def __init__(self, members: int, is_quiet: bool = False) -> None:
        self._bar: tqdm[Any] = bar(total=members, bar_format=BAR, disable=is_quiet)
        self._bar.set_description_str(self._text(), refresh=True)

    def __call__(self, member: Member, outcome: Outcome) -> None:
        """Show that a member is over; those beyond the design make the bar longer."""
        if outcome.state != FINISHED:
            text = f"member {member.number} ({shown_values(member.values)}) {outcome.state}: "
            tqdm.write(shown(text + outcome.message), file=sys.stderr)
        self._bar.total = max(self._bar.total, self._bar.n + 1)
        self._bar.update()
        self._bar.set_description_str(self._text(), refresh=False)

    def _text(self) -> str:
        return f"{self._bar.n} of {self._bar.total} members"

    def __enter__(self) -> Self:
        """Return the bar itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Leave the bar as it stands."""
        self._bar.close()
