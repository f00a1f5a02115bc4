"""The zero of play: where in its gap a drive counts depth from.

Play is taken to begin in the middle of its gap, unless the form with a zero explains more when it is found. Beside causes that are named
later it may: a zero of depth within the gap is then no second fault, but where the drive stood when it was zeroed.
"""

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.search.named import Named, NotNamed
from skin_ident.criticism.search.rivals import reach
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.vocabulary import PLAY, ZERO_OF_DEPTH
from skin_models.effects.backlash import Backlash, ZeroedBacklash
from skin_models.parameter import clipped


def is_zero_of_play(search: Search, finding: Named) -> bool:
    """Whether play that is in the model, with a zero of its own, explains as much as a `finding` of a zero of depth. It then takes that
    form, and the zero of depth is no finding."""
    present = search.present.model
    plays = [e for e in present.having(PLAY) if type(e) is Backlash]
    if finding.key != ZERO_OF_DEPTH or finding.courses or finding.model is None or not plays:
        return False
    play, offset = plays[0], sum(e.offset for e in finding.model.having(ZERO_OF_DEPTH))
    own = clipped(ZeroedBacklash, gap=play.gap, zero=2.0 * offset / max(play.gap, abs(offset)))
    zeroed = present.without(play).extended(ZeroedBacklash.typical(play.where, **own))
    after = fit(zeroed, search.train, search.noise)
    if after.score_over(search.present) < reach(finding.explained):
        return False
    search.present = after
    search.tared[ZERO_OF_DEPTH] = NotNamed(
        size=abs(offset),
        because=f"a zero of depth that is off by {1e6 * abs(offset):.2g} µm lies within the play that was found: which side of its gap "
        "the drive was zeroed on decides it",
        needs="depths that are zeroed where the plunger touches the skin, moving as it does in the test",
    )
    return True
