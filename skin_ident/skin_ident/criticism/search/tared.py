"""Zeros that tares leave, where they explain what was about to be named: they belong to the baseline."""

import numpy as np

from skin_ident.criticism.baseline.fitting import Fit, cost_of, fit
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.courses.left_by_tare import tare_of_drive, tares
from skin_ident.criticism.courses.run import LEAST_SCORE, least_depth
from skin_ident.criticism.courses.tare import Zeros, added_by, zeros
from skin_ident.criticism.gates.gate import own_channels
from skin_ident.criticism.search.hardware import tare_does, zeros_do
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.rivals import Rival
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.sessions.session import Session, with_zeros
from skin_ident.criticism.telemetry.symptom import sensor_of
from skin_ident.criticism.vocabulary import FORCE_OFFSET, POSITION_OFFSET, SENSORS
from skin_models.model import Model

KEPT = 0.5  # share of what zeros promise, which must be left of it once everything is fitted
WORTH_SAYING = 0.2  # of what a tare leaves, from which a zero is reported


def take_tare(search: Search, finding: Named) -> bool:
    """Take zeros as tares leave them, in all sessions, where they explain as much of training as a `finding`; return whether they were
    taken. A finding of zeros per session is judged by its own size. One zero that all sessions, or a lone one, have may be a tare's."""
    if finding.courses and _is_zero(finding.cause):
        return False
    shared = _shared(search, finding)
    found = shared or _instead(search, search.train, finding.explained, free=True)
    if found:
        train, after = _with(search, found)
        _take(search, train, after, found, shared)
        search.yielded.append(finding)
    return bool(found)


def beside_zeros(search: Search, finding: Named) -> Named:
    """The finding, with causes among its alternatives in whose place zeros were taken in the same sensor: what the zeros left of these may
    pass for it."""
    same = [y for y in search.yielded if y.where == finding.where and y.where.startswith(SENSORS) and y.explained > finding.explained]
    return finding.with_rivals(Rival(*y.key, 0.0) for y in same if not _is_zero(y.cause))


def take_zeros(search: Search, least: float = 0.0) -> bool:
    """Take zeros as good hardware leaves them, where they explain more than `least`; return whether they were taken. Where no cause is
    believed they would otherwise remain unexplained. They are taken at most once beside the same findings."""
    if search.zeroed == len(search.named):
        return False
    for driven in (True, False):
        found, fall = zeros(search.present.model, search.train, search.noise, search.encoder_step, free=True, driven=driven)
        free = sum(np.count_nonzero(z) for z in found.values())
        if fall < max(LEAST_SCORE, least, free * np.log(max(search.present.count, 2))):
            return False
        train, after = _with(search, found)
        # A zero of depth beside play whose own zero is at its bound may not keep what a small one promises; those of the channels will.
        if cost_of(search.present.model, search.train, search.noise) - after.cost > KEPT * fall:
            _take(search, train, after, found, {})
            search.zeroed = len(search.named)
            return True
    return False


def settle_zeros(search: Search) -> bool:
    """Where such zeros were taken before something else was named, ask for them again beside it, and return whether they changed: what was
    named may have been hiding in them. A gain that steps leaves zeros in its channel that are none."""
    if search.zeroed in (None, len(search.named)):
        return False
    changed = take_zeros(search)
    search.zeroed = len(search.named)
    return changed


def _with(search: Search, found: Zeros) -> tuple[list[Session], Fit]:
    """The training sessions with zeros, and the fit to them."""
    train = with_zeros(search.train, added_by(found, search.present.model, search.train))
    return train, fit(search.present.model, train, search.noise)


def _take(search: Search, train: list[Session], after: Fit, found: Zeros, shared: Zeros) -> None:
    """Take the training sessions with the zeros that were `found`, and the fit to them. Put into held-out sessions their own zeros, or
    those that all sessions share."""
    search.train, search.present = train, after
    _said(search, found | zero_held(search, shared))


def zero_held(search: Search, shared: Zeros) -> Zeros:
    """Put zeros into the held-out sessions: those that all sessions have (`shared`), or else their own, as their tares leave them. Return
    them."""
    held, model = search.held, search.present.model
    found = shared or (zeros(model, held, search.noise, search.encoder_step, free=False)[0] if held else {})
    add_to_held(search, added_by(found, model, held))
    return found


