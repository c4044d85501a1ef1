"""A valley that opens onto a fan, by a formula, and the layers of a flow down it."""

from pathlib import Path

import numpy as np

from debrisflow.case import build_case
from debrisflow.case.rasters import MapGrid, Raster, write_raster
from debrisflow.results.hazard import hazard_map, write_hazard
from debrisflow.results.hazard_classes import read_classes
from debrisflow.run.history import COLUMNS

CRS = (
    'PROJCS["JGD2011 / Japan Plane Rectangular CS VIII",GEOGCS["JGD2011",DATUM["JGD2011",'
    'SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],'
    'UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",36],PARAMETER["central_meridian",138.5],'
    'PARAMETER["scale_factor",0.9999],PARAMETER["false_easting",0],'
    'PARAMETER["false_northing",0],UNIT["metre",1]]'
)
GRID = MapGrid(west=-32_150.0, south=-71_400.0, cell=5.0, columns=90, rows=130, crs=CRS)
APEX = (225.0, 260.0)  # of the fan, m from the south-west corner
TIMES = tuple(range(0, 95, 5))


def middles():
    """Return x and y of the middles of the cells from the south-west corner, (rows, columns), m."""
    x = GRID.cell * (np.arange(GRID.columns) + 0.5)
    y = GRID.cell * (np.arange(GRID.rows)[::-1] + 0.5)
    return np.meshgrid(x, y)


def channel(y):
    """Return where the channel runs, x in m, by y."""
    return APEX[0] + 30.0 * np.sin(np.maximum(y - APEX[1], 0.0) / 60.0)


def terrain():
    """Return the elevation, m: a valley with steep sides, below its apex a fan and a plain."""
    x, y = middles()
    up = y - APEX[1]
    off = np.abs(x - channel(y))
    valley = 412.0 + 0.33 * up + 0.62 * np.maximum(off - 6.0, 0.0)
    ridge = 412.0 + 0.33 * up + 60.0 + 9.0 * np.sin(x / 37.0) + 6.0 * np.sin(y / 29.0 + x / 51.0)
    hills = ridge - np.logaddexp(0.0, (ridge - valley) / 8.0) * 8.0  # the lower of both, rounded
    fan = np.maximum(412.0 - 0.14 * np.hypot(x - APEX[0], up), 372.0 + 0.01 * y)
    above = 1.0 / (1.0 + np.exp(-np.clip(up + 0.12 * off, -200.0, 200.0) / 9.0))
    return above * hills + (1.0 - above) * fan


def flow():
    """Return shape (0 to 1), distance along the flow, m, and the release, of a flow down it."""
    x, y = middles()
    up = y - APEX[1]
    off = np.abs(x - channel(y))
    along = np.where(up > 0.0, 300.0 - up, 300.0 + np.hypot(x - APEX[0], up))
    width = np.where(up > 0.0, 14.0, 14.0 + 0.42 * -up)
    shape = np.exp(-((off / width) ** 2)) * np.clip((520.0 - along) / 60.0, 0.0, 1.0)
    shape *= np.clip((320.0 - up) / 20.0, 0.0, 1.0) * (14.0 / width) ** 0.7
    ragged = 1.0 + 0.15 * np.random.default_rng(1).standard_normal(shape.shape)
    shape = np.where(shape > 0.03, shape * np.clip(ragged, 0.5, 1.5), 0.0)
    release = np.where((up > 260.0) & (up < 310.0) & (off < 17.0), 2.5, np.nan)
    return shape, along, release


def layers():
    """Return the layers that a run would write, (rows, columns) arrays by their names."""
    shape, along, release = flow()
    wet = shape > 0.0
    depth, speed = 2.8 * shape, 11.0 * shape**0.4 * np.clip((560.0 - along) / 400.0, 0.05, 1.0)
    arrival = np.maximum(along - 20.0, 0.0) / 8.0
    last = np.clip((along - 300.0) / 90.0, 0.0, 1.0) * shape * 2.2
    found = {
        "peak_depth": depth,
        "peak_speed": speed,
        "peak_momentum_flux": depth * speed**2,
        "peak_pressure": 1.8 * speed**2,
        "arrival": arrival,
        "duration": 15.0 + 60.0 * shape,
        "deposit": last,
        "final_depth": last,
    }
    found = {name: np.where(wet, values, np.nan) for name, values in found.items()}
    return found | {"release": release, "terrain": terrain()}


