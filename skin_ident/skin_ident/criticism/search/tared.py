"""Zeros that tares leave, where they explain what was about to be named: they belong to the baseline."""

from typing import TYPE_CHECKING

import numpy as np

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.courses.carriers import ZERO
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.courses.kinds import CAUSES, CONSTANT
from skin_ident.criticism.courses.tare import Zeros, zeros
from skin_ident.criticism.gates.resolution import converter_step
from skin_ident.criticism.search.hardware import tare_does
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.symptom import place_of

if TYPE_CHECKING:
    from skin_ident.criticism.search.search import Search

WORTH_SAYING = 0.2  # of a step
OFFSET = CAUSES[ZERO, CONSTANT]


def take_tare(search: "Search", cause: str, explained: float) -> bool:
    """Whether zeros as tares leave them explain in training what a `cause` has `explained`, and were taken for that, in all sessions."""
    found = _instead(search, search.train, cause, explained, free=True)
    if not found:
        return False
    search.train = _without(search.train, found)
    search.present = fit(search.present.model, search.train, search.noise)
    others = zeros(search.present.model, search.held, search.noise, free=False)[0] if search.held else {}
    search.held = _without(search.held, others)
    _said(search, found | others)
    return True


def take_tare_of_held(search: "Search", cause: str, explained: float) -> bool:
    """The same of what a `cause` has `explained` in held-out sessions alone."""
    found = _instead(search, search.held, cause, explained, free=False)
    if not found:
        return False
    search.held = _without(search.held, found)
    _said(search, found)
    return True


def _instead(search: "Search", sessions: list[Session], cause: str, explained: float, *, free: bool) -> Zeros:
    """The zeros that explain as much as a cause has; none of another zero, which is judged by its own size."""
    if cause == OFFSET:
        return {}
    found, fall = zeros(search.present.model, sessions, search.noise, free=free)
    return found if fall >= explained else {}


def _without(sessions: list[Session], found: Zeros) -> list[Session]:
    return added(sessions, {s.name: found[s.name][:, None] * np.ones(s.motion.t.size) for s in sessions})


def _said(search: "Search", found: Zeros) -> None:
    for channel, largest in zip(search.train[0].channels, np.max(np.abs([*found.values()]), axis=0).tolist(), strict=True):
        step = converter_step(search.train, channel)
        if largest > WORTH_SAYING * step:
            search.tared[OFFSET, place_of(channel, search.train[0].n_taxels)] = tare_does(largest, step)
