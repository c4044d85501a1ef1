"""The sampler of the flow at a point."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase
from debrisflow.case.probes.point import PointProbe
from debrisflow.particles.record import Particles
from debrisflow.particles.state import State
from debrisflow.run import row_mean
from debrisflow.run.probe import Column, Sampler
from debrisflow.space.domain import domain

Floats = NDArray[np.float64]
REACH = 2.0  # spacings
WET = 1.0  # spacings; with no particle nearer than this the point is dry
WORST_CONDITION = 1000.0  # of the moments, above which a slope is not told


class PointFlow(Sampler):
    """Velocity, pressure and concentration at a point, means over the steps since the row before.

    The value at the point of the straight line nearest to the particles within two spacings, by
    least squares with the weight ``(1 - r / R)^2``: exact for fields that vary linearly, beside a
    wall and under a surface too.  Where the particles stand in a line or are too few it is their
    weighted mean.  Steps in which the point is dry count neither in the means nor in ``wet``.
    """

    sum_shape = row_mean.sum_shape(6)
    averaged = ("velocity", "pressure", "concentration", "wet")

    def __init__(self, probe: PointProbe, case: ResolvedCase, particles: Particles) -> None:
        self._name, self._axes = probe.name, case.dimension
        self._place = np.array([probe.x, probe.y, probe.z or 0.0])
        self._spacing, self._period = case.particles.spacing, domain(case).period

    @staticmethod
    def columns(dimension: int) -> tuple[Column, ...]:
        """Return velocity, pressure, concentration, and the share of time that it was wet."""
        mean = "mean since the row before over the time that the point was wet, nan if it was dry"
        return (
            *(Column(f"velocity_{axis}", "m/s", mean) for axis in "xyz"[:dimension]),
            Column("pressure", "Pa", mean),
            Column("concentration", "", f"volumetric, of sediment; {mean}"),
            Column("wet", "", "share of the time since the row before in which it was"),
        )

    @staticmethod
    def headline(dimension: int) -> tuple[str, ...]:
        """See :meth:`Sampler.headline`."""
        return tuple(f"velocity_{axis}" for axis in "xyz"[:dimension])

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the means since the sample before."""
        means = row_mean.mean_since_row(state.sums[self._name], state, self._flow(state))
        wet, values = means[0], np.full(5, np.nan)
        if wet > 0.0:
            values = means[1:] / wet
        return (*map(float, values[: self._axes]), *map(float, values[3:]), float(wet))

    def add_step(self, state: State) -> None:
        """Add the last step."""
        row_mean.add_step(state.sums[self._name], state, self._flow(state))

    def _flow(self, state: State) -> Floats:
        """Return 1 and velocity, pressure and concentration at the point; zeros where it is dry."""
        p, fluid = state.particles, state.particles.fluid
        offset = p.position[fluid] - self._place
        repeat = np.where(self._period > 0.0, self._period, np.inf)
        offset -= np.where(self._period > 0.0, self._period, 0.0) * np.rint(offset / repeat)
        near = np.flatnonzero(np.all(np.abs(offset) < REACH * self._spacing, axis=1))
        offset = offset[near, : self._axes] / self._spacing
        distance = np.linalg.norm(offset, axis=1)
        if distance.min(initial=np.inf) > WET:
            return np.zeros(6)
        fields = np.column_stack([p.velocity[near], p.pressure[near], p.concentration[near]])
        weight = np.maximum(1.0 - distance / REACH, 0.0) ** 2
        return np.concatenate([[1.0], _value_at_origin(offset, weight, fields)])


def _value_at_origin(offset: Floats, weight: Floats, fields: Floats) -> Floats:
    """Return the value at the origin of the nearest linear function of each field.

    Examples
    --------
    >>> offset = np.array([[-0.5, 0.0], [0.5, 0.0], [0.5, 1.0], [1.5, 0.0]])
    >>> _value_at_origin(offset, np.ones(4), 3.0 + offset @ [[2.0], [1.0]]).round(9)
    array([3.])
    """
    basis = np.column_stack([np.ones(len(offset)), offset])
    moments = basis.T @ (weight[:, None] * basis)
    if len(offset) > offset.shape[1] and np.linalg.cond(moments) < WORST_CONDITION:
        return np.asarray(np.linalg.solve(moments, basis.T @ (weight[:, None] * fields))[0])
    return np.asarray(weight @ fields / weight.sum())