def with_own_zeros(search: Search, held: list[Session]) -> list[Session]:
    """Held-out sessions with their own zeros, as their tares leave them."""
    model = search.present.model
    return with_zeros(held, added_by(zeros(model, held, search.noise, search.encoder_step, free=False)[0], model, held))


def add_to_held(search: Search, zeros: dict[str, np.ndarray]) -> None:
    """Add what zeros come to, (C, N) N by session, to the held-out sessions, and keep it in mind."""
    search.held = with_zeros(search.held, zeros)
    search.zeros_of_held |= {name: zero + search.zeros_of_held.get(name, 0.0) for name, zero in zeros.items()}


def untared(search: Search) -> list[Session]:
    """The held-out sessions without such zeros, which are not taken back twice. A course of theirs is fitted without them: they were taken
    beside what that course has to explain."""
    taken, search.zeros_of_held = search.zeros_of_held, {}
    return with_zeros(search.held, _opposite(taken)) if taken else search.held


def taken_off(sessions: list[Session], values: dict[str, np.ndarray]) -> list[Session]:
    """The sessions without a course that was `added` to their simulation."""
    return added(sessions, _opposite(values))


def _opposite(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    return {name: -v for name, v in values.items()}


def _shared(search: Search, finding: Named) -> Zeros:
    """The zero that a finding gives to all sessions alike, where it is no larger than tares may leave it. Sessions that are each tared
    share only a small one."""
    if finding.cause != FORCE_OFFSET or finding.model is None or finding.free:
        return {}
    offset = _offset_of(finding.model, finding) - _offset_of(finding.before, finding)
    channels = search.train[0].channels
    own = [c in own_channels(finding.where, channels) for c in channels]
    count = len(search.train) + len(search.held)
    left = [t.leaves_all(count) for t, mine in zip(tares(search.train, search.noise), own, strict=True) if mine]
    if not 0.0 < abs(offset) <= min(left, default=0.0):
        return {}
    zero = np.append(offset * np.array(own), 0.0)
    return {s.name: zero for s in (*search.train, *search.held)}


def _offset_of(model: Model, finding: Named) -> float:
    return sum(e.offset for e in model.having(finding.key))


def take_tare_of_held(search: Search, cause: str, explained: float) -> bool:
    """The same in held-out sessions alone, of what a `cause` has `explained` there."""
    return not _is_zero(cause) and take_zeros_of_held(search, explained)


def take_zeros_of_held(search: Search, explained: float) -> bool:
    """Take zeros of all channels, as the tares of held-out sessions leave them, where they explain as much there as was `explained`
    otherwise; return whether they were taken."""
    found = _instead(search, search.held, explained, free=False)
    if not found:
        return False
    add_to_held(search, added_by(found, search.present.model, search.held))
    _said(search, found)
    return True


def _is_zero(cause: str) -> bool:
    return cause in (FORCE_OFFSET, POSITION_OFFSET)


def _instead(search: Search, sessions: list[Session], explained: float, *, free: bool) -> Zeros:
    """The zeros that explain as much as was `explained` otherwise; empty where none do."""
    found, fall = zeros(search.present.model, sessions, search.noise, search.encoder_step, free=free)
    return found if fall >= explained else {}


def _said(search: Search, found: Zeros) -> None:
    *channels, driving = np.max(np.abs([*found.values()]), axis=0).tolist()
    for channel, largest, tare in zip(search.train[0].channels, channels, tares(search.train, search.noise), strict=True):
        if largest > WORTH_SAYING * tare.leaves:
            search.tared[FORCE_OFFSET, sensor_of(channel, search.train[0].n_taxels)] = tare_does(largest, tare)
    if search.train[0].drive is not None:
        tare = tare_of_drive(search.train)
        if driving > WORTH_SAYING * tare.leaves:
            search.tared[FORCE_OFFSET, "load_cell"] = tare_does(driving, tare)
    elif driving > WORTH_SAYING * least_depth(search.encoder_step):
        search.tared[POSITION_OFFSET, sensor_of("depth", search.train[0].n_taxels)] = zeros_do(driving, search.encoder_step)
