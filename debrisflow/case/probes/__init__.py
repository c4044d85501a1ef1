"""The tables of the probes: each file in this folder holds one.

A probe is two files named after its type.  ``debrisflow/case/probes/TYPE.py`` holds its table, the
only :class:`debrisflow.case.probe.Probe` that the file defines, with the check of its fields.
``debrisflow/run/probes/TYPE.py`` takes its samples, see :mod:`debrisflow.run.probe`.  No list of
probes needs to be edited.
"""

from __future__ import annotations

from functools import reduce
from operator import or_
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from debrisflow.case.probe import Probe, only_subclass

TABLES = {
    module.name: only_subclass(f"{__name__}.{module.name}", Probe)
    for module in iter_modules(__path__)
}

if TYPE_CHECKING:
    AnyProbe = Probe
else:
    AnyProbe = Annotated[reduce(or_, TABLES.values()), Field(discriminator="type")]
