"""The program for SLURM in the docs: which jobs it asks for, without a batch system."""

import re
from types import SimpleNamespace

import dask_jobqueue
import distributed
import pytest

from debrisflow.study.sweep import Sweep
from tests.fast.test_docs import ROOT, SLURM, blocks

PAGE = ROOT / "docs/many_runs.md"


class Cluster(dask_jobqueue.SLURMCluster):
    """One that submits nothing, with its scheduler on this machine alone."""

    def __init__(self, **given):
        options = given.pop("scheduler_options") | {"host": "127.0.0.1"}
        self.asked = None
        super().__init__(scheduler_options=options, **given)

    def scale(self, jobs):
        self.asked = jobs


@pytest.fixture(scope="module")
def names():
    """Return what the program of the page leaves, with a sweep that computes nothing."""
    (block,) = [block for block in blocks(PAGE) if block.note == SLURM]
    clients, known = [], {}

    def run(client):
        clients.append(client)
        return SimpleNamespace(table="the table")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dask_jobqueue, "SLURMCluster", Cluster)
        patch.setattr(Sweep, "from_file", lambda *_, **__: SimpleNamespace(run=run))
        exec(compile(block.text, PAGE.name, "exec"), known)
    yield known | {"clients": clients}
    known["cluster"].close()


def test_a_job_asks_for_one_thread_memory_and_time(names):
    script = names["cluster"].job_script()

    assert script.count("#SBATCH --cpus-per-task=1\n") == 1
    assert "#SBATCH -n 1\n" in script
    assert "#SBATCH --mem=2G\n" in script
    assert "#SBATCH -t 04:00:00\n" in script
    assert "#SBATCH -p normal\n#SBATCH -A hazard\n" in script


def test_a_worker_computes_one_member_on_one_thread(names):
    script = names["cluster"].job_script()

    (worker,) = re.findall(r"^.*distributed\.cli\.dask_worker.*$", script, re.M)
    assert "--nthreads 1 " in worker
    assert "--nworkers" not in worker
    assert script.index("export NUMBA_NUM_THREADS=1\n") < script.index(worker)


def test_the_sweep_is_run_by_the_cluster(names):
    (client,) = names["clients"]

    assert isinstance(client, distributed.Client)
    assert names["cluster"].asked == 64
    assert client.cluster is names["cluster"]
    assert names["results"].table == "the table"


def test_the_page_of_the_scheduler_is_not_on_the_network(names):
    sockets = names["cluster"].scheduler.http_server._sockets.values()

    assert {one.getsockname()[0] for one in sockets} == {"127.0.0.1"}


def test_the_pages_of_the_workers_are_not_on_the_network(names):
    (worker,) = re.findall(r"^.*dask_worker.*$", names["cluster"].job_script(), re.M)

    assert worker.endswith(" --dashboard-address 127.0.0.1:0")
