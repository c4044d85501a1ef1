"""Has an answer moved?  Renew the curves by scripts/renew_regression.py only, with the reason."""

from __future__ import annotations

import numpy as np
import pytest

from tests.slow.regression.small_cases import COLUMNS, CURVES, SMALL_CASES, curve, read

# Share of the range of a curve.  Another processor rounds otherwise, and particles are chaotic: a
# change of 1e-12 m in every initial position moved these curves by up to 8e-4 within their time.
TOLERANCE = 0.005


@pytest.mark.parametrize("name", SMALL_CASES)
def test_the_curves_of_a_small_case_have_not_moved(name, tmp_path):
    found, kept = curve(name, tmp_path / name), read(CURVES / f"{name}.csv")
    assert found.shape == kept.shape
    for k, column in enumerate(COLUMNS):
        scale = np.ptp(kept[:, k][np.isfinite(kept[:, k])]) or 1.0
        np.testing.assert_allclose(
            found[:, k], kept[:, k], atol=TOLERANCE * scale, rtol=0, err_msg=column
        )
