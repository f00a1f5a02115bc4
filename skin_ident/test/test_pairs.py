"""Two effects at once are both named: neither hides behind the other, nor behind one name that fits a little of each."""

import numpy as np
import pytest
from hide_and_seek import seek
from hypothesis import given
from hypothesis import strategies as st
from rows import rows
from scipy.signal import lfilter
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.search.exchange import _better
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording

PAIRS = [
    (Hide("lag", "taxel_0", "one_pole", 1.5), Hide("off_centre", "rig", "walk", 1.5), 3),  # the second a hundredth of the first, elsewhere
    (Hide("friction", "load_cell", "coulomb", 1.5), Hide("dead_zone", "taxel", "threshold", 1.5), 1),  # a loop in part, a threshold in part
]


@pytest.mark.parametrize(("one", "other", "taxels"), rows(PAIRS, 0), ids=lambda h: getattr(h, "cause", ""))
def test_both_are_named(tmp_path, one, other, taxels):
    sessions, _ = make_sessions([one, other], seed=7, n_taxels=taxels, protocol="full", noise="white")
    write_case(sessions, tmp_path)
    recordings = load(tmp_path)
    found = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    named = [{f["cause"], *(a["cause"] for a in f["alternatives"])} for f in found]
    assert len(found) == 2 and all(any(h.cause in names for names in named) for h in (one, other)), named


LARGE = [
    (Hide("cyclic_softening", "skin", "mullins", 4.0), Hide("stress_relaxation", "skin", "prony2", 1.0), 7),
    (Hide("drift", "load_cell", "warm_up", 4.0), Hide("friction", "rig", "coulomb", 1.0), 7),
]


@pytest.mark.parametrize(("large", "small", "seed"), rows(LARGE, 0), ids=lambda h: getattr(h, "cause", ""))
def test_what_explains_all_that_is_left_beside_a_large_effect_is_no_imperfect_form_of_that(tmp_path, large, small, seed):
    sessions, _ = make_sessions([large, small], seed=seed, n_taxels=1, protocol="full", noise="white")
    write_case(sessions, tmp_path)
    recordings = load(tmp_path)
    found = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert [(f["cause"], f["where"]) for f in found] == [(h.cause, h.where) for h in (large, small)]


# Loops that grow with the load, fitted as loops of one height, had left a rest that was named as well: softening, or friction.
PRESSED = [(Hide("lag", "taxel_0", None, 2.0), 2.0, 903, 2), (Hide("drift", "load_cell", None, 2.0), 1.0, 900, 1)]


@pytest.mark.parametrize(("other", "size", "seed", "taxels"), rows(PRESSED, 0), ids=lambda x: getattr(x, "cause", ""))
def test_beside_a_loop_that_grows_with_the_load_one_other_is_named(tmp_path, other, size, seed, taxels):
    loop = Hide("hysteresis", "skin", "pressed", size)
    assert seek(tmp_path, [loop, other], taxels=taxels, seed=seed).names == [
        ("hysteresis", "skin"),
        (other.cause, other.where.removesuffix("_0")),
    ]


@given(st.floats(10.0, 1e6), st.floats(10.0, 1e6), st.integers(-9, 9))
def test_of_two_accounts_at_most_one_takes_the_place_of_the_other(one, other, more_numbers):
    """Else the search would go to and fro."""
    assert not (_better(one, other, more_numbers) and _better(other, one, -more_numbers))


RATE = 125.0


def worn_and_stiffening(rng: np.random.Generator, gap: float = 11e-6, bend: float = 0.09) -> Recording:
    """A plunger behind a worn nut, which follows with `gap` m of play, on skin of 6 mm that is in part (`bend`)
    neo-Hookean: one takes load away where the other adds it. With wandering heavy-tailed noise, coarse encoder and converters."""
    x = [-0.3e-3]
    while len(x) < 40 * RATE:
        target = rng.uniform(0.3e-3, 1.9e-3) if rng.random() < 0.8 else -0.3e-3
        count = max(int(abs(target - x[-1]) / 10 ** rng.uniform(-3.7, -2.5) * RATE), 2)
        x += [*np.linspace(x[-1], target, count + 1)[1:]]
        if rng.random() < 0.3:
            x += [target] * int(rng.uniform(0.5, 2.0) * RATE)
    soft = np.hanning(9) / np.hanning(9).sum()
    path = np.convolve(np.pad(x, 4, mode="edge"), soft, "valid")
    tip, at = np.empty_like(path), path[0]
    for i, depth in enumerate(path):
        at = min(max(at, depth - gap), depth)
        tip[i] = at
    y = np.maximum(tip, 0.0)
    stretch = 1.0 - y / 6e-3
    bent, speed = (1.0 - bend) * y + bend * 3.7e-3 / 3.0 * (stretch**-2 - stretch), np.gradient(y, 1.0 / RATE)
    force, taxel = (np.maximum(k * bent + b * speed, 0.0) * (y > 0.0) for k, b in ((6000.0, 190.0), (1920.0, 59.0)))
    e = lfilter([np.sqrt(1.0 - 0.81)], [1.0, -0.9], rng.standard_t(4, (2, path.size)), axis=1) / np.sqrt(2.0)

    def read(row, step):
        return step * np.round(row / step)

    depth, seen = read(path, 10e-6), read(taxel + 0.017 * e[1], 0.01)[None]
    return Recording(f"run_{rng.integers(1e9)}", np.arange(path.size) / RATE, depth, read(force + 0.027 * e[0], 0.02), seen)


@pytest.mark.slow
def test_what_was_named_first_is_asked_again_when_the_other_is_known(tmp_path):
    """Of a lagging taxel and a load cell with memory a mount that yields explains most, until one of them is known."""
    one, other = Hide("lag", "taxel_0", "one_pole", 1.0), Hide("hysteresis", "load_cell", "bouc_wen", 1.0)
    sessions, _ = make_sessions([one, other], seed=670979871, n_taxels=1, protocol="full")
    write_case(sessions, tmp_path)
    recordings = load(tmp_path)
    found = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert {(f["cause"], f["where"]) for f in found} == {("lag", "taxel"), ("hysteresis", "load_cell")}


def test_two_that_hide_each_other_are_found_together():
    """Neither predicts held-out data alone: the fit bends each to stand for the other as well."""
    recordings = [worn_and_stiffening(np.random.default_rng(i)) for i in range(3)]
    found = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    assert {(f["cause"], f["where"]) for f in found} == {("nonlinear_stiffness", "skin"), ("backlash", "rig")}
