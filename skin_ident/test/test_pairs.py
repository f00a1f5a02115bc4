"""Two effects at once are both named: neither hides behind the other, nor behind one name that fits a little of each."""

import pytest
from world import make_sessions, write_case
from world.hidden import Hide

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.load import load

PAIRS = [
    (Hide("lag", "taxel_0", "one_pole", 1.5), Hide("off_centre", "rig", "walk", 1.5), 3),  # the second a hundredth of the first, elsewhere
    (Hide("friction", "load_cell", "coulomb", 1.5), Hide("dead_zone", "taxel", "threshold", 1.5), 1),  # a loop in part, a threshold in part
]


@pytest.mark.parametrize(("one", "other", "taxels"), PAIRS, ids=lambda h: getattr(h, "cause", ""))
def test_both_are_named(tmp_path, one, other, taxels):
    sessions, _ = make_sessions([one, other], seed=7, n_taxels=taxels, protocol="full", noise="white")
    write_case(sessions, tmp_path)
    recordings = load(tmp_path)
    found = diagnose(recordings[:2], recordings[2:]).findings["findings"]
    named = [{f["cause"], *(a["cause"] for a in f["alternatives"])} for f in found]
    assert len(found) == 2 and all(any(h.cause in names for names in named) for h in (one, other)), named
