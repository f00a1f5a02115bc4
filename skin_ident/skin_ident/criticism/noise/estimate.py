"""Fits the noise model to the residual that remains after everything that any cause could explain is taken out.

Whitening with the residual of a poor model would count the model's own error as noise, and a test built on it would be blind. Whitening as
if the noise were white would reject the truth half of the time. So the residual is first reduced by the directions that explain most of it,
whatever their cause, chosen one after the other (orthogonal matching pursuit). The noise is fitted to the rest. The first pass takes the
noise as white: colour fitted to the residual itself would contain the very effect that is looked for, and would hide an offset or a slow
drift. The second pass chooses directions again, under the coloured noise of the first.

The first pass may mistake wandering noise for an effect; the second may mistake an effect for wandering noise. The pass with the shorter
description length is kept (J. Rissanen, Automatica 14 (1978) 465-471). In nats it is

    n sum_c log r_c + sum log s + k / 2 (log(n C) + 2 log M)

with r_c the standard deviations of the C innovations, n samples of each, s the factors by which noise grows under load, and k directions
chosen out of M. With a single session the second pass is always taken: no model may fit it well, and held-out data decide there.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.noise.pursuit import pursue
from skin_ident.criticism.noise.taken import taken
from skin_ident.criticism.noise.whitening import Given, Stacked, Whitener, fit_whitener, order_for, stack, white, with_growth
from skin_ident.criticism.sessions.session import Session

RICHEST = 24  # most directions that the richest model may use beyond the model's own
AS_FEW = 12.0  # nats by which the two description lengths may differ and count as equal: then the first pass, which explains more, is kept


def noise_model(residuals: list[np.ndarray], every: Stacked, own: int, offered: np.ndarray | None = None) -> Whitener:
    """Returns the noise model fitted to residuals (C, n) of each session, given the directions `every` (M, C, n). The first `own` of these
    are the model's tangents and always used; of the others only those `offered` (M,) may explain anything."""
    offered = np.ones(len(every.rows[0]), bool) if offered is None else offered
    weights = [s.weight for s in every.sessions]
    first, words = _pass(residuals, every, own, offered, white(residuals, order_for(weights), weights))
    again, fewer = _pass(residuals, every, own, offered, first)
    return first if len(weights) > 1 and words < fewer + AS_FEW else again


def _pass(residuals: list[np.ndarray], every: Stacked, own: int, offered: np.ndarray, noise: Whitener) -> tuple[Whitener, float]:
    """Chooses the directions that explain most under `noise`, fits the noise to the rest, and returns it with the description length, nats,
    of both."""
    z = _richest(residuals, every, own, noise, offered)
    asked = [replace(s, weight=s.weight * noise.believed(s)) for s in every.sessions]  # elsewhere the residual may be anything
    left = _less(residuals, every.rows, z)
    gone = taken([a[z != 0.0] for a in every.rows], left, [s.weight for s in asked])
    steady = fit_whitener(left, asked, gone, Given(noise.order, floor=noise.floor))
    fitted = with_growth(steady, left, asked, gone)
    return fitted, _words(fitted, asked, np.count_nonzero(z[own:]), np.count_nonzero(offered[own:]))


def _words(noise: Whitener, asked: list[Session], chosen: int, offered: int) -> float:
    """Description length, nats, of the residual under this noise and of which directions were taken out, with their coefficients."""
    n = sum(np.count_nonzero(s.weight.min(axis=0)) for s in asked)
    return noise.words(asked) + 0.5 * chosen * (np.log(max(n * len(noise.root), 2)) + 2.0 * np.log(max(offered, 1)))


def less(residuals: list[np.ndarray], every: Stacked, forced: int, noise: Whitener) -> list[np.ndarray]:
    """Residuals (C, n) of each session less what the directions explain under `noise`: the first `forced` rows of `every` (M, C, n), and
    the best of the others. Fitted to the trusted samples (weight above 0)."""
    return _less(residuals, every.rows, _richest(residuals, every, forced, noise))


def _richest(residuals: list[np.ndarray], every: Stacked, forced: int, noise: Whitener, offered: np.ndarray | None = None) -> np.ndarray:
    return pursue(every.under(noise), stack(residuals, every.sessions, noise), forced + RICHEST, forced, offered)


def _less(residuals: list[np.ndarray], every: list[np.ndarray], z: np.ndarray) -> list[np.ndarray]:
    used = z != 0.0
    return [e - np.tensordot(z[used], a[used], 1) for e, a in zip(residuals, every, strict=True)]
