"""The page of the documentation, in Markdown: what was compared, how, and what came out."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator, Sequence
from itertools import groupby
from math import isfinite

from debrisflow.validation.comparison import Group
from debrisflow.validation.figures import FIGURES
from debrisflow.validation.result import Result, count
from debrisflow.validation.row import Row, Verdict, shown
from debrisflow.validation.table import summary

PAGE = "validation.md"
_INTRODUCTION = """\
The tables and figures of this page are written by `debrisflow validate`. Each row is a figure that
was computed, the limit that it is held to, and the reason of the limit: the scatter of the
experiment, the error that an author reports, the resolution; or that it is chosen, and what it is
made of. A value in brackets is that of the reference. "Missed" means outside the limit; below the
table stands why, as far as it is known, and what was tried. "Stated" figures are held to nothing.
d0 is the particle spacing. Rows on conservation (particles that are lost, energy that is gained)
are counted apart.
"""


def page(
    results: Sequence[Result], drawn: Container[str], figures: str = FIGURES, note: str = ""
) -> str:
    """Return the page on some results.

    Parameters
    ----------
    results : sequence of Result
        In the order of the register.
    drawn : container of str
        Names of the comparisons that have a figure.
    figures : str
        Where the figures lie, from the page.
    note : str, optional
        A paragraph after the introduction.
    """
    lines = ["# Validation", "", _INTRODUCTION, *([note, ""] if note else []), *_count(results), ""]
    lines += [*_overview(results), ""]
    for group, members in groupby(results, lambda result: result.comparison.group):
        lines += [f"## {group.value}", ""]
        for result in members:
            lines += _comparison(result)
            name = result.comparison.name
            if name in drawn:
                lines += [f"![{result.comparison.title}]({figures}/{name}.png)", ""]
    return "\n".join(lines).rstrip() + "\n"


def _count(results: Sequence[Result]) -> Iterator[str]:
    """Yield when and by what all was computed, and how many rows of each group are held."""
    yield f"{computed_by(results)} In all, {summary(results)}."
    yield ""
    finest = summary([result.finest() for result in results])
    yield f"At the finest spacing of each alone: {finest}."
    yield ""
    yield "| | rows | within | missed | checks of conservation that hold |"
    yield "|---|---|---|---|---|"
    for group, members in groupby(results, lambda result: result.comparison.group):
        found = count(list(members))
        kept = f"{found.conserved} of {found.conserved + found.not_conserved}"
        cells = (found.held, found.within, found.known + found.missed, kept)
        yield f"| [{group.value}](#{anchor(group)}) | {' | '.join(map(str, cells))} |"


def _overview(results: Sequence[Result]) -> Iterator[str]:
    """Yield a line on each comparison: how many rows are within, its error, and the order."""
    yield "| comparison | name | rows within | error from coarse to fine | order |"
    yield "|---|---|---|---|---|"
    for result in results:
        found, errors = count([result]), result.convergence
        fell = " → ".join(shown(100.0 * step.error) for step in errors.steps)
        order = f"{errors.order:.1f}" if isfinite(errors.order) else "none"
        cells = (
            result.comparison.title,
            f"`{result.comparison.name}`",
            f"{found.within} of {found.held}",
            f"{fell} %" if fell else "",
            order if len(errors.steps) > 1 else "",
        )
        yield "| " + " | ".join(map(_cell, cells)) + " |"


def anchor(group: Group) -> str:
    """Return the address of the section of a group."""
    return group.value.lower().replace(" ", "-")


def computed_by(results: Sequence[Result]) -> str:
    """Return when and by what results were computed, in a sentence."""
    origins = [level.origin for result in results for level in result.levels]
    dates = sorted({origin.date for origin in origins})
    versions = sorted({origin.version for origin in origins})
    kernels = sorted({origin.kernels for origin in origins})
    processors = sorted({f"{one.processor} (Python {one.python})" for one in origins})
    days = " to ".join(dict.fromkeys((dates[0], dates[-1]))) if dates else "never"
    return (
        f"Computed {days} with debrisflow {', '.join(versions)}, kernels {', '.join(kernels)}, on "
        f"one thread of {', '.join(processors)}."
    )


def _comparison(result: Result) -> Iterator[str]:
    one = result.comparison
    yield f"### {one.title}"
    yield ""
    yield f"`{one.name}`. {one.compared}"
    yield ""
    yield f"*Reference:* {_linked(one.reference)}. *Computed with:* {one.parameters}. "
    yield f"*Calibrated:* {one.calibrated}."
    yield ""
    yield "| spacing | measure | value | limit | reason of the limit | verdict |"
    yield "|---|---|---|---|---|---|"
    before, misses = "", result.misses
    for level, row in result.rows:
        yield _row(row, "" if level.label == before else level.label, misses)
        before = level.label
    for failure in result.failures:
        yield f"| {_cell(failure)} | | | | | not computed |"
    for number, reason in enumerate(misses, 1):
        yield ""
        yield f"[{number}] {reason[0].upper()}{reason[1:].rstrip('.')}."
    if one.discussion:
        yield ""
        yield one.discussion
    yield ""
    yield from _convergence(result)


def _row(row: Row, level: str, misses: list[str]) -> str:
    verdict = row.verdict.value
    if row.verdict is Verdict.KNOWN:
        verdict = f"**{verdict}** [{misses.index(row.miss) + 1}]"
    cells = (level, row.measure, row.shown_value(), row.shown_limit(), row.reason, verdict)
    return "| " + " | ".join(map(_cell, cells)) + " |"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _convergence(result: Result) -> Iterator[str]:
    """Yield the errors of the levels, what they cost, and their order."""
    found = result.convergence
    if not result.comparison.error or not found.steps:
        return
    parts = [
        f"{shown(step.error, '%')} at {step.label} ({shown(step.seconds, 's')})"
        for step in found.steps
    ]
    yield (
        f"*Convergence*, {result.comparison.error} (processor time): {', '.join(parts)}; "
        f"{found.in_words()}."
    )
    yield ""


def _linked(text: str) -> str:
    """Return a reference whose DOIs are links.

    Examples
    --------
    >>> _linked("Ritter 1892, doi:10.1/ab")
    'Ritter 1892, [doi:10.1/ab](https://doi.org/10.1/ab)'
    """
    return re.sub(r"doi:(10\.[^\s,;]+[^\s,;.)])", r"[doi:\1](https://doi.org/\1)", text)
