"""Projection off what a model may change by itself: the span of its whitened tangents, or of any other whitened rows."""

import numpy as np


def basis(A: np.ndarray) -> np.ndarray:
    """An orthonormal basis (R, U) of the span of the non-zero columns of `A` (R, M). For a zero column QR would invent a direction."""
    return np.linalg.qr(A[:, np.any(A != 0.0, axis=0)])[0]


def projected_off(rows: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Whitened rows (R, …) without what the orthonormal columns of `Q` (R, U) span."""
    return rows - Q @ (Q.T @ rows)
