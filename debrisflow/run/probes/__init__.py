"""Probes: what is measured at a place, on a wall or across the flow while a case runs.

All probes read the particles as they are after a step, in both schemes and in two and three
dimensions, and leave them as they are.  Quantities of two dimensions are per meter of width.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from debrisflow.case import ResolvedCase, tables
from debrisflow.case.probes import (
    AnyProbe,
    ForceProbe,
    HeightProbe,
    PressureProbe,
    SectionProbe,
    VolumeProbe,
)
from debrisflow.case.resolved import ResolvedHeightProbe, ResolvedPressureProbe
from debrisflow.errors import CaseError
from debrisflow.neighbors.lattice import reference
from debrisflow.particles.record import Kind, Particles
from debrisflow.particles.state import State
from debrisflow.run.measures import LEAST_DENSITY_RATIO, particle_volume, piled, wetted_width
from debrisflow.run.probes.wall_pressure import (
    Faces,
    face_pressure,
    force,
    nearest_on,
    patch_shares,
    wall_faces,
)
from debrisflow.run.tables import Series
from debrisflow.space.domain import domain
from debrisflow.space.floor import is_over_floor
from debrisflow.space.plan_grid import floor_ends

Floats = NDArray[np.float64]
UPWARD = 0.5  # upward part of the normal above which a wall carries what stands on it
_OF_STEP = "of the step before; at a start that at rest, or none in two dimensions"
_IMPULSE = "of that force since t = 0, summed over all steps"
_TIME = "time: s; end of the step in which the sample was due"


class Measure(Protocol):
    """What takes the samples of one probe."""

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the columns of the probe after the time."""


def probe_measures(case: ResolvedCase, particles: Particles) -> dict[str, Measure]:
    """Return what takes the samples of each probe of a case, by its name.

    Raises
    ------
    CaseError
        If the place of a pressure probe is more than a spacing from its wall.
    """
    measures: dict[str, Measure] = {}
    sections = walls = 0
    for probe in case.probe:
        if isinstance(probe, HeightProbe):
            measures[probe.name] = Height(probe, case, particles)
        elif isinstance(probe, PressureProbe):
            measures[probe.name] = PatchPressure(probe, case, particles)
        elif isinstance(probe, ForceProbe):
            measures[probe.name] = WallForce(probe, case, particles, walls)
            walls += 1
        elif isinstance(probe, VolumeProbe):
            measures[probe.name] = BoxVolume(probe, case)
        else:
            measures[probe.name] = Section(probe, case, sections)
            sections += 1
    return measures


