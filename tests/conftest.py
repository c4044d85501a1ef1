"""Case files that several tests start from."""

from pathlib import Path

import pytest

TANK = """
title = "a column of water"
particles = { spacing = 0.01 }
geometry = { type = "tank", width = 0.4, height = 0.3 }
time = { end = 1.0 }
output = { interval = 0.1 }

[[fill]]
type = "block"
x = [0, 0.2]
y = [0.0, 0.1]
material = "water"
"""

CHANNEL = """
title = "a flume with a bed"
particles = { spacing = 0.02 }
gravity = { slope = 15.0 }
time = { end = 1.0 }
output = { interval = 0.1 }

[geometry]
type = "channel"
length = 4.0
height = 0.4
bed_start = 1.0
bed_thickness = 0.1

[[fill]]
type = "bed"

[inflow]
depth = 0.04
discharge = 0.02
"""


@pytest.fixture
def tank(tmp_path: Path) -> Path:
    path = tmp_path / "tank.toml"
    path.write_text(TANK)
    return path


@pytest.fixture
def channel(tmp_path: Path) -> Path:
    path = tmp_path / "channel.toml"
    path.write_text(CHANNEL)
    return path
