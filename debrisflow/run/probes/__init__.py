"""The samplers of the probes: each file in this folder holds one, named after the probe's type.

The file ``TYPE.py`` defines one :class:`debrisflow.run.probe.Sampler`; the table of the probe in a
case stands in ``debrisflow/case/probes/TYPE.py``.
"""

from __future__ import annotations

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.probe import Probe, only_subclass
from debrisflow.errors import OutputError
from debrisflow.neighbors.patches import Band, Patch
from debrisflow.particles.seeding import wall_particles
from debrisflow.particles.state import State
from debrisflow.run.probe import Column, Sampler
from debrisflow.run.wall_pressure import patches_in


def samplers(case: ResolvedCase, state: State) -> dict[str, Sampler]:
    """Return the samplers of the probes of a case by the name of the probe.

    At the first step of a run the running sums of the probes are put into the state, and at each
    beginning the patches of walls whose forces they read.

    Raises
    ------
    CaseError
        If the place of a probe is wrong in a way that shows only among the particles.
    OutputError
        If a state that is continued lacks the running sum of a probe.
    """
    classes = {probe.name: sampler_of(probe.type) for probe in case.probe}
    walls = state.particles
    if case.has_surfaces and any(sampler.reads_walls(case) for sampler in classes.values()):
        walls = wall_particles(case)  # surfaces, drawn once for all probes
    found = {
        probe.name: classes[probe.name](
            probe, case, walls if classes[probe.name].reads_walls(case) else state.particles
        )
        for probe in case.probe
    }
    patches: list[Patch | Band] = []
    for sampler in found.values():
        sampler.patch_row = len(patches)
        patches.extend(sampler.patches)
    state.patches = patches_in(case, patches)
    if len(state.patch_force) != len(patches):
        state.patch_force = np.zeros((len(patches), 3))
    for name, sampler in found.items():
        if sampler.sum_shape is None:
            continue
        if name in state.sums and state.sums[name].shape == sampler.sum_shape:
            continue
        if state.step > 0:
            raise OutputError(
                f"the checkpoint holds no running sum of the probe '{name}': it is no probe of the "
                "run that wrote it, or an older version wrote it; start the run again"
            )
        state.sums[name] = np.zeros(sampler.sum_shape)
    return found


def columns_of(probe: Probe, dimension: int) -> tuple[Column, ...]:
    """Return the columns of a probe after the time."""
    return sampler_of(probe.type).columns(dimension)


def sampler_of(name: str) -> type[Sampler]:
    """Return the sampler class of a type of probe."""
    return only_subclass(f"{__name__}.{name}", Sampler)
