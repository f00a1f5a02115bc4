"""Extra variance of the shares from the scatter between sessions at one place.

A fault of an array is the same in all sessions that press at one place. If their shares differ beyond chance, the noise has a longer memory
than the sessions show, or something has changed between them; no ratio is known better than that. For each taxel the variance between
sessions is added to that within them,

    tau^2 = (Q - (S - 1)) / (sum w - sum w^2 / sum w),    Q = sum w (g - mean g)^2,    w = 1 / sigma^2.

Source: R. DerSimonian, N. Laird, Controlled Clinical Trials 7 (1986) 177-188.
"""

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from skin_ident.criticism.array.gains import Gains
from skin_ident.criticism.array.layout import APART, Layout

CHANCE = 1e-4  # probability of so large a scatter from the standard errors alone, below which the variance is added


def with_scatter(measured: Gains, layout: Layout) -> Gains:
    """The same shares, with the scatter between sessions at one place added to their covariance."""
    covariance = measured.covariance.copy()
    places = np.round(layout.contacts / APART)
    for place in np.unique(places, axis=0):
        alike = np.flatnonzero(np.all(places == place, axis=1))
        if len(alike) > 1:
            covariance[alike] += np.diag(_between(measured.value[alike], measured.covariance[alike]))
    return replace(measured, covariance=covariance)


def _between(g: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """Variance (T,) between sessions of shares (S, T), each session scaled by itself."""
    mean = g.mean(axis=0)
    scale = np.maximum(g @ mean / max(mean @ mean, 1e-300), 1e-3)[:, None]
    w = scale**2 / np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 1e-300)
    g = g / scale
    excess = np.sum(w * (g - np.sum(w * g, axis=0) / np.sum(w, axis=0)) ** 2, axis=0)
    more = np.maximum(excess - (len(g) - 1), 0.0) / (np.sum(w, axis=0) - np.sum(w**2, axis=0) / np.sum(w, axis=0))
    return np.where(excess > chi2.isf(CHANCE, len(g) - 1), more, 0.0)
