"""The content of findings.json as the report needs it: typed and complete."""

from dataclasses import dataclass, field
from typing import Any

from skin_ident.criticism.pattern import RANGE, listed
from skin_ident.criticism.vocabulary import EXCHANGED, SWAPPED, cause_at, place, spoken
from skin_ident.report.tolerant import mapping, text, with_spoken_taxels

NOTHING, EXPLAINED, PARTLY, UNEXPLAINED = "nothing_wrong", "explained", "partly_explained", "unexplained"
ROUNDING = 1e-12  # SI: smaller than any real value of a parameter
SCAN = "static spread scan"  # the kind of recording of a spread scan
DIRECT = {"quantization", "saturation", "outliers", "dead_taxel", "noise", "data_error", "interference"}  # seen without a model
ZEROS = {"position_offset": "zero of depth", "force_offset": "zero of {}"}
HELD_OUT, STRETCHES, IN_TURN, UNTESTED = "held_out", "stretches", "in_turn", ""  # how a gain was tested


@dataclass(frozen=True)
class Amount:
    """One parameter: its name in code, its name in words, its SI value with unit and standard error (None where not known), `none`, the
    neutral value at which it has no effect, and whether it lies `at_end`, at the end of its allowed range."""

    name: str
    words: str
    value: float | None
    unit: str
    std: float | None = None
    none: float = 0.0
    at_end: bool = False

    @property
    def is_rounding(self) -> bool:
        """Whether it differs from its neutral value only by rounding of the computation."""
        return self.value is not None and self.value != self.none and abs(self.value - self.none) < ROUNDING


@dataclass(frozen=True)
class Gain:
    """Error on held-out data before and after; `low` and `high` bound the fall at 95 %."""

    before: float | None
    after: float | None
    low: float | None
    high: float | None
    channel: str
    unit: str
    held_out: str

    @property
    def fall(self) -> float | None:
        """Relative fall of the error."""
        return 1.0 - self.after / self.before if self.before and self.after is not None else None


@dataclass(frozen=True)
class Finding:
    """One named cause."""

    cause: str
    where: str
    channels: tuple[str, ...]
    amounts: tuple[Amount, ...]
    evidence: tuple[tuple[str, Any], ...]
    gain: Gain
    alternatives: tuple[tuple[str, str, str], ...]  # cause, where, remark
    separating: str
    hid_in: tuple[tuple[Amount, Amount], ...] = ()  # parameters of the baseline that it had biased, before and after
    battery: str = ""  # file of the experiment in `separating`, where one was computed
    by_hand: bool = False  # experiments were computed, but none of them helps
    act: str = ""  # what to do: the finding's own advice, else that of its cause
    means: str = ""  # what it means: the finding's own words, else those of its cause
    behind: tuple[float | None, ...] = ()  # for each alternative, the share by which it explains less; None where that may be chance

    rival_amounts: tuple[tuple[Amount, ...], ...] = ()  # for each alternative, its parameters, where they are known

    @property
    def shown_in(self) -> tuple[str, ...]:
        """The channels to look at first: that of the sensor in which it lies, then the one that its gain is about."""
        own = {"load_cell": ("force",)}.get(self.where, (self.where,) if self.where.startswith("taxel_") else ())
        return (*own, self.gain.channel)

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """Cause and place of the named cause, then of its alternatives."""
        return (self.cause, self.where), *((c, w) for c, w, _ in self.alternatives)

    @property
    def why(self) -> str:
        """The finding's own sentence on why it was named; empty where it has none."""
        return with_spoken_taxels(text(dict(self.evidence).get("why")))

    @property
    def partly(self) -> bool:
        """Whether only some sessions have it."""
        return bool(dict(self.evidence).get("not_in"))

    @property
    def called(self) -> str:
        """Its cause and place in words; for exchanged columns, which these are."""
        if self.exchanged:
            return f"{EXCHANGED} of {listed([spoken(c) for c in self.channels])}"
        return cause_at(self.cause, self.where)

    @property
    def lies(self) -> str:
        """Its place in words; for exchanged columns, the columns."""
        return listed([spoken(c) for c in self.channels]) if self.exchanged else place(self.where)

    @property
    def exchanged(self) -> bool:
        """Whether the finding is that columns of the record were exchanged."""
        return text(dict(self.evidence).get("kind")) in (EXCHANGED, SWAPPED) and len(self.channels) > 1

    @property
    def each_session(self) -> dict[str, Any]:
        """What each session has of its own, in words by session; empty where all sessions share the finding's parameters."""
        return mapping(dict(self.evidence).get("of_each_session"))

    @property
    def goes(self) -> str:
        """The pattern over the sessions, such as `from day18 on`, where each has its own values or only some have it; else empty."""
        return text(dict(self.evidence).get("pattern"))

    @property
    def has_pattern(self) -> bool:
        """Whether `goes` is a pattern, and not only the range of the sessions' values."""
        return bool(self.goes) and not self.goes.startswith(RANGE)

    @property
    def in_some(self) -> str:
        """In which sessions it is, after a comma, where only some have it; else empty."""
        return f", {self.goes or 'in some sessions'}" if self.partly else ""

    @property
    def simulated(self) -> bool:
        """Whether the finding says that it is in the extended model."""
        return dict(self.evidence).get("in_model") is True

    @property
    def carried(self) -> bool:
        """Whether it is in the extended model: as the finding says, else whether it was named because the simulation improved."""
        return self.simulated if self.says_whether_simulated else not self.direct

    @property
    def says_whether_simulated(self) -> bool:
        """Whether the finding says whether it is in the extended model."""
        return "in_model" in dict(self.evidence)

    @property
    def direct(self) -> bool:
        """Whether it is seen in the record itself, without a model, so that there is no gain of the simulation. A dead taxel is always
        direct: it has no signal to predict."""
        return self.cause == "dead_taxel" or (not self.gain.fall and (self.cause in DIRECT or self.says_whether_simulated))

    @property
    def put_right(self) -> bool:
        """Whether it was taken out of the whole record before anything was compared."""
        return dict(self.evidence).get("put_right") is True

    @property
    def unmeasured(self) -> str:
        """Why the comparison cannot measure its gain, as a clause; empty where it can, or where it is a fault of the record."""
        said = text(dict(self.evidence).get("predicts_nothing_for"))
        beside = "it was taken out before anything was compared" if self.put_right else "the moments at which it acts are not compared"
        beside = "" if self.cause in DIRECT else beside
        return (said or beside) if self.direct else ""


