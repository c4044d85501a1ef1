"""Coordinate reference systems of maps: which may be computed in, and whether two are the same.

The names of authorities are looked up by rasterio; without it only what a name itself says is
known.
"""

from __future__ import annotations

import re
from typing import Any

GEOGRAPHIC = re.compile(
    r"^\s*(GEOGCS|GEOGCRS|GEODCRS)\b|CRS:?:?(84|83|27)$|EPSG:+(4326|4258|4269|4267|4283|4612|6668)$",
    re.IGNORECASE,
)
METRE = re.compile(r"met(er|re)s?|m", re.IGNORECASE)
VERTICAL_UNIT = re.compile(r'\bVERT_?(?:CS|CRS)\[.*?UNIT\[\s*"([^"]*)"', re.IGNORECASE | re.DOTALL)
LONGEST_WKT = 20_000  # characters
# Names of GDAL may also be addresses in a network and files, which are read at once.
SAFE = re.compile(
    r"(EPSG|ESRI|IGNF|OGC):+\w+(\+\w+)?|urn:(x-)?ogc:def:crs:[\w.:-]+|"
    r"https?://www\.opengis\.net/def/crs/\w+/[\w.]+/\w+|(WGS|NAD)\d\d|"
    r"(PROJ|GEOG|GEOC|LOCAL_|COMPD_|PROJC|GEOGC|GEOD|COMPOUND|BOUND|ENG|VERT_|VERT)(CS|CRS|RS)\[.*",
    re.IGNORECASE | re.DOTALL | re.ASCII,
)
INSTEAD = "project it to that of the DEM, a system in meters"


def wkt_of(name: str) -> str:
    """Return a system, by its name of an authority or as WKT, as WKT; as it is if it is unknown."""
    crs = _known(name)
    return str(crs.to_wkt()) if crs is not None else name


def fault_of_system(name: str) -> str:
    """Return why nothing can be computed in a system, in words that follow a file; else nothing.

    Examples
    --------
    >>> fault_of_system("urn:ogc:def:crs:OGC:1.3:CRS84").split(";")[0]
    'has geographic coordinates (urn:ogc:def:crs:OGC:1.3:CRS84: degrees)'
    >>> fault_of_system("")
    ''
    """
    crs = _known(name)
    if GEOGRAPHIC.search(name) or (crs is not None and crs.is_geographic):
        short = name if crs is None or len(name) < 40 else crs.to_string()
        short = short if len(short) < 40 else "longitude and latitude"
        return f"has geographic coordinates ({short}: degrees); {INSTEAD}"
    unit = crs.linear_units if crs is not None and crs.is_projected else "m"
    if not METRE.fullmatch(unit or "m"):
        return f"has coordinates in {unit}; {INSTEAD}"
    return ""


def differ(one: str, other: str) -> bool:
    """Return whether two systems are known to differ; one that is not told is taken as the same.

    Of a system with a vertical part, a horizontal one with heights, the horizontal part counts.

    Examples
    --------
    >>> differ("", "EPSG:32610"), differ("EPSG:32610", "EPSG:32610")
    (False, False)
    """
    if not one or not other or one == other:
        return False
    systems = _known(one), _known(other)
    if None in systems:
        return False
    first, second = map(_horizontal, systems)
    return bool(first != second)


def fault_of_heights(wkt: str) -> str:
    """Return why the heights of a system cannot be levels; empty if nothing is said against it.

    Examples
    --------
    >>> fault_of_heights('COMPD_CS["a",PROJCS["b"],VERT_CS["c",UNIT["US survey foot",0.3048]]]')
    'has heights in US survey foot, says its reference system; convert them to meters'
    """
    found = VERTICAL_UNIT.search(wkt[:LONGEST_WKT])
    if found is None or METRE.fullmatch(found[1]):
        return ""
    return f"has heights in {found[1]}, says its reference system; convert them to meters"


def _horizontal(crs: Any) -> Any:
    """Return the horizontal part of a system of rasterio; itself if it has no other part."""
    parts = crs.to_dict(projjson=True).get("components")
    return type(crs).from_user_input(parts[0]) if parts else crs


def _known(name: str) -> Any:
    """Return a system of rasterio; None where that is not installed or does not know it."""
    name = name.strip()
    if len(name) > LONGEST_WKT or not SAFE.fullmatch(name):
        return None
    try:
        from rasterio.crs import CRS
        from rasterio.errors import CRSError
    except ImportError:
        return None
    try:
        return CRS.from_user_input(name)
    except (CRSError, ValueError):  # the latter of a code with odd signs
        return None
