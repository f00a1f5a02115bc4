"""What the search for causes has named, and everything else that it found out on the way."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.said import Said
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import PARAMETERS, Key
from skin_models.model import Model


@dataclass(frozen=True)
class Named:
    """One cause in the extended model, with its evidence, and the models fitted without it (`before`) and with it, when it was named."""

    cause: str
    where: str
    gain: Gain
    explained: float
    alternatives: tuple[Rival, ...]
    before: Model | None = None
    model: Model | None = None
    courses: dict[str, Said] = field(default_factory=dict)  # what belongs to one session alone, in words by session
    only: tuple[str, ...] = ()  # the sessions that have it, by name, where others are
    free: tuple[str, ...] = ()  # free of it

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where

    @property
    def is_another_skin(self) -> bool:
        """Whether it says that the skin is another from session to session, and not that numbers of a given model are wrong."""
        return self.key == PARAMETERS and bool(self.courses)

    def with_rivals(self, rivals: Iterable[Rival]) -> "Named":
        """The finding with those of the `rivals` behind its alternatives that it has not yet, each once."""
        had = {self.key, *(a.key for a in self.alternatives)}
        more = {r.key: r for r in rivals if r.key not in had}
        return replace(self, alternatives=(*self.alternatives, *more.values()))


@dataclass(frozen=True)
class NotNamed:
    """What is in the record and no finding: its size in the unit of its cause's directions (inf: nothing of it is ruled out), why it is
    none, what would tell, by default what its cause needs, whether it may be there all the same, whether hardware that is no worse than
    it should be does as much, and whether it is a zero that every session was let have of its own."""

    size: float
    because: str
    needs: str = ""
    doubt: bool = False
    hardware: bool = False
    own_zero: bool = False


@dataclass(frozen=True)
class Criticism:
    """Everything the criticism found, before it is written down."""

    baseline: Fit
    extended: Fit
    named: tuple[Named, ...]
    last: Survey
    rounds: tuple[tuple[Survey, str | None], ...] = ()
    train: tuple[Session, ...] = ()  # as compared: without what cannot be compared, and with the courses of their own
    held: tuple[Session, ...] = ()
    not_named: dict[Key, NotNamed] = field(default_factory=dict)  # by cause and place

    def skin_before(self, own: Session) -> Mapping[str, float]:
        """The skin under which the baseline is held against a session: its `own`, unless that is a finding."""
        return {} if any(n.is_another_skin for n in self.named) else own.skin

    def before(self, own: Session, plain: Session) -> Session:
        """A session as the baseline is held against it: its `own`, but for what it was found to have beyond the model since it was `plain`,
        and but for its skin where that is a finding."""
        return replace(own, beyond=plain.beyond, skin=self.skin_before(own))
