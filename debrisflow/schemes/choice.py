"""Which scheme computes a case."""

from __future__ import annotations

from debrisflow.case import ResolvedCase
from debrisflow.schemes.explicit import Explicit
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.schemes.study_explicit import StudyExplicit
from debrisflow.schemes.study_semi_implicit import StudySemiImplicit

AnyScheme = SemiImplicit | StudySemiImplicit | Explicit | StudyExplicit


def scheme_of(case: ResolvedCase) -> AnyScheme:
    """Return the scheme of a case, before its first step."""
    if case.scheme.type == "semi-implicit":
        return StudySemiImplicit(case) if case.scheme.form == "study" else SemiImplicit(case)
    return StudyExplicit(case) if case.scheme.form == "study" else Explicit(case)
