"""What the search for causes has named, and everything else that it found on the way."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from skin_ident.criticism.baseline.fitting import Fit
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.said import Said
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.sessions.session import Session, delayed
from skin_ident.criticism.vocabulary import PARAMETERS, Key
from skin_models.model import Model


@dataclass(frozen=True)
class Named:
    """One cause in the extended model, with its evidence, and the models fitted without it (`before`) and with it (`model`) when it was
    named.

    `gain` is what it gains on held-out data. `explained` is what it explained of the sessions that it was fitted to when it was named, in
    squared whitened units: its score, or the sum of scores if more of it was named later. For the cause `parameters` it is the gain,
    without a charge. `unread`: it is searched beside, and is no finding (see `unread_play`).
    """

    cause: str
    where: str
    gain: Gain
    explained: float
    alternatives: tuple[Rival, ...]
    before: Model | None = None
    model: Model | None = None
    courses: dict[str, Said] = field(default_factory=dict)  # for what each session has of its own: that in words, by session
    only: tuple[str, ...] = ()  # names of the sessions that have it, where others do not
    free: tuple[str, ...] = ()  # names of the sessions that do not have it
    unread: bool = False

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where

    @property
    def is_another_skin(self) -> bool:
        """Whether it says that the skin differs from session to session, and not that numbers of a given model are wrong."""
        return self.key == PARAMETERS and bool(self.courses)

    def with_rivals(self, rivals: Iterable[Rival]) -> "Named":
        """The finding with those of the `rivals` appended to its alternatives that it does not have yet, each once."""
        had = {self.key, *(a.key for a in self.alternatives)}
        more = {r.key: r for r in rivals if r.key not in had}
        return replace(self, alternatives=(*self.alternatives, *more.values()))


@dataclass(frozen=True)
class NotNamed:
    """Something that is in the record and is no finding.

    `size` is in the unit of its cause's directions (inf: no amount of it is ruled out). `because` says why it is no finding, and `needs`
    what would tell, by default what its cause needs. `doubt`: it may be there all the same. `hardware`: sound hardware does as much.
    `own_zero`: it is a zero that every session was allowed to have of its own.
    """

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
    grown: dict[Key, Fit] = field(default_factory=dict)  # what the causes tried last come to, where they explain something

    def skin_before(self, own: Session) -> Mapping[str, float]:
        """The skin factors with which the baseline is compared in a session: those of `own`, unless another skin is a finding."""
        return {} if any(n.is_another_skin for n in self.named) else own.skin

    def before(self, own: Session) -> Session:
        """A session as the baseline is compared with it: `own`, with zeros and a delay as good hardware has them, but without courses, and
        without its skin where that is a finding."""
        beyond = own.beyond if own.course is None else own.beyond - own.course
        return replace(own, beyond=beyond, course=None, skin=self.skin_before(own))

    def as_before(self, plain: Session, own: Session) -> Session:
        """The session `plain`, which has the same samples, with that of `own` which the baseline has, too."""
        bare = self.before(own)
        return replace(delayed(plain, bare.late), beyond=bare.beyond, skin=bare.skin)
