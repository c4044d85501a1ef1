"""A report on all results of a folder: one HTML file that needs nothing else."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path

from markupsafe import Markup, escape

from debrisflow import __version__
from debrisflow.results.html import picture_of, write_html
from debrisflow.validation.figures import FIGURES
from debrisflow.validation.page import anchor, computed_by
from debrisflow.validation.result import Result, count
from debrisflow.validation.table import summary

REPORT = "report.html"


def coded(text: str) -> Markup:
    """Return a text as HTML in which code stands between backquotes.

    Examples
    --------
    >>> print(coded("`a < b`, or not"))
    <code>a &lt; b</code>, or not
    """
    return Markup(re.sub(r"`([^`]*)`", r"<code>\1</code>", str(escape(text))))


def write_report(folder: Path, results: Sequence[Result]) -> Path:
    """Write the report of a folder and return it.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    path = folder / REPORT
    groups = [
        (group, anchor(group), list(members))
        for group, members in groupby(results, lambda result: result.comparison.group)
    ]
    pictures = {}
    for result in results:
        name = result.comparison.name
        file = folder / FIGURES / f"{name}.png"
        if file.is_file():
            pictures[name] = picture_of(file, file.name, result.comparison.title)
    write_html(
        path,
        "validation.html",
        {
            "language": "en",
            "title": "Validation",
            "groups": groups,
            "counts": {anchor(group): count(members) for group, _, members in groups},
            "pictures": pictures,
            "summary": summary(results),
            "finest": summary([result.finest() for result in results]),
            "computed": computed_by(results),
            "version": __version__,
            "coded": coded,
            "made": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        },
        package="debrisflow.validation",
        style="validation.css",
    )
    return path
