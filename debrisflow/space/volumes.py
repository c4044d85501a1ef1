"""What a case builds otherwise than it asks: rounded lengths, and the volumes of its fills."""

from __future__ import annotations

from collections.abc import Iterator

from debrisflow.case import Case, ResolvedCase
from debrisflow.case.bodies import BoxObstacle, MeshFill
from debrisflow.case.built import Rounded, roundings
from debrisflow.case.regions import Region, covered, occupied, surface_of, volume_left
from debrisflow.case.tables import Bed, Block
from debrisflow.space.carving import filled

SMALL = 0.01  # of a volume


def differences(case: ResolvedCase) -> list[Rounded]:
    """Return what is built otherwise than asked; of the volumes of fills what is over 1 % off."""
    return [*roundings(case), *_volumes(case)]


def _volumes(case: ResolvedCase) -> Iterator[Rounded]:
    """Yield the volumes of fills, in two dimensions areas, that differ from what is asked."""
    word, unit = ("area", " m2") if case.dimension == 2 else ("volume", " m3")
    for k, places in enumerate(filled(case)):
        asked = _volume_asked(case.asked or case, k)
        built = len(places) * case.particles.spacing**case.dimension
        if asked is not None and abs(built - asked) > SMALL * asked:
            yield Rounded(f"fill.{k}, {word}", asked, built, unit, asked)


def _volume_asked(case: Case, number: int) -> float | None:
    """Return what obstacles and later fills leave of a fill, m2 or m3; None if a mesh cuts it."""
    part = case.fill[number]
    area = covered(part, case.geometry, case.particles)
    if area is None:
        return None
    holes: list[Region] = []
    others = [(body, occupied(body)) for body in case.obstacle]
    later = case.fill[number + 1 :]
    for body, hole in (*others, *((b, covered(b, case.geometry, case.particles)) for b in later)):
        if hole is None or area.overlap(hole).volume == 0.0:
            continue
        if not isinstance(body, BoxObstacle | Block | Bed) or isinstance(part, MeshFill):
            return None
        holes.append(hole)
    return surface_of(part).volume if isinstance(part, MeshFill) else volume_left([area], holes)
