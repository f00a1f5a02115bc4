"""The prediction-error filter of `predictor`, applied to many rows at once.

A recursive filter runs sample after sample. Over a block of B samples, however, its output is a matrix product, and of everything before
the block only the last p samples and the M averages matter (see `predictor`):

    w[n+k] = sum_j h[k-j] e[n+j] + sum_{i>k} f_i e[n+k-i] - sum_m c_m (1 - 1/T_m)^k s_m[n],    0 <= j <= k < B,

with h the pulse response of the whole predictor. The averages at the start of each block are sums over the blocks before it, computed the
same way for groups of `AT_ONCE` blocks. All of this is matrix products and takes a third of the time of the recursive filter.

Source: S. K. Mitra and R. Gnanasekaran, IEEE Trans. Circuits and Systems 25 (1978) 200-207 (block implementation of recursive filters).
"""

import numpy as np
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from skin_ident.criticism.noise.predictor import AVERAGING, MEMORIES, POLES, whole

BLOCK = 32  # samples in a block: smaller blocks need more sums over blocks, larger ones larger products
AT_ONCE = 128  # blocks whose averages are summed in one product
KEPT = POLES[:, None] ** (BLOCK * np.arange(AT_ONCE + 1))  # (M, K+1): share of each average that is left after so many blocks
SUMS = np.array([toeplitz(np.zeros(AT_ONCE), [0.0, *kept[:-1]]) for kept in KEPT])  # (M, K, K+1): from blocks to the averages before each


class InBlocks:
    """The prediction-error filter with taps `f` (p+1,) on the last samples and coefficients `c` (M,) on the averages."""

    def __init__(self, f: np.ndarray, c: np.ndarray) -> None:
        if f.size > BLOCK:
            raise ValueError(f"a filter of {f.size} coefficients reaches further back than one block of {BLOCK} samples")
        pulse, steps = lfilter(whole(f, c), AVERAGING, np.eye(1, BLOCK)[0]), np.arange(BLOCK)
        own = toeplitz(np.eye(1, BLOCK)[0] * pulse, pulse)  # (B, B): from the samples of a block to its output
        last = toeplitz(f[:0:-1], np.zeros(BLOCK)) if f.size > 1 else np.zeros((0, BLOCK))  # (p, B): from the last before it to its output
        averaged = (POLES[:, None] ** steps[::-1] / MEMORIES[:, None]).T  # (B, M): from the samples of a block to the averages after it
        self._answers = np.block([[last, np.zeros((len(last), MEMORIES.size))], [own, averaged]])
        self._slow = -c[:, None] * POLES[:, None] ** steps  # (M, B): from the averages before a block to its output

    def apply(self, rows: np.ndarray) -> np.ndarray:
        """Prediction errors of `rows` (..., n), in their precision; samples before the first are taken as zero."""
        *many, n = rows.shape
        count, last = -(-n // BLOCK), len(self._answers) - BLOCK
        padded = np.zeros((*many, count * BLOCK), rows.dtype)
        padded[..., :n] = rows
        blocks = np.zeros((*many, count, last + BLOCK), rows.dtype)
        blocks[..., last:] = padded.reshape(*many, count, BLOCK)
        blocks[..., 1:, :last] = blocks[..., :-1, BLOCK:]  # the last samples before each block
        answers = blocks.reshape(-1, last + BLOCK) @ self._answers.astype(rows.dtype, copy=False)
        before = _before(np.ascontiguousarray(answers[:, BLOCK:].T).reshape(MEMORIES.size, -1, count))
        left = answers[:, :BLOCK] + before.reshape(MEMORIES.size, -1).T @ self._slow.astype(rows.dtype, copy=False)
        return left.reshape(*many, -1)[..., :n]


def _before(added: np.ndarray) -> np.ndarray:
    """The averages at the start of every block, (M, R, K), from what each block has `added` to them."""
    before, carried = np.empty_like(added), np.zeros((*added.shape[:2], 1), added.dtype)
    for start in range(0, added.shape[-1], AT_ONCE):
        few = added[..., start : start + AT_ONCE]
        sums, kept = (a[..., : few.shape[-1] + 1].astype(added.dtype, copy=False) for a in (SUMS[:, : few.shape[-1]], KEPT[:, None]))
        whole = few @ sums + carried * kept
        before[..., start : start + AT_ONCE], carried = whole[..., :-1], whole[..., -1:]
    return before
