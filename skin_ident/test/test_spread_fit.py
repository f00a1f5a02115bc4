import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from skin_ident.spread_fit import fit_gaussian, fit_spread
from skin_ident.spread_scan import SpreadScan, SpreadScanError
from skin_ident.thesis_spread import CENTRE, spread_comparisons, spread_disagreements, thesis_scan
from skin_models.thesis.tables import scan, table

# Table 4-8: what its scan gives where the printed digits differ; False: no rounding of the scan can explain it
TABLE_4_8 = {
    "0.20 mm r2": (".9653", 0.964994, True),
    "0.30 mm r2": (".9599", 0.960003, True),
    "0.40 mm a": ("3.47", 3.47587, True),
    "0.40 mm r2": (".9903", 0.990432, True),
    "0.50 mm r2": (".9948", 0.994942, True),
    "0.90 mm a": ("9.23", 9.28148, False),
    "0.99 mm a": ("10.5", 10.4467, True),
    "0.99 mm c": ("5.25", 5.24473, True),
}


def test_table_4_8_comes_out_to_the_printed_digits_except_where_pinned():
    compared = [c for c in spread_comparisons() if c.table == "4-8"]
    assert len(compared) == 30
    differing = [c for c in compared if not c.agrees]
    assert {c.entry: (str(c.printed), pytest.approx(c.recomputed, rel=2e-6), c.within_rounding) for c in differing} == TABLE_4_8


@pytest.mark.parametrize("depth", list(table("4-8").rows))
def test_one_scan_that_rounds_to_table_4_10_gives_a_whole_row_of_table_4_8(depth):
    """A witness for `within rounding`: forces within half a digit of the printed ones from which a, c and R^2 follow together."""
    printed = table("4-8").rows[depth]
    entries = [e for e in ("a", "c", "r2") if (depth, e) != ("0.90", "a")]
    target = np.array([printed[e].value for e in entries])
    room = np.array([printed[e].half for e in entries])
    cells = list(table("4-10").rows[depth].values())
    force, half = np.array([c.value for c in cells]), np.array([c.half for c in cells])
    distance = scan("4-10")[1]

    def results(f):
        fit = fit_gaussian(distance, f, centre=CENTRE)
        return np.array([{"a": fit.a, "c": fit.c * 1e3, "r2": fit.r2}[e] for e in entries])

    move = np.zeros(force.size)  # in half digits
    for _ in range(3):  # the smallest move for which the results, linear about the last one, lie inside the printed digits
        move = _smallest_move(results, force, half, move, target, 0.9 * room)
    assert np.all(np.abs(results(force + half * move) - target) <= room)


def _smallest_move(results, force, half, move, target, room):
    """Minimise w subject to |u| <= w <= 1 and |results + slope (u - move) - target| <= room."""
    at, n = force + half * move, force.size
    slope = np.array([results(at + h) - results(at - h) for h in np.diag(half)]).T / 2
    off = target - results(at) + slope @ move
    none, one = np.zeros((target.size, 1)), np.ones((n, 1))
    rows = np.block([[slope, none], [-slope, none], [np.eye(n), -one], [-np.eye(n), -one]])
    found = linprog(np.r_[np.zeros(n), 1.0], rows, np.r_[off + room, room - off, np.zeros(2 * n)], bounds=[(-1, 1)] * n + [(0, 1)])
    assert found.success
    return found.x[:n]


def test_table_4_9_does_not_come_from_table_4_11():
    wrong = [d for d in spread_disagreements() if d.table == "4-9"]
    assert len(wrong) == 12 and not any(d.within_rounding for d in wrong) and all("copy" in d.why for d in wrong)
    at_2_7 = next(d for d in wrong if d.entry == "2.7 mm a")
    assert (at_2_7.printed, at_2_7.recomputed) == ("3.66", "2.53627")


def test_noise_alone_is_no_fit():
    fit = fit_spread(thesis_scan("4-11"))[0]  # printed as NA in Table 4-9
    assert np.isnan(fit.a) and "nothing but noise" in fit.reason


def test_centre_stays_where_symmetry_puts_it():
    _, distance, force = scan("4-10")
    fit = fit_gaussian(distance, force[5], centre=CENTRE, free_centre=True)
    assert fit.b == pytest.approx(CENTRE, abs=1e-9)


@given(a=st.floats(0.1, 50.0), b=st.floats(-2e-3, 2e-3), c=st.floats(1e-3, 8e-3))
def test_known_gaussian_is_found_again(a, b, c):
    x = np.linspace(-12e-3, 12e-3, 25)
    fit = fit_gaussian(x, a * np.exp(-(((x - b) / c) ** 2)), free_centre=True, mirror=False)
    assert (fit.a, fit.c) == pytest.approx((a, c), rel=1e-6) and fit.b == pytest.approx(b, abs=1e-8) and fit.r2 > 1 - 1e-9


def test_standard_errors_cover_the_truth():
    rng, r = np.random.default_rng(3), np.linspace(0, 12e-3, 13)
    fits = [fit_gaussian(r, 8 * np.exp(-((r / 5e-3) ** 2)) + rng.normal(0, 0.1, r.size)) for _ in range(400)]
    inside = np.mean([abs(f.c - 5e-3) < f.half_width("c") for f in fits])
    assert 0.92 < inside < 0.98


def test_no_error_is_smaller_than_what_is_declared():
    r = np.linspace(0, 12e-3, 13)
    exact, noisy = (fit_gaussian(r, 8 * np.exp(-((r / 5e-3) ** 2)), noise=noise) for noise in (0.0, 0.1))
    assert exact.c_std < 1e-9 < 3e-5 < noisy.c_std


def test_lost_samples_are_left_out_and_bad_mirrors_refused():
    depth, distance, force = scan("4-10")
    lost = force[5].copy()
    lost[3] = np.nan
    assert fit_gaussian(distance, lost).samples == 21
    with pytest.raises(SpreadScanError, match="both sides"):
        fit_gaussian(distance - 1e-3, force[5])
    both = SpreadScan(depth, np.linspace(-5e-3, 6e-3, 12), force)
    assert fit_spread(both)[0].samples == 12
