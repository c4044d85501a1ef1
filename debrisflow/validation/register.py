"""All comparisons, in the order in which they are listed."""

from __future__ import annotations

from debrisflow.validation.at_rest import (
    still_dam,
    still_ground,
    still_tank,
    still_water,
    terrain_pool,
    tilted_tank,
)
from debrisflow.validation.beds import endless_bed, kynch, sedimentation, settling
from debrisflow.validation.comparison import Comparison, Group
from debrisflow.validation.dam_breaks import (
    check_dam,
    gate,
    jet_on_dam,
    koshizuka_oka,
    martin_moyce,
    martin_moyce3d,
    moving_walls,
    plate_jet,
    spheric2,
    wet_bed,
    zhou,
)
from debrisflow.validation.debris_flows import (
    collapse,
    coulomb_slab,
    flume3d,
    flume_deposit,
    long_flume,
    mixture_cube,
    runout3d,
    short_flume,
    usgs_flume,
    voellmy_layer,
    voellmy_slab,
)
from debrisflow.validation.field import st_helens
from debrisflow.validation.granular import grain_film, heap3d, plane_shear, staron_hinch, vescovi
from debrisflow.validation.viscous import (
    deposit3d,
    film3d,
    rough_film,
    slurry_film,
    start_up,
    taylor_green,
)

_MODULES = (
    still_water,
    tilted_tank,
    still_tank,
    still_ground,
    terrain_pool,
    still_dam,
    start_up,
    taylor_green,
    rough_film,
    slurry_film,
    film3d,
    deposit3d,
    martin_moyce,
    martin_moyce3d,
    koshizuka_oka,
    wet_bed,
    zhou,
    spheric2,
    plate_jet,
    jet_on_dam,
    check_dam,
    gate,
    moving_walls,
    settling,
    sedimentation,
    kynch,
    endless_bed,
    plane_shear,
    grain_film,
    vescovi,
    heap3d,
    staron_hinch,
    coulomb_slab,
    long_flume,
    short_flume,
    flume_deposit,
    collapse,
    mixture_cube,
    flume3d,
    runout3d,
    voellmy_layer,
    voellmy_slab,
    usgs_flume,
    st_helens,
)


def _by_name() -> dict[str, Comparison]:
    found = [comparison for module in _MODULES for comparison in module.COMPARISONS]
    order = list(Group)
    found.sort(key=lambda comparison: order.index(comparison.group))  # stable within a group
    return {comparison.name: comparison for comparison in found}


COMPARISONS = _by_name()
"""By name."""
