"""The first run after an installation, which compiles, against later ones, which read the cache."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
STEPS = """
from hashlib import sha256
from debrisflow._jit import COMPILATIONS
from debrisflow.particles.start import initial_state
from debrisflow.schemes.choice import scheme_of
from tests.building import tank3d_case

case = tank3d_case(size=(1.2, 0.6, 1.0), fill=[{
    "type": "block", "x": [0.0, 0.5], "y": [0.0, 0.6], "z": [0.0, 0.6], "material": "water"
}])
scheme, state = scheme_of(case), initial_state(case)
scheme.fill_number_density(state)
for _ in range(5):
    dt = scheme.stable_dt(state)
    scheme.step(state, dt)
    state.time, state.dt, state.step = state.time + dt, dt, state.step + 1
p = state.particles
digest = sha256(p.position.tobytes() + p.velocity.tobytes() + p.pressure.tobytes())
print(COMPILATIONS.seconds > 5.0, digest.hexdigest())
"""


def test_a_run_that_compiles_has_the_bits_of_one_that_reads_the_cache(tmp_path):
    told = [
        subprocess.run(
            [sys.executable, "-c", STEPS],
            env=os.environ | {"XDG_CACHE_HOME": str(tmp_path)},
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        for _ in range(2)
    ]
    assert [compiled for compiled, _ in told] == ["True", "False"]
    assert told[0][1] == told[1][1]
