"""Orthogonal matching pursuit: of many directions, chooses the few that explain most, one after the other, until none gains enough.

A direction must reduce the squared error (unit noise) of n samples by more than log n, the BIC charge for its amplitude.

Source: Y. C. Pati, R. Rezaiifar and P. S. Krishnaprasad, Proc. 27th Asilomar Conference (1993) 40-44.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

NEXT = 8  # columns, the likeliest to be chosen next, whose inner products are computed together
NOTHING = 1e-10  # share of a column's square that rounding leaves of a column which others span


@dataclass(frozen=True)
class Normal:
    """Least squares of r (R,) on columns A (R, M), held by inner products: `gram` A^T A (M, M), `product` A^T r (M,), and the `count` of
    samples."""

    gram: np.ndarray
    product: np.ndarray
    count: int

    @staticmethod
    def by_blocks(blocks: list[np.ndarray], r: np.ndarray, Q: np.ndarray | None) -> "Normal":
        """Normal equations of columns [(R_i, M_i), …] that are non-zero in samples of their own (block-diagonal A), less their projection
        on an orthonormal `Q` (R', U), to which r (R',) is already orthogonal. The columns are zero at samples beyond the blocks."""
        ends = np.cumsum([len(a) for a in blocks])
        product = np.concatenate([a.T @ part for a, part in zip(blocks, np.split(r, ends)[:-1], strict=True)])
        gram = block_diag(*(a.T @ a for a in blocks))
        if Q is not None:
            whole = gram.diagonal().copy()
            spanned = np.concatenate([part.T @ a for a, part in zip(blocks, np.split(Q, ends)[:-1], strict=True)], axis=1)
            gram -= spanned.T @ spanned
            gone = gram.diagonal() < NOTHING * whole
            gram[gone], gram[:, gone], product[gone] = 0.0, 0.0, 0.0
        return Normal(gram, product, np.count_nonzero(r))

    def explained(self, z: np.ndarray) -> float:
        """The reduction of the squared error by A z."""
        return float(2.0 * z @ self.product - z @ self.gram @ z)

    def least_squares(self, free: np.ndarray) -> np.ndarray:
        """The best coefficients (M,) within the span of `free` (M, L)."""
        z = free @ np.linalg.lstsq(free.T @ self.gram @ free, free.T @ self.product, rcond=NOTHING)[0]
        return np.where(self.gram.diagonal() > 0.0, z, 0.0)

    def square(self) -> tuple[np.ndarray, np.ndarray]:
        """The smallest set of rows, columns (K, M) and target (K,), that has the same inner products."""
        sizes, vectors = np.linalg.eigh(self.gram)
        felt = sizes > NOTHING * sizes.max(initial=0.0)
        roots, some = np.sqrt(sizes[felt]), vectors.T[felt]
        return roots[:, None] * some, some @ self.product / roots

    def pursue(self, most: int) -> np.ndarray:
        """Coefficients (M,) of the pursuit with at most `most` columns."""
        return _pursue(self.product, np.sqrt(self.gram.diagonal()), lambda few: self.gram[few], self.count, most)


def pursue(A: np.ndarray, r: np.ndarray, most: int, forced: int = 0, offered: np.ndarray | None = None) -> np.ndarray:
    """Coefficients of the pursuit of r (R,) by columns of A (R, M). The first `forced` columns are always used; of the others only those
    `offered` (M,), where that is given.

    Inner products are computed only with the columns likely to be chosen next, a few at a time: some two dozen of hundreds are chosen, and
    reading all columns takes longer than multiplying them.
    """
    return _pursue(A.T @ r, np.sqrt(np.einsum("ij,ij->j", A, A)), lambda few: A.T[few] @ A, len(r), most, forced, offered)


def _pursue(
    product: np.ndarray,
    size: np.ndarray,
    grams_of: Callable[[list[int]], np.ndarray],
    count: int,
    most: int,
    forced: int = 0,
    offered: np.ndarray | None = None,
) -> np.ndarray:
    able = size > 0 if offered is None else (size > 0) & offered
    chosen = [i for i in range(forced) if size[i] > 0]
    grams = dict(zip(chosen, grams_of(chosen), strict=True))
    z, charge = np.zeros(product.size), np.log(max(count, 2))
    while True:
        left = product
        if chosen:
            gram = np.array([grams[i] for i in chosen])
            z[chosen] = np.linalg.lstsq(gram[:, chosen], product[chosen], rcond=1e-10)[0]
            left = product - z[chosen] @ gram
        gains = np.where(able, (left / np.where(able, size, 1.0)) ** 2, 0.0)
        gains[chosen] = 0.0
        best = int(np.argmax(gains))
        if len(chosen) >= most or gains[best] < charge:
            return z
        if best not in grams:
            few = np.argsort(-gains, kind="stable")[:NEXT].tolist()
            grams.update(zip(few, grams_of(few), strict=True))
        chosen.append(best)
