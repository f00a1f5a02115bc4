"""One cause tried: grown and refitted beside everything else, and what can be said of it before held-out data are asked."""

from dataclasses import dataclass

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.search.growing import determined, instances
from skin_ident.criticism.search.ranking import Ranked
from skin_ident.criticism.vocabulary import Key
from skin_models.parameter import AMPLITUDE, parameters_of


@dataclass(frozen=True)
class Trial:
    """One cause, grown and refitted: `score` is its likelihood gain less the charge for its parameters; `plainer` is the same with its
    first instance alone, where it has several."""

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
        """What may be believed of the cause: several instances may go wrong beyond what they were fitted to where the first does not."""
        return (self, self.plainer) if self.plainer else (self,)


def sized(t: Trial) -> bool:
    """Whether a cause that has one size is surely not of none in its shape: where only the product of both is known, either may be
    anything. Several sizes of one cause may stand for each other."""
    mine = instances(t.fit.model, *t.key)
    several = len(mine) > 1 or any(sum(p.role == AMPLITUDE for p in parameters_of(e)) > 1 for e in mine)
    return several or t.fit.model.effects[-1] not in mine or determined(t.fit, t.fit.std_in_shape)
