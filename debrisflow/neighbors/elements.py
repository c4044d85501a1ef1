"""Sums over what a closed surface encloses, as integrals over the surface.

By the divergence theorem, from small elements of the surface: with r from a particle outside to an
element, n out of the solid, and lengths in spacings,

    N = -sum of A(r) r.n / r^3,  m likewise with A_m,  G = -sum of psi n,
    T = -sum of psi (r n) - I sum of C r.n / r^3

times the areas, where ``A = int_r^R w s^2 ds``, ``A_m = int_r^R (1 - s/R)^2 s^2 ds``,
``psi = R/r - 1 - ln(R/r)`` and ``C = int_r^R psi s^2 ds``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from debrisflow._jit import kernel

Floats = NDArray[np.float64]
SQRT_HALF = 0.7071067811865476
EXACT = 1.0  # spacings, within which the solid angle of an element is exact
QUARTERED = 1.5  # spacings, within which wide elements count by their quarters
WIDE = 0.34  # spacings from the middle to the farthest corner; wider than a side of half a spacing


class Elements(NamedTuple):
    """Elements of closed surfaces, triangles no wider than a part of a spacing.

    Attributes
    ----------
    corners : (e, 3, 3) float64 array, m
        Of the triangles, on the surface.
    middle, inner : (e, 3) float64 array, m
        Their middles on the surface, and on the solid of the sums, which lies a little behind it.
    normal : (e, 3) float64 array
        Unit normals out of the solid.
    area : (e,) float64 array, m2
        On the solid of the sums.
    size : (e,) float64 array, m
        From the middle to the farthest corner.
    number : (e,) int64 array
        Of the wall that they belong to.
    is_face : (e,) bool array
        False where an element lies in a wall of the space, so that nothing meets it; in two
        dimensions false for the rows of :mod:`debrisflow.neighbors.rows` alone, and only these
        count in the sums.
    """

    corners: Floats
    middle: Floats
    inner: Floats
    normal: Floats
    area: Floats
    size: Floats
    number: NDArray[np.int64]
    is_face: NDArray[np.bool_]


@kernel
def surface_integrands(r, radius):
    """Return A, A_m, psi and C at a distance, in spacings.

    Examples
    --------
    >>> surface_integrands(2.4, 2.4)[2], round(surface_integrands(1.2, 2.4)[2], 4)
    (0.0, 0.3069)
    """
    cube, r2 = r * r * r, r * r
    whole = radius * radius * radius
    logarithm = np.log(radius / r)
    a = 0.5 * radius * (radius * radius - r2) - (whole - cube) / 3.0
    smooth = cube * (1.0 / 3.0 - r / (2.0 * radius) + r2 / (5.0 * radius * radius))
    psi = radius / r - 1.0 - logarithm
    c = whole / 18.0 - 0.5 * radius * r2 + 4.0 / 9.0 * cube + cube / 3.0 * logarithm
    return a, whole / 30.0 - smooth, psi, c


@kernel
def _part_of(a, b, c, p):
    """Return along one axis the corners of quarter p of a triangle; p = 4 is all of it."""
    if p == 4:
        return a, b, c
    if p == 3:
        return 0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)
    own = a if p == 0 else (b if p == 1 else c)
    return 0.5 * (a + own), 0.5 * (b + own), 0.5 * (c + own)


@kernel
def middle_of_quarter(e, p, mx, my, mz, elements, scale):
    """Return the middle of quarter p of triangle e, whose own is (mx, my, mz)."""
    if p == 3:
        return mx, my, mz
    c, middle, half = elements.corners[e, p], elements.middle[e], 0.5 * scale
    return (
        mx + half * (c[0] - middle[0]),
        my + half * (c[1] - middle[1]),
        mz + half * (c[2] - middle[2]),
    )


@kernel
def seen_angle(e, p, x, y, z, elements):
    """Return the solid angle of quarter p of triangle e, of all of it if p is 4.

    It is the integral of r.n / r^3, negative as seen from outside.

    References
    ----------
    Van Oosterom & Strackee 1983, doi:10.1109/TBME.1983.325207.
    """
    c = elements.corners[e]
    # of the triangle on the solid of the sums
    x, y, z = (
        x - elements.inner[e, 0] + elements.middle[e, 0],
        y - elements.inner[e, 1] + elements.middle[e, 1],
        z - elements.inner[e, 2] + elements.middle[e, 2],
    )
    ax, bx, cx = _part_of(c[0, 0] - x, c[1, 0] - x, c[2, 0] - x, p)
    ay, by, cy = _part_of(c[0, 1] - y, c[1, 1] - y, c[2, 1] - y, p)
    az, bz, cz = _part_of(c[0, 2] - z, c[1, 2] - z, c[2, 2] - z, p)
    a = np.sqrt(ax * ax + ay * ay + az * az)
    b = np.sqrt(bx * bx + by * by + bz * bz)
    length = np.sqrt(cx * cx + cy * cy + cz * cz)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    below = a * b * length + (ax * bx + ay * by + az * bz) * length
    below += (bx * cx + by * cy + bz * cz) * a + (cx * ax + cy * ay + cz * az) * b
    return 2.0 * np.arctan2(volume, below)


@kernel
def add_elements(x, y, z, listed, count, elements, radius, spacing, stretch, total):
    """Add the sums over the solids within reach of a place outside them.

    Each integrand is that at the middle of an element, or where a wide one is near at those of its
    quarters.  Of near ones the solid angle is exact, and psi, which grows with 1/r, is that of the
    mean distance over a disc.

    Parameters
    ----------
    x, y, z : float, m
    listed : (capacity,) int32 array
        Elements near the place, of which the first ``count`` count.
    elements : Elements
    radius : float
        R, in spacings.
    spacing : float, m
    stretch : float
        By how much the sums see the solids farther away than they are.
    total : (11,) float64 array
        n, m, G, and T as xx, yy, zz, xy, xz, yz, in spacings; changed.
    """
    for k in range(count):
        e = listed[k]
        nx, ny, nz = elements.normal[e, 0], elements.normal[e, 1], elements.normal[e, 2]
        mx, my, mz = (
            stretch * (elements.inner[e, 0] - x) / spacing,
            stretch * (elements.inner[e, 1] - y) / spacing,
            stretch * (elements.inner[e, 2] - z) / spacing,
        )
        square = mx * mx + my * my + mz * mz
        if square >= radius * radius:
            continue
        is_split = square < QUARTERED * QUARTERED and elements.size[e] > WIDE * spacing
        area = elements.area[e] * (stretch / spacing) ** 2 * (0.25 if is_split else 1.0)
        for p in range(0 if is_split else 4, 4 if is_split else 5):
            dx, dy, dz = mx, my, mz
            if is_split:
                dx, dy, dz = middle_of_quarter(e, p, mx, my, mz, elements, stretch / spacing)
            r = max(np.sqrt(dx * dx + dy * dy + dz * dz), 1e-3)
            if r >= radius:
                continue
            near = max(1.0 - 0.25 * np.pi * r * r / area, 0.0)
            a, smooth, psi, c = surface_integrands(r, radius)
            if near > 0.0:
                _, _, psi, _ = surface_integrands(
                    np.sqrt(r * r + 0.25 * near * area / np.pi), radius
                )
            toward = area * (dx * nx + dy * ny + dz * nz) / (r * r * r)
            if r < EXACT:
                toward = seen_angle(e, p, x, y, z, elements)
            total[0] -= a * toward
            total[1] -= smooth * toward
            psi *= area
            total[2] -= psi * nx
            total[3] -= psi * ny
            total[4] -= psi * nz
            total[5] -= psi * dx * nx + c * toward
            total[6] -= psi * dy * ny + c * toward
            total[7] -= psi * dz * nz + c * toward
            total[8] -= 0.5 * psi * (dx * ny + dy * nx)
            total[9] -= 0.5 * psi * (dx * nz + dz * nx)
            total[10] -= 0.5 * psi * (dy * nz + dz * ny)


@kernel
def add_sphere(radius, total):
    """Add the sums over all of the reach, which a place inside a solid sees beyond its surface."""
    whole = radius * radius * radius
    total[0] += 2.0 * np.pi / 3.0 * whole
    total[1] += 2.0 * np.pi / 15.0 * whole
    for k in range(3):
        total[5 + k] += 2.0 * np.pi / 9.0 * whole


@kernel
def share_of_side(ax, ay, az, bx, by, bz, px, py, pz):
    """Return how far along a side from a to b the point nearest to p lies, from 0 to 1."""
    ux, uy, uz = bx - ax, by - ay, bz - az
    along = (px - ax) * ux + (py - ay) * uy + (pz - az) * uz
    square = ux * ux + uy * uy + uz * uz
    return min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0


@kernel
def nearest_in(e, x, y, z, elements):
    """Return the vector to a place from the nearest point of triangle e, m.

    That is the foot of the place on its plane if it lies within the triangle, else the nearest
    point of its three sides.
    """
    c = elements.corners[e]
    nx, ny, nz = elements.normal[e, 0], elements.normal[e, 1], elements.normal[e, 2]
    level = (x - c[0, 0]) * nx + (y - c[0, 1]) * ny + (z - c[0, 2]) * nz
    px, py, pz = x - level * nx, y - level * ny, z - level * nz
    inside, best, fx, fy, fz = True, np.inf, px, py, pz
    for k in range(3):
        a, b = c[k], c[(k + 1) % 3]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = px - a[0], py - a[1], pz - a[2]
        turn = (uy * vz - uz * vy) * nx + (uz * vx - ux * vz) * ny + (ux * vy - uy * vx) * nz
        inside &= turn >= 0.0
        t = share_of_side(a[0], a[1], a[2], b[0], b[1], b[2], px, py, pz)
        qx, qy, qz = a[0] + t * ux, a[1] + t * uy, a[2] + t * uz
        square = (px - qx) ** 2 + (py - qy) ** 2 + (pz - qz) ** 2
        if square < best:
            best, fx, fy, fz = square, qx, qy, qz
    if inside:
        return level * nx, level * ny, level * nz
    return x - fx, y - fy, z - fz


@kernel
def _farthest(x, y, z, listed, count, elements):
    """Return the distance beyond which no face of elements is the nearest one, m."""
    least = np.inf
    for k in range(count):
        e = listed[k]
        if elements.is_face[e]:
            dx, dy = elements.middle[e, 0] - x, elements.middle[e, 1] - y
            dz = elements.middle[e, 2] - z
            least = min(least, dx * dx + dy * dy + dz * dz)
    return np.sqrt(least)


@kernel
def _is_beyond(e, x, y, z, distance, elements):
    """Return whether no point of triangle e is within a distance of a place."""
    dx, dy = elements.middle[e, 0] - x, elements.middle[e, 1] - y
    dz, most = elements.middle[e, 2] - z, distance + elements.size[e]
    return dx * dx + dy * dy + dz * dz > most * most


@kernel
def face_of_elements(x, y, z, listed, count, elements, reach, is_second, first, normal):
    """Return distance and number of the face of elements nearest to a place, and whether off a rim.

    Parameters
    ----------
    x, y, z : float, m
    listed : (capacity,) int32 array
        Elements near the place, of which the first ``count`` count.
    elements : Elements
    reach : float, m
        How far a face counts.
    is_second : bool
        Whether only elements count that the place is over, and whose normals are at least 45
        degrees from ``first``, (3,) float64 array.
    normal : (3,) float64 array
        Written: that of the face, at a rim the way from its nearest point.

    Returns
    -------
    float, int, bool
        The distance, m, negative inside; the wall, -1 where none is in reach; whether the place
        is off an edge of the body.
    """
    found, least, slack = -1, reach, 1e-9 * reach
    most = reach if is_second else min(_farthest(x, y, z, listed, count, elements), reach)
    dx, dy, dz, nx, ny, nz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        e = listed[k]
        ex, ey, ez = elements.normal[e, 0], elements.normal[e, 1], elements.normal[e, 2]
        turned = ex * first[0] + ey * first[1] + ez * first[2]
        if not elements.is_face[e] or (is_second and turned > SQRT_HALF):
            continue
        if _is_beyond(e, x, y, z, min(least, most) + 2.0 * slack, elements):
            continue
        wx, wy, wz = nearest_in(e, x, y, z, elements)
        distance = np.sqrt(wx * wx + wy * wy + wz * wz)
        if is_second and wx * ex + wy * ey + wz * ez < (1.0 - 1e-9) * distance:
            continue
        if distance < least - slack:
            found, least, dx, dy, dz = e, distance, wx, wy, wz
            nx, ny, nz = ex, ey, ez
        elif distance <= least + slack and found >= 0:
            # at a side or corner the outside is where all that meet there are turned to
            nx, ny, nz = nx + ex, ny + ey, nz + ez
    if found < 0:
        return reach, -1, False
    outside = dx * nx + dy * ny + dz * nz
    flat = elements.normal
    level = abs(dx * flat[found, 0] + dy * flat[found, 1] + dz * flat[found, 2])
    is_edge = outside > 0.0 and level < (1.0 - 1e-9) * least
    if least > 1e-12 * reach and (is_edge or outside < 0.0):
        sign = 1.0 if outside >= 0.0 else -1.0
        normal[0], normal[1], normal[2] = sign * dx / least, sign * dy / least, sign * dz / least
    else:
        normal[0], normal[1], normal[2] = flat[found, 0], flat[found, 1], flat[found, 2]
    return (least if outside >= 0.0 else -least), elements.number[found], is_edge
