"""The noise model, from what is left when everything that any cause could explain is taken away.

Whitening with the residual of a poor model would count the model's own error as noise, and a test built on it would be blind; whitening
as if the noise were white would reject the truth half of the time. So the residual is first reduced by the directions that explain most
of it, chosen one after the other (orthogonal matching pursuit), whatever their cause, and the noise is fitted to the rest. The first pass
takes the noise as white: colour fitted to the residual itself would contain the very effect that is looked for, and an offset or a slow
drift would drown in it. The second pass chooses again under the colour that the first has left.

The first pass may take noise that wanders for something that is explained, the second what is explained for noise that wanders. Of the two
that one is taken which describes the record in fewer words (J. Rissanen, Automatica 14 (1978) 465-471):

    n sum_c log r_c + sum log s + k / 2 (log(n C) + 2 log M)

with the standard deviations r_c of the C innovations, n samples of each, what they grow by under load, s, and k directions chosen out of
M. A lone session that no model fits well is always looked at twice: held-out data decide there.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.noise.pursuit import pursue
from skin_ident.criticism.noise.taken import taken
from skin_ident.criticism.noise.whitening import Given, Stacked, Whitener, fit_whitener, order_for, stack, white, with_growth
from skin_ident.criticism.sessions.session import Session

RICHEST = 24  # directions that the richest model may use
AS_FEW = 12.0  # words by which passes do not differ: then the first of them, which explains more


def noise_model(residuals: list[np.ndarray], every: Stacked, own: int, offered: np.ndarray | None = None) -> Whitener:
    """Fit the noise to residuals (C, n) of each session, given the directions (M, C, n): first the model's `own` tangents, then others, of
    which only those `offered` (M,) may explain anything."""
    offered = np.ones(len(every.rows[0]), bool) if offered is None else offered
    weights = [s.weight for s in every.sessions]
    first, words = _pass(residuals, every, own, offered, white(residuals, order_for(weights), weights))
    again, fewer = _pass(residuals, every, own, offered, first)
    return first if len(weights) > 1 and words < fewer + AS_FEW else again


def _pass(residuals: list[np.ndarray], every: Stacked, own: int, offered: np.ndarray, noise: Whitener) -> tuple[Whitener, float]:
    """The noise that is left beside the directions that explain most under `noise`, and the words that it takes to say both."""
    z = _richest(residuals, every, own, noise, offered)
    asked = [replace(s, weight=s.weight * noise.believed(s)) for s in every.sessions]  # what is left of the others may be anything
    left = _less(residuals, every.rows, z)
    gone = taken([a[z != 0.0] for a in every.rows], left, [s.weight for s in asked])
    steady = fit_whitener(left, asked, gone, Given(noise.order, floor=noise.floor))
    fitted = with_growth(steady, left, asked, gone)
    return fitted, _words(fitted, asked, np.count_nonzero(z[own:]), np.count_nonzero(offered[own:]))


def _words(noise: Whitener, asked: list[Session], chosen: int, offered: int) -> float:
    """How long it takes to say what is left in this noise, and which directions were taken out."""
    n = sum(np.count_nonzero(s.weight.min(axis=0)) for s in asked)
    return noise.words(asked) + 0.5 * chosen * (np.log(max(n * len(noise.root), 2)) + 2.0 * np.log(max(offered, 1)))


def less(residuals: list[np.ndarray], every: Stacked, forced: int, noise: Whitener) -> list[np.ndarray]:
    """Residuals (C, n) of each session less what the first `forced` rows of `every` (M, C, n), and the best of the others, explain of the
    samples believed."""
    return _less(residuals, every.rows, _richest(residuals, every, forced, noise))


def _richest(residuals: list[np.ndarray], every: Stacked, forced: int, noise: Whitener, offered: np.ndarray | None = None) -> np.ndarray:
    return pursue(every.under(noise), stack(residuals, every.sessions, noise), forced + RICHEST, forced, offered)


def _less(residuals: list[np.ndarray], every: list[np.ndarray], z: np.ndarray) -> list[np.ndarray]:
    used = z != 0.0
    return [e - np.tensordot(z[used], a[used], 1) for e, a in zip(residuals, every, strict=True)]
