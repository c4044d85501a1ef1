"""TOML from a file or the command line, refused where it is made to be read without end."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from debrisflow.errors import shown, steers

MOST_BYTES = 8_000_000  # of a case with a long hydrograph written into it
MOST_DEPTH = 16  # of tables and lists within each other
LARGEST_WHOLE = 2**63 - 1  # what TOML promises
# The time that a key takes grows with the square of the number of its parts.
_LONG_KEY = re.compile(r"""(?<![\w"'.-])(?:[\w"'-]+[ \t]*\.[ \t]*){64}""")


class WrongTomlError(ValueError):
    """Why a text is no TOML that can be used, in words that follow its name."""


def tables_of(text: str) -> dict[str, Any]:
    """Return the tables of a text.

    Raises
    ------
    WrongTomlError
        If it is not TOML, or nested too deep, or holds a number of too many digits.

    Examples
    --------
    >>> tables_of("a.b = 1")
    {'a': {'b': 1}}
    >>> tables_of("a = " + 400 * "[" + 400 * "]")
    Traceback (most recent call last):
    ...
    debrisflow.case.toml_text.WrongTomlError: has tables or lists more than 16 deep in each other
    """
    if _LONG_KEY.search(text):
        raise WrongTomlError("has a key of more than 64 parts")
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise WrongTomlError(f"is not valid TOML: {shown(str(error))}") from error
    except ValueError as error:  # of a whole number with thousands of digits, of a date
        raise WrongTomlError("holds a number or a date that cannot be one") from error
    except RecursionError as error:
        raise WrongTomlError(_TOO_DEEP) from error
    if fault := fault_of_structure(tables):
        raise WrongTomlError(fault)
    return tables


_TOO_DEEP = f"has tables or lists more than {MOST_DEPTH} deep in each other"


def fault_of_structure(tables: Any) -> str:
    """Return why nested tables cannot be those of a case; empty if they can.

    Parameters
    ----------
    tables : object
        Of dicts, lists and plain values.
    """
    waiting: list[tuple[Any, int]] = [([tables], 0)]
    while waiting:
        value, depth = waiting.pop()
        if depth > MOST_DEPTH:
            return _TOO_DEEP
        if isinstance(value, dict):
            if bad := next((str(key) for key in value if steers(str(key))), None):
                return f"has a key with a character that cannot be printed: {shown(bad)}"
            value = value.values()
        for part in value:
            if isinstance(part, dict | list):
                waiting.append((part, depth + 1))
            elif isinstance(part, int) and abs(part) > LARGEST_WHOLE:
                return "has a whole number of more than 64 bits"
    return ""
