"""The seeding of mixes."""

import numpy as np
import pytest

from debrisflow.particles import seed
from tests.building import tank_case


@pytest.mark.parametrize("share", [0.2, 0.55])
def test_a_mix_has_its_share_everywhere(share):
    columns, rows, spacing = 40, 20, 0.01
    case = tank_case(columns, rows, "mix", spacing=spacing)
    fill = case.fill[0].model_copy(update={"sediment_share": share})
    particles = seed(case.model_copy(update={"fill": (fill,)}))
    fluid = particles.fluid
    sediment = np.zeros((columns, rows))
    i, j = (particles.position[fluid, :2] / spacing).astype(int).T
    sediment[i, j] = particles.sediment_fraction[fluid]
    assert sediment.sum() == pytest.approx(share * columns * rows, abs=0.5)
    squares = sediment.reshape(columns // 2, 2, rows // 2, 2).sum(axis=(1, 3))
    # rounding may move one particle at either end of a square; at random it would be far more
    assert np.abs(squares - 4 * share).max() < 2.0
    assert squares.std() < 0.8 * np.sqrt(4 * share * (1 - share))
    # no pattern that repeats: every row holds about its share
    assert np.abs(sediment.mean(axis=0) - share).max() < 0.25