class Height:
    """Height of the fluid in a column with a square base (a strip, in two dimensions).

    Two heights above what the column stands on, the wall under its middle:

    - ``height``, the top of the particles with n >= 0.5 n0 and their centers in the column that
      follow each other upward without a gap of more than 1.5 d0.  It ends below spray and below
      a jet that plunges over air, and steps by what the top particle stands higher or lower.
    - ``filled_height``, the volume of all particles above the wall in the column over the area of
      its base.  Each particle counts by the part of its own square, d0 wide, that the base
      covers, so that the height does not jump when it enters: that of particles on a lattice is
      exact wherever the column stands.  Air in the column lowers it, spray raises it.

    The base ends at the ends of the space; keep it a spacing away from the sides of an obstacle.
    """

    def __init__(
        self, probe: ResolvedHeightProbe, case: ResolvedCase, particles: Particles
    ) -> None:
        self._name = probe.name
        self._d0, self._axes, self._up = case.particles.spacing, case.dimension, case.dimension - 1
        lattice = reference(case.dimension, case.particles.effective_radius, self._d0)
        self._least_density = LEAST_DENSITY_RATIO * lattice.number_density
        self._place = np.array([probe.x, probe.y or 0.0])[: self._up]
        self._period = domain(case).period[: self._up]
        first, last = floor_ends(case, probe.x, probe.y or 0.0)
        half = np.full(self._up, 0.5 * probe.size)
        repeats = self._period > 0.0
        self._lower = -np.where(repeats, half, np.minimum(half, self._place - first))
        self._upper = np.where(repeats, half, np.minimum(half, last - self._place))
        self.base = self._base(particles, case)

    def sample(self, state: State) -> tuple[float, ...]:
        """Return height and filled height, m."""
        p, d0 = state.particles, self._d0
        level = p.position[p.fluid, self._up] - self.base
        offset = self._offset(p.position[p.fluid])
        covered = np.minimum(offset + 0.5 * d0, self._upper) - np.maximum(
            offset - 0.5 * d0, self._lower
        )
        share = np.prod(np.clip(covered, 0.0, None), axis=1)
        filled = d0 * share[level > 0.0].sum() / np.prod(self._upper - self._lower)
        inside = np.all((offset >= self._lower) & (offset < self._upper), axis=1) & (level > 0.0)
        inside &= p.number_density[p.fluid] >= self._least_density
        column = np.zeros(int(np.count_nonzero(inside)), dtype=np.int64)
        pile = level[inside][piled(column, level[inside], d0)]
        height = pile.max() + 0.5 * d0 if pile.size else 0.0
        return float(height), float(filled)

    def _offset(self, position: Floats) -> Floats:
        """Return the horizontal distance from the place, through the nearest image, m."""
        offset = position[:, : self._up] - self._place
        repeat = np.where(self._period > 0.0, self._period, np.inf)
        return np.asarray(
            offset - np.where(self._period > 0.0, self._period, 0.0) * np.rint(offset / repeat)
        )

    def _base(self, p: Particles, case: ResolvedCase) -> float:
        """Return the level of the highest wall under the place that looks up, m."""
        solid = slice(p.inflow.stop, p.count)
        under = np.all(np.abs(self._offset(p.position[solid])) <= (0.5 + 1e-6) * self._d0, axis=1)
        x, y, _ = p.position[solid].T
        under &= is_over_floor(case, x, y)  # not a rim
        under &= (p.kind[solid] == Kind.WALL) & (p.wall_normal[solid, self._up] > UPWARD)
        if not under.any():
            raise CaseError(f"probe '{self._name}': no floor under it looks up; move it aside")
        return float(p.position[solid, self._up][under].max() + 0.5 * self._d0)


