"""Finds where in a session a step would explain most, at the resolution of its samples.

With whitening W (a filter), whitened residual r and a carrier c(t), the signal that the step multiplies, a step at moment m explains

    p_m^2 / e_m,    p_m = <W (c 1[t >= m]), r> = sum over t >= m of c W'r,    e_m = |W (c 1[t >= m])|^2,

so that all p_m come from one adjoint filter and one running sum. Under coloured noise a whitened step is a pulse as short as the filter,
and a grid of moments coarser than that misses it. e_m is the energy of the whitened carrier from m on. The filter's start-up is computed as
if the carrier were constant during it.
"""

import numpy as np
from scipy.signal import lfilter

from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session

APART_S = 0.5  # s, least distance between moments: one step explains nearly as much at all moments beside it


def sharpest(carrier: np.ndarray, r: np.ndarray, s: Session, noise: Whitener, most: int) -> np.ndarray:
    """Up to `most` moments, sorted, at which a step of `carrier` (C, n) explains most of the whitened residual `r` (C, n), at least half a
    second apart."""
    explained = _from_here_on(np.sum(carrier * noise.turned(r, s), axis=0)) ** 2 / _energy(carrier, s, noise)
    moments: list[float] = []
    for i in np.argsort(explained)[::-1]:
        if len(moments) == most:
            break
        if all(abs(s.t[i] - m) >= APART_S for m in moments):
            moments.append(float(s.t[i]))
    return np.sort(moments)


def _energy(carrier: np.ndarray, s: Session, noise: Whitener) -> np.ndarray:
    """e_m (n,) of the module's equation: the whitened carrier's energy from m + p on, plus that of the filter's start-up after the step."""
    order = noise.order
    whole = _from_here_on(np.sum(noise.apply(carrier, s) ** 2, axis=0))
    if not order:  # no filter, so no start-up
        return np.maximum(whole, 1e-12 * (1.0 + whole[0]))
    settled = np.append(whole[order:], np.zeros(order))
    begun = np.array([lfilter(*noise.predictor(c), np.ones(order)) for c in range(len(carrier))])  # the filters' responses to a step
    mixed = noise.mix @ noise.steady(carrier, s)
    starting = sum(np.sum((noise.to_unit @ (taps[:, None] * mixed)) ** 2, axis=0) for taps in begun.T)
    return np.maximum(settled + starting, 1e-12 * (1.0 + whole[0]))


def _from_here_on(y: np.ndarray) -> np.ndarray:
    return np.cumsum(y[::-1])[::-1]
