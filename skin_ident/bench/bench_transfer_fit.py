"""Thesis eq 32 from data: ours beside what one would take instead. Error, coverage and time on the same sessions.

    bench_transfer_fit.py [--runs 20]        (./skin bench transfer_fit: as it stands)

Every contender gets the input, the output and the sampling period. Those that fit a discrete model have its poles and static gain turned
into the continuous ones. `error` is the worst of alpha_1, alpha_0 and static gain, relative, median over the runs; `covers` is how often
its own 95 % intervals of alpha_1 and alpha_0 hold the truth, where it gives any; `time` that of its quickest run. Libraries that are not
installed are named as such: lmfit, mujoco[sysid], pysindy, sippy_unipi, sysidentpy.
"""

import argparse
import importlib
import os
import time
import warnings
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import rivals
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter, lsim

from skin_ident.estimators.transfer_data import Pair
from skin_ident.estimators.transfer_fit import output_error
from skin_ident.estimators.transfer_function import TransferFunction

TRUTH = TransferFunction((6.69, 37.1), (8.57, 48.4))
DT = 0.01
START = np.array([3.0, 20.0, 5.0, 30.0])


def session(n: int, seed: int, rho: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Input and output, 1 % noise, white or AR(1)."""
    rng, t = np.random.default_rng(seed), np.arange(n) * DT
    u = 5 + 3 * np.sin(1.9 * t) + 2 * np.sin(6.9 * t + 1) + 1.5 * np.sin(17 * t + 2)
    y = TRUTH.simulate(u, DT)
    w = lfilter([np.sqrt(1 - rho**2)], [1, -rho], rng.normal(size=n + 1000))[1000:]
    return u, y + 0.01 * np.std(y) * w


def answer(theta, std=None):
    """alpha_1, alpha_0, gain and their standard errors."""
    _, b0, a1, a0 = theta
    values = np.array([a1, a0, b0 / a0])
    return values, None if std is None else np.array([std[2], std[3], np.nan])


def ours(u, y):
    """output_error."""
    fit = output_error([Pair("bench", u, y, DT)])
    return answer(fit.function.theta, fit.std)


def ours_compared(u, y, whiten=False):
    """The same without a noise model."""
    fit = output_error([Pair("bench", u, y, DT)], whiten=whiten)
    return answer(fit.function.theta, fit.std)


def _by_hand(simulate):
    def run(u, y):
        fit = least_squares(lambda p: simulate(p, u) - y, START, x_scale=np.abs(START))
        dof = y.size - 4
        covariance = np.linalg.inv(fit.jac.T @ fit.jac) * 2 * fit.cost / dof
        return answer(fit.x, np.sqrt(np.diag(covariance)))

    return run


def _lsim(p, u):
    return p[1] / p[3] * u[0] + lsim((p[:2], [1.0, *p[2:]]), u - u[0], np.arange(u.size) * DT)[1]


def _lfilter(p, u):
    num, den, _ = cont2discrete((p[:2], [1.0, *p[2:]]), DT, "foh")
    return p[1] / p[3] * u[0] + lfilter(num.ravel(), den, u - u[0])


def lmfit_lfilter(u, y):
    """lmfit around the same simulation."""
    lmfit = importlib.import_module("lmfit")
    start = lmfit.Parameters()
    for i, value in enumerate(START):
        start.add(f"p{i}", value)
    fit = lmfit.minimize(lambda p: _lfilter(np.array([p[f"p{i}"].value for i in range(4)]), u) - y, start)
    p = [fit.params[f"p{i}"] for i in range(4)]
    return answer([q.value for q in p], [q.stderr or np.nan for q in p])


def _rival(of):
    return lambda u, y: answer(*of(u, y, DT))


SLOW = ("scipy least_squares + lsim", "mujoco.sysid", "SIPPY OE")
CONTENDERS = {
    "ours": ours,
    "ours, white noise assumed": ours_compared,
    "scipy least_squares + lfilter": _by_hand(_lfilter),
    "scipy least_squares + lsim": _by_hand(_lsim),
    "lmfit + lfilter": lmfit_lfilter,
    "mujoco.sysid": _rival(rivals.mujoco_sysid),
    "PySINDy": _rival(rivals.pysindy_linear),
    "SIPPY OE": _rival(rivals.sippy_output_error),
    "SIPPY ARX": _rival(rivals.sippy_arx),
    "SysIdentPy FROLS": _rival(rivals.sysidentpy_narx),
    "SysIdentPy FROLS, extended": _rival(partial(rivals.sysidentpy_narx, extended=True)),
}


def run(name, contender, n: int, runs: int, rho: float):
    """One line of the table."""
    truth, _ = answer(TRUTH.theta)
    errors, hits, took = [], [], []
    for seed in range(runs):
        u, y = session(n, seed, rho)
        begin = time.perf_counter()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                values, std = contender(u, y)
        except ImportError:
            return f"{name:<32} not installed"
        took.append(time.perf_counter() - begin)
        errors.append(np.max(np.abs(values / truth - 1)))
        if std is not None:
            hits += list(np.abs(values - truth)[:2] <= 1.96 * std[:2])
    if not took:
        return f"{name:<32} not run"
    covers = f"{100 * np.mean(hits):5.1f} %" if hits else "      –"
    return f"{name:<32} {100 * np.median(errors):9.3f} % {covers:>9} {1e3 * min(took):10.2f} ms {len(took):>6}"


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--slow", type=int, default=2, help="runs of the contenders that need seconds each")
    parser.add_argument("--samples", type=int, nargs="+", default=[4000, 60_000])
    chosen = parser.parse_args()
    for n, rho in [(n, rho) for n in chosen.samples for rho in (0.0, 0.95) if n < 10_000 or rho == 0.0]:
        print(f"\n{n} samples at 100 Hz, 1 % {'white' if rho == 0 else f'AR({rho})'} noise")
        print(f"{'':<32} {'error':>11} {'covers':>9} {'time':>13} {'runs':>6}")
        for name, contender in CONTENDERS.items():
            print(run(name, contender, n, chosen.slow if name in SLOW else chosen.runs, rho), flush=True)


if __name__ == "__main__":
    main()
