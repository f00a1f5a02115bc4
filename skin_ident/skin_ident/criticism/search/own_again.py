"""Courses once more, when everything else is known: steps that nothing needs any more, and gains in whose place zeros explain as much."""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.fitting import cost_of, fit
from skin_ident.criticism.courses.carriers import SLOPE
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.courses.ground import fitted_ground, held_ground
from skin_ident.criticism.courses.kinds import WAVE
from skin_ident.criticism.courses.run import Run
from skin_ident.criticism.courses.thinning import may_thin, thinned
from skin_ident.criticism.gates.uncertain import left_open
from skin_ident.criticism.search.own import SEARCHED
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.tared import take_zeros, taken_off
from skin_ident.criticism.sessions.session import Session


def settle_courses(search: Search) -> bool:
    """Take the steps out of named courses that are not needed beside what else was named, and courses that have none left; return whether
    any was taken out."""
    runs = [r for r in search.runs if may_thin(r) and _is_named(search, r)]
    if not runs or len(search.named) < 2:
        return False
    model, noise = search.present.model, search.noise
    train, held = (taken_off(sessions, _sum_of(runs, sessions)) for sessions in (search.train, search.held))
    fewer, charge = thinned(runs, fitted_ground(model, train, noise))
    free = left_open(model, search.train, held, noise)
    fewer, charge_of_held = thinned(fewer, held_ground(model, held, noise, free)) if held else (fewer, 0.0)
    if charge + charge_of_held == 0.0:
        return False
    train, held = (added(sessions, _sum_of(fewer, sessions)) for sessions in (train, held))
    after = fit(model, train, noise)
    rise = after.cost - cost_of(model, search.train, noise)
    rise_of_held = cost_of(after.model, held, noise) - cost_of(model, search.held, noise) if held else 0.0
    if rise > charge or rise_of_held > charge_of_held + charge:
        return False
    search.present, search.train, search.held = after, train, held
    for run, less in zip(runs, fewer, strict=True):
        _put(search, run, less)
    return True


def _is_named(search: Search, run: Run) -> bool:
    return any(n.courses is run.said for n in search.named)


def _sum_of(runs: list[Run], sessions: list[Session]) -> dict[str, np.ndarray]:
    """What courses add to sessions together, (C, N) N by name."""
    return {s.name: sum((r.values[s.name] for r in runs if s.name in r.values), np.zeros_like(s.raw)) for s in sessions}


def _put(search: Search, run: Run, by: Run) -> None:
    """Put another run in the place of one, and of its finding; nothing, where it is empty."""
    search.alone = by if search.alone is run else search.alone
    search.runs = [by if r is run else r for r in search.runs]
    search.named = [replace(n, courses=by.said) if n.courses is run.said else n for n in search.named]
    if by.is_empty:
        _take_out(search, by)


def _take_out(search: Search, run: Run) -> None:
    """Forget a run, and what was named for it."""
    search.alone = None if search.alone is run else search.alone
    search.runs = [r for r in search.runs if r is not run]
    search.named = [n for n in search.named if n.courses is not run.said]


def drop_gain(search: Search) -> bool:
    """Take out a gain of single sessions that was named before zeros as tares leave them were taken, where these explain as much in its
    place: a channel whose zero is off reads a wrong share of the force. Return whether one was taken out."""
    gains = [r for r in search.runs if r.course.carrier == SLOPE and r.course.shape != WAVE and r is not search.alone]
    return search.zeroed is not None and any(_dropped(search, run) for run in gains)


def _dropped(search: Search, run: Run) -> bool:
    """Whether a gain was taken out, since without it, but with zeros, next to nothing more is left."""
    ahead = search.ahead(search.present)
    ahead.train, ahead.held = taken_off(search.train, run.values), taken_off(search.held, run.values)
    ahead.present, ahead.zeroed = fit(search.present.model, ahead.train, search.noise), None
    take_zeros(ahead)
    if ahead.present.cost - search.present.cost > SEARCHED * search.least(search.present.count):
        return False
    search.train, search.held, search.present = ahead.train, ahead.held, ahead.present
    search.tared, search.zeros_of_held = ahead.tared, ahead.zeros_of_held
    _take_out(search, run)
    return True
