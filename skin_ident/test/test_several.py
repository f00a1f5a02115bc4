"""Two causes for which several instances of one may stand: a load cell that lags above skin that locks is told as both."""

import numpy as np
import pytest
from rows import rows

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.recording import Recording

DT, SECONDS = 0.01, 40.0
DEEP, LOCKS, K, B = 1.0e-3, 1.35e-3, 1200.0, 12.0  # m, m, N/m, N s/m
TAU = 0.022  # s


def path(rng, t):
    """Triangles at three speeds, a hold and two sines, smoothed."""
    points, at = [(0.0, -2e-4), (1.0, -2e-4)], 1.0
    while at < t[-1]:
        for time in rng.choice([0.25, 0.8, 2.5], 2):
            at += time * rng.uniform(0.8, 1.2)
            points.append((at, rng.uniform(0.5, 1.0) * DEEP if len(points) % 2 == 0 else rng.uniform(-0.2, 0.3) * DEEP))
        at += rng.uniform(0.2, 1.5)
        points.append((at, points[-1][1]))
    x = np.interp(t, *np.array(points).T)
    x = x + 0.03 * DEEP * (np.sin(2 * np.pi * 1.3 * t) + np.sin(2 * np.pi * 3.1 * t))
    return np.convolve(np.pad(x, 15, "edge"), np.hanning(31) / np.hanning(31).sum(), "valid")


def session(seed):
    """Chains that lock, F = K x (1 + 0.05 / (1 - (x / LOCKS)^2)) + B x', under a load cell of the first order, in steps of a fiftieth of a
    sample."""
    rng, fine = np.random.default_rng(seed), 50
    t = np.arange(int(SECONDS / DT)) * DT
    inner = np.arange(t.size * fine) * DT / fine
    x = np.interp(inner, t, path(rng, t))
    press = np.where(x > 0.0, K * x * (1.0 + 0.05 / (1.0 - (x / LOCKS) ** 2)) + B * np.gradient(x, inner), 0.0)
    press, read, late = np.maximum(press, 0.0), 0.0, np.empty(inner.size)
    for i, p in enumerate(press):
        read += (p - read) * DT / fine / TAU
        late[i] = read
    noise = 0.015 * rng.standard_normal((4, t.size))
    taxels = np.array([[0.4], [0.3], [0.2]]) * press[::fine] + 0.4 * noise[1:]
    return Recording(f"session_{seed}", t, x[::fine], late[::fine] + noise[0], taxels)


@pytest.mark.parametrize("seed", rows(range(2), 0))
def test_a_load_cell_that_lags_above_skin_that_locks_is_no_mount_of_two_forms(seed):
    made = [session(10 * seed + i) for i in range(3)]
    findings = diagnose(made[:2], made[2:]).findings["findings"]
    assert {(f["cause"], f["where"]) for f in findings} == {("lag", "load_cell"), ("nonlinear_stiffness", "skin")}
