"""Shares of taxels that were left out of the search because they died part-way, estimated from the samples at which they lived:

    share = sum w p r / sum w p^2

with r the residual of the taxel at share 0, p the change of its simulation at share 1, and w 1 for trusted samples, over all sessions in
their common band.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model


def with_living_shares(model: Model, sessions: list[Session], names: Collection[str]) -> Model:
    """The model with shares for those taxels of `names` whose share is 0, estimated from the trusted samples of `sessions`."""
    index = {f"taxel_{i}": i for i, share in enumerate(model.shares) if share == 0.0}
    return _with_shares(model, {index[name]: _share(model, sessions, name, index[name]) for name in names if name in index})


def _share(model: Model, sessions: list[Session], name: str, i: int) -> float:
    whole = _with_shares(model, {i: 1.0})
    row = sessions[0].channels.index(name)
    w = np.concatenate([s.weight[row] for s in sessions])
    without, left = (np.concatenate([residual(m, s)[row] for s in sessions]) for m in (model, whole))
    p = without - left
    energy = float(np.sum(w * p**2))
    return float(np.sum(w * p * without)) / energy if energy > 0.0 else 0.0


def _with_shares(model: Model, shares: dict[int, float]) -> Model:
    return replace(model, shares=tuple(shares.get(i, share) for i, share in enumerate(model.shares)))
