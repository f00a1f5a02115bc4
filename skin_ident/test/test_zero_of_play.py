"""A zero of depth within the gap of play that was found before is where the drive was zeroed, and no fault of its own."""

import pytest
from gate_records import PLAIN, QUICK, recorded

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.zero_of_play import is_zero_of_play
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.vocabulary import PLAY, ZERO_OF_DEPTH
from skin_models.effects.backlash import Backlash, ZeroedBacklash
from skin_models.effects.position_offset import PositionOffset

GAP = 60e-6  # m


def found(offset: float) -> tuple[Search, Named]:
    """A search that has named play, and a zero of depth of `offset` m that it is about to name beside it."""
    truth = PLAIN.extended(Backlash("rig", gap=GAP)).extended(PositionOffset("rig", offset=offset))
    sessions = [prepare(recorded(truth, seed=seed)) for seed in (3, 4)]
    search = Search(sessions, [], (), lambda stage: None)
    search.noise = fit_whitener([residual(truth, s) for s in sessions], sessions)
    search.present = fit(PLAIN.extended(Backlash("rig", gap=GAP)), sessions, search.noise)
    after = fit(search.present.model.extended(PositionOffset("rig", offset=offset)), sessions, search.noise)
    assert after.score_over(search.present) > 50.0
    return search, Named(*ZERO_OF_DEPTH, QUICK, after.score_over(search.present), (), search.present.model, after.model)


@pytest.mark.parametrize("share", [0.9, -0.5])
def test_within_the_gap_it_is_the_form_of_the_play(share):
    search, finding = found(share * GAP / 2)
    assert is_zero_of_play(search, finding)
    (play,) = search.present.model.having(PLAY)
    assert isinstance(play, ZeroedBacklash) and play.zero == pytest.approx(share, abs=0.1) and play.gap == pytest.approx(GAP, rel=0.05)
    assert "within the play" in search.not_named[ZERO_OF_DEPTH].because


def test_beyond_the_gap_it_is_a_finding():
    search, finding = found(1.5 * GAP)
    present = search.present
    assert not is_zero_of_play(search, finding) and search.present is present and not search.not_named
