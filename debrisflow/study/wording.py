"""A study in words: its distributions, its design, what it is compared with, how it is fitted."""

from __future__ import annotations

from pathlib import Path

from debrisflow.study.distributions import (
    AnyParameter,
    Choice,
    LogNormal,
    Normal,
    Triangular,
    Uniform,
)
from debrisflow.study.tables import AnyDesign, AnyObservation, Calibration, Extent


def law_in_words(parameter: AnyParameter) -> str:
    """Return the distribution of a parameter.

    Examples
    --------
    >>> known = dict(name="mu", key="x")
    >>> law_in_words(Uniform(distribution="uniform", low=0.1, high=0.2, **known))
    'uniform from 0.1 to 0.2'
    >>> law_in_words(Normal(distribution="normal", mean=1.0, deviation=0.5, low=0.0, **known))
    'normal, mean 1, standard deviation 0.5, from 0 on'
    """
    match parameter:
        case Uniform(low=low, high=high):
            return f"uniform from {low:g} to {high:g}"
        case Normal(mean=mean, deviation=deviation, low=low, high=high):
            return f"normal, mean {mean:g}, standard deviation {deviation:g}{_bounds(low, high)}"
        case LogNormal(median=median, deviation=deviation):
            return (
                f"lognormal, median {median:g}, standard deviation of the logarithm {deviation:g}"
            )
        case Triangular(low=low, likely=likely, high=high):
            return f"triangular from {low:g} to {high:g}, most likely {likely:g}"
        case Choice(values=values):
            return "one of " + ", ".join(
                f"{value:g}" if isinstance(value, float) else value for value in values
            )


def _bounds(low: float | None, high: float | None) -> str:
    if low is None and high is None:
        return ""
    if high is None:
        return f", from {low:g} on"
    return f", up to {high:g}" if low is None else f", from {low:g} to {high:g}"


def design_in_words(design: AnyDesign) -> str:
    """Return a design with its settings; of a file its name.

    Examples
    --------
    >>> from debrisflow.study.tables import SobolSequence
    >>> design_in_words(SobolSequence(type="sobol", members=64, seed=1))
    'sobol: members = 64, seed = 1'
    """
    settings = design.model_dump(exclude={"type"})
    if "file" in settings:
        settings["file"] = Path(settings["file"]).name
    told = ", ".join(f"{key} = {value}" for key, value in settings.items())
    return f"{design.type}: {told}"


def observation_in_words(observation: AnyObservation) -> str:
    """Return what the members are compared with, and its error.

    Examples
    --------
    >>> from debrisflow.study.tables import Figure
    >>> observation_in_words(Figure(type="figure", quantity="reach", value=250.0, error=20.0))
    'reach = 250, standard deviation of its error 20'
    """
    if isinstance(observation, Extent):
        false = observation.error if observation.false_error is None else observation.false_error
        return (
            f"{observation.name}: {Path(observation.file).name}, errors of the missed area "
            f"{observation.error:g} and of the falsely reached {false:g} of the observed one"
        )
    return (
        f"{observation.quantity} = {observation.value:g}, standard deviation of its error "
        f"{observation.error:g}"
    )


def calibration_in_words(calibration: Calibration) -> str:
    """Return how the parameters are fitted, and what tests the fit.

    Examples
    --------
    >>> calibration_in_words(Calibration(runs=20, predictive=8)).partition(".")[0]
    '20 runs in all, and 8 drawn from the posterior'
    """
    drawn = f", and {calibration.predictive} drawn from the posterior"
    runs = f"{calibration.runs} runs in all{drawn if calibration.predictive else ''}"
    part = calibration.held_out
    if part is None:
        return (
            f"{runs}. Nothing was held out, so that the fit is not tested on what it has not seen"
        )
    sides = [
        f"{axis} from {side[0]:g} to {side[1]:g} m"
        for axis, side in (("x", part.x), ("y", part.y))
        if side is not None
    ]
    return f"{runs}. Held out, and compared afterwards: the observed extents in {', '.join(sides)}"
