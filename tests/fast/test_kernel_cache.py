"""Where compiled kernels are kept, by whom a folder is trusted, and what damage does to a run."""

from __future__ import annotations

import errno
import logging
import os
import sys
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

from debrisflow import _jit, _kernel_cache
from debrisflow._kernel_cache import KernelCache, is_trusted, places

NAME = "kernels-0123456789abcdef"
# Windows has no such owners and modes, so that there is nothing to test
POSIX = pytest.mark.skipif(sys.platform == "win32", reason="owners and modes of files are POSIX")


def square(x):
    return x * x


def compiled(folder: Path) -> Dispatcher:
    """Return the function as a new process would have it: compiled for nothing yet."""
    fresh = _jit._kept(**_jit.KERNEL_OPTIONS)(square)
    fresh._cache = KernelCache(square, (folder,))
    return fresh


def counts(function: Dispatcher) -> tuple[int, int]:
    """Return how often machine code was read from the disk, and compiled."""
    return sum(function.stats.cache_hits.values()), sum(function.stats.cache_misses.values())


def test_what_one_process_compiles_another_reads(tmp_path):
    first, second = compiled(tmp_path), compiled(tmp_path)
    assert first(3.0) == 9.0
    assert second(3.0) == 9.0
    assert (counts(first), counts(second)) == ((0, 1), (1, 0))
    assert len(list(tmp_path.iterdir())) == 1


def test_signatures_do_not_share_a_file(tmp_path):
    one, other = compiled(tmp_path), compiled(tmp_path)
    assert one(3.0) == 9.0
    assert other(3) == 9
    again = compiled(tmp_path)
    assert (again(3), again(3.0)) == (9, 9.0)
    assert counts(again) == (2, 0)


@pytest.mark.parametrize("keep", [0, 10, 33, 200, -1])
def test_a_truncated_file_is_compiled_again_and_mended(keep, tmp_path):
    compiled(tmp_path)(3.0)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole[:keep])
    again, later = compiled(tmp_path), compiled(tmp_path)
    assert again(3.0) == 9.0
    assert later(3.0) == 9.0
    assert (counts(again), counts(later)) == ((0, 1), (1, 0))


def test_a_changed_byte_is_never_run(tmp_path):
    compiled(tmp_path)(3.0)
    (file,) = tmp_path.iterdir()
    damaged = bytearray(file.read_bytes())
    damaged[len(damaged) // 2] ^= 1
    file.write_bytes(damaged)
    again = compiled(tmp_path)
    assert again(3.0) == 9.0
    assert counts(again) == (0, 1)


def test_machine_code_of_another_signature_is_never_run(tmp_path):
    compiled(tmp_path)(3.0)
    (real,) = tmp_path.iterdir()
    code = real.read_bytes()
    real.unlink()
    compiled(tmp_path)(3)
    (whole_number,) = tmp_path.iterdir()
    whole_number.write_bytes(code)
    again = compiled(tmp_path)
    assert again(3) == 9
    assert counts(again) == (0, 1)


def test_a_full_disk_costs_the_cache_and_not_the_run(tmp_path, monkeypatch, caplog):
    def full(path, data):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with caplog.at_level(logging.WARNING):
        assert compiled(tmp_path)(3.0) == 9.0
        assert compiled(tmp_path)(4.0) == 16.0
    assert [record.message for record in caplog.records] == [
        f"compiled kernels cannot be kept in {tmp_path}: No space left on device; the run goes on, "
        "and the next one compiles them again"
    ]
    assert list(tmp_path.iterdir()) == []


def test_without_a_folder_each_process_compiles():
    function = _jit._kept(**_jit.KERNEL_OPTIONS)(square)
    function._cache = KernelCache(square, ())
    assert function(3.0) == 9.0
    assert counts(function) == (0, 1)


@pytest.fixture
def spares(tmp_path, monkeypatch) -> Path:
    """Return the directory for temporary files, of an account without a home that it can write."""
    home = tmp_path / "home"
    home.write_text("not a folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    spare = tmp_path / "tmp"
    spare.mkdir()
    monkeypatch.setattr(_kernel_cache.tempfile, "tempdir", str(spare))
    return spare


@POSIX
def test_the_spare_folder_is_closed_to_others(spares):
    (folder,) = places(NAME)
    assert folder == spares / f"debrisflow-{os.getuid()}" / NAME
    assert [one.stat().st_mode & 0o777 for one in (folder, folder.parent)] == [0o700, 0o700]
    assert places(NAME) == (folder,)


@POSIX
@pytest.mark.parametrize("depth", [0, 1])
def test_a_spare_folder_that_others_can_fill_is_not_used(depth, spares):
    (folder,) = places(NAME)
    (folder, folder.parent)[depth].chmod(0o770)
    assert places(NAME) == ()


@POSIX
def test_a_spare_folder_that_is_a_link_is_not_used(spares, tmp_path):
    (folder,) = places(NAME)
    folder.rename(tmp_path / "elsewhere")
    folder.symlink_to(tmp_path / "elsewhere")
    assert places(NAME) == ()


@POSIX
def test_a_spare_folder_of_another_user_is_not_used(spares, monkeypatch):
    (folder,) = places(NAME)
    other = os.getuid() + 1
    monkeypatch.setattr(_kernel_cache, "_user", lambda: other)
    folder.parent.rename(folder.parents[1] / f"debrisflow-{other}")
    assert places(NAME) == ()


@POSIX
def test_a_folder_at_home_that_everybody_can_fill_is_not_used(spares, tmp_path, monkeypatch):
    home = tmp_path / "open"
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    (folder,) = places(NAME)
    assert home in folder.parents
    assert is_trusted(folder)
    folder.chmod(0o777)
    (folder,) = places(NAME)
    assert spares in folder.parents


@POSIX
def test_an_account_without_a_home_has_the_spare_folder(spares, monkeypatch):
    def none():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", none)
    (folder,) = places(NAME)
    assert spares in folder.parents


def test_without_any_directory_there_is_no_folder(spares, monkeypatch):
    def none():
        raise FileNotFoundError("no usable temporary directory")

    monkeypatch.setattr(_kernel_cache.tempfile, "gettempdir", none)
    assert places(NAME) == ()
