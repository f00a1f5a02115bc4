"""The analysis of an array: what the ratios of the taxels say once everything else is in the model."""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.array.gains import Gains, gains
from skin_ident.criticism.array.gate import held_out_gain
from skin_ident.criticism.array.judgement import Judgement, judge, unlike
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.scatter import with_scatter
from skin_ident.criticism.gates.gate import MATERIAL_RMSE, Gain
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

MOST = 0.67  # of what the ratios get wrong (mean square), which a cause must account for to be named
FAR = 0.25  # of the shares: so far off is no calibration,
BEYOND = 5.0  # nor is what is so many times as far off as calibrations are declared to be
DOUBTED = 0.1  # relative error granted to the share of a taxel in which another fault was found
BENDING = ("saturation", "dead_zone", "hysteresis", "lag", "gain_error", "drift", "crosstalk", "nonlinear_stiffness")


@dataclass(frozen=True, eq=False)
class ArrayCriticism:
    """What was found: `gain` is None where no cause was sure enough to be tried on held-out data; `least` is what shares as measured leave
    there, N; `unlike` is the part of the shares by which training differs from the declared layout."""

    layout: Layout
    measured: Gains
    judgement: Judgement
    gain: Gain | None
    least: float = 0.0
    unlike: float = 0.0

    @property
    def unexplained(self) -> bool:
        """Whether the ratios are wrong by more than calibrations ever are, or by far more than they are declared to be, and no cause has
        been named for it."""
        declared = self.layout.gain_std
        far = FAR if declared is None else min(FAR, BEYOND * declared)
        return not self.named and self.judgement.named is not None and self.unlike > far

    @property
    def named(self) -> bool:
        """Whether a cause is sure, held-out sessions are predicted better with it beyond doubt and by enough to matter, and it accounts for
        most of what the ratios get wrong.

        The whitened gain need not be large: a static share is slow, and under coloured noise there is little of it to whiten.
        """
        gain = self.gain
        if gain is None or gain.lower <= 0.0 or gain.after >= (1.0 - MATERIAL_RMSE) * gain.before:
            return False
        return gain.squares > MOST * (gain.before**2 - self.least**2)


def analyse(
    model: Model, layout: Layout, sessions: list[Session], held: list[int], noise: Whitener, doubted: list[int], thickness_mm: float | None
) -> ArrayCriticism:
    """Judge the shares that the training sessions show under the extended `model`; `held` are indices of held-out sessions.

    `doubted` are taxels in which another fault was found, whose share is not to be relied upon.
    """
    if any(e.cause == "spread_depth" for e in model.effects):  # where it begins and how it grows stand for each other
        layout = replace(layout, width_declared=False)
    measured = with_scatter(_granted(gains(model, sessions, noise), doubted), layout)
    train = [i for i in range(len(sessions)) if i not in held]
    judgement = judge(layout.of(train), measured.of(train), thickness_mm)
    best = judgement.named
    if best is None:
        return ArrayCriticism(layout, measured, judgement, None)
    gain, least = held_out_gain(model, layout, measured, sessions, held, noise, best)
    return ArrayCriticism(layout, measured, judgement, gain, least, unlike(layout.of(train), measured.of(train), judgement.nothing))


def _granted(measured: Gains, doubted: list[int]) -> Gains:
    if not doubted:
        return measured
    more = np.zeros(measured.covariance.shape)
    for i in doubted:
        more[:, i, i] = (DOUBTED * measured.value[:, i]) ** 2
    return replace(measured, covariance=measured.covariance + more)


def doubted_taxels(named) -> list[int]:
    """The taxels to which the search has ascribed something that bends their static share."""
    places = {n.where for n in named if n.cause in BENDING}
    return sorted(int(w.partition("_")[2]) for w in places if w.startswith("taxel_"))
