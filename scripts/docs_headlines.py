"""What the README says of the accuracy, a part of scripts/docs.py."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import click

from debrisflow.validation.page import anchor
from debrisflow.validation.result import Result
from debrisflow.validation.row import Row
from debrisflow.validation.table import summary

# words, and comparison, level and measure of the row
HEADLINES = (
    (
        "still water, 20 rows: rms error of the pressure over that at the floor",
        ("still_water", "20 rows", "rms error of the pressure / pressure at the floor"),
    ),
    (
        "dam break of Martin & Moyce, 32 particles across: rms of the front, shifted in time",
        ("martin_moyce", "a/32", "rms of the front, after the best shift"),
    ),
    (
        "dam break against a box, three dimensions: rms of the level before the box (0.15 m deep)",
        ("spheric2", "d0 = 31 mm", "rms of the level H2 to 2 s"),
    ),
    (
        "flume with a movable bed (A1): time of the front from 2.0 to 6.9 m, calibrated",
        ("flume2d", "20 mm", "front from 2.0 to 6.9 m (fitted)"),
    ),
    (
        "flume of the USGS: mean arrival at 66 m, one friction fitted at 32 m",
        ("usgs_flume", "100 mm", "mean arrival at 66 m"),
    ),
    (
        "landslide near Mount St. Helens: run-out along its path, friction fitted",
        ("st_helens", "2 m", "run-out along the path"),
    ),
)


def headlines(results: Sequence[Result]) -> Iterator[str]:
    """Yield the table of accuracy of some results, and how many rows are within their limits."""
    by_name = {result.comparison.name: result for result in results}
    yield "| what | computed (reference) |"
    yield "|---|---|"
    for words, (name, label, measure) in HEADLINES:
        result, row = row_of(by_name, name, label, measure)
        address = f"docs/validation.md#{anchor(result.comparison.group)}"
        yield f"| [{words}]({address}) | {row.shown_value()} |"
    yield ""
    yield (
        "The [validation page](docs/validation.md) has all; `debrisflow validate --quick` computes "
        "a part of them"
    )
    yield (
        f"on your machine in ten minutes. In all, over {len(results)} comparisons: "
        f"{summary(results)}."
    )


def row_of(by_name: dict[str, Result], name: str, label: str, measure: str) -> tuple[Result, Row]:
    """Return a row and its result, or say how it is computed."""
    result = by_name.get(name)
    rows = result.rows if result else []
    found = [row for level, row in rows if (level.label, row.measure) == (label, measure)]
    if result is None or not found:
        raise click.ClickException(
            f"no row '{measure}' of {name} at {label}, which the README shows; compute it with: "
            f"debrisflow validate {name} -o docs/validation"
        )
    return result, found[0]
