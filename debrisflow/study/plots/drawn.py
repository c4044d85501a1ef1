"""All pictures of the sensitivity of one quantity, in files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from debrisflow import __version__
from debrisflow.results.plots.style import save, styled
from debrisflow.study.distributions import Values
from debrisflow.study.plots.effects import morris_figure, shares_figure
from debrisflow.study.plots.scatter import EXPLANATION, scatter_figure
from debrisflow.study.plots.tornado import explanation, tornado_figure
from debrisflow.study.sensitivity import Effect
from debrisflow.study.tables import OneAtATime, Study

Floats = NDArray[np.float64]
OF_SHARES = "A share may come out below 0 or above 1 within its confidence."
OF_CORRELATED = "It holds what the parameters make too that are correlated with this one."
OF_MORRIS = (
    "Effects: change of the quantity per change of the parameter, as a share of all its values "
    "below, by 1. A large sigma beside mu*: not linear, or together with other parameters. "
    "Bars: 95 % confidence of mu*."
)


def draw_sensitivity(
    study: Study,
    points: Sequence[Values],
    values: Floats,
    effects: Sequence[Effect],
    name: str,
    unit: str,
    folder: Path,
) -> list[Path]:
    """Draw what the parameters do to a quantity into a folder, and return the files.

    Parameters
    ----------
    study : Study
    points : sequence of dict
        Of the members of the design.
    values : (members,) float64 array
        Of the quantity; nan where there is none.
    effects : sequence of Effect
        On the quantity, see :func:`debrisflow.study.sensitivity.sensitivity`.
    name, unit : str
        Of the quantity.
    folder : Path
        Existing.

    Returns
    -------
    list of Path
        Empty if no member has a value.

    Raises
    ------
    OutputError
        If the operating system refuses.
    """
    there = int(np.isfinite(values).sum())
    if there == 0:
        return []
    words = name.replace("_", " ")
    source = (
        f"{study.title}: {study.design.type}, {there} of {len(values)} members have a value. "
        f"debrisflow {__version__}"
    )
    with styled():
        figures: dict[str, tuple[str, Figure, str]] = {
            "tornado": (
                f"Change by each parameter: {words}",
                tornado_figure(study, points, values, name, unit),
                explanation(study, values),
            )
        }
        if not isinstance(study.design, OneAtATime):
            title = f"Members by their parameters: {words}"
            drawn = scatter_figure(study, points, values, name, unit)
            figures["scatter"] = (title, drawn, EXPLANATION)
        measures = {one.measure for one in effects if np.isfinite(one.value)}
        if "S1" in measures:
            title = f"Shares of the variance: {words} ({effects[0].method})"
            text = f"{OF_SHARES} {OF_CORRELATED}" if study.correlation else OF_SHARES
            figures["shares"] = (title, shares_figure(effects), text)
        if "mu_star" in measures:
            title = f"Elementary effects (Morris): {words}"
            figures["morris"] = (title, morris_figure(effects, unit), OF_MORRIS)
        return [
            save(figure, folder / f"{name}_{kind}.png", title, [text, source])
            for kind, (title, figure, text) in figures.items()
        ]
