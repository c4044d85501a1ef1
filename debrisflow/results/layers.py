"""The layers of a map in the folder of a run, as rasters."""

from __future__ import annotations

from pathlib import Path

from debrisflow.case.rasters import EmptyRasterError, Raster, UnreadableRasterError, read_raster
from debrisflow.errors import OutputError
from debrisflow.run.layers import ENDINGS, FOLDER, LAYERS


def layer_names(run: Path) -> list[str]:
    """Return the names of the layers that the folder of a run holds, in the order of their table.

    Raises
    ------
    OutputError
        If it holds none.
    """
    names = [name for name in LAYERS if layer_file(run, name) is not None]
    if not names:
        raise OutputError(
            f"{run} holds no layers of a map in {FOLDER}/: only a run on a terrain writes them"
        )
    return names


def read_layer(run: Path, name: str) -> Raster:
    """Return a layer of a run; nan where it has no data, which may be everywhere.

    Parameters
    ----------
    run : Path
        Its folder.
    name : str
        Of :data:`debrisflow.run.layers.LAYERS`.

    Raises
    ------
    OutputError
        If the run has no such layer, or its file is damaged.
    """
    file = layer_file(run, name)
    if file is None:
        raise OutputError(f"{run} has no layer '{name}'; it has {', '.join(layer_names(run))}")
    try:
        return read_raster(file)
    except EmptyRasterError as empty:
        return empty.raster
    except UnreadableRasterError as error:
        raise OutputError(f"{file} {error}") from error


def layer_file(run: Path, name: str) -> Path | None:
    """Return the file of a layer; GeoTIFF before text, None for none."""
    files = [run / FOLDER / f"{name}.{ending}" for ending in ENDINGS]
    return next((file for file in files if file.is_file()), None)
