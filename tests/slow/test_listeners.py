"""Where the processes of dask listen that the docs and the script of workers start."""

import re
import shlex
import socket
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import pytest

from tests.fast.test_docs import ROOT, blocks

psutil = pytest.importorskip("psutil")
pytest.importorskip("distributed")
PAGE = ROOT / "docs/many_runs.md"
PATIENCE = 60.0  # s, for a process to start
GRACE = 20.0  # s, for one to end
AT_LEAST = {"scheduler": 2, "worker": 3}  # listeners, with the process that starts a worker again


def commands():
    """Return the commands of dask on the page, by what they start."""
    lines = [line for block in blocks(PAGE) for line in block.text.splitlines()]
    found = {line.split()[1]: line for line in lines if line.startswith("dask ")}
    assert found.keys() == AT_LEAST.keys()
    return found


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return str(one.getsockname()[1])


def listeners(process):
    """Return the addresses at which a process and those that it has started listen."""
    own = psutil.Process(process.pid)
    return [
        one.laddr.ip
        for part in (own, *own.children(recursive=True))
        for one in part.net_connections("inet")
        if one.status == psutil.CONN_LISTEN
    ]


def once_up(process, log: Path, text: str):
    """Return where a process listens once its log has a text."""
    end = monotonic() + PATIENCE
    while not re.search(text, log.read_text(errors="replace")):
        assert process.poll() is None, log.read_text()
        assert monotonic() < end, log.read_text()
        sleep(0.1)
    return listeners(process)


def test_the_commands_of_the_page_listen_on_the_loopback_only(tmp_path):
    port, found, started = free_port(), {}, []
    signs = {"scheduler": "Scheduler at:", "worker": "Registered to"}
    try:
        for name, line in commands().items():
            one = line.replace("8786", port).replace("--nworkers 4", "--nworkers 1")
            log = tmp_path / name
            with log.open("wb") as out:
                program, *arguments = shlex.split(one)
                command = [sys.executable, "-P", "-m", program, *arguments]
                started.append(subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT))
            found[name] = once_up(started[-1], log, signs[name])
    finally:
        stop(started)
    for name, addresses in found.items():
        assert len(addresses) >= AT_LEAST[name]
        assert set(addresses) == {"127.0.0.1"}


def test_the_script_listens_on_the_loopback_only(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "scripts")
    import sweep_workers

    started = [sweep_workers.scheduler_at(tmp_path / "scheduler")]
    try:
        address = sweep_workers.wait_for(r"tcp://127\.0\.0\.1:\d+", tmp_path / "scheduler")[0]
        started.append(sweep_workers.worker(address, tmp_path / "worker"))
        sweep_workers.wait_for("Registered to", tmp_path / "worker")
        found = [listeners(process) for process in started]
    finally:
        stop(started)
    assert all(len(addresses) >= 2 for addresses in found)
    assert {address for addresses in found for address in addresses} == {"127.0.0.1"}


def stop(processes):
    """End processes, workers before their scheduler."""
    for process in reversed(processes):
        process.terminate()
        try:
            process.wait(timeout=GRACE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
