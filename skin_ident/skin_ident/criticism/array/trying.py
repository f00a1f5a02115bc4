"""Causes in the ratios tried on held-out sessions: the best one alone, and two of them, each beside the other.

One wrong calibration beside an oval spread, say, leaves ratios that no single cause explains. So where something is left beyond doubt
beside the best cause, all pairs are compared: the best cause alone may stand for two others. The best pair is named where each of the two
is sure beside the other and predicts held-out sessions better than the other alone.

Spread, crosstalk and the like fall smoothly with distance, and so does what is left by a spread of another form than those of the family.
Two such causes are therefore never named together: the second might only mend the form of the first. Nor are two of one taxel, which would
rather lie elsewhere, nor one beside a stage whose axes are turned: with that, contacts that are each a little off their places agree.
"""

from dataclasses import dataclass

from skin_ident.criticism.array.family import is_repeat
from skin_ident.criticism.array.gains import Gains
from skin_ident.criticism.array.gate import held_out_gain
from skin_ident.criticism.array.hypotheses import NOTHING, Background, Hypothesis
from skin_ident.criticism.array.judgement import Judged, Judgement, Pair, judge, pairs
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.gates.gate import MATERIAL_RMSE, Gain
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import Key
from skin_models.model import Model

MOST = 0.67  # share of the mean-square error from wrong ratios that a cause must remove to be named


@dataclass(frozen=True, eq=False)
class Tried:
    """The best cause of a judgement and its gain on held-out sessions; `least` is the RMSE, N, that the measured shares leave there.
    `instead`: of two causes, those of other pairs that explain as much, and by how much their log odds are lower."""

    judgement: Judgement
    gain: Gain
    least: float
    instead: dict[Key, float]

    @property
    def best(self) -> Judged:
        """The cause that was tried."""
        return self.judgement.causes[0]

    @property
    def passed(self) -> bool:
        """Whether the cause predicts held-out sessions better beyond doubt and by enough to matter, and accounts for most of the error
        from wrong ratios that is there without it.

        The whitened gain need not be large: a static share is a slow signal, and coloured noise hides most of it.
        """
        gain = self.gain
        if gain.lower <= 0.0 or gain.after >= (1.0 - MATERIAL_RMSE) * gain.before:
            return False
        return gain.squares > MOST * (gain.before**2 - self.least**2)


@dataclass(frozen=True, eq=False)
class Shown:
    """What is judged: the `measured` shares of the `sessions`, of which `held` are the indices of held-out ones, under the extended `model`
    and its noise."""

    model: Model
    layout: Layout
    measured: Gains
    sessions: list[Session]
    held: list[int]
    noise: Whitener
    thickness_mm: float | None

    @property
    def train(self) -> list[int]:
        """Indices of the training sessions."""
        return [i for i in range(len(self.sessions)) if i not in self.held]

    def judged(self, beside: Hypothesis = NOTHING) -> Judgement:
        """All causes compared on the training sessions, `beside` one that is there."""
        return judge(self.layout.of(self.train), self.measured.of(self.train), self.thickness_mm, beside)

    def pairs(self, alone: Judgement, b: Background) -> list[Pair]:
        """All pairs of the causes of a judgement, compared on the training sessions."""
        return pairs(self.layout.of(self.train), self.measured.of(self.train), alone, b)

    def tried(self, judgement: Judgement, beside: Hypothesis = NOTHING, instead: dict[Key, float] | None = None) -> Tried:
        """The best cause of a judgement, tried on held-out sessions."""
        best = judgement.causes[0]
        gain, least = held_out_gain(self.model, self.layout, self.measured, self.sessions, self.held, self.noise, best, beside)
        return Tried(judgement, gain, least, instead or {})


def tried(shown: Shown, alone: Judgement) -> tuple[tuple[Tried, ...], Judgement | None]:
    """Two causes that pass, else the best one of the judgement `alone`, whether or not it passes; none where nothing is wrong beyond doubt.

    And, where one is tried alone, the judgement of what is left beside it.
    """
    if alone.named is None:
        return (), None
    left = shown.judged(beside=alone.named.hypothesis)
    two = _two(shown, alone, left) if left.named else ()
    return (two, None) if two else ((shown.tried(alone),), left)


def _two(shown: Shown, alone: Judgement, left: Judgement) -> tuple[Tried, ...]:
    """The two causes that explain the ratios best together; none unless each is sure beside the other, and both may be named and pass."""
    found = shown.pairs(alone, left.causes[0].background)
    if not found:
        return ()
    best, *others = found
    one, other = best.causes
    first, second = shown.judged(beside=other), shown.judged(beside=one)
    sure = all(j.named is not None and j.named.key == h.key for j, h in ((first, one), (second, other)))
    if not (sure and _may_be_together(first.causes[0].hypothesis, second.causes[0].hypothesis)):
        return ()
    near = [p for p in others if p.log > best.log - first.reach and not p.keys & best.keys]
    instead = {key: best.log - p.log for p in reversed(near) for key in p.keys}
    both = shown.tried(first, other, instead), shown.tried(second, one, instead)
    return both if all(t.passed for t in both) else ()


def _may_be_together(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether two causes may be named together."""
    free = {**one.free, **other.free}
    return (_is_particular(one) or _is_particular(other)) and one.where != other.where and "axis" not in free


def _is_particular(h: Hypothesis) -> bool:
    """Whether a cause concerns one taxel, or moves the contact: no form of a spread under the declared contact does."""
    return h.cause in ("gain_error", "off_centre") or any(map(is_repeat, h.free))
