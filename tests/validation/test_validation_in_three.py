"""Is the physics of the explicit scheme right: still water, experiments, a cube of mixture.

The coarse runs only; finer ones and their figures: scripts/validate.py still3d dam_break3d marin.
"""

from __future__ import annotations

import pytest

from tests.validation import dam_break3d, mixture_cube, spheric, still3d
from tests.validation.dam_break import HIGH, SQUARE