def depth_at(time):
    """Return the depth at a time, s, (rows, columns), m."""
    known = layers()
    since = time - known["arrival"]
    part = np.exp(-np.maximum(since, 0.0) / 20.0)
    depth = part * known["peak_depth"] + (1.0 - part) * known["final_depth"]
    depth = np.where(since >= 0.0, depth, np.nan)
    return known["release"] if time == 0 else depth


def fan_case(folder: Path, **tables):
    """Return a case on this terrain, whose file is written into a folder."""
    write_raster(folder / "dem.asc", Raster(GRID, terrain()))
    west, south = GRID.west + 180.0, GRID.south + 520.0
    square = [[west + x, south + y] for x, y in ((0, 0), (35, 0), (35, 45), (0, 45))]
    release = {"type": "polygon", "corners": square, "depth": 4.0, "material": "mixture"}
    friction = {"law": "voellmy", "coefficient": 0.14, "turbulence": 300.0}
    known = {
        "title": "fan",
        "particles": {"spacing": 2.0},
        "geometry": {"type": "terrain", "dem": "dem.asc"},
        "release": [release | tables.pop("release", {})],
        "mixture": {"concentration": 0.5},
        "walls": {"floor": {"friction": friction}},
        "time": {"end": 60.0},
        "output": {"interval": 5.0},
    }
    return build_case(known | tables, folder=folder)


def write_layers(folder: Path, grid=GRID):
    """Write the layers into a run folder, on a grid that may lie elsewhere."""
    folder = folder / "layers"
    folder.mkdir(parents=True, exist_ok=True)
    for name, values in layers().items():
        write_raster(folder / f"{name}.asc", Raster(grid, values))


def write_ledger(folder: Path):
    """Write where the particles are, at the start and at the end."""
    head = "time,released,moving,at_rest,left,through_ground,volume_released"
    rows = ["0,1000,0,1000,0,0,2000", "90,1000,100,880,20,0,2000"]
    (folder / "ledger.csv").write_text("\n".join([head, *rows]) + "\n")


def write_history(folder: Path):
    """Write the totals at the start and at the end, of nothing."""
    rows = [[time, *([0] * (len(COLUMNS) - 1))] for time in (0, 90)]
    lines = [",".join(COLUMNS), *(",".join(map(str, row)) for row in rows)]
    (folder / "history.csv").write_text("\n".join(lines) + "\n")


def write_classes(folder: Path, table="japan"):
    """Write the map of hazard classes of a run folder."""
    write_hazard(folder, hazard_map(folder, read_classes(table)))


def write_frames(folder: Path, grid=GRID):
    """Write the depths at times into the layers of a run folder."""
    listing = ["# time: s", "time,frame"]
    for number, time in enumerate(TIMES):
        raster = Raster(grid, depth_at(time))
        write_raster(folder / "layers" / f"depth_{number:06d}.asc", raster)
        listing.append(f"{time},{number}")
    (folder / "layers" / "depth.csv").write_text("\n".join(listing) + "\n")


def frame_at(time, spacing=1.0):
    """Return particles at a time, s, from the south-west corner: a square grid, in layers."""
    from debrisflow.particles.record import Kind
    from debrisflow.results.frames import Frame

    depth, known = np.nan_to_num(depth_at(time)), layers()
    x, y = middles()
    points, speeds = [], []
    fine = (np.arange(GRID.cell / spacing) + 0.5) * spacing - 0.5 * GRID.cell
    level = known["terrain"]
    slope_y, slope_x = np.gradient(level, -GRID.cell, GRID.cell)
    for dx in fine:
        for dy in fine:
            under = level + slope_x * dx + slope_y * dy
            for layer in range(3):
                there = depth > (layer + 0.5) * spacing if layer else depth > 0.2
                above = under + (layer + 0.5) * spacing
                points.append(np.column_stack([(x + dx)[there], (y + dy)[there], above[there]]))
                fading = np.exp(-np.maximum(time - known["arrival"], 0.0) / 15.0)
                speeds.append((fading * known["peak_speed"])[there])
    position, speed = np.concatenate(points), np.concatenate(speeds)
    velocity = np.column_stack([0.0 * speed, -speed, 0.0 * speed])
    kind = np.full(speed.size, Kind.MIXTURE)
    return Frame(float(time), position, {"kind": kind, "velocity": velocity})
