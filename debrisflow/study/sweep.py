"""A study in its folder: its members, computed by an engine and never twice."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from debrisflow.errors import OutputError
from debrisflow.run.atomic import made, replaced
from debrisflow.run.forecast import forecast
from debrisflow.run.lock import LockedError, locked
from debrisflow.study.designs import points_of
from debrisflow.study.distributions import Values
from debrisflow.study.engine import (
    computed,
    connected,
    expect_fit,
    local_cluster,
    workers_for,
    workers_of,
)
from debrisflow.study.loading import load_study
from debrisflow.study.maps.checks import expect_on_map, expect_told_apart
from debrisflow.study.member import Cases, Member, members_of
from debrisflow.study.names import MEMBERS, PLAN
from debrisflow.study.outcome import Outcome, read_outcome
from debrisflow.study.results import Results
from debrisflow.study.tables import Study

if TYPE_CHECKING:
    from distributed import Client

Told = Callable[[Member, Outcome], None]


class Sweep:
    """The runs of a study.

    Parameters
    ----------
    study : Study
        As :func:`debrisflow.study.loading.load_study` returns it.
    folder : Path or str
        Of the results; the runs lie in its folder ``members``.
    store : Path or str, optional
        Folder of the runs instead of that, which several studies and machines may share.

    Attributes
    ----------
    cases : Cases
    members : list of Member
        Of the design.

    Raises
    ------
    CaseError
        If the case is wrong, or that of any member.
    """

    def __init__(self, study: Study, folder: Path | str, store: Path | str | None = None) -> None:
        self.study, self.folder = study, Path(folder)
        self.store = Path(store) if store is not None else self.folder / MEMBERS
        self.cases = Cases(study)
        expect_on_map(study, self.cases.base)
        expect_told_apart(study, self.cases.base)
        self._further: list[Member] = []

    @classmethod
    def from_file(
        cls,
        path: Path | str,
        folder: Path | str | None = None,
        store: Path | str | None = None,
    ) -> Sweep:
        """Return the sweep of a study file; its folder is ``runs/NAME`` if none is given.

        Raises
        ------
        CaseError
            If the study or its case is wrong.
        """
        return cls(load_study(path), folder or Path("runs") / Path(path).stem, store)

    @cached_property
    def members(self) -> list[Member]:
        """The members of the design."""
        return self._members_at(points_of(self.study))

    @property
    def left(self) -> list[Member]:
        """The members of the design that are not yet computed, those of equal content once."""
        found = {one.digest: one for one in self.members if read_outcome(one.folder) is None}
        return list(found.values())

    @property
    def most_at_once(self) -> int:
        """How many members there are to compute at the same time, at most."""
        calibration = self.study.calibration
        further = max(calibration.at_once, calibration.predictive) if calibration else 0
        return max(len(self.left), further)

    @cached_property
    def need(self) -> float:
        """Memory of a member, bytes."""
        return forecast(self.cases.base).memory

    def run(
        self, client: Client | None = None, threads: int = 1, told: Told | None = None
    ) -> Results:
        """Compute the members of the design that are not yet computed, and return all results.

        Parameters
        ----------
        client : distributed.Client, optional
            Of the workers; if left out, as many as this machine has room for are started.
        threads : int
            Of each member.
        told : callable, optional
            Called with each member and its outcome, in the order in which they end.

        Raises
        ------
        OutputError
            If another process runs this study, a folder cannot be written, or no worker has room.
        """
        if client is None:
            with self.workers(threads=threads) as started:
                return self.run(started, threads, told)
        with self.open():
            return self.results(client, threads, told)

    def results(self, client: Client, threads: int = 1, told: Told | None = None) -> Results:
        """Return the results of the design, as :meth:`run`, within a block of :meth:`open`."""
        outcomes = self.compute(client, self.members, threads, told)
        return Results(self.study, self.cases.base, self.members, outcomes)

    @contextmanager
    def workers(
        self, count: int | None = None, threads: int = 1, scheduler: str | None = None
    ) -> Iterator[Client]:
        """Start workers, or connect to those of a scheduler, for the length of a block.

        Parameters
        ----------
        count : int, optional
            Of workers on this machine; as many as it has room for if left out.
        threads : int
            Of each.
        scheduler : str, optional
            Address of a running one, ``tcp://HOST:PORT``.
        """
        if scheduler is not None:
            with connected(scheduler) as client:
                expect_fit(client, self.need)
                yield client
            return
        room = count or workers_for(self.need, threads)
        with local_cluster(max(min(room, self.most_at_once), 1), threads) as client:
            expect_fit(client, self.need)
            yield client

    def room(self, count: int | None, threads: int, scheduler: str | None) -> int:
        """Return how many workers there would be; see :meth:`workers`."""
        if scheduler is None:
            return count or workers_for(self.need, threads)
        with connected(scheduler) as client:
            return len(workers_of(client))

    @contextmanager
    def open(self) -> Iterator[None]:
        """Keep other processes from running this study, and write down its members."""
        made(self.folder, is_deep=True)
        made(self.store, is_deep=True)
        try:
            with locked(self.folder):
                self._write_plan()
                yield
        except LockedError as error:
            raise OutputError(
                f"another process runs the study in {self.folder}; watch it with: debrisflow sweep "
                f"status {self.folder}"
            ) from error

    def compute(
        self, client: Client, members: Sequence[Member], threads: int = 1, told: Told | None = None
    ) -> list[Outcome]:
        """Return what became of each of some members, computed where it is not known.

        Raises
        ------
        OutputError
            If what a member left is damaged.
        """
        found = {one.number: outcome for one in members if (outcome := read_outcome(one.folder))}
        left = [one for one in members if one.number not in found]
        for member in members:
            if told and member.number in found:
                told(member, found[member.number])
        for member, outcome in computed(client, left, self._program, threads):
            found[member.number] = outcome
            if told:
                told(member, outcome)
        return [found[one.number] for one in members]

    def at(self, points: Sequence[Values]) -> list[Member]:
        """Return the members at some points, those that are new after the others.

        Raises
        ------
        CaseError
            If a case is wrong.
        """
        known = {one.digest: one for one in (*self.members, *self._further)}
        found = []
        for member in self._members_at(points):
            if member.digest not in known:
                member = member._replace(number=len(self.members) + len(self._further))
                known[member.digest] = member
                self._further.append(member)
            found.append(known[member.digest])
        self._write_plan()
        return found

    def _members_at(self, points: Sequence[Values]) -> list[Member]:
        return members_of(self.cases, self.store, points, self._program)

    @cached_property
    def _program(self) -> str:
        from debrisflow.run.loop import program

        return program()

    def _write_plan(self) -> None:
        """Write which members there are, for whoever looks into the folder."""
        store, own = self.store.absolute(), self.folder.absolute()
        is_inside = store.is_relative_to(own)  # then the folder may be moved
        plan: dict[str, Any] = {
            "title": self.study.title,
            "store": store.relative_to(own).as_posix() if is_inside else str(store),
            "members": [
                {"number": one.number, "folder": one.folder.name, "values": one.values}
                for one in (*self.members, *self._further)
            ],
        }
        try:
            text = json.dumps(plan, indent=1)
        except ValueError as error:
            raise OutputError(f"{self.folder}: {error}") from error
        with replaced(self.folder / PLAN) as unfinished:
            unfinished.write_text(text + "\n", encoding="utf-8")
