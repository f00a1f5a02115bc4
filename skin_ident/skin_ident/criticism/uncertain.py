"""What training leaves uncertain of a model, and what held-out sessions show beside that.

A taxel that no training session loads may have any share of the force; what it reads in a held-out session is then no error of the model.
With whitened tangents J of the training sessions and K of the held-out ones, the unknowns may still move by the u that minimises

    |e - K u|^2 + |J u|^2,

which is next to nothing in any direction that training knows.
"""

import numpy as np

from skin_ident.criticism.fitting import tangents
from skin_ident.criticism.session import Session
from skin_ident.criticism.unknowns import unknowns
from skin_ident.criticism.whitening import Whitener, stack
from skin_models.model import Model


def own_rows(model: Model, train: list[Session], sessions: list[Session]) -> list[np.ndarray]:
    """What each unknown of the model fitted to `train` changes in `sessions`, (U, C, n) each."""
    return tangents(model, sessions, unknowns(model, train[0]))


def beside_training(own: list[np.ndarray], model: Model, train: list[Session], held: list[Session], noise: Whitener) -> np.ndarray:
    """K over J, (R + U, U): the `own_rows` of the held-out sessions, whitened, and under them how surely training knows each combination
    of the unknowns: a triangle as good as J."""
    known = np.linalg.qr(stack(own_rows(model, train, train), train, noise), mode="r")
    return np.concatenate([stack(own, held, noise), known])


def beside_uncertainty(
    e: list[np.ndarray], model: Model, train: list[Session], held: list[Session], noise: Whitener
) -> list[np.ndarray]:
    """Residuals (C, n) of the held-out sessions less what training leaves open. Where all press at one place that is nothing: every session
    loads every taxel as the others do."""
    if held[0].spread is None:
        return e
    own = own_rows(model, train, held)
    A, r = beside_training(own, model, train, held, noise), stack(e, held, noise)
    u = np.linalg.lstsq(A, np.concatenate([r, np.zeros(len(A) - len(r))]), rcond=None)[0]
    return [x - np.tensordot(u, k, 1) for x, k in zip(e, own, strict=True)]
