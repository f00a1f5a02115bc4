"""Analysis of an array: what the ratios of the taxels show once everything else is in the model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.gains import Gains, gains
from skin_ident.criticism.array.gate import held_out_gain
from skin_ident.criticism.array.judgement import Judgement, judge, unlike
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.scatter import with_scatter
from skin_ident.criticism.gates.gate import MATERIAL_RMSE, Gain
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

MOST = 0.67  # share of the mean-square error from wrong ratios that a cause must remove to be named
FAR = 0.25  # relative error of the shares that no calibration error reaches,
BEYOND = 5.0  # nor this many times the declared error of calibrations
UNKNOWN = 100.0  # times the largest share, standard error of the share of a dead taxel
DOUBTED = 0.1  # relative standard error added to the share of a taxel in which another fault was found
BENDING = ("saturation", "dead_zone", "hysteresis", "lag", "gain_error", "drift", "crosstalk", "nonlinear_stiffness")


@dataclass(frozen=True, eq=False)
class ArrayCriticism:
    """The result. `gain` is None where no cause was sure enough to be tested on held-out data; `least` is the RMSE, N, that the measured
    shares leave there; `unlike` is the relative difference of the training shares from the declared layout."""

    layout: Layout
    measured: Gains
    judgement: Judgement
    gain: Gain | None
    least: float = 0.0
    unlike: float = 0.0

    @property
    def unexplained(self) -> bool:
        """Whether the ratios are wrong by more than any calibration error, or by far more than the declared one, and no cause has been
        named for it."""
        declared = self.layout.gain_std
        far = FAR if declared is None else min(FAR, BEYOND * declared)
        return not self.named and self.judgement.named is not None and self.unlike > far

    @property
    def named(self) -> bool:
        """Whether a cause is sure, predicts held-out sessions better beyond doubt and by enough to matter, and accounts for most of the
        error from wrong ratios.

        The whitened gain need not be large: a static share is a slow signal, and coloured noise hides most of it.
        """
        gain = self.gain
        if gain is None or gain.lower <= 0.0 or gain.after >= (1.0 - MATERIAL_RMSE) * gain.before:
            return False
        return gain.squares > MOST * (gain.before**2 - self.least**2)


def analyse(
    model: Model,
    layout: Layout,
    sessions: list[Session],
    held: list[int],
    noise: Whitener,
    doubted: list[int],
    thickness_mm: float | None,
    dead: Sequence[int] = (),
) -> ArrayCriticism:
    """Judge the shares of the training sessions under the extended `model`; `held` are indices of held-out sessions.

    `doubted` are taxels in which another fault was found and whose share is less certain; of `dead` ones it is unknown.
    """
    if any(e.cause == "spread_depth" for e in model.effects):  # its initial width and its growth cannot be told apart
        layout = replace(layout, width_declared=False)
    measured = with_scatter(_granted(_without(dead, gains(model, sessions, noise), layout), doubted), layout)
    train = [i for i in range(len(sessions)) if i not in held]
    judgement = judge(layout.of(train), measured.of(train), thickness_mm)
    best = judgement.named
    if best is None:
        return ArrayCriticism(layout, measured, judgement, None)
    gain, least = held_out_gain(model, layout, measured, sessions, held, noise, best)
    return ArrayCriticism(layout, measured, judgement, gain, least, unlike(layout.of(train), measured.of(train), judgement.nothing))


def _without(dead: Sequence[int], measured: Gains, layout: Layout) -> Gains:
    """The shares as if nothing was known of dead taxels: they are put where the layout expects them, with an error larger than any
    share."""
    if not len(dead):
        return measured
    value, covariance, plain = measured.value.copy(), measured.covariance.copy(), Family(layout).shares({})
    seen = np.delete(np.arange(value.shape[1]), dead)
    level = np.sum(plain[:, seen] * value[:, seen], axis=1) / np.maximum(np.sum(plain[:, seen] ** 2, axis=1), 1e-300)
    value[:, dead] = level[:, None] * plain[:, dead]
    covariance[:, dead, :] = covariance[:, :, dead] = 0.0
    covariance[:, dead, dead] = (UNKNOWN * np.abs(value).max()) ** 2
    return replace(measured, value=value, covariance=covariance)


def _granted(measured: Gains, doubted: list[int]) -> Gains:
    if not doubted:
        return measured
    more = np.zeros(measured.covariance.shape)
    for i in doubted:
        more[:, i, i] = (DOUBTED * measured.value[:, i]) ** 2
    return replace(measured, covariance=measured.covariance + more)


def doubted_taxels(named) -> list[int]:
    """The taxels for which the search has named something that changes their static share."""
    places = {n.where for n in named if n.cause in BENDING}
    return sorted(int(w.partition("_")[2]) for w in places if w.startswith("taxel_"))
