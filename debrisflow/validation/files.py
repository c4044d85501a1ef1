"""Where the shipped cases and the tables of measurements lie."""

from __future__ import annotations

from pathlib import Path

from debrisflow.case.templates import templates

REFERENCES = Path(__file__).parent / "references"
CASES = next(iter(templates().values())).parent
