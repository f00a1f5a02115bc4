"""The noise model, from what is left when everything that any cause could explain is taken away.

Whitening with the residual of a poor model would count the model's own error as noise, and a test built on it would be blind; whitening
as if the noise were white would reject the truth half of the time. So the residual is first reduced by the directions that explain most
of it, chosen one after the other (orthogonal matching pursuit), whatever their cause, and the noise is fitted to the rest. The first pass
takes the noise as white: colour fitted to the residual itself would contain the very effect that is looked for, and an offset or a slow
drift would drown in it. Every other pass chooses again under the colour that the one before has left.

The first passes take noise that wanders for something that is explained, the last ones what is explained for noise that wanders. Of all of
them that one is taken which describes the record in the fewest words (J. Rissanen, Automatica 14 (1978) 465-471):

    n sum_c log r_c + k / 2 (log(n C) + 2 log M)

with the standard deviations r_c of the C innovations, n samples of each, and k directions chosen out of M. A lone session that no model
fits well is described shortest by colour alone, under which nothing is found: there the second pass is taken, and held-out data decide.
"""

import numpy as np

from skin_ident.criticism.noise.whitening import Whitener, fit_whitener, stack, white
from skin_ident.criticism.sessions.session import Session

RICHEST = 24  # directions that the richest model may use
PASSES, PASSES_ALONE = 4, 2  # of several sessions, and of one
AS_FEW = 12.0  # words by which passes do not differ: then the first of them, which explains more


def noise_model(residuals: list[np.ndarray], tangents: list[np.ndarray], bank: list[np.ndarray], sessions: list[Session]) -> Whitener:
    """Fit the noise to residuals (C, n) of each session, given the model's tangents (U, C, n) and the catalogue's directions (M, C, n)."""
    every = [np.concatenate([t, b]) for t, b in zip(tangents, bank, strict=True)]
    own, offered = len(tangents[0]), len(bank[0])
    noise, found, before = white(residuals), [], None
    for _ in range(PASSES if len(sessions) > 1 else PASSES_ALONE):
        z = _richest(residuals, every, own, noise, sessions)
        if len(found) > 1 and np.array_equal(z != 0.0, before):  # the same again, and so would be all that follow
            break
        before = z != 0.0
        asked = [s.weight * noise.believed(s.weight) for s in sessions]  # what is left of the others may be anything
        noise = fit_whitener(_less(residuals, every, z), asked)
        found.append((_words(noise, asked, np.count_nonzero(z[own:]), offered), noise))
    if len(sessions) == 1:
        return noise
    fewest = min(words for words, _ in found)
    return next(noise for words, noise in found if words < fewest + AS_FEW)


def _words(noise: Whitener, asked: list[np.ndarray], chosen: int, offered: int) -> float:
    """How long it takes to say what is left in this noise, and which directions were taken out."""
    n = sum(np.count_nonzero(w.min(axis=0)) for w in asked)
    scale = np.diag(noise.root)
    return float(n * np.sum(np.log(scale)) + 0.5 * chosen * (np.log(max(n * scale.size, 2)) + 2.0 * np.log(max(offered, 1))))


def less(residuals: list[np.ndarray], every: list[np.ndarray], forced: int, noise: Whitener, sessions: list[Session]) -> list[np.ndarray]:
    """Residuals (C, n) of each session less what the first `forced` rows of `every` (M, C, n), and the best of the others, explain of the
    samples believed."""
    return _less(residuals, every, _richest(residuals, every, forced, noise, sessions))


def _richest(residuals: list[np.ndarray], every: list[np.ndarray], forced: int, noise: Whitener, sessions: list[Session]) -> np.ndarray:
    return pursue(stack(every, sessions, noise), stack(residuals, sessions, noise), forced + RICHEST, forced=forced)


def _less(residuals: list[np.ndarray], every: list[np.ndarray], z: np.ndarray) -> list[np.ndarray]:
    return [e - np.tensordot(z, a, 1) for e, a in zip(residuals, every, strict=True)]


def pursue(A: np.ndarray, r: np.ndarray, most: int, forced: int = 0) -> np.ndarray:
    """Orthogonal matching pursuit: coefficients of at most `most` columns of A, the first `forced` always used, until nothing gains.

    Inner products are taken with the chosen columns alone: of hundreds, two dozen are chosen.
    """
    product, size = A.T @ r, np.sqrt(np.einsum("ij,ij->j", A, A))
    chosen = [i for i in range(forced) if size[i] > 0]
    grams = [A.T @ A[:, i] for i in chosen]
    z, charge = np.zeros(A.shape[1]), np.log(max(len(r), 2))
    while True:
        left = product
        if chosen:
            gram = np.array(grams)
            z[chosen] = np.linalg.lstsq(gram[:, chosen], product[chosen], rcond=1e-10)[0]
            left = product - z[chosen] @ gram
        gains = np.where(size > 0, (left / np.where(size > 0, size, 1.0)) ** 2, 0.0)
        gains[chosen] = 0.0
        best = int(np.argmax(gains))
        if len(chosen) >= most or gains[best] < charge:
            return z
        chosen.append(best)
        grams.append(A.T @ A[:, best])
