"""Good data spoilt in every way, singly and in pairs: a right answer or a clear refusal. Never a wrong number."""

import warnings
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from corrupting import DEFECTS, raw, write
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from making import SILICONE, recording

from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.estimators.estimate import NOT_IDENTIFIABLE
from skin_ident.estimators.force_to_force import fit_force_to_force
from skin_ident.recordings.load import load
from skin_models.errors import SkinError

TRUTH = dict(zip(("b1", "k1", "b2", "k2", "share_1"), (*SILICONE[4][1:], 0.4), strict=True))
RATIOS = {"share": 9619 / 12385, "lead": 939.5 / 9619, "lag": 1568.7 / 12385}
SUFFIXES = [".csv", ".mcap", ".db3"]
GOOD = recording(n=800, hz=0.5, sigma=0.02, shares=(1.0, 0.4))


def dispersion(recordings):
    return fit_dispersion(recordings, SILICONE[4][0])


def judged(path, fitted=dispersion, truth=TRUTH):
    """ "refused", "right", "partly" or "wrong", and what was said. What is called not identifiable is refused; partly is right beside that.

    A parameter that is given a wrong value is wrong however loudly it is warned of, and one that is missing without a word, too.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a stray numpy warning is a case nobody thought of
        try:
            fit = fitted(load(path))
        except SkinError as error:
            assert str(error) and "\n" not in str(error)
            return "refused", str(error)
    claimed = {n: v for n, v in truth.items() if n in fit.values and fit.verdicts[n].word != NOT_IDENTIFIABLE}
    far = [n for n, v in claimed.items() if not abs(fit.values[n] - v) <= 5 * fit.std[n] + 0.03 * abs(v)]
    told = f"{far} {fit.values} {' | '.join(fit.warnings)}"
    if far or (not truth.keys() <= fit.values.keys() and not fit.warnings):
        return "wrong", told
    return "right" if len(claimed) == len(truth) else "partly", told


def between_forces(recordings):
    return fit_force_to_force([replace(r, depth=None) for r in recordings], taxel=0)


def spoilt(folder, suffix, defects, seed):
    draw, s = np.random.default_rng(seed), raw(GOOD)
    s.only_table = suffix == ".csv"
    for defect in sorted(defects, key=DEFECTS.index):
        defect(draw, s)
    return write(s, folder / f"a{suffix}")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("spoilt")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_good_data_are_right_without_a_warning(folder, suffix):
    outcome, said = judged(spoilt(folder, suffix, [], 0))
    assert outcome == "right" and said.endswith("} ")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("defect", DEFECTS, ids=lambda d: d.__name__)
def test_one_defect(folder, defect, suffix):
    for seed in range(4):
        outcome, said = judged(spoilt(folder, suffix, [defect], seed))
        assert outcome != "wrong", (seed, said)


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda d: d.__name__)
def test_one_defect_from_force_to_force(folder, defect):
    for seed in range(3):
        outcome, said = judged(spoilt(folder, ".mcap", [defect], seed), between_forces, RATIOS)
        assert outcome != "wrong", (seed, said)


pairs = st.lists(st.sampled_from(DEFECTS), min_size=2, max_size=2)


@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(defects=pairs, seed=st.integers(0, 2**32 - 1), suffix=st.sampled_from(SUFFIXES))
def test_pairs_of_defects(folder, defects, seed, suffix):
    outcome, said = judged(spoilt(folder, suffix, defects, seed))
    assert outcome != "wrong", said


@pytest.mark.campaign
@pytest.mark.parametrize(("fitted", "truth", "cases", "known"), [(dispersion, TRUTH, 5000, 0), (between_forces, RATIOS, 2000, 4)])
def test_thousands_of_pairs(folder, fitted, truth, cases, known, capsys):
    """`known`: without a depth nothing tells that load cell and taxel are clipped at once; lead and lag are then wrong, with a warning."""
    outcomes, bad = Counter(), []

    @settings(max_examples=cases, deadline=None, suppress_health_check=list(HealthCheck), database=None)
    @given(
        defects=st.lists(st.sampled_from(DEFECTS), min_size=1, max_size=2),
        seed=st.integers(0, 2**32 - 1),
        suffix=st.sampled_from(SUFFIXES),
    )
    def run(defects, seed, suffix):
        outcome, said = judged(spoilt(folder, suffix, defects, seed), fitted, truth)
        outcomes[outcome] += 1
        if outcome == "wrong":
            bad.append(([d.__name__ for d in defects], seed, suffix, said))

    run()
    with capsys.disabled():
        print(dict(outcomes), bad[:5])
    silent = [case for case in bad if case[-1].endswith("} ")]
    assert not silent and len(bad) <= known
