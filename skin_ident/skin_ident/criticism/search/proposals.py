"""What each cause would change: every effect of the catalogue, simulated on top of the present model.

An effect switched on by a little, at one setting of its shape, changes every channel a little; that change is a *direction*. A cause
at a place owns all directions of its classes and shapes: a Prony series of many arms, a Prandtl–Ishlinskii sum of many thresholds.
Ranking with the whole span of a cause, not with one textbook form of it, is what makes a finding robust to forms that no catalogue holds.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skin_ident.criticism.baseline.own_shares import take_shares
from skin_ident.criticism.baseline.residual import at_place, placed, rows
from skin_ident.criticism.baseline.unknowns import shown
from skin_ident.criticism.gates.gate import own_channels
from skin_ident.criticism.sessions.session import Session, motion_under
from skin_ident.criticism.vocabulary import DEAD_ZONE, Key
from skin_models.catalogue import effects
from skin_models.effect import Effect, Place
from skin_models.effects.time_shift import Scanning
from skin_models.model import Model, Response
from skin_models.parameter import AMPLITUDE, clipped, parameters_of, scan_of

PROBE = 0.1  # share of an effect's typical size at which a direction is probed, unless the effect gives its own amounts
CLIPS = "saturation"
SCANNED = 3  # least number of taxels for which reading in turn is tried: of two, one is simply late, or lags
FULL = 24.0  # N, full scale of the sensor for which the catalogue's grid of clipping forces is laid out
SMALL = 5.0  # N, greatest reading below which the catalogue's other forces are too large for a sensor
LEAST_READING = 0.024  # N, least value taken for a greatest reading: a sensor that reads nothing is bent by nothing


@dataclass(frozen=True)
class Direction:
    """One way to bend the model: `effect` (absent) with its amplitude `parameter` turned up. `sign` is +1, -1, or 0 for either."""

    effect: Effect
    parameter: str
    size: float
    sign: int
    probe: float = PROBE  # share of `size` by which the model is changed

    @property
    def cause(self) -> str:
        """The cause of the effect, as CAUSES names it."""
        return self.effect.cause

    @property
    def where(self) -> str:
        """Where the effect acts."""
        return self.effect.where

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where

    @cached_property
    def probed(self) -> Effect:
        """The effect at the amount by which the model is changed."""
        return self.switched_on(self.amount)

    @property
    def amount(self) -> float:
        """By how much the model is changed, in typical sizes, to the side that physics allows."""
        return self.probe if self.sign >= 0 else -self.probe

    def switched_on(self, amount: float) -> Effect:
        """The effect with its amplitude at `amount` of its typical size."""
        return self.effect.with_values(**{self.parameter: amount * self.size})


def directions(session: Session) -> tuple[Direction, ...]:
    """Every direction that the catalogue offers for the channels at hand."""
    return tuple(d for cls in effects() for where in places_of(cls, session) for d in _directions(cls, where, session))


def places_of(cls: type[Effect], session: Session) -> Iterator[str]:
    """Every place at which an effect could show in the channels of a session, by the names that findings use. A ceiling is not looked for
    again in a channel where the record itself has shown one."""
    for word in _places(cls, session):
        if cls.cause != "saturation" or not session.clipped & set(own_channels(word, session.channels)):
            yield word


def _places(cls: type[Effect], session: Session) -> Iterator[str]:
    """Every place of an effect that some channel could show; where there are several taxels, each of them and all of them."""
    for word in cls.places:
        if _unseen(cls.places[word], session) or (cls is Scanning and session.n_taxels < SCANNED):
            continue
        if word.endswith(("taxel", "taxels")):
            if session.n_taxels == 0:
                continue
            if session.n_taxels > 1 and word == "taxel":
                yield from (f"taxel_{i}" for i in range(session.n_taxels) if f"taxel_{i}" not in session.stuck)
        yield word


def _unseen(place: Place, session: Session) -> bool:
    """Whether no channel can carry an effect at this place: no load cell to compare, or no depth that could be wrong."""
    return (place is Place.LOAD_CELL and "force" not in session.channels) or (place is Place.DEPTH and session.drive is not None)


def _directions(cls: type[Effect], where: str, session: Session) -> Iterator[Direction]:
    """One direction for every amplitude of an effect at a place, and every shape that is profiled."""
    amplitudes = [p for p in parameters_of(cls) if p.role == AMPLITUDE and not np.isnan(p.typical) and p.typical != 0.0]
    times = _times(cls, where, session)
    for shape in _shapes(cls, session, times):
        absent = cls.typical(where, **shape).absent()
        for p in amplitudes:
            if not shown(p, session):
                continue
            usual = abs(p.typical)
            size = usual * (times if p.unit == "N" and not cls.linear else 1.0)
            yield from (Direction(absent, p.name, size, _sign(p), at / usual) for at in scan_of(cls, p.name) or (PROBE * usual,))


def _shapes(cls: type[Effect], session: Session, times: float) -> Iterator[dict[str, float]]:
    """The shapes of an effect that are profiled, with the catalogue's forces multiplied by `times`."""
    forces = {p.name for p in parameters_of(cls) if p.unit == "N"}
    for shape in cls.shapes(session.motion):
        yield clipped(cls, **{name: value * (times if name in forces else 1.0) for name, value in shape.items()})


