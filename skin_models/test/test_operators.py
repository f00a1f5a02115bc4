"""Shared numerical operators against the loop they replace, and the properties hysteresis theory gives them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from skin_models.operators import lagging
from skin_models.operators import play as play_module
from skin_models.operators.draws import BLOCK, Stream, gaussian, uniform, whole
from skin_models.operators.growing_root import growing_root
from skin_models.operators.lagging import lagged, lagged_either_way, lagged_in_contact, lagged_in_contact_step, lagged_step_either_way
from skin_models.operators.play import play, play_step, stop
from skin_models.operators.relay import relay, relay_step
from skin_models.operators.scan import running_affine, running_clamp

numbers = st.floats(-5.0, 5.0)
records = arrays(float, st.integers(1, 70), elements=numbers)
slack = st.floats(0.0, 6.0)


@given(records, slack)
def test_play_equals_the_loop(x, r):
    state, out = None, []
    for value in x:
        state = play_step(state, value, r)
        out.append(state)
    assert np.array_equal(play(x, r), out)


@given(arrays(float, (3, 40), elements=numbers), slack)
def test_play_of_several_rows_is_that_of_each(x, r):
    assert np.array_equal(play(x, r), [play(row, r) for row in x])


@given(arrays(float, (2, 40), elements=numbers), slack)
def test_play_is_the_same_without_a_compiler(x, r):
    with pytest.MonkeyPatch.context() as without:
        without.setattr(play_module, "_compiled", lambda: None)
        plain = play(x, r)
    assert np.array_equal(play(x, r), plain)


@given(arrays(float, 50, elements=numbers), arrays(float, 50, elements=st.floats(0.0, 3.0)), numbers)
def test_running_clamp_equals_the_loop(low, width, start):
    w, out = start, []
    for bottom, top in zip(low, low + width, strict=True):
        w = min(top, max(bottom, w))
        out.append(w)
    assert np.array_equal(running_clamp(low, low + width, start), out)


@given(arrays(float, 60, elements=st.floats(-1.0, 1.0)), arrays(float, 60, elements=numbers), numbers)
def test_running_affine_equals_the_loop(gain, offset, start):
    w, out = start, []
    for a, b in zip(gain, offset, strict=True):
        w = a * w + b
        out.append(w)
    assert running_affine(gain, offset, start) == pytest.approx(out, rel=1e-12, abs=1e-11)


@given(records, st.floats(0.01, 6.0))
def test_play_does_not_depend_on_rate(x, r):
    """Samples put in between on the way change nothing: the operator sees the path, not the time."""
    n = np.arange(x.size)
    finer = np.interp(np.arange(4 * x.size - 3) / 4, n, x)
    assert play(finer, r)[::4] == pytest.approx(play(x, r), abs=1e-12)


@given(records, st.floats(0.01, 6.0))
def test_stop_is_bounded_and_dissipates(x, r):
    e, dx = stop(x, r), np.diff(x)
    assert np.all(np.abs(e) <= r + 1e-12)
    stored = 0.5 * e**2
    assert np.all(0.5 * (e[1:] + e[:-1]) * dx - np.diff(stored) >= -1e-12)


@given(st.floats(0.1, 2.0), st.floats(0.1, 3.0), st.floats(0.1, 3.0))
def test_play_forgets_a_closed_minor_loop(r, up, back):
    """Return-point memory: after a smaller excursion back to the same turning point the state is what it was."""
    back = min(back, up)
    x = np.array([0.0, up, up - back, up])
    assert play(x, r)[3] == pytest.approx(play(x, r)[1])


@given(records, st.floats(-3.0, 0.0), st.floats(0.0, 3.0))
def test_relay_equals_the_loop(x, low, high):
    state, out = 0.0, []
    for value in x:
        state = relay_step(state, value, low, high)
        out.append(state)
    assert np.array_equal(relay(x, low, high), out)


@pytest.mark.parametrize("draw", [gaussian, uniform])
@pytest.mark.parametrize("rows", [(), (2,)])
def test_numbers_drawn_one_by_one_are_those_drawn_together(draw, rows):
    n = BLOCK + 50  # past the end of a block
    together, stream = whole(99, (*rows, n), draw), Stream(99)
    for i in range(n):
        before, (stream, number) = stream, stream.next(rows, draw)
        if i % 500 == 0:
            assert np.array_equal(before.next(rows, draw)[1], number)  # a draw can be taken back
        assert np.array_equal(number, together[..., i])
    assert not np.array_equal(whole(98, (*rows, n), draw), together)


@given(
    root=arrays(float, 6, elements=st.floats(1e-6, 2.0)),
    bend=arrays(float, 6, elements=st.floats(0.0, 50.0)),
    flat=arrays(float, 6, elements=st.floats(0.0, 0.9)),
    start=arrays(float, 6, elements=st.floats(1e-3, 5.0)),
    slope=arrays(float, 6, elements=st.floats(1e-3, 1e6)),
)
def test_zeros_of_growing_functions_are_found_wherever_the_search_starts(root, bend, flat, start, slope):
    def pull(x):
        return np.maximum(x - flat * root, 0.0) * (1.0 + bend * x**2)

    size, last = pull(root), []
    x, _ = growing_root(lambda x: (last.append(x), pull(x) - size)[1], np.zeros(6), start, slope, size, 1e3)
    assert np.abs(pull(x) - size) == pytest.approx(np.zeros(6), abs=1e-9 * size.max()) and np.array_equal(last[-1], x)


def test_a_jump_across_zero_ends_just_below_it():
    x, _ = growing_root(lambda x: np.where(x > 0.3, 1.0, -1.0), np.zeros(2), np.array([0.1, 2.0]), np.ones(2), np.ones(2), 10.0)
    assert x == pytest.approx([0.3, 0.3], abs=1e-12) and np.all(x <= 0.3)


def test_a_function_that_stays_negative_ends_beyond_the_highest():
    x, _ = growing_root(lambda x: x - 9.0, np.zeros(1), np.full(1, 1e-3), np.full(1, 1e3), np.full(1, 9.0), 1.0)
    assert 1.0 < x[0] <= 9.0 + 1e-9
    x, _ = growing_root(lambda x: np.full(1, -9.0), np.zeros(1), np.full(1, 1e-3), np.full(1, 1e3), np.full(1, 9.0), 1.0)
    assert x[0] > 1.0


@given(records, st.floats(0.05, 30.0))
def test_a_lag_in_contact_begins_anew_at_every_touch(x, tau):
    state, one_by_one = None, []
    for depth in x:
        state, z = lagged_in_contact_step(state, depth, tau, 1.0)
        one_by_one.append(z)
    whole = lagged_in_contact(x, tau, 1.0)
    assert np.allclose(whole, one_by_one, atol=1e-9 * max(np.abs(x).max(), 1e-3)) and not whole[x <= 0.0].any()
    for a, b in zip(*touches(x > 0.0), strict=True):
        if a > 0:
            assert np.allclose(whole[a:b], lagged(np.append(0.0, x[a:b]), tau, 1.0)[1:], atol=1e-9 * max(np.abs(x).max(), 1e-3))


def touches(mask):
    edges = np.diff(np.concatenate([[0], mask.astype(int), [0]]))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)


times = st.floats(1e-3, 30.0)


@pytest.mark.parametrize("compiled", [True, False])
@given(records, times, times)
def test_a_lag_either_way_equals_the_loop(compiled, y, up, down):
    rows, state, out = np.array([y, -y]), None, []
    for sample in rows.T:
        state, z = lagged_step_either_way(state, sample, up, down, 1.0)
        out.append(z)
    with pytest.MonkeyPatch.context() as without:
        if not compiled:
            without.setattr(lagging, "_compiled_either_way", lambda: None)
        assert lagged_either_way(rows, up, down, 1.0) == pytest.approx(np.transpose(out), abs=1e-12)