@dataclass(frozen=True)
class ChannelError:
    """Root mean squared error of one channel: baseline and extended model, on training and on held-out data; and the noise floor."""

    channel: str
    unit: str
    train: tuple[float | None, float | None]
    held_out: tuple[float | None, float | None]
    floor: float | None
    interval: tuple[float, float] | None = None  # of the fall, at 95 %

    @property
    def pair(self) -> tuple[float | None, float | None]:
        """Error before and after: held-out where both are known, else on training data."""
        return self.held_out if None not in self.held_out else self.train


@dataclass(frozen=True)
class View:
    """Everything that the report needs from findings.json."""

    verdict: str
    model: str
    recordings: tuple[Any, ...]
    findings: tuple[Finding, ...]
    errors: tuple[ChannelError, ...]
    before: tuple[Amount, ...]
    after: tuple[Amount, ...]
    excluded: tuple[dict[str, Any], ...]
    untestable: tuple[dict[str, Any], ...]
    warnings: tuple[str, ...]
    rest: float | None  # share of the residual's mean square that a general model still predicts
    band_hz: float | None  # errors are counted below this frequency
    in_turn: bool  # whether the errors are of sessions that were held out in turn
    other: dict[str, Any]  # entries of findings.json that the report does not know
    held: tuple[tuple[Amount, str], ...] = ()  # parameters that were not fitted, and where their values come from
    above: tuple[str, float] | None = None  # the channel whose error is clearly above its noise, and the ratio of the two
    given: bool = False  # whether the baseline was given, not fitted
    reach: dict[str, float] = field(default_factory=dict)  # the largest reading (N) by channel, and `depth` (m)
    most_left: dict[str, Any] = field(default_factory=dict)  # the entry `systematic_rest`, with the sessions of the largest residual

    @property
    def alone(self) -> bool:
        """Whether the load cell stands alone, without taxels."""
        return {e.channel for e in self.errors} == {"force"}

    @property
    def loudest(self) -> list[float]:
        """The largest error, as a list of one (empty without errors). It decides the unit of all errors on the page, because two units for
        one kind of number would be misread."""
        errors = [x for e in self.errors if e.channel not in self.silent for x in e.pair if x]
        return [max(errors)] if errors else []

    @property
    def doubts(self) -> tuple[dict[str, Any], ...]:
        """Causes in doubt: training data speak for them, but held-out data do not confirm them."""
        return tuple(e for e in self.untestable if e.get("in_doubt"))

    @property
    def left_open(self) -> tuple[dict[str, Any], ...]:
        """Causes of which each could explain a departure, so that none was named. Empty where anything was named or the verdict is not
        "nothing wrong"."""
        return tuple(e for e in self.untestable if e.get("left_open") is True) if self.verdict == NOTHING and not self.findings else ()

    @property
    def unsettled(self) -> tuple[dict[str, Any], ...]:
        """Causes in doubt or left open, which keep a verdict of "nothing wrong" from being an all-clear."""
        return (*self.doubts, *self.left_open) if self.verdict == NOTHING else ()

    @property
    def own_zeros(self) -> tuple[str, ...]:
        """The zeros that were fitted to every session. Good hardware and tares leave such zeros, so they are no fault."""
        own = [e for e in self.untestable if e.get("own_zero") is True and text(e.get("cause")) in ZEROS]
        return tuple(dict.fromkeys(ZEROS[text(e.get("cause"))].format(place(text(e.get("where")))) for e in own))

    @property
    def tested(self) -> str:
        """How the extended model was tested: on a held-out session, on stretches of the only session, on each session in turn, or not."""
        if self.in_turn:
            return IN_TURN
        if any(e.held_out[0] is not None for e in self.errors):
            return STRETCHES if len(self.recordings) == 1 and not self.is_scan else HELD_OUT
        return IN_TURN if len(self.recordings) > 1 else UNTESTED

    @property
    def is_scan(self) -> bool:
        """Whether this is about a static spread scan."""
        return any(mapping(r).get("kind") == SCAN for r in self.recordings)

    @property
    def has_model(self) -> bool:
        """Whether there is an extended model; one without parameters was never fitted."""
        return bool(self.after)

    @property
    def is_twin(self) -> bool:
        """Whether the given baseline is a twin: the recorded output of another simulator."""
        return self.given and self.model == "twin"

    @property
    def begun(self) -> str:
        """The heading of the baseline's parameters."""
        return "in the twin" if self.is_twin else "as given" if self.given else "before"

    @property
    def silent(self) -> tuple[str, ...]:
        """Channels without a signal (dead taxels)."""
        return tuple(c for f in self.findings if f.cause == "dead_taxel" for c in f.channels)

    @property
    def judged(self) -> tuple[Finding, ...]:
        """The findings that were named because the simulation improved."""
        return tuple(f for f in self.findings if not f.direct)


def unit_of(v: View, name: str) -> str:
    """The unit of a channel."""
    return next((e.unit for e in v.errors if e.channel == name), "N")
