"""Where compiled kernels are kept between processes, and how they are read and written there.

In place of Numba's own cache, which ends a run with a traceback where a file is damaged or the
disk is full, can mix up the machine code of two signatures when two processes compile one
function at the same time, and takes no folder that it cannot write to.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import stat
import sys
import tempfile
import uuid
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

LOG = logging.getLogger(__name__)
DIGEST_BYTES = hashlib.sha256().digest_size


def places(name: str) -> tuple[Path, ...]:
    """Return the folders from which kernels are read; they are written into the last of them.

    The first is ``debrisflow/NAME`` in ``XDG_CACHE_HOME``, or ``~/.cache``.  Where that cannot be
    written, a folder of this user in the system's temporary directory follows.  The files are
    pickled code, so a folder that others could have filled is none of them.

    Parameters
    ----------
    name : str
        Changes with all that the machine code depends on.

    Returns
    -------
    tuple of Path
        Empty where there is neither; each process then compiles for itself.
    """
    home = _home()
    if home is not None:
        home = home / "debrisflow" / name
        if _is_writable(home) and is_trusted(home):
            return (home,)
    prepared = (home,) if home is not None and is_trusted(home) else ()
    spare = _spare(name)
    return prepared if spare is None else (*prepared, spare)


def _home() -> Path | None:
    with suppress(RuntimeError):  # an account without a home folder
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return None


def _spare(name: str) -> Path | None:
    """Return a folder in the temporary directory that only this user can reach, if there is one."""
    try:
        spare = Path(tempfile.gettempdir()) / f"debrisflow-{_user()}" / name
    except OSError:  # no directory for temporary files
        return None
    return spare if _is_writable(spare) and is_trusted(spare, private=True) else None


def _user() -> int:
    return (
        os.getuid() if sys.platform != "win32" else 0
    )  # there each user has a temporary directory


def _is_writable(folder: Path) -> bool:
    """Make a folder, if need be, and return whether files can be made in it."""
    try:
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def is_trusted(folder: Path, private: bool = False) -> bool:
    """Return whether a folder and the one that it is in could be filled by this user or root alone.

    Parameters
    ----------
    folder : Path
    private : bool
        Whether they must be this user's, and closed to a group too: in a directory for everybody.
    """
    owners = {_user()} if private else {_user(), 0}
    others = stat.S_IWGRP | stat.S_IWOTH if private else stat.S_IWOTH
    for one in (folder.parent, folder):
        try:
            found = one.lstat() if private else one.stat()
        except OSError:
            return False
        if not stat.S_ISDIR(found.st_mode):
            return False
        if sys.platform != "win32" and (found.st_uid not in owners or found.st_mode & others):
            return False
    return True


class KernelCache(_Cache):
    """The machine code of one function on disk, one file for each signature.

    A file is a digest and what follows it.  It appears under its name when it is complete; one that
    is damaged all the same is deleted, and compiled again.

    Parameters
    ----------
    function : callable
    folders : tuple of Path
        Read from all, written into the last.
    """

    def __init__(self, function: Callable[..., Any], folders: tuple[Path, ...]) -> None:
        self._function, self._folders = function, folders

    @property
    def cache_path(self) -> str:
        """The folder of the files."""
        return str(self._folders[-1]) if self._folders else ""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled function of a signature, or None."""
        target_context.refresh()
        name = self._file_name(sig, target_context.codegen())
        for file in (folder / name for folder in self._folders if name):
            with suppress(FileNotFoundError):
                try:
                    return _read(file, sig, target_context)
                except Exception as error:  # whatever damaged bytes make of the decoding
                    LOG.debug("the kernel %s is damaged (%s) and compiled again", file, error)
                    with suppress(OSError):
                        file.unlink()
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the compiled function of a signature, if the disk takes it."""
        name = self._file_name(sig, data.codegen)
        if not (self._folders and name) or data.lifted or data.library.has_dynamic_globals:
            return
        file = self._folders[-1] / name
        unfinished = file.with_name(f"{file.name}.tmp.{uuid.uuid4().hex[:16]}")
        body = dumps((sig, data._reduce()))
        try:
            file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            unfinished.write_bytes(hashlib.sha256(body).digest() + body)
            os.replace(unfinished, file)
        except OSError as error:
            _tell_once(file.parent, error.strerror or str(error))
            with suppress(OSError):
                unfinished.unlink()

    def _file_name(self, sig: Any, codegen: Any) -> str | None:
        """Return the name of the file of a signature; None for a function typed at a prompt."""
        code = self._function.__code__
        source = _digest_of(code.co_filename)
        if source is None:
            return None
        closure = [cell.cell_contents for cell in self._function.__closure__ or ()]
        key = (
            repr(sig),
            codegen.magic_tuple(),
            hashlib.sha256(code.co_code).hexdigest(),
            hashlib.sha256(dumps(closure) if closure else b"").hexdigest(),
            sys.implementation.cache_tag,
            source,
        )
        place = f"{self._function.__module__}.{self._function.__qualname__}-{code.co_firstlineno}"
        digest = hashlib.sha256(repr(key).encode()).hexdigest()[:32]
        return f"{place.removeprefix('debrisflow.').replace('<locals>.', '')}.{digest}.nbc"

    def enable(self) -> None:
        """Do nothing: kernels are always kept."""

    def disable(self) -> None:
        """Do nothing: kernels are always kept."""

    def flush(self) -> None:
        """Do nothing: no file outlives what it was compiled from."""


def _read(file: Path, sig: Any, target_context: Any) -> Any:
    """Return what a file holds.

    Raises
    ------
    Exception
        Of many kinds, if it is damaged.
    """
    data = file.read_bytes()
    digest, body = data[:DIGEST_BYTES], data[DIGEST_BYTES:]
    if digest != hashlib.sha256(body).digest():
        raise ValueError("its digest differs")
    found, reduced = pickle.loads(body)
    if found != sig:
        raise ValueError("it has another signature")
    return CompileResult._rebuild(target_context, *reduced)


@lru_cache
def _digest_of(source: str) -> str | None:
    try:
        return hashlib.sha256(Path(source).read_bytes()).hexdigest()
    except OSError:
        return None


@lru_cache
def _tell_once(folder: Path, why: str) -> None:
    LOG.warning(
        "compiled kernels cannot be kept in %s: %s; the run goes on, and the next one compiles them"
        " again",
        folder,
        why,
    )
