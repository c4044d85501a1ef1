"""The points at which a study computes its members."""

from __future__ import annotations

from scipy.stats import qmc

from debrisflow.study.member import Values
from debrisflow.study.tables import LatinHypercube, Study


def points_of(study: Study) -> list[Values]:
    """Return the values of the parameters of each member, by name."""
    assert isinstance(study.design, LatinHypercube)
    sample = qmc.LatinHypercube(len(study.parameter), rng=study.design.seed)
    shares = sample.random(study.design.members)
    return [
        {one.name: one.at(share) for one, share in zip(study.parameter, row, strict=True)}
        for row in shares
    ]
