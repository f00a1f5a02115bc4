"""The gain of a cause in the ratios, on sessions that were not used to find it.

Before: shares of the declared layout; after: shares under the cause. Both are given the level (a common factor, the skin's stiffness there)
of each predicted session, which is no ratio. Where the skin is found to be equally stiff in all fitted sessions, and levels were measured
as precisely as that, the level is not given, so that what the cause does to it counts, too. Everything else is the extended model, and the
test is the common gate: whitened squared error and block bootstrap.
"""

import numpy as np

from skin_ident.criticism.array.evidence import fitted
from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.gains import Gains, with_shares
from skin_ident.criticism.array.hypotheses import EXACT, NOTHING, Background, Hypothesis
from skin_ident.criticism.array.judgement import Judged
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.baseline.residual import residual, rmse
from skin_ident.criticism.gates.gate import EACH_IN_TURN, Gain, gain_of_residuals
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model


def held_out_gain(
    model: Model,
    layout: Layout,
    measured: Gains,
    sessions: list[Session],
    held: list[int],
    noise: Whitener,
    best: Judged,
    beside: Hypothesis = NOTHING,
) -> tuple[Gain, float]:
    """The gain on the sessions `held` (indices), and the RMSE, N, that measured shares leave there in the channel that gains most. If
    `held` is empty, or if sessions press at different places, each training session in turn is also predicted from all other sessions: some
    sessions may not show the cause, and two or three places may not determine it.

    Before, only the stiffness of each session is free, and the width if it is expected and not known, and what a cause `beside` sets free.
    """
    train = [i for i in range(len(sessions)) if i not in held]
    every = range(len(sessions))
    in_turn = [([i for i in every if i != j] or [j], [j]) for j in train] if not held or layout.several_contacts else []
    folds = [*([(train, held)] if held else []), *in_turn]
    said = " and ".join([*(sessions[i].name for i in held), *([EACH_IN_TURN] if in_turn else [])])
    around = best.background
    known = {name: std for name, std in around.alone.items() if name != "width" or std > EXACT} | beside.free
    before, after, judged, least = [], [], [], []
    for fit_on, try_on in folds:
        for errors, free in ((before, known), (after, {**known, **best.hypothesis.free})):
            shares = _predicted(layout, measured, fit_on, try_on, around, free)
            errors += [residual(*with_shares(model, sessions[i], row)) for i, row in zip(try_on, shares, strict=True)]
        judged += [sessions[i] for i in try_on]
        least += [residual(*with_shares(model, sessions[i], measured.value[i])) for i in try_on]
    gain = gain_of_residuals(before, after, judged, noise, said)
    return gain, rmse(least, judged)[gain.channel]


def _predicted(
    layout: Layout, measured: Gains, fit_on: list[int], try_on: list[int], around: Background, free: dict[str, float]
) -> np.ndarray:
    """Shares (S, T) of the sessions `try_on` from a member fitted to `fit_on`, each at its own level, or at the mean level of `fit_on`."""
    member = fitted(Family(layout.of(fit_on)), measured.of(fit_on), around.scatter, free).member
    rest = {name: value for name, value in member.items() if not name.startswith("scale_")}
    shares = Family(layout.of(try_on)).shares(rest)
    if around.at_one_level and measured.level_error < around.places:
        return shares * np.exp(np.mean([member[f"scale_{s}"] for s in range(len(fit_on))]))
    return measured.of(try_on).at_own_levels(shares)
