"""Fits a Gaussian over the plane to the taxels' shares, weighted by their standard errors, where the taxels' positions are declared."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skin_ident.estimators.estimate import NOT_IDENTIFIABLE, Estimate
from skin_ident.recordings.recording import Recording
from skin_ident.spread_plane import FEWEST_TAXELS, fit_plane


def with_spread(estimate: Estimate, recordings: Sequence[Recording]) -> Estimate:
    """The estimate with the spread in its notes, where positions are declared and enough taxels are identifiable."""
    places = recordings[0].declared.taxel_positions_mm
    names = [p.name for p in estimate.parameters if p.name.startswith("share_") and estimate.verdicts[p.name].word != NOT_IDENTIFIABLE]
    if len(places) != len(recordings[0].taxels) or len(names) < FEWEST_TAXELS:
        return estimate
    at = np.array([places[int(name[6:])] for name in names]) * 1e-3
    felt, std = (np.array([source[name] for name in names]) for source in (estimate.values, estimate.std))
    # the strongest taxel's share is 1 by definition and has no standard error of its own, so it gets the median one
    fit = fit_plane(at, felt, np.maximum(std, np.median(std)))
    return replace(estimate, notes={**estimate.notes, "spread": fit.as_dict()})
