"""Records for the tests of the gates: loops and slow bends of a plain skin, with white noise, steps and zeros that a test asks for."""

import numpy as np

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.signals import motion

RATE = 100.0
T = np.arange(4000) / RATE
DEPTH = 0.5e-3 + 0.3e-3 * np.sin(0.9 * T) + 0.1e-3 * np.sin(4.1 * T)
PLAIN = Model(Dispersion(m=0.0, b1=900.0, k1=9000.0, b2=600.0, k2=3000.0), shares=(1.0,))
QUICK = Gain("force", ("force",), before=0.02, after=0.0185, ci95=(0.001, 0.002), relative=0.1, lower=0.05, held_out="")


def recorded(
    model: Model, depth: np.ndarray = DEPTH, noise: float = 0.01, step: float = 0.0, zero: float = 0.0, seed: int = 3
) -> Recording:
    """Channels of `model`, the force off by `zero` N, with white noise and rounded to `step` N."""
    rng = np.random.default_rng(seed)
    truth = model.simulate(motion(T, depth))
    y = np.vstack([truth.force + zero, truth.taxels]) + noise * rng.standard_normal((2, T.size))
    y = step * np.round(y / step) if step else y
    return Recording("made", T, depth, y[0], y[1:])


WHITE = fit_whitener([residual(PLAIN, prepare(recorded(PLAIN)))], [prepare(recorded(PLAIN))])
