"""What is still wrong when every named cause is in the model.

A general predictor, the richest set of directions that the catalogue offers, is fitted to the training residual and asked to predict the
residual of held-out sessions. If it can, something systematic is left that no cause has been given for.
"""

import numpy as np

from skin_ident.criticism.fitting import tangents
from skin_ident.criticism.gate import bootstrap_fall
from skin_ident.criticism.noise import RICHEST, pursue
from skin_ident.criticism.proposals import bank
from skin_ident.criticism.residual import residual
from skin_ident.criticism.session import Session
from skin_ident.criticism.survey import Survey
from skin_ident.criticism.unknowns import unknowns
from skin_ident.criticism.whitening import stack

SYSTEMATIC = 0.03  # fall of the held-out mean square that a general predictor must reach


def systematic_rest(last: Survey, train: list[Session], held: list[Session]) -> tuple[float, float]:
    """Fall of the held-out whitened mean square by the general predictor, and its lower 99 % bound."""
    held = held or train[-1:]
    fitted = [s for s in train if s not in held] or train
    rows = {s.name: _directions(last, s) for s in [*fitted, *held]}
    A = stack([rows[s.name][0] for s in fitted], fitted, last.noise)
    r = stack([rows[s.name][1] for s in fitted], fitted, last.noise)
    own = len(unknowns(last.model, train[0]))
    z = pursue(A, r, own + RICHEST, forced=own)
    before = [last.noise.apply(rows[s.name][1], s.weight) for s in held]
    after = [last.noise.apply(rows[s.name][1] - np.tensordot(z, rows[s.name][0], 1), s.weight) for s in held]
    return bootstrap_fall(before, after, held)


def _directions(last: Survey, s: Session) -> tuple[np.ndarray, np.ndarray]:
    own = tangents(last.model, [s], unknowns(last.model, s))[0]
    return np.concatenate([own, bank(last.model, last.projected.which, [s])[0]]), residual(last.model, s)


def is_systematic(fall: float, lower: float) -> bool:
    """Whether the rest is worth the word `unexplained`."""
    return lower > 0.0 and fall > SYSTEMATIC
