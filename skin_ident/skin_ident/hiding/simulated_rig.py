"""Recordings of a simulated rig with the errors of a real one: coloured noise, converter steps, and depth noise."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from skin_ident.recordings.declared import Declared
from skin_ident.recordings.recording import Recording
from skin_ident.separating.path import planned
from skin_models.model import Model
from skin_models.signals import motion
from skin_motion_profiles.entry import Entry


@dataclass(frozen=True)
class SimulatedRig:
    """A rig's sensor errors; the steps are those of the thesis's converters (its sections 3.1 and 3.3).

    `noise_steps` is the standard deviation of the force noise in converter steps, `colour` its AR(1) coefficient; `wobble` is the standard
    deviation of white noise on the plunger's depth.
    """

    rate: float = 100.0  # Hz
    force_step: float = 0.0678  # N
    taxel_step: float = 0.107  # N
    encoder_step: float = 1e-6  # m
    wobble: float = 0.3e-6  # m
    noise_steps: float = 0.7
    colour: float = 0.5

    def record(self, model: Model, battery: Entry, seed: int, name: str = "") -> Recording:
        """One session of `battery` on a specimen that behaves as `model`, as the sensors read it. Raises `ProfileError`."""
        path = planned(battery, 1.0 / self.rate)
        rng = np.random.default_rng([seed, 3])
        x = path.x + self.wobble * rng.standard_normal(len(path))
        true = model.simulate(motion(path.t, x, path.v, path.a), seed)
        force = self._read(np.asarray(true.force), self.force_step, rng)
        taxels = [self._read(row, self.taxel_step, rng) for row in true.taxels]
        depth = self.encoder_step * np.round(x / self.encoder_step)
        return Recording(name or f"session_{seed}", path.t, depth, force, np.array(taxels), declared=self._declared(len(taxels)))

    def _read(self, y: np.ndarray, step: float, rng: np.random.Generator) -> np.ndarray:
        white = rng.standard_normal(y.size)
        coloured = lfilter([np.sqrt(1.0 - self.colour**2)], [1.0, -self.colour], white)
        return step * np.round((y + self.noise_steps * step * coloured) / step)

    def _declared(self, taxels: int) -> Declared:
        return Declared(force_step_n=self.force_step, taxel_step_n=(self.taxel_step,) * taxels, encoder_step_um=1e6 * self.encoder_step)


def varied(model: Model, seed: int, spread: float = 0.1) -> Model:
    """Another specimen: stiffness and damping of both branches vary by `spread` (log-normal)."""
    rng = np.random.default_rng([seed, 7])
    d = model.dispersion
    names = ("b1", "k1", "b2", "k2")
    return replace(model, dispersion=replace(d, **{n: getattr(d, n) * float(np.exp(spread * rng.standard_normal())) for n in names}))