class PatchPressure:
    """Mean pressure on a square patch of a wall.

    The mean of :func:`debrisflow.run.probes.wall_pressure.face_pressure` over the faces of the
    wall, each by the part of it that the patch covers; 0 where the patch is dry.  The patch lies
    on the face that is nearest to the given place.
    """

    def __init__(
        self, probe: ResolvedPressureProbe, case: ResolvedCase, particles: Particles
    ) -> None:
        faces = wall_faces(case, particles, probe.wall)
        if len(faces.position) == 0:
            raise CaseError(f"probe '{probe.name}': nothing of {probe.wall} is open to the fluid")
        place = np.array([probe.x, probe.y, probe.z or 0.0])
        center, distance = nearest_on(faces, place, case)
        if distance > (1.0 + 1e-6) * case.particles.spacing:
            raise CaseError(
                f"probe '{probe.name}': the place is {distance:.3g} m from the surface of "
                f"{probe.wall}; at most a spacing"
            )
        share = patch_shares(faces, center, probe.size, case)
        self._case, self._share = case, share[share > 0.0]
        self._faces = Faces(faces.position[share > 0.0], faces.normal[share > 0.0])

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the mean pressure, Pa."""
        pressure = _pressure_on(self._faces, self._case, state)
        return (float(self._share @ pressure / self._share.sum()),)


class WallForce:
    """Force and moment of the pressure on a whole wall: the sum over its faces.

    The impulse since t = 0 is the sum of force and time step over all steps, whatever the interval.
    """

    def __init__(
        self, probe: ForceProbe, case: ResolvedCase, particles: Particles, number: int
    ) -> None:
        self._case, self._number = case, number
        self._faces = wall_faces(case, particles, probe.wall)
        self._area = case.particles.spacing ** (case.dimension - 1)
        self._about = np.zeros(3)
        self._about[: len(probe.about)] = probe.about

    def sample(self, state: State) -> tuple[float, ...]:
        """Return force, moment and impulse, N, N m, N s, in two dimensions per meter of width."""
        push, moment = self._push(state)
        axes = self._case.dimension
        impulse = state.impulse[self._number, :axes]
        turning = moment if axes == 3 else moment[2:]
        return (*map(float, push[:axes]), *map(float, turning), *map(float, impulse))

    def add_impulse(self, state: State) -> None:
        """Add the impulse of the last step to the state; before t = 0 nothing is added."""
        if state.time > 0.0:
            state.impulse[self._number] += state.dt * self._push(state)[0]

    def _push(self, state: State) -> tuple[Floats, Floats]:
        pressure = _pressure_on(self._faces, self._case, state)
        return force(self._faces, pressure, self._area, self._about)


class Section:
    """What flows through the plane x = const.

    The state at the plane is the sum over particles of volume V, velocity u and sediment share f
    nearer than d0 to it, with the weight h = (1 - |x_i - x| / d0) / d0, whose integral is 1:

        A = sum V h,   Q = sum V h u,   Q_s = sum V h u f

    On a lattice the sums are exact wherever the plane stands.  What went through is counted
    particle by particle at every step, so that the volumes are exact whatever the interval, and a
    mean discharge is the difference of two rows.
    """

    def __init__(self, probe: SectionProbe, case: ResolvedCase, number: int) -> None:
        self._x, self._number = probe.x, number
        self._d0, self._axes = case.particles.spacing, case.dimension
        self._volume = particle_volume(case)
        self._period = domain(case).period[0]

    def sample(self, state: State) -> tuple[float, ...]:
        """Return the columns of the section."""
        p, d0 = state.particles, self._d0
        offset = p.position[p.fluid, 0] - self._x
        if self._period > 0.0:
            offset -= self._period * np.rint(offset / self._period)
        rows = np.flatnonzero(np.abs(offset) < d0)
        part = self._volume * (1.0 - np.abs(offset[rows]) / d0) / d0
        flux = part * p.velocity[rows, 0]
        area, discharge = float(part.sum()), float(flux.sum())
        sediment = float(flux @ p.sediment_fraction[rows])
        width = 1.0 if self._axes == 2 else wetted_width(p.position[rows, 1], d0)
        crossed = (state.crossed[self._number], state.crossed_sediment[self._number])
        volumes = [self._volume * float(passed.sum()) for passed in crossed]
        return (
            discharge,
            sediment,
            sediment / discharge if discharge != 0.0 else np.nan,
            discharge / area if area > 0.0 else np.nan,
            area / width if area > 0.0 else 0.0,
            *([width] if self._axes == 3 else []),
            *volumes,
        )


class BoxVolume:
    """Volume of the fluid, and of the sediment in it, whose particles have their centers in a box.

    What is counted is whole particles, so that boxes beside each other add up.
    """

    def __init__(self, probe: VolumeProbe, case: ResolvedCase) -> None:
        extents = (probe.x, probe.y, probe.z or (-np.inf, np.inf))
        self._lower, self._upper = np.array(extents).T
        self._volume = particle_volume(case)

    def sample(self, state: State) -> tuple[float, ...]:
        """Return volume and volume of sediment, m3; in two dimensions m2."""
        p = state.particles
        place = p.position[p.fluid]
        inside = np.all((place >= self._lower) & (place < self._upper), axis=1)
        sediment = float(p.sediment_fraction[p.fluid][inside].sum())
        return np.count_nonzero(inside) * self._volume, sediment * self._volume


class ProbeWriter(Series):
    """Writes ``probes/NAME.csv``; a file that is there already is continued.

    Parameters
    ----------
    path : Path
    probe : HeightProbe, PressureProbe, ForceProbe, SectionProbe or VolumeProbe
    dimension : int
    """

    def __init__(self, path: Path, probe: AnyProbe, dimension: int) -> None:
        columns = _columns(probe, dimension)
        head = [_title(path, f"{probe.type}, {_where(probe)}"), _TIME]
        head += [f"{names}: {meaning}" for names, meaning in _meanings(probe, dimension)]
        super().__init__(path, columns, head)

    def write(self, time: float, sample: Sequence[float]) -> None:
        """Append a sample at a time, s."""
        self.append([(time, *sample)])


def is_probe_file(path: Path) -> bool:
    """Return whether a file was written by a probe."""
    with path.open(encoding="utf-8", errors="replace") as file:
        return file.readline().startswith("# " + _title(path, ""))


def _title(path: Path, rest: str) -> str:
    return f"probe {path.stem}: {rest}"


def _where(probe: AnyProbe) -> str:
    """Return the place of a probe, as in the case file."""
    fields = probe.model_dump(exclude={"name", "interval", "type"}, exclude_none=True)
    return ", ".join(f"{key} = {value}" for key, value in fields.items()) + " (m)"


def _columns(probe: AnyProbe, dimension: int) -> tuple[str, ...]:
    names = (name for group, _ in _meanings(probe, dimension) for name in group.split(", "))
    return ("time", *names)


def _meanings(probe: AnyProbe, dimension: int) -> list[tuple[str, str]]:
    """Return the columns after the time, and what they mean."""
    if isinstance(probe, HeightProbe):
        return [
            (
                "height",
                "m above the wall below; top of the particles that follow each other upward",
            ),
            ("filled_height", "m; volume of all particles in the column over the area of its base"),
        ]
    if isinstance(probe, PressureProbe):
        return [("pressure", f"Pa; mean over the patch, 0 where it is dry; {_OF_STEP}")]
    if isinstance(probe, ForceProbe):
        return _force_meanings(dimension)
    if isinstance(probe, VolumeProbe):
        volume = "m2" if dimension == 2 else "m3"
        return [("volume, sediment_volume", f"{volume}; of the particles in the box")]
    return _section_meanings(dimension)


def _force_meanings(dimension: int) -> list[tuple[str, str]]:
    if dimension == 2:
        return [
            ("force_x, force_y", f"N per meter of width; of the pressure on the wall; {_OF_STEP}"),
            ("moment_z", "N m per meter of width; counterclockwise about the given point"),
            ("impulse_x, impulse_y", f"N s per meter of width; {_IMPULSE}"),
        ]
    return [
        ("force_x, force_y, force_z", f"N; of the pressure on the wall; {_OF_STEP}"),
        ("moment_x, moment_y, moment_z", "N m; about the given point"),
        ("impulse_x, impulse_y, impulse_z", f"N s; {_IMPULSE}"),
    ]


def _section_meanings(dimension: int) -> list[tuple[str, str]]:
    volume = "m2" if dimension == 2 else "m3"
    width = [("width", "m; wetted")] if dimension == 3 else []
    return [
        ("discharge, sediment_discharge", f"{volume}/s; at this time, positive along x"),
        ("concentration", "sediment_discharge / discharge; nan where nothing flows"),
        ("speed", "m/s; discharge over the wetted area, nan where it is dry"),
        ("depth", "m; wetted area over wetted width"),
        *width,
        ("volume, sediment_volume", f"{volume}; net of what went through since t = 0, exact"),
    ]


def _pressure_on(faces: Faces, case: ResolvedCase, state: State) -> Floats:
    p, rows = state.particles, state.particles.fluid
    pressure = p.pressure[rows]
    if isinstance(case.scheme, tables.ExplicitScheme):
        # there walls return the pressure of colliding grains too; that of grains in contact is a
        # part of the whole
        pressure = pressure + p.collision_pressure[rows]
    return face_pressure(faces, case, p.position[rows], pressure, p.density[rows])
