"""The case file: read, checked, completed and written."""

from debrisflow.case.loading import build_case, case_schema, dump_case, load_case
from debrisflow.case.resolved import ResolvedCase
from debrisflow.case.tables import Case

__all__ = ["Case", "ResolvedCase", "build_case", "case_schema", "dump_case", "load_case"]
