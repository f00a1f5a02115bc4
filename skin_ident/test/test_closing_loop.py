"""A loop of a sensor whose way in and way out meet at zero, as in its data sheet: it is the sensor's, and nothing of the skin's beside it.

The loop is written out here with reversals in newtons; in the model that is fitted a reversal counts by how many times the load changes.
"""

import numpy as np
import pytest
from rows import rows
from test_sound_records import branches, noise, presses

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.recording import Recording

TURNED = 0.12  # share of the peak that the load changes on the way from one branch to the other


def between_branches(load: np.ndarray) -> np.ndarray:
    """Place z (N,) between the branch of the way in (1) and that of the way out (-1)."""
    z = [0.0]
    for step in np.diff(load) / (0.5 * TURNED * load.max()):
        z.append(z[-1] + step * (1.0 - z[-1] * np.sign(step)) if abs(step) < 1.0 else float(np.sign(step)))  # gradual, as Dahl's
    return np.array(z)


def session(seed: int, height: dict[str, float]) -> Recording:
    """Presses with reversals at many depths, and loops of these half heights, as shares of the reading."""
    t, x = presses(seed, 80.0)
    x = x + np.where(x > 2e-4, 1.2e-4 * np.sin(2.0 * np.pi * 0.9 * t), 0.0)
    rng, (sensed, dispersed, _) = np.random.default_rng([seed, 6]), branches(x)
    clean = {"load_cell": sensed + dispersed, "taxel": 0.7 * sensed}
    force, taxel = (y * (1.0 - height.get(name, 0.0) * between_branches(y)) + noise(rng, t.size, 0.05, 0.7) for name, y in clean.items())
    return Recording(f"session_{seed}", t, x, force, taxel[None])


@pytest.mark.parametrize(("where", "seed"), rows([(w, s) for s in (1, 11) for w in ("load_cell", "taxel")], 2))
def test_a_loop_that_closes_at_zero_is_the_sensors(where, seed):
    outcome = diagnose([session(seed, {where: 0.02}), session(seed + 1, {where: 0.02})], [session(seed + 2, {where: 0.02})])
    assert [(f["cause"], f["where"]) for f in outcome.findings["findings"]] == [("hysteresis", where)]
