"""Forecast of a case on a terrain: the volumes released and the smoothness of the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from debrisflow.case import ResolvedCase
from debrisflow.case.released import volume, volume_until
from debrisflow.case.resolved import ResolvedHydrographRelease, ResolvedRelease
from debrisflow.case.terrain_speeds import within_reach
from debrisflow.space.ground import ground_of

BENT, SHARP = 0.25, 0.5
"""Mean curvature times influence radius up to which the ground is felt to 1 %, and beyond which its
curvature is not followed."""
AT_EDGE = 2  # cells of the surface along the edges, where it turns level and the flow leaves
LEAST_SHOWN = 0.001  # m, between DEM and surface
MOST_SHARP = 0.01  # of the ground within reach
AT_START, LATER, BY_HYDROGRAPHS = "at t = 0", "of later masses", "by hydrographs"


@dataclass(frozen=True)
class GroundForecast:
    """Figures of a case on a terrain; those of the ground are over the cells within reach.

    Cells along the edges of the DEM are left out.

    Attributes
    ----------
    volumes : dict of str to float, m3
        By the keys of the releases, until the end of the run.
    cell, width : float, m
        Cells of the DEM and of the smooth surface.
    rms, greatest : float, m
        Root mean square and greatest distance of the DEM from the smooth surface, in the middles of
        its cells.
    place : (float, float), m
        Where that is, on the map.
    bent, sharp : float
        Shares of the ground where the mean curvature, of valleys or crests, times the influence
        radius is greater than ``BENT`` and ``SHARP``.
    sharpest : float
        The greatest of it.
    area : float, m2
        Of the ground within reach, in plan.
    """

    volumes: dict[str, float]
    cell: float
    width: float
    rms: float
    greatest: float
    place: tuple[float, float]
    bent: float
    sharp: float
    sharpest: float
    area: float

    def __str__(self) -> str:
        """Return the figures as readable lines, with a warning of a ground that is too sharp."""
        whole = sum(self.volumes.values())
        parts = ", ".join(f"{name}: {format_volume(one)}" for name, one in self.volumes.items())
        apart = "the surface passes through all of them"
        if self.greatest >= LEAST_SHOWN:
            apart = (
                f"the DEM is off it by {self.rms:.2g} m rms, at most {self.greatest:.2g} m at "
                f"{self.place[0]:.0f}, {self.place[1]:.0f}"
            )
        lines = [
            f"released       {format_volume(whole)} m3, {parts}",
            f"ground         cells of {self.width:g} m, of the DEM {self.cell:g} m; {apart}",
            f"within reach   {self.area:,.0f} m2 below the energy line of the least friction",
            f"curvature      |H| r_e > {BENT:g} on {_percent(self.bent)}, > {SHARP:g} on "
            f"{_percent(self.sharp)} of the ground within reach; {self.sharpest:.2g} at most",
        ]
        if self.sharp > MOST_SHARP:
            lines.append(
                f"warning        geometry.cell = {2.0 * self.width:g} m would be smoother: where "
                f"|H| r_e > {SHARP:g}, the ground is felt as if it were less curved"
            )
        return "\n".join(lines)


def format_volume(volume: float) -> str:
    """Return a volume, m3, with three digits, or whole from 1000 m3 on.

    Examples
    --------
    >>> format_volume(22480.68), format_volume(12.345)
    ('22,481', '12.3')
    """
    return f"{volume:,.0f}" if volume >= 1000.0 else f"{volume:.3g}"


def _percent(share: float) -> str:
    """Return a share in percent.

    Examples
    --------
    >>> _percent(0.0), _percent(0.0004), _percent(0.234)
    ('0 %', '0.04 %', '23 %')
    """
    return f"{100.0 * share:.2g} %"


def ground_forecast(case: ResolvedCase) -> GroundForecast:
    """Return the figures of a case on a terrain."""
    ground, terrain = ground_of(case), case.terrain
    cell = ground.grid.cell
    within = within_reach(terrain, case.release, case.zone, case.walls.floor)[::-1].T
    within &= np.isfinite(ground.given)
    edge = round(AT_EDGE * ground.surface.width / cell)
    is_inner = np.zeros_like(within)
    is_inner[edge : within.shape[0] - edge, edge : within.shape[1] - edge] = True
    within &= is_inner
    i, j = np.nonzero(within)
    x, y = ((k.astype(np.float64) + 0.5) * cell for k in (i, j))
    apart = ground.given[i, j] - ground.whole.level(x, y)
    radius = case.particles.effective_radius * case.particles.spacing
    bent = np.abs(ground.surface.mean_curvature(x, y)) * radius
    count, worst = max(1, i.size), int(np.abs(apart).argmax()) if i.size else 0
    place = (ground.grid.west + x[worst], ground.grid.south + y[worst]) if i.size else (0.0, 0.0)
    return GroundForecast(
        volumes={
            f"release.{part.name or number}": _until_end(part, case)
            for number, part in enumerate(case.release)
        },
        cell=cell,
        width=ground.surface.width,
        rms=float(np.sqrt((apart**2).sum() / count)),
        greatest=float(np.abs(apart).max(initial=0.0)),
        place=(float(place[0]), float(place[1])),
        bent=np.count_nonzero(bent > BENT) / count,
        sharp=np.count_nonzero(bent > SHARP) / count,
        sharpest=float(bent.max(initial=0.0)),
        area=i.size * cell**2,
    )


def released_counts(case: ResolvedCase) -> dict[str, int]:
    """Return the particles that a case on a terrain releases, by when and how."""
    counts = dict.fromkeys((AT_START, LATER, BY_HYDROGRAPHS), 0)
    for part in case.release:
        number = _until_end(part, case) / case.particles.spacing**3
        if isinstance(part, ResolvedHydrographRelease):
            counts[BY_HYDROGRAPHS] += int(number)
        else:
            counts[LATER if part.start > 0.0 else AT_START] += round(number)
    return {name: count for name, count in counts.items() if count}


def _until_end(part: ResolvedRelease, case: ResolvedCase) -> float:
    """Return the volume that is released until the end of a run, m3."""
    if isinstance(part, ResolvedHydrographRelease):
        return volume_until(part, case.time.end)
    return volume(part) if part.start <= case.time.end else 0.0
