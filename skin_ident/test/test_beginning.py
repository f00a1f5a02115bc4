"""Sessions that begin in contact: what a skin remembers of presses that nobody recorded is no zero that warms up, and no drift."""

import numpy as np
import pytest
from rows import rows

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.recording import Recording

K, ARM, TAU = 3000.0, 300.0, 4.0  # N/m, N/m, s
DT, BEFORE_S, SECONDS = 0.02, 12.0, 60.0
NOISE = 0.008  # N


def path(rng, t):
    """Way points half a second to three seconds apart, in contact all the time, taken smoothly."""
    knots = np.cumsum(rng.uniform(0.5, 3.0, t.size))
    knots = np.concatenate([[0.0], knots[knots < t[-1]], [t[-1]]])
    x = np.interp(t, knots, rng.uniform(0.3e-3, 0.9e-3, knots.size))
    return np.convolve(np.pad(x, 20, "edge"), np.hanning(41) / np.hanning(41).sum(), "valid")


def session(seed):
    """A standard linear solid by steps of Euler that are twenty times as fine, pressed at once some time before it is recorded."""
    rng, fine = np.random.default_rng(seed), 20
    t = np.arange(int((BEFORE_S + SECONDS) / DT)) * DT
    x = path(rng, t)
    inner = np.interp(np.arange(t.size * fine) * DT / fine, t, x)
    dashpot, out, start = 0.0, [], int((BEFORE_S - rng.uniform(0.0, 4.0)) / DT)
    for now in inner[start * fine :]:
        out.append(K * now + ARM * (now - dashpot))
        dashpot += (now - dashpot) * DT / fine / TAU
    force, x = np.array(out[::fine]), x[start:]
    noisy = force + NOISE * rng.standard_normal(force.size)
    taxel = 0.4 * force + 0.4 * NOISE * rng.standard_normal(force.size)
    return Recording(f"session_{seed}", np.arange(x.size) * DT, x, noisy, taxel[None])


@pytest.mark.parametrize("seed", rows(range(3), 0))
def test_a_skin_that_was_pressed_before_has_no_zero_that_warms_up(seed):
    made = [session(10 * seed + i) for i in range(4)]
    content = diagnose(made[:3], made[3:]).findings
    assert [(f["cause"], f["where"]) for f in content["findings"]] == [("stress_relaxation", "skin")]
    assert content["gain_by_channel"]["force"]["held_out_rmse_after"] < NOISE
    assert "begins in contact" in content["recordings"][0]["compared"]["because"]
