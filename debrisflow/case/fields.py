"""What the tables of the case file are made of: a frozen model, and fields with their unit."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, Strict

NONE = "-"
NAME_PATTERN = r"^[a-z][a-z0-9_]*$"
Interval = Annotated[tuple[float, float], Strict(False)]
Vector = Annotated[tuple[float, float], Strict(False)]
Series = Annotated[tuple[float, ...], Strict(False)]
Point = Annotated[tuple[float, float, float], Strict(False)]
Components = Annotated[tuple[float, ...], Strict(False), Field(min_length=2, max_length=3)]


def quantity(unit: str, description: str, default: Any = ..., **limits: Any) -> Any:
    """Return a pydantic field that carries its unit into the JSON schema."""
    return Field(default, description=description, json_schema_extra={"unit": unit}, **limits)


class Table(BaseModel):
    """A frozen table of the case file that refuses unknown keys and non-finite numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)
