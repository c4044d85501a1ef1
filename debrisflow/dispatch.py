"""How a function finds the formula of the record that it is given: of a law, of a kind of walls."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from typing import Any

from numba import types
from numba.extending import overload

from debrisflow._jit import KERNEL_OPTIONS, kernel

Formula = Callable[..., Any]


def by_record(usual: Formula) -> Formula:
    """Return a function that is the formula of its last argument, a record (NamedTuple).

    That is the function of the same name in the module of the record; where it has none, or the
    module is that of ``usual``, it is ``usual``.
    In kernels, where each is compiled as ``kernel`` does, the choice is made when they are
    compiled, by the type of the record, so that it costs nothing and Numba's cache on disk keeps
    it.  Python code and kernels that are not compiled choose at each call.

    Parameters
    ----------
    usual : function
        The formula of a record that has none of its own.  Its arguments are given by position.
    """
    name, fallback = usual.__name__, kernel(usual)

    def formula_of(record: type) -> Formula:
        found: Formula = getattr(sys.modules[record.__module__], name, fallback)
        return fallback if found is chosen else found

    @wraps(usual)
    def chosen(*arguments: Any) -> Any:
        return formula_of(type(arguments[-1]))(*arguments)

    @overload(chosen, jit_options=KERNEL_OPTIONS, strict=False)
    def compiled(*arguments: Any) -> Formula | None:
        law = arguments[-1]
        if not isinstance(law, types.BaseNamedTuple):
            return None
        formula = formula_of(law.instance_class)
        source: Formula = getattr(formula, "py_func", formula)
        return source

    return chosen
