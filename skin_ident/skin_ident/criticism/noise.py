"""The noise model, from what is left when everything that any cause could explain is taken away.

Whitening with the residual of a poor model would count the model's own error as noise, and a test built on it would be blind; whitening
as if the noise were white would reject the truth half of the time. So the residual is first reduced by the directions that explain most
of it, chosen one after the other (orthogonal matching pursuit), whatever their cause, and the noise is fitted to the rest. The first pass
takes the noise as white: colour fitted to the residual itself would contain the very effect that is looked for, and an offset or a slow
drift would drown in it. The second pass chooses again under the colour that the first has left.
"""

import numpy as np

from skin_ident.criticism.session import Session
from skin_ident.criticism.whitening import Whitener, fit_whitener, stack, white

RICHEST = 24  # directions that the richest model may use
PASSES = 2
ROUNDING = 1e-6  # of single precision, in a chosen set of directions


def noise_model(residuals: list[np.ndarray], tangents: list[np.ndarray], bank: list[np.ndarray], sessions: list[Session]) -> Whitener:
    """Fit the noise to residuals (C, n) of each session, given the model's tangents (U, C, n) and the catalogue's directions (M, C, n)."""
    weights = [s.weight for s in sessions]
    single = [np.concatenate(pair, dtype=np.float32) for pair in zip(tangents, bank, strict=True)]  # plenty to choose by, at half the cost
    noise = white(residuals)
    for _ in range(PASSES):
        A, r = stack(single, sessions, noise), stack(residuals, sessions, noise)
        z = pursue(A, r, len(tangents[0]) + RICHEST, forced=len(tangents[0]))
        used = np.flatnonzero(z)
        left = [e - np.tensordot(z[used], a[used], 1) for e, a in zip(residuals, single, strict=True)]
        noise = fit_whitener(left, weights)
    return noise


def pursue(A: np.ndarray, r: np.ndarray, most: int, forced: int = 0) -> np.ndarray:
    """Orthogonal matching pursuit: coefficients of at most `most` columns of A, the first `forced` always used, until nothing gains.

    Columns are taken at unit length and multiplied in single precision.
    """
    single = A.astype(np.float32, copy=False)
    gram = (single.T @ single).astype(float)
    length = np.sqrt(np.diag(gram))
    usable = length > 0.0
    scale = np.where(usable, length, 1.0)
    gram /= np.outer(scale, scale)
    product = (A.T @ r.astype(A.dtype)) / scale
    chosen = [i for i in range(forced) if usable[i]]
    z, charge = np.zeros(A.shape[1]), np.log(max(len(r), 2))
    while True:
        if chosen:
            z[:] = 0.0
            z[chosen] = np.linalg.lstsq(gram[np.ix_(chosen, chosen)], product[chosen], rcond=ROUNDING)[0]
        gains = np.where(usable, product - gram @ z, 0.0) ** 2
        gains[chosen] = 0.0
        best = int(np.argmax(gains))
        if len(chosen) >= most or gains[best] < charge:
            return z / scale
        chosen.append(best)
