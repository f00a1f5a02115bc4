"""What training leaves undetermined of a model, and the residual of held-out sessions after allowing for it.

Where sessions press at several places, a held-out one has shares of its own (see `own_shares`), and may load taxels that no training
session has loaded. What this changes is no error of the model. With whitened tangents J of the training sessions, K of the held-out ones
and the whitened residual e of these, the unknowns may still move by the u that minimises

    |e - K u|^2 + |J u|^2,

which is next to nothing in any direction that training determines.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.settling import share_rows
from skin_ident.criticism.baseline.unknowns import unknowns
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model


def own_rows(model: Model, train: list[Session], sessions: list[Session]) -> list[np.ndarray]:
    """Tangents (U, C, n) of each of `sessions`: by every unknown of the model fitted to `train`, then by every share of the sessions'
    own."""
    free = tangents(model, sessions, unknowns(model, train[0]))
    return [np.concatenate(both) for both in zip(free, share_rows(model, sessions), strict=True)]


@dataclass(frozen=True)
class Open:
    """What training leaves undetermined of a model in held-out sessions.

    `own` (U, C, n) by session are the tangents there. `known` is the triangular QR factor of J: how surely training determines each
    combination of the first unknowns. The unknowns after these are shares of the held-out sessions.
    """

    own: list[np.ndarray]
    known: np.ndarray

    @classmethod
    def to(cls, model: Model, train: list[Session], held: list[Session], noise: Whitener) -> "Open":
        """For `model` fitted to `train`, in the sessions `held`."""
        known = np.linalg.qr(stack(tangents(model, train, unknowns(model, train[0])), train, noise), mode="r")
        return cls(own_rows(model, train, held), known)

    def of(self, i: int) -> "Open":
        """The same in the i-th session alone."""
        return Open([self.own[i]], self.known)

    def rows(self, held: list[Session], noise: Whitener) -> np.ndarray:
        """K stacked over J, (R + U, U), under the weights that `held` have now."""
        rows = stack(self.own, held, noise)
        return np.concatenate([rows, np.pad(self.known, ((0, 0), (0, rows.shape[1] - self.known.shape[1])))])

    def beside(self, e: list[np.ndarray], held: list[Session], noise: Whitener) -> list[np.ndarray]:
        """Residuals (C, n) of the held-out sessions after the move u of the unknowns that training still allows."""
        A, r = self.rows(held, noise), stack(e, held, noise)
        u = np.linalg.lstsq(A, np.concatenate([r, np.zeros(len(A) - len(r))]), rcond=None)[0]
        return [x - np.tensordot(u, k, 1) for x, k in zip(e, self.own, strict=True)]


def left_open(model: Model, train: list[Session], held: list[Session], noise: Whitener) -> Open | None:
    """What `train` leaves undetermined in `held`. None where all sessions press at one place: every session then loads every taxel as the
    others do, and next to nothing is undetermined."""
    return Open.to(model, train, held, noise) if held and held[0].spread is not None else None


def beside_uncertainty(e: list[np.ndarray], model: Model, train: list[Session], held: list[Session], noise: Whitener) -> list[np.ndarray]:
    """Residuals (C, n) of the held-out sessions less what training leaves undetermined."""
    free = left_open(model, train, held, noise)
    return free.beside(e, held, noise) if free else e
