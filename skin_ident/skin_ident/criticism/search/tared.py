"""Zeros that tares leave, where they explain what was about to be named: they belong to the baseline."""

from typing import TYPE_CHECKING

import numpy as np

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.courses.carriers import DEPTH, ZERO
from skin_ident.criticism.courses.course import added
from skin_ident.criticism.courses.kinds import CAUSES, CONSTANT, STEPS
from skin_ident.criticism.courses.run import least_depth
from skin_ident.criticism.courses.tare import Zeros, added_by, zeros
from skin_ident.criticism.gates.resolution import converter_step
from skin_ident.criticism.search.hardware import tare_does, zeros_do
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.symptom import place_of

if TYPE_CHECKING:
    from skin_ident.criticism.search.search import Search

WORTH_SAYING = 0.2  # of a step
OFFSET, SHIFT = CAUSES[ZERO, CONSTANT], CAUSES[DEPTH, STEPS]


def take_tare(search: "Search", cause: str, explained: float) -> bool:
    """Whether zeros as tares leave them explain in training what a `cause` has `explained`, and were taken for that, in all sessions."""
    found = _instead(search, search.train, cause, explained, free=True)
    if not found:
        return False
    model = search.present.model
    search.train = added(search.train, added_by(found, model, search.train))
    search.present = fit(model, search.train, search.noise)
    held, model = search.held, search.present.model
    others = zeros(model, held, search.noise, search.encoder_step, free=False)[0] if held else {}
    search.held = added(held, added_by(others, model, held))
    _said(search, found | others)
    return True


def take_tare_of_held(search: "Search", cause: str, explained: float) -> bool:
    """The same of what a `cause` has `explained` in held-out sessions alone."""
    found = _instead(search, search.held, cause, explained, free=False)
    if not found:
        return False
    search.held = added(search.held, added_by(found, search.present.model, search.held))
    _said(search, found)
    return True


def _instead(search: "Search", sessions: list[Session], cause: str, explained: float, *, free: bool) -> Zeros:
    """The zeros that explain as much as a cause has; none of another zero, which is judged by its own size."""
    if cause in (OFFSET, SHIFT):
        return {}
    found, fall = zeros(search.present.model, sessions, search.noise, search.encoder_step, free=free)
    return found if fall >= explained else {}


def _said(search: "Search", found: Zeros) -> None:
    *channels, depth = np.max(np.abs([*found.values()]), axis=0).tolist()
    for channel, largest in zip(search.train[0].channels, channels, strict=True):
        step = converter_step(search.train, channel)
        if largest > WORTH_SAYING * step:
            search.tared[OFFSET, place_of(channel, search.train[0].n_taxels)] = tare_does(largest, step)
    if depth > WORTH_SAYING * least_depth(search.encoder_step):
        search.tared[SHIFT, place_of("depth", search.train[0].n_taxels)] = zeros_do(depth, search.encoder_step)
