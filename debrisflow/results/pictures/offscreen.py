"""Whether VTK can render without a screen, which it does not tell but dies of."""

from __future__ import annotations

import subprocess
import sys

from debrisflow.errors import OutputError

PATIENCE = 120.0  # seconds; on a busy machine the import of VTK alone takes some
PROBE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(16, 16))
plotter.add_mesh(pyvista.Sphere())
plotter.screenshot(return_img=True)
"""
NO_DRIVER = (
    "VTK cannot render off screen here: it found no driver.\n"
    "Install EGL (Debian, Ubuntu: apt install libegl1 libgl1-mesa-dri) or OSMesa (libosmesa6),\n"
    "or call debrisflow render on a desktop."
)


def require_offscreen() -> None:
    """Render a small picture in a process of its own, where a crash does no harm.

    Raises
    ------
    OutputError
        If there comes none.
    """
    try:
        subprocess.run(
            [sys.executable, "-c", PROBE], check=True, capture_output=True, timeout=PATIENCE
        )
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        raise OutputError(NO_DRIVER) from error
