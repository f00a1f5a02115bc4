"""The shares of taxels that a search did without, for they died on the way: from the samples in which they live.

    share = sum w p r / sum w p^2

with r what is measured less what is simulated of a taxel without a share, p what one of share 1 reads more, and w 1 where it may be
believed, over all sessions in their common band.
"""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model


def with_living_shares(model: Model, sessions: list[Session], names: Collection[str]) -> Model:
    """The model with shares for the taxels `names` that have none, as `sessions` read them where they may be believed."""
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
