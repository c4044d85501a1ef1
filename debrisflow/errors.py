"""What can go wrong, as a person is told it; one exit code a class."""

from __future__ import annotations

import re

# What steers a terminal, breaks a line or turns the direction of what follows: control characters
# but for the ends of lines and tabs, lone surrogates, separators of lines, marks of direction.
_STEERING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\u2028\u2029\u202a-\u202e\u2066-\u2069]"
)


def steers(text: str) -> bool:
    """Return whether a text holds characters that do something else than to be read.

    Examples
    --------
    >>> steers("a flume"), steers(chr(27) + "[2J")
    (False, True)
    """
    return _STEERING.search(text) is not None


def shown(text: str) -> str:
    r"""Return a text whose steering characters are written out, fit for a terminal or a log.

    Examples
    --------
    >>> print(shown(chr(27) + "[2J"))
    \x1b[2J
    """
    return _STEERING.sub(lambda one: ascii(one[0])[1:-1], text)


class DebrisflowError(Exception):
    """Base of every error whose message is meant for the user, shown without a traceback."""

    exit_code = 1

    def __str__(self) -> str:
        """Return the message, which may repeat what stands in a file, fit for a terminal."""
        return shown(super().__str__())


class CaseError(DebrisflowError):
    """The case file, or a change made to it on the command line, is wrong; nothing was written."""

    exit_code = 2


class OutputError(DebrisflowError):
    """Results cannot be written, or a folder does not hold the results that it should."""

    exit_code = 3


class DivergedError(DebrisflowError):
    """A run broke a promise: a stability limit, a NaN, a pressure that was not found.

    Parameters
    ----------
    what : str
        What happened, when, and to which particle at which place; one line.
    cause : str
        The likely one.
    remedy : str
        What to do about it.
    where_kept : str
        Which files hold the last good state and the failure.
    """

    exit_code = 4

    def __init__(self, what: str, cause: str = "", remedy: str = "", where_kept: str = "") -> None:
        self.what, self.cause, self.remedy = what, cause, remedy
        parts = (("likely cause", cause), ("what to do", remedy))
        lines = [what, *(f"{name}: {text}" for name, text in parts if text)]
        super().__init__("\n".join([*lines, where_kept] if where_kept else lines))


class NotConvergedError(DivergedError):
    """A linear system was not solved; the step may be tried again with a shorter time step."""


class Interrupted(KeyboardInterrupt):
    """A run was stopped by a signal, from the terminal or a batch system.

    Attributes
    ----------
    number : int
        Of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number

    @property
    def exit_code(self) -> int:
        """That of a shell."""
        return 128 + self.number
