"""Start-up of plane Poiseuille and Couette flow and of a film on a slope, against their series."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import shapes, tables
from debrisflow.case.rheology import Coulomb
from debrisflow.particles.start import initial_state
from debrisflow.schemes.semi_implicit import SemiImplicit
from debrisflow.validation.cases import case_of

Floats = NDArray[np.float64]
LENGTH, VISCOSITY = 1.0e-3, 1.0e-6
TERMS = np.arange(1, 200)


def poiseuille(y: Floats, tau: float) -> Floats:
    """Return u / u_max at y / L and nu t / L^2 (Morris, Fox & Zhu 1997)."""
    n = 2 * np.arange(100)[:, None] + 1
    decaying = 32.0 / (np.pi * n) ** 3 * np.sin(n * np.pi * y) * np.exp(-((n * np.pi) ** 2) * tau)
    return 4.0 * y * (1.0 - y) - decaying.sum(axis=0)


def couette(y: Floats, tau: float) -> Floats:
    """Return u / U at y / L and nu t / L^2; the wall at y = L moves."""
    n = TERMS[:, None]
    series = 2.0 / (n * np.pi) * (-1.0) ** n * np.sin(n * np.pi * y)
    return y + (series * np.exp(-((n * np.pi) ** 2) * tau)).sum(axis=0)


def film(y: Floats, tau: float) -> Floats:
    """Return u / u_surface at y / h and nu t / h^2: half a channel of twice the depth."""
    return poiseuille(0.5 * y, 0.25 * tau)


def channel(
    rows: int, body_force: tuple[float, float], closed: bool, wall_speed: float
) -> tables.Case:
    """Return a channel of 1 mm, periodic along x, with ``rows`` of particles across."""
    spacing = LENGTH / rows
    length = 16 * spacing
    return case_of(
        title="viscous",
        particles=tables.Particles(spacing=spacing),
        gravity=tables.Gravity(vector=body_force),
        geometry=shapes.Tank(
            type="tank",
            length=length,
            height=LENGTH if closed else 2.0 * LENGTH,
            ceiling=closed,
            periodic=True,
        ),
        fill=(tables.Block(type="block", x=(0.0, length), y=(0.0, LENGTH), material="water"),),
        water=tables.Water(viscosity=1000.0 * VISCOSITY),
        walls=tables.Walls(ceiling=tables.Wall(velocity=(wall_speed, 0.0))),
        time=tables.Time(end=2.0),
        output=tables.Output(interval=0.1),
    )


def error(
    flow: str, rows: int, speed: float, times: tuple[float, ...], implicit: bool = False
) -> float:
    """Return the greatest error of the profile at the times nu t / L^2, in units of ``speed``.

    ``speed`` is that of the steady flow: at mid height, of the moving wall, or at the surface.
    With a strength, which finds no sediment here, viscosity is implicit.
    """
    if flow == "poiseuille":
        case = channel(rows, (8.0 * VISCOSITY * speed / LENGTH**2, 0.0), True, 0.0)
    elif flow == "couette":
        case = channel(rows, (0.0, 0.0), True, speed)
    else:
        force = 2.0 * VISCOSITY * speed / LENGTH**2
        case = channel(rows, (force, -force), False, 0.0)
    if implicit:
        case = case.model_copy(update={"rheology": Coulomb(type="coulomb")})
    exact = {"poiseuille": poiseuille, "couette": couette, "film": film}[flow]
    scheme, state = SemiImplicit(case), initial_state(case)
    p, worst = state.particles, 0.0
    for tau in times:
        end = tau * LENGTH**2 / VISCOSITY
        while state.time < end * (1.0 - 1e-12):
            dt = min(scheme.stable_dt(state), end - state.time)
            scheme.step(state, dt)
            state.time += dt
            state.step += 1
        y, u = p.position[p.fluid, 1] / LENGTH, p.velocity[p.fluid, 0] / speed
        worst = max(worst, float(np.abs(u - exact(y, tau)).max()))
    return worst
