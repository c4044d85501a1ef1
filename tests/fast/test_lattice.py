"""Lattice constants: number of neighbors, n0 and lambda of an influence radius."""

import numpy as np
import pytest

from debrisflow.neighbors.lattice import reference
from tests.building import RADII

# Hand sums: dimension, radius in spacings, neighbors, n0, lambda / d0^2.
FIGURES = [
    (2, 3.1, 28, 18.9764, 2.4485),
    (2, 2.1, 12, 6.5397, 1.3884),
    (3, 2.4, 56, 22.8093, 2.1036),
    (3, 2.1, 32, 14.4186, 1.7017),
]


@pytest.mark.parametrize(("dimension", "radius", "neighbors", "n0", "lambda_"), FIGURES)
def test_constants_have_their_known_figures(dimension, radius, neighbors, n0, lambda_):
    lattice = reference(dimension, radius, 1.0)
    assert lattice.neighbors == neighbors
    # half a unit of the last digit given
    assert lattice.number_density == pytest.approx(n0, abs=5e-5)
    assert lattice.laplacian_lambda == pytest.approx(lambda_, abs=5e-5)


@pytest.mark.parametrize(("dimension", "radius"), [*RADII, (2, 1.5), (2, 4.7), (3, 3.6)])
def test_constants_are_the_sums_over_the_lattice(dimension, radius):
    points = np.stack(np.meshgrid(*dimension * [np.arange(-6.0, 7.0)]), axis=-1)
    r = np.linalg.norm(points.reshape(-1, dimension), axis=1)
    r = r[(r > 0) & (r < radius)]
    w = radius / r - 1
    lattice = reference(dimension, radius, 1.0)
    assert lattice.neighbors == r.size
    # the same terms, added in another order
    assert lattice.number_density == pytest.approx(w.sum(), rel=1e-13)
    assert lattice.laplacian_lambda == pytest.approx((w * r**2).sum() / w.sum(), rel=1e-13)


@pytest.mark.parametrize(("dimension", "radius"), RADII)
def test_only_lengths_scale_with_the_spacing(dimension, radius):
    one, small = reference(dimension, radius, 1.0), reference(dimension, radius, 0.02)
    assert (small.dimension, small.neighbors) == (dimension, one.neighbors)
    assert small.number_density == one.number_density
    # one rounding each
    assert small.spacing == 0.02
    assert small.effective_radius == pytest.approx(0.02 * radius, rel=1e-15)
    assert small.laplacian_lambda == pytest.approx(0.02**2 * one.laplacian_lambda, rel=1e-15)


def test_a_point_at_the_radius_is_not_a_neighbor():
    assert reference(2, 2.0, 1.0).neighbors == 8
    assert reference(3, 3.0, 1.0).neighbors == 92
