"""How much of the residual each cause explains, once the model's own unknowns are projected out.

With whitened residual r, base Jacobian J and a cause's directions A, both A and r are projected off J; the gain of the cause is the fall of
|r|^2 by least squares on A with the signs that its physics allows,

    gain = min |P r|^2 - |P (r - A z)|^2,        z_i >= 0 where the amplitude cannot be negative.

It is twice a log-likelihood ratio; `score` charges each direction used as in the Bayesian information criterion.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from skin_ident.criticism.projection import projected_off
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.vocabulary import Key

MOST_USED = 5  # directions of one cause
LEADING = 6  # causes and places, beside whose best directions all others are bounded
UNEXCITED = 1e-6  # share of a direction's energy left after projection, below which the model can imitate it entirely


@dataclass(frozen=True)
class Ranked:
    """One cause at one place: its gain in squared whitened units, the score (gain less charge), the directions it used and how much of
    each. `best` is the direction that explains most by itself."""

    cause: str
    where: str
    gain: float
    score: float
    used: tuple[Direction, ...]
    amounts: np.ndarray
    best: Direction
    best_amount: float
    best_gain: float

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where


@dataclass(frozen=True)
class Projected:
    """Directions and residual after the model's own unknowns are projected out, as inner products, which are all that ranking needs.

    `grams` holds the inner products among the directions of one cause at one place, in the order of `which`. `beside` holds those of every
    direction with the `leading` ones: the best direction of each cause and place, for those that explain most.
    """

    which: tuple[Direction, ...]
    grams: dict[Key, np.ndarray]
    energies: np.ndarray  # of each direction
    product: np.ndarray
    left: np.ndarray  # share of each direction's energy that the model cannot imitate; 0 only for a direction that does nothing
    energy: float  # of the residual
    rows: int
    leading: np.ndarray  # (L,) indices
    beside: np.ndarray  # (directions, L)


def project(which: tuple[Direction, ...], A: np.ndarray, Q: np.ndarray, r: np.ndarray) -> Projected:
    """Project `A` (rows, directions) and `r` (rows,) off the model's own unknowns, of whose tangents `Q` (rows, unknowns) is the `basis`.

    Only inner products of projected directions are formed, (a - Q Q'a)'(b - Q Q'b) = a'b - (Q'a)'(Q'b): the projected directions themselves
    are never stored.
    """
    imitated = Q.T @ A
    r = projected_off(r, Q)

    def products(index: np.ndarray) -> np.ndarray:
        a, q = A.T[index], imitated.T[index]
        return a @ a.T - q @ q.T

    before = np.einsum("ij,ij->j", A, A)
    after = np.maximum(before - np.einsum("ij,ij->j", imitated, imitated), 0.0)
    left = np.where(before > 0, np.maximum(after / np.where(before > 0, before, 1.0), np.finfo(float).eps), 0.0)
    product = A.T @ r
    causes = _by_cause(which)
    grams = {key: products(index) for key, index in causes.items()}
    leading = _leading(causes, np.where(left > UNEXCITED, product**2 / np.where(after > 0, after, 1.0), 0.0))
    beside = A.T @ A[:, leading] - imitated.T @ imitated[:, leading]
    return Projected(which, grams, after, product, left, float(r @ r), int(np.count_nonzero(r)), leading, beside)


def _leading(causes: dict[Key, np.ndarray], gains: np.ndarray) -> np.ndarray:
    """The best direction of every cause at every place, for the `LEADING` of these that explain most."""
    best = np.array([index[np.argmax(gains[index])] for index in causes.values()], int)
    return best[np.argsort(-gains[best])][:LEADING]


def _by_cause(which: tuple[Direction, ...]) -> dict[Key, np.ndarray]:
    """The indices of the directions of every cause at every place."""
    keys = [d.key for d in which]
    return {key: np.flatnonzero([k == key for k in keys]) for key in dict.fromkeys(keys)}


def rank(p: Projected) -> list[Ranked]:
    """Every cause at every place, the best first."""
    return sorted((_ranked(p, *key, index) for key, index in _by_cause(p.which).items()), key=lambda r: -r.score)


def _ranked(p: Projected, cause: str, where: str, index: np.ndarray) -> Ranked:
    free = p.left[index] > UNEXCITED
    able = index[free]
    if able.size == 0:
        return Ranked(cause, where, 0.0, 0.0, (), np.zeros(0), p.which[index[0]], 0.0, 0.0)
    signs = np.array([p.which[i].sign for i in able])
    z, gain = signed_pursuit(p.grams[cause, where][np.ix_(free, free)], p.product[able], signs)
    used = np.flatnonzero(z)
    charge = np.log(max(p.rows, 2))
    best, amount, best_gain = _single(p, able, signs)
    return Ranked(
        cause, where, gain, gain - charge * used.size, tuple(p.which[able[i]] for i in used), z[used], p.which[best], amount, best_gain
    )


def _single(p: Projected, able: np.ndarray, signs: np.ndarray) -> tuple[int, float, float]:
    """Index, amount and gain of the direction that explains most by itself."""
    z = p.product[able] / p.energies[able]
    z = np.where((signs != 0) & (np.sign(z) != signs), 0.0, z)
    gains = z * p.product[able]
    i = int(np.argmax(gains))
    return int(able[i]), float(z[i]), float(gains[i])


def signed_pursuit(gram: np.ndarray, product: np.ndarray, signs: np.ndarray) -> tuple[np.ndarray, float]:
    """Orthogonal matching pursuit from A'A (M, M) and A'r (M,), with sign constraints (M,); returns the amounts (M,) and the fall of the
    squared error.

    It uses at most `MOST_USED` directions: enough for a spectrum of relaxation times, too few to let a cause bend into anything.
    """
    scale = np.sqrt(np.diag(gram))
    G, b = gram / np.outer(scale, scale) + 1e-8 * np.eye(scale.size), product / scale
    chosen: list[int] = []
    z = np.zeros(scale.size)
    while len(chosen) < min(MOST_USED, scale.size):
        left = b - G @ z
        left[(signs != 0) & (np.sign(left) != signs)] = 0.0
        left[chosen] = 0.0
        best = int(np.argmax(np.abs(left)))
        if abs(left[best]) < 1e-9 * max(np.abs(b).max(), 1e-300):
            break
        chosen.append(best)
        z = _signed_solution(G, b, signs, chosen)
    gain = float(2.0 * z @ b - z @ G @ z)
    return z / scale, max(gain, 0.0)


def _signed_solution(G: np.ndarray, b: np.ndarray, signs: np.ndarray, chosen: list[int]) -> np.ndarray:
    """Least squares on the chosen directions; those of one sign are flipped into `z >= 0`, those of either sign are split in two."""
    index = np.array(chosen)
    flips = np.where(signs[index] == 0, 1.0, signs[index])
    free = index[signs[index] == 0]
    split = np.concatenate([index, free])
    turn = np.concatenate([flips, -np.ones(free.size)])
    root = np.linalg.cholesky(G[np.ix_(index, index)])
    columns = np.concatenate([np.arange(index.size), np.flatnonzero(signs[index] == 0)])
    lifted = root.T[:, columns] * turn
    w, _ = nnls(lifted, np.linalg.solve(root, b[index]), maxiter=50 * split.size)
    z = np.zeros(b.size)
    np.add.at(z, split, w * turn)
    return z
