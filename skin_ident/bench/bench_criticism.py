"""What a look at every cause costs: ranking per session of 10,000 samples with 3 taxels, on one core.

The yardstick is the obvious way: one whole simulation for every direction of the catalogue, filtered by scipy at full rate and thinned
afterwards. Both give the same directions; the table says how far apart they are.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable

import numpy as np
from scipy.signal import oaconvolve

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.search.proposals import bank, directions
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion

SAMPLES, SESSIONS, REPEATS = 10_000, 2, 5


def made(seed: int) -> Recording:
    """A session of a simulated skin over three taxels, with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES) / 100.0
    depth = 4e-4 + 3e-4 * np.sin(0.7 * t + seed) + 1e-4 * np.sin(5.3 * t) - 1e-4 * (t < 3.0)
    skin = Model(Dispersion(m=0.000432, b1=939.5, k1=9619.0, b2=629.2, k2=2766.0), shares=(0.3, 1.0, 0.3))
    r = skin.simulate(motion(t, depth))
    noisy = [y + 0.03 * rng.standard_normal(y.shape) for y in (r.force, r.taxels)]
    return Recording(f"made {seed}", t, depth, *noisy)


def obvious(model: Model, which, session) -> np.ndarray:
    """The directions, each by a simulation of its own."""
    base, kernel = simulated(model, session), session.band.kernel[None, :]
    changes = [simulated(model.extended(d.probed), session) - base for d in which]
    return np.array([oaconvolve(c, kernel, mode="valid", axes=-1)[:, :: session.band.every] for c in changes])


def seconds(run: Callable) -> float:
    """Processor time of one run."""
    started = time.process_time()
    run()
    return time.process_time() - started


def main() -> None:
    """Print the table."""
    sessions = [prepare(made(seed)) for seed in range(SESSIONS)]
    model, which = dispersion_start(sessions), directions(sessions[0])
    took = {}
    for name, run in {
        "ranking of every cause": lambda: survey(model, sessions, which),
        "of which the directions": lambda: bank(model, which, sessions),
        "the directions, the obvious way": lambda: [obvious(model, which, s) for s in sessions],
    }.items():
        took[name] = float(np.median([seconds(run) for _ in range(REPEATS)])) / SESSIONS
    print(f"{len(which)} directions, sessions of {SAMPLES} samples, 3 taxels; CPU seconds per session, median of {REPEATS}\n")
    for name, cost in took.items():
        print(f"{name:34} {cost:7.3f} s   ratio to the obvious way {cost / took['the directions, the obvious way']:5.2f}")


if __name__ == "__main__":
    main()
