"""How well the shares of an array are known, where sessions at one place disagree."""

import numpy as np

from skin_ident.criticism.array.gains import Gains
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.scatter import with_scatter


def shares(*rows: list[float], error: float = 0.01) -> Gains:
    value = np.array(rows)
    return Gains(value, np.tile(error**2 * np.eye(value.shape[1]), (len(value), 1, 1)))


def layout(*contacts: float) -> Layout:
    return Layout(np.array([(0.0, 0.0), (7e-3, 0.0)]), np.array([(x, 0.0) for x in contacts]), 5e-3, True)


def test_sessions_that_agree_are_as_sure_as_they_say():
    measured = shares([1.0, 0.5], [1.01, 0.49], [0.5, 0.25])  # the third of another scale
    assert np.array_equal(with_scatter(measured, layout(0.0, 0.0, 0.0)).covariance, measured.covariance)


def test_a_taxel_on_which_sessions_disagree_is_known_no_better_than_that():
    measured = shares([1.0, 0.2], [1.01, 0.6], [0.99, -0.2])
    errors = np.sqrt(np.diagonal(with_scatter(measured, layout(0.0, 0.0, 0.0)).covariance, axis1=1, axis2=2))
    assert np.all(errors[:, 1] > 0.3) and np.all(errors[:, 0] < 0.1)


def test_sessions_at_several_places_need_not_agree():
    measured = shares([1.0, 0.1], [0.5, 0.5], [0.1, 1.0])
    assert np.array_equal(with_scatter(measured, layout(0.0, 3.5e-3, 7e-3)).covariance, measured.covariance)
