"""Directions chosen by their inner products are those chosen by the columns themselves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import block_diag

from skin_ident.criticism.noise.pursuit import Normal, pursue


def problem(seed, beside=3):
    """Columns of two sessions one below the other, what they are to explain, and an orthonormal span that both are free of, with rows more
    than the sessions have."""
    rng = np.random.default_rng(seed)
    blocks = [rng.normal(size=(40, 5)), rng.normal(size=(70, 4))]
    whole = np.vstack([block_diag(*blocks), np.zeros((6, 9))])
    Q = np.linalg.qr(np.column_stack([rng.normal(size=(116, beside - 1)), whole[:, 0]]))[0]  # the first column is not the session's own
    A, r = whole - Q @ (Q.T @ whole), whole[:, [1, 6]] @ [3.0, -2.0] + rng.normal(size=116)
    return blocks, A, r - Q @ (Q.T @ r), Q


@given(st.integers(0, 10**6))
def test_blocks_beside_what_a_model_may_do_are_as_columns(seed):
    blocks, A, r, Q = problem(seed)
    normal, able = Normal.by_blocks(blocks, r, Q), np.arange(1, 9)
    assert normal.gram == pytest.approx(A.T @ A, abs=1e-9) and normal.product[able] == pytest.approx((A.T @ r)[able], abs=1e-9)
    assert not normal.gram[0].any() and normal.product[0] == 0.0, "what others span is nothing, and no rounding is taken for it"
    z = normal.pursue(4)
    assert z[able] == pytest.approx(pursue(A[:, able], r, 4), abs=1e-9)
    best = np.linalg.lstsq(A[:, able], r, rcond=None)[0]
    assert normal.least_squares(np.eye(9))[able] == pytest.approx(best, abs=1e-8)
    assert normal.explained(z) == pytest.approx(r @ r - np.sum((r - A @ z) ** 2), abs=1e-8)


@given(st.integers(0, 10**6))
def test_as_few_rows_as_columns_have_the_same_inner_products(seed):
    blocks, A, r, Q = problem(seed)
    few, seen = Normal.by_blocks(blocks, r, Q).square()
    assert few.shape == (8, 9)
    assert few.T @ few == pytest.approx(A.T @ A, abs=1e-9) and few.T @ seen == pytest.approx(A.T @ r, abs=1e-8)


def test_noise_alone_chooses_nothing():
    rng = np.random.default_rng(5)
    chosen = [np.count_nonzero(pursue(rng.normal(size=(2000, 12)), rng.normal(size=2000), 12)) for _ in range(40)]
    assert sum(chosen) <= 6  # a column gains more than log n with a chance of 0.006
