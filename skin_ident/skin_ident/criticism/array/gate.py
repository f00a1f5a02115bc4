"""What a cause in the ratios is worth on sessions that were not used to find it.

Before: shares as the declared layout has them; after: shares as the cause has them. Of the sessions that are predicted both are told the
level, as one number each: that is how stiff the skin is there, and no ratio. Where the cause leaves the fitted sessions at one level, and
levels were measured as well as that, they are not: then what it does to levels is seen, too. Everything else is the extended model. The
rest is the common gate: whitened squared error, and a bootstrap over blocks.
"""

import numpy as np

from skin_ident.criticism.array.evidence import fitted
from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.gains import Gains, with_shares
from skin_ident.criticism.array.hypotheses import EXACT, Background
from skin_ident.criticism.array.judgement import Judged
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.baseline.residual import residual, rmse
from skin_ident.criticism.gates.gate import EACH_IN_TURN, Gain, gain_of_residuals
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model


def held_out_gain(
    model: Model, layout: Layout, measured: Gains, sessions: list[Session], held: list[int], noise: Whitener, best: Judged
) -> tuple[Gain, float]:
    """The gain on the sessions `held` (indices), and what is left there (RMSE, N, in the channel that gains most) where every taxel has the
    share that was measured. Where there are none, or where sessions press at different places and one of them may not show the cause, each
    of the others in turn is predicted from all but itself as well: two or three places alone may not tell where a cause is.

    Before, nothing is free but how stiff the skin is from session to session, and a width that is only expected, and not known.
    """
    train = [i for i in range(len(sessions)) if i not in held]
    every = range(len(sessions))
    in_turn = [([i for i in every if i != j] or [j], [j]) for j in train] if not held or layout.several_contacts else []
    folds = [*([(train, held)] if held else []), *in_turn]
    said = " and ".join([*(sessions[i].name for i in held), *([EACH_IN_TURN] if in_turn else [])])
    around = best.background
    known = {name: std for name, std in around.alone.items() if name != "width" or std > EXACT}
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
    """Shares (S, T) of the sessions `try_on` by a member fitted to `fit_on`, each at its own level, or at the mean one of these."""
    member = fitted(Family(layout.of(fit_on)), measured.of(fit_on), around.scatter, free).member
    rest = {name: value for name, value in member.items() if not name.startswith("scale_")}
    shares = Family(layout.of(try_on)).shares(rest)
    if around.at_one_level and measured.level_error < around.places:
        return shares * np.exp(np.mean([member[f"scale_{s}"] for s in range(len(fit_on))]))
    return measured.of(try_on).at_own_levels(shares)
