"""What the past does not predict, of many rows at once.

A recursive filter runs sample after sample. Its first B answers to a block of B samples are a product with a matrix, though, and of all
that came before a block only the last p samples and the M averages matter (see `predictor`):

    w[n+k] = sum_j h[k-j] e[n+j] + sum_{i>k} f_i e[n+k-i] - sum_m c_m (1 - 1/T_m)^k s_m[n],    0 <= j <= k < B,

with the pulse response h of the whole predictor, and the averages go from block to block by recursions of their own, B times shorter. Three
matrix products, in three fifths of the time of a filter that runs.

Source: S. K. Mitra and R. Gnanasekaran, IEEE Trans. Circuits and Systems 25 (1978) 200-207 (block implementation of recursive filters).
"""

import numpy as np
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from skin_ident.criticism.noise.predictor import AVERAGING, MEMORIES, POLES, whole

BLOCK = 32  # samples: fewer are more recursion, more are more products


class InBlocks:
    """The prediction-error filter of the last samples `f` (p+1,) and coefficients `c` (M,) of the averages."""

    def __init__(self, f: np.ndarray, c: np.ndarray) -> None:
        if f.size > BLOCK:
            raise ValueError(f"a filter of {f.size} coefficients reaches further back than one block of {BLOCK} samples")
        pulse, steps = lfilter(whole(f, c), AVERAGING, np.eye(1, BLOCK)[0]), np.arange(BLOCK)
        self._own = toeplitz(np.eye(1, BLOCK)[0] * pulse, pulse)  # (B, B): samples of a block to its answers
        self._last = toeplitz(f[:0:-1], np.zeros(BLOCK)) if f.size > 1 else np.zeros((0, BLOCK))  # (p, B): the last before it to the same
        self._averaged = (POLES[:, None] ** steps[::-1] / MEMORIES[:, None]).T  # (B, M): samples to the averages behind them
        self._slow = -c[:, None] * POLES[:, None] ** steps  # (M, B): the averages before a block to its answers

    def apply(self, rows: np.ndarray) -> np.ndarray:
        """What is left of `rows` (..., n), before which there was nothing, in their precision."""
        *many, n = rows.shape
        count, last = -(-n // BLOCK), len(self._last)
        blocks = np.zeros((*many, count * BLOCK), rows.dtype)
        blocks[..., :n] = rows
        blocks = blocks.reshape(*many, count, BLOCK)
        left = _product(blocks, self._own)
        left[..., 1:, :] += blocks[..., :-1, BLOCK - last :] @ self._last.astype(rows.dtype)
        averages = _product(blocks, self._averaged)
        for m, pole in enumerate(POLES**BLOCK):
            averages[..., m] = lfilter([0.0, 1.0], [1.0, -pole], averages[..., m], axis=-1)
        left += _product(averages, self._slow)
        return left.reshape(*many, -1)[..., :n]


def _product(blocks: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """(..., B) times (B, N) as one product of two matrices: numpy would make many small ones of it."""
    flat = blocks.reshape(-1, blocks.shape[-1]) @ matrix.astype(blocks.dtype)
    return flat.reshape(*blocks.shape[:-1], -1)
