"""The runs of ``torture.py``: shipped cases with inflow, made small, with probes of all kinds."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from debrisflow.case import build_case, dump_case

SHIPPED = Path(__file__).parents[1] / "cases"
Tables = dict[str, Any]
CHANGES: dict[str, tuple[str, Tables]] = {
    "2D": (
        "flume2d",
        {
            "geometry": {"length": 2.0, "bed_start": 0.6, "bed_end": 1.92},
            "time": {"end": 4.0, "settling": 0.3},
            "output": {"interval": 0.1, "checkpoint_interval": 0.01},
            "probe": [
                {"type": "section", "name": "outlet", "x": 1.8, "interval": 0.02},
                {
                    "type": "line",
                    "name": "line",
                    "start": [1.2, 0.01],
                    "end": [1.2, 0.15],
                    "interval": 0.05,
                },
                {
                    "type": "grid",
                    "name": "grid",
                    "x": [0.6, 1.9],
                    "y": [0.0, 0.2],
                    "interval": 0.1,
                },
            ],
        },
    ),
    "3D": (
        "check_dam3d",
        {
            "particles": {"spacing": 0.01},
            "output": {"interval": 0.025, "checkpoint_interval": 0.01},
        },
    ),
    "terrain": (
        "channelled_fan",
        {
            "particles": {"spacing": 2.0},
            "time": {"end": 60.0},
            "output": {"interval": 2.0, "layer_interval": 1.0, "checkpoint_interval": 0.5},
        },
    ),
}
"""Shipped cases and what is changed in them: wall times of some seconds, many files."""


def write_case(name: str, folder: Path) -> Path:
    """Write the case of a run, into a folder."""
    shipped, changes = CHANGES[name]
    tables = tomllib.loads((SHIPPED / f"{shipped}.toml").read_text(encoding="utf-8"))
    tables = _changed(tables, changes)
    path = folder / f"{name}.toml"
    path.write_text(dump_case(build_case(tables, folder=SHIPPED)), encoding="utf-8")
    return path


def _changed(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> Tables:
    """Return tables with changes, table by table; a list is replaced."""
    found = dict(tables)
    for key, value in changes.items():
        found[key] = _changed(found.get(key, {}), value) if isinstance(value, dict) else value
    return found
