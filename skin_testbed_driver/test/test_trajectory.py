import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from skin_testbed_driver.trajectory import Trajectory, brake, extremes, quickest

DEPTH = st.floats(-0.01, 0.01)
SPEED = st.floats(-0.02, 0.02)


def dense(path: Trajectory, n: int = 4001):
    t = np.linspace(path.t[0], path.end, n)
    return t, np.array([path.at(s) for s in t])


def test_cubic_through_set_points_of_a_cubic_is_that_cubic():
    cubic = np.polynomial.Polynomial([1e-3, 2e-3, -3e-3, 1e-3])
    t = (0.0, 0.3, 1.1, 2.0)
    path = Trajectory(t, tuple(cubic(s) for s in t), tuple(cubic.deriv()(s) for s in t))
    times, states = dense(path)
    np.testing.assert_allclose(states[:, 0], cubic(times), atol=1e-15)
    np.testing.assert_allclose(states[:, 1], cubic.deriv()(times), atol=1e-14)


def test_rests_before_and_after():
    path = Trajectory((1.0, 2.0), (0.0, 1e-3), (0.0, 0.0))
    assert path.at(0.0) == (0.0, 0.0)
    assert path.at(5.0) == (1e-3, 0.0)


@given(st.lists(st.tuples(DEPTH, SPEED), min_size=2, max_size=6), st.floats(0.01, 1.0))
def test_extremes_are_those_of_a_dense_look(points, h):
    x, v = zip(*points, strict=True)
    path = Trajectory(tuple(h * i for i in range(len(x))), x, v)
    e, (_, states) = extremes(path), dense(path)
    assert e.deepest >= states[:, 0].max() - 1e-12 and e.deepest <= states[:, 0].max() + 1e-6
    assert e.lowest <= states[:, 0].min() + 1e-12 and e.lowest >= states[:, 0].min() - 1e-6
    assert e.speed >= np.abs(states[:, 1]).max() - 1e-9


@given(DEPTH, SPEED, DEPTH)
def test_the_quickest_way_arrives_at_rest_within_both_limits(x, v, target):
    path = quickest(3.0, x, v, target, 0.02, 1.0)
    e = extremes(path)
    assert path.t[0] == 3.0 and math.isclose(path.x[0], x, abs_tol=1e-10)
    assert math.isclose(path.x[-1], target, abs_tol=1e-12) and path.v[-1] == 0.0
    assert e.speed <= 0.02 + 1e-9
    assert e.acceleration <= 1.0 + 1e-3


@given(DEPTH, SPEED)
def test_braking_is_constant_deceleration(x, v):
    path = brake(0.0, x, v, 0.5)
    assert path.v[-1] == 0.0
    assert abs(path.x[-1] - x) == pytest.approx(v * v / 1.0, abs=1e-15)


def test_since_and_until_cut_at_set_points():
    path = Trajectory((0.0, 1.0, 2.0), (0.0, 1.0, 2.0), (0.0, 0.0, 0.0))
    assert path.until(1.0).t == (0.0,)
    assert path.since(1.5).t == (1.0, 2.0)
    assert path.until(1.5).then(path.since(2.0)).t == (0.0, 1.0, 2.0)