def _times(cls: type[Effect], where: str, session: Session) -> float:
    """Factor on the catalogue's forces for effects that bend the reading of a sensor. The force at which it clips is a share of its
    greatest reading; other thresholds are scaled only where it reads little. A test without depth uses the catalogue's own forces."""
    where = "taxel" if cls.cause == DEAD_ZONE else where  # a dead zone of the skin acts on the taxels
    if session.drive is not None or not where.startswith(("load_cell", "taxel")):
        return 1.0
    own = [session.channels.index(c) for c in own_channels(where, session.channels)]
    most = max(float(np.abs(session.bridged[own]).max(initial=0.0)), LEAST_READING)
    return most / FULL if cls.cause == CLIPS else min(most / SMALL, 1.0)


def _sign(p) -> int:
    return int(p.lower >= 0.0) - int(p.upper <= 0.0)


def bank(model: Model, which: tuple[Direction, ...], sessions: list[Session]) -> list[np.ndarray]:
    """The change of every channel per unit of typical size, (directions, C, n) for each session, in the common band, less what the
    session's own shares can follow."""
    return [between(np.zeros((0, *s.measured.shape)), model, which, s, np.zeros((0, *s.measured.shape))) for s in sessions]


def between(before: np.ndarray, model: Model, which: tuple[Direction, ...], session: Session, after: np.ndarray) -> np.ndarray:
    """`bank` of one session, laid out between the rows `before` and `after` (M, C, n): all of these are large, and allocated only once."""
    out = np.zeros((len(before) + len(which) + len(after), *session.measured.shape))
    out[: len(before)], out[len(before) + len(which) :] = before, after
    _lay_out(out[len(before) : len(before) + len(which)], model, which, session)
    return out


def _changed_channels(bent: Response, plain: Response, session: Session) -> slice:
    """The channels that may have changed: not those whose response is the very same array."""
    if bent.force is plain.force:
        return session.taxel_rows
    return slice(0, session.taxel_rows.start) if bent.taxels is plain.taxels else slice(None)


def _lay_out(out: np.ndarray, model: Model, which: tuple[Direction, ...], session: Session) -> None:
    """Write the changes of one session into `out` (directions, C, n): zeros for causes that the session lacks."""
    model = placed(model, session)
    run = model.trace(motion_under(session, model.dispersion))
    base = rows(run.response, session)
    for i, d in enumerate(which):
        if d.key in session.lacks:
            continue
        bent = model.bent(run, at_place(d.probed, session))
        felt = _changed_channels(bent, run.response, session)
        session.band.thin_changes(rows(bent, session)[felt] - base[felt], out[i, felt])
        out[i] /= d.amount
    take_shares(out, base, session)
