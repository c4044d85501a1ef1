"""The free surfaces of all frames of a run, for ParaView and pyvista."""

from __future__ import annotations

from pathlib import Path

from debrisflow.results.reader import BAR, Run
from debrisflow.results.surfaces import free_surface
from debrisflow.run.atomic import made
from debrisflow.run.bar import bar
from debrisflow.run.names import POSTPROCESS, SURFACES
from debrisflow.run.vtu import write_collection, write_mesh


def write_surfaces(run: Run) -> Path:
    """Write the free surface of each frame as ``surface/NNNNNN.vtp``, and return their PVD.

    Raises
    ------
    OutputError
        If a frame is damaged, the folder cannot be written, or a surface is too large.
    """
    listing, written = made(run.folder / POSTPROCESS) / SURFACES, []
    frames = bar(run.frames(), total=len(run.files), desc=f"{run.name}: surfaces", bar_format=BAR)
    for number, frame in enumerate(frames):
        file = made(listing.with_suffix("")) / f"{number:06d}.vtp"
        write_mesh(file, free_surface(frame, run.case, run.walls(frame.time)).mesh)
        written.append((frame.time, file))
    write_collection(listing, written)
    return listing
