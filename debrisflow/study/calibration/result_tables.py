"""The tables that a calibration leaves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from debrisflow.run.atomic import made
from debrisflow.run.tables import Row, write_table
from debrisflow.study.calibration.parameter_space import shares_of
from debrisflow.study.calibration.predictive import Score
from debrisflow.study.calibration.result import CalibrationResult

MOST_SAMPLES = 4000  # rows of the posterior that are written
RUNS = ("runs of the calibration; residuals: (computed - observed) / error, nan of failed runs",)
POSTERIOR = ("sample of the posterior, drawn by an emulator of the runs",)
SUMMARY = (
    "parameters before and after the observations: values below which 5, 50 and 95 % lie",
    "ratio: width of the 90 % interval after, over that before",
)
EMULATOR = (
    "error of the emulator, each run by the others; rms in errors of the observation",
    "explained: share of the variance, Q2; standardized: rms of the error over the deviation",
    "  stated, about 1 if that is honest",
    "at_posterior: rms of the error at the predictive runs, which it does not know",
)
CHECK = (
    "observed extents by groups of runs, in the part that was used and that held out",
    "missed, false: areas as shares of the observed one; brier: over the observed cells",
    "covered: share of the observed cells that are reached with a probability of 0.1 at least",
)


def write_tables(found: CalibrationResult, target: Path) -> list[Path]:
    """Write the tables of a calibration into a folder, and return the files.

    Raises
    ------
    OutputError
        If the operating system refuses to write.
    """
    made(target, is_deep=True)
    names = found.space.names
    sample = found.space.values(shares_of(found.posterior.scores))
    step = -(-len(sample) // MOST_SAMPLES)
    chain = found.posterior
    drawing = (
        *POSTERIOR,
        f"{chain.effective:.0f} independent samples, autocorrelation {chain.autocorrelation:.1f} "
        f"of {chain.steps} steps, {chain.acceptance:.2f} of the moves accepted",
    )
    columns = ["number", "kind", *names, *found.residual_names, "misfit", "folder"]
    widths = [f"{when}_{share}" for when in ("prior", "posterior") for share in (5, 50, 95)]
    tables = {
        "runs.csv": (columns, RUNS, _runs(found)),
        "posterior.csv": (names, drawing, sample[::step].tolist()),
        "summary.csv": (
            ["parameter", *widths, "best", "ratio", "verdict"],
            SUMMARY,
            _summary(found),
        ),
        "emulator.csv": (
            ["residual", "explained", "rms", "standardized", "at_posterior"],
            EMULATOR,
            _emulator(found),
        ),
        "extents.csv": (Score._fields, CHECK, found.scores),
    }
    if not found.scores:
        del tables["extents.csv"]
    for name, (columns_of, head, rows) in tables.items():
        write_table(target / name, list(columns_of), head, rows)
    return [target / name for name in tables]


def _runs(found: CalibrationResult) -> Iterator[Row]:
    for number, (run, residuals) in enumerate(zip(found.runs, found.residuals, strict=True)):
        folder = run.evaluated.folder
        yield [
            str(number),
            run.kind,
            *(run.values[name] for name in found.space.names),
            *residuals.tolist(),
            float(found.misfits[number]),
            folder.name if folder else "",
        ]


def _summary(found: CalibrationResult) -> Iterator[Row]:
    best = found.runs[found.best].values
    for one in found.marginals:
        yield [one.name, *one.prior, *one.posterior, best[one.name], one.ratio, one.verdict]


def _emulator(found: CalibrationResult) -> Iterator[Row]:
    errors = found.left_out
    spread = (errors.standardized**2).mean(axis=0) ** 0.5
    columns = errors.explained, errors.rms, spread, found.at_posterior
    for name, *figures in zip(found.residual_names, *columns, strict=True):
        yield [name, *map(float, figures)]
