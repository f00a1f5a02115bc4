"""What is in the record and is named for nothing, since good hardware does as much."""

import numpy as np

from skin_ident.criticism.courses.carriers import DELAY, DEPTH
from skin_ident.criticism.courses.course import Run
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.gates.resolution import converter_step, of_the_converter, resolved, unreadable
from skin_ident.criticism.search.growing import instances
from skin_ident.criticism.search.named import Seen
from skin_ident.criticism.search.trial import Trial
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

FINER = "an encoder, and converters, with finer steps"
STEPS = {DEPTH: ("the zero of depth", "{:.2g} µm", 1e6), DELAY: ("the delay", "{:.2g} ms", 1e3)}


def of_the_hardware(trial: Trial, gain: Gain, before: Model, train: list[Session], encoder_step: float) -> Seen | None:
    """Why a trial that gains over the model `before` is no finding, where converter or encoder may do it by themselves."""
    worth, step = f"explain {np.sqrt(gain.squares):.2g} N rms of {gain.channel}", f"{1e6 * encoder_step:.2g} µm"
    if of_the_converter(gain, trial.key[0], train):
        why = f"it would {worth}, which a converter with steps of {converter_step(train, gain.channel):.2g} N may do by itself"
        return Seen(np.inf, why, f"a {gain.channel} read in finer steps, or a larger force")
    length = unreadable(instances(trial.fit.model, *trial.key), encoder_step)
    if length:
        return Seen(length, f"it would be {1e6 * length:.2g} µm and {worth}, but the encoder reads in steps of {step}", FINER)
    if not resolved(gain, trial.key[0], before, trial.fit.model, train, encoder_step):
        return Seen(np.inf, f"it would {worth}, which the steps of encoder ({step}) and converters may leave open", FINER)
    return None


def of_the_stage(run: Run, encoder_step: float) -> Seen:
    """Why what sessions have of their own, and explains most, is no finding, where it is less than a good stage or clock does."""
    what, size, scale = STEPS[run.course.carrier]
    found, least = (size.format(scale * x) for x in (run.largest, run.least(encoder_step)))
    return Seen(run.largest, f"within single sessions {what} would step by {found}, and good hardware does up to {least} by itself")
