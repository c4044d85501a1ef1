"""Members on the workers of dask.distributed: a cluster of this machine, or a running scheduler."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from hashlib import sha256
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from debrisflow.case.memory import available_memory, size
from debrisflow.errors import OutputError
from debrisflow.study.computing import compute
from debrisflow.study.member import DIGITS, Member
from debrisflow.study.outcome import STOPPED, Outcome

if TYPE_CHECKING:
    from distributed import Client

NEEDED = ("distributed", "SALib", "emcee", "sklearn", "xarray", "cryptography")
PATIENCE = "10s"  # for a scheduler that does not answer
JOINING = "120s"  # for its first worker, which a batch system may have to start
OF_A_PROCESS = 1e9  # bytes, of Python while it compiles kernels, beside the particles
DEATHS = 10  # of workers, after which their member is given up
SPARE = 0.6  # share of a worker's memory beyond which a member does not fit: dask ends it at 0.95


@contextmanager
def local_cluster(workers: int, threads: int) -> Iterator[Client]:
    """Start workers on this machine, each for one member at a time, and stop them at the end.

    Parameters
    ----------
    workers : int
    threads : int
        Of each.

    Raises
    ------
    OutputError
        If dask is not installed.
    """
    distributed = _distributed()
    _quiet()
    memory = available_memory()
    # Read when Numba and tqdm are imported there: threads of a pool, and no bars of their own.
    environment = {"NUMBA_NUM_THREADS": str(threads), "TQDM_DISABLE": "1"}
    with (
        _configured(environment),
        distributed.LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            memory_limit=memory / workers if memory else "auto",
            security=True,  # else any user of this machine could run code as this one
            silence_logs=logging.CRITICAL,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@contextmanager
def connected(address: str) -> Iterator[Client]:
    """Connect to a running scheduler.

    Raises
    ------
    OutputError
        If nothing answers there, or no worker has joined.
    """
    distributed = _distributed()
    _quiet()
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise OutputError(
            f"no scheduler of dask answers at {address}: {error}; start one with: dask scheduler "
            f"--host HOST, and workers with: dask worker {address} --host HOST --nthreads 1. "
            "Whoever reaches them can run code as you: let HOST be 127.0.0.1, or in a network of "
            "people whom you trust"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=JOINING)
        except TimeoutError as error:
            raise OutputError(
                f"the scheduler at {address} has had no worker for {JOINING}; start some with: "
                f"dask worker {address} --host HOST --nthreads 1"
            ) from error
        yield client


def workers_for(need: float, threads: int) -> int:
    """Return how many workers this machine has room for.

    Parameters
    ----------
    need : float
        Memory of a member, bytes.
    threads : int
        Of each.

    Raises
    ------
    OutputError
        If there is no room for one.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    by_cores = max(1, (cores or 1) // threads)
    memory = available_memory()
    if memory is None:
        return by_cores
    by_memory = int(SPARE * memory / (need + OF_A_PROCESS))
    if by_memory < 1:
        raise OutputError(
            f"a member needs about {size(need + OF_A_PROCESS)} of memory, and {size(memory)} are "
            "free here; coarsen its particles, or use --scheduler with larger machines"
        )
    return min(by_cores, by_memory)


def expect_fit(client: Client, need: float) -> None:
    """Refuse workers that cannot hold a member, or would compute several in one process.

    Raises
    ------
    OutputError
    """
    for name, worker in workers_of(client).items():
        if worker["nthreads"] != 1:
            raise OutputError(
                f"the worker {name} has {worker['nthreads']} threads and would compute as many "
                "members in one process; start workers with --nthreads 1"
            )
        limit = worker["memory_limit"]
        if limit and need + OF_A_PROCESS > SPARE * limit:
            raise OutputError(
                f"a member needs about {size(need + OF_A_PROCESS)} of memory, and the worker "
                f"{name} has {size(limit)}; use fewer workers, or coarsen the particles"
            )


def workers_of(client: Client) -> Mapping[str, Any]:
    """Return the workers that a scheduler knows, by their addresses."""
    found: Mapping[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return found


def computed(
    client: Client, members: Sequence[Member], program: str, threads: int
) -> Iterator[tuple[Member, Outcome]]:
    """Compute members, and yield each with what became of it, in the order in which they end.

    A member whose worker dies is given to another one, which goes on with it.  Members with the
    same content are computed once.

    Parameters
    ----------
    client : distributed.Client
    members : sequence of Member
    program : str
        That the workers must have.
    threads : int
        Of each.
    """
    from distributed import as_completed

    alike: dict[str, list[Member]] = {}
    for member in members:
        alike.setdefault(member.digest, []).append(member)
    futures = {
        digest: client.submit(
            compute,
            same[0].case,
            same[0].folder.absolute(),
            digest,
            program,
            threads,
            key=_key(same[0], threads),
        )
        for digest, same in alike.items()
    }
    of_future = {future.key: digest for digest, future in futures.items()}
    try:
        for future in as_completed(futures.values()):
            outcome = _outcome(future)
            for member in alike[of_future[future.key]]:
                yield member, outcome
            future.release()
    finally:
        client.cancel([future for future in futures.values() if not future.done()])


def _key(member: Member, threads: int) -> str:
    """Return the name of a task, by which clients of a scheduler share it: that of one folder."""
    folder = sha256(str(member.folder.absolute()).encode()).hexdigest()
    return f"member-{member.digest}-{folder[:DIGITS]}-{threads}"


def _outcome(future: Any) -> Outcome:
    """Return what a worker found, or why it died."""
    error = future.exception()
    if error is None:
        found: Outcome = future.result()
        return found
    reason = (
        "each worker that computed it died; one does that takes more memory than it has (use fewer "
        "workers), or whose time in a batch system is over (the same command goes on)"
        if type(error).__name__ == "KilledWorker"
        else f"{type(error).__name__}: {error}"
    )
    return Outcome(STOPPED, reason, {}, 0.0)


def _distributed() -> Any:
    """Return dask.distributed, if all that a sweep needs later is there as well."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise OutputError(
            f"{', '.join(missing)} cannot be imported; a sweep needs the packages of the extra "
            "'sweep', see docs/install.md"
        )
    import distributed

    return distributed


def _quiet() -> None:
    """Keep the messages of dask on its own workings off the terminal."""
    for name in ("distributed", "tornado"):
        logging.getLogger(name).setLevel(logging.CRITICAL)


@contextmanager
def _configured(environment: Mapping[str, str]) -> Iterator[None]:
    """Set what the workers of a cluster are started with."""
    import dask

    before = dask.config.get("distributed.nanny.pre-spawn-environ", {})
    with dask.config.set(
        {
            "distributed.nanny.pre-spawn-environ": {**before, **environment},
            "distributed.admin.tick.limit": "1h",  # compiling kernels holds the interpreter
            "distributed.scheduler.allowed-failures": DEATHS,
        }
    ):
        yield
