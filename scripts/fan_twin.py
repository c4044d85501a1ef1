"""Write the synthetic event of ``cases/studies/fan_twin.toml``: a run, disturbed as surveys are.

    python scripts/fan_twin.py

The case of the study is computed with the true parameters.  Its arrivals and its run-out get normal
errors with the deviations that the study states.  The border of its extent is shifted outward or
inward by a smooth random field: 2 m standard deviation, which is one cell, over 15 m.  The polygons
are written; the figures are printed, to be copied into the study.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter

from debrisflow.case.vectors import write_polygons
from debrisflow.results.layers import read_layer
from debrisflow.run.layers import polygons_of
from debrisflow.run.loop import program
from debrisflow.study.computing import compute
from debrisflow.study.distributions import Values
from debrisflow.study.loading import load_study
from debrisflow.study.member import Cases, members_of
from debrisflow.study.quantities import quantities_of
from debrisflow.study.tables import Figure, Study

STUDIES = Path(__file__).parent.parent / "cases" / "studies"
TRUTH: Values = {"friction": 0.17, "pore_pressure": 0.45}
SEED = 22
SHIFT, ALONG = 2.0, 15.0  # m, of the border, and over which it keeps


def observe(study: Study, truth: Values, folder: Path, extent: Path, seed: int) -> dict[str, float]:
    """Compute a run in a folder, write its disturbed extent and return its disturbed figures."""
    (member,) = members_of(Cases(study), folder, [truth], program())
    folder = member.folder
    outcome = compute(member.case, folder, member.digest, program())
    random = np.random.default_rng(seed)
    depth = read_layer(folder, "peak_depth")
    reached, cell = np.isfinite(depth.values), depth.grid.cell
    inside = cell * (distance_transform_edt(reached) - distance_transform_edt(~reached))
    field = gaussian_filter(random.standard_normal(reached.shape), ALONG / cell)
    shifted = inside + SHIFT * field / field.std() > 0.0
    write_polygons(extent, polygons_of(depth.grid, shifted), crs=depth.grid.crs)
    found = quantities_of(study, folder, outcome)
    return {
        one.quantity: found[one.quantity].value + one.error * float(random.standard_normal())
        for one in study.observation
        if isinstance(one, Figure)
    }


def main() -> None:
    """Write the extent and print the figures."""
    study = load_study(STUDIES / "fan_twin.toml")
    with TemporaryDirectory() as folder:
        extent = STUDIES / "data" / "fan_twin_extent.geojson"
        for name, value in observe(study, TRUTH, Path(folder), extent, SEED).items():
            print(f"{name} = {value:.4g}")


if __name__ == "__main__":
    main()
