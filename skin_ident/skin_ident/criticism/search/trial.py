"""One cause on trial: grown and refitted with everything else, with what can be said of it before held-out data are used."""

from dataclasses import dataclass

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.search.growing import determined
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.vocabulary import Key
from skin_models.parameter import AMPLITUDE, parameters_of


@dataclass(frozen=True)
class Trial:
    """One cause, grown and refitted: `score` is its gain less the charge for its parameters (`Fit.score_over` the fit without it).
    `plainer` is the same with the first instance alone, where it has several."""

    ranked: Ranked
    fit: Fit
    score: float
    plainer: "Trial | None" = None

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.ranked.cause, self.ranked.where

    @property
    def forms(self) -> tuple["Trial", ...]:
        """The forms that may be believed: several instances may predict worse than the first alone beyond what they were fitted to."""
        return (self, self.plainer) if self.plainer else (self,)


def sized(t: Trial) -> bool:
    """Whether the one amplitude of a cause is surely not zero at the fitted shape. Where only the product of amplitude and shape is
    determined, either may be anything, so the shape is held. A cause with several amplitudes always passes, since these may stand in for
    each other."""
    mine = t.fit.model.having(t.key)
    several = len(mine) > 1 or any(sum(p.role == AMPLITUDE for p in parameters_of(e)) > 1 for e in mine)
    return several or t.fit.model.effects[-1] not in mine or determined(t.fit, t.fit.std_in_shape)
