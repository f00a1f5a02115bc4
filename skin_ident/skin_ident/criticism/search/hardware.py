"""What held-out data support and is no finding, since good hardware does as much by itself: it is said, with what would tell."""

import numpy as np

from skin_ident.criticism.courses.carriers import DELAY, DEPTH
from skin_ident.criticism.courses.course import AT_REST, Run
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.gates.resolution import converter_step, of_the_converter, resolved, unreadable
from skin_ident.criticism.search.growing import instances
from skin_ident.criticism.search.named import Seen
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

FINER = "an encoder, and converters, with finer steps"
KINDS = {DEPTH: ("the zero of depth", 1e6, "µm"), DELAY: ("the delay", 1e3, "ms")}


def converter_does(cause: str, gain: Gain, train: list[Session]) -> Seen | None:
    """Why a cause that gains is no finding, where the converter may do it by itself."""
    if not of_the_converter(gain, cause, train):
        return None
    step = converter_step(train, gain.channel)
    why = f"it would {_worth(gain)}, which a converter with steps of {step:.2g} N may do by itself"
    return Seen(np.inf, why, f"a {gain.channel} read in finer steps, or a larger force")


def encoder_does(key: tuple[str, str], gain: Gain, before: Model, after: Model, train: list[Session], encoder_step: float) -> Seen | None:
    """Why a cause and place that `after` gains by over `before` are no finding, where the encoder could not tell, or steps leave as much
    open."""
    length, step = unreadable(instances(after, *key), encoder_step), _micrometres(encoder_step)
    if length:
        return Seen(np.inf, f"it would be {_micrometres(length)} and {_worth(gain)}, but the encoder reads in steps of {step}", FINER)
    if not resolved(gain, key[0], before, after, train, encoder_step):
        return Seen(np.inf, f"it would {_worth(gain)}, which the steps of encoder ({step}) and converters may leave open", FINER)
    return None


def stage_does(run: Run, encoder_step: float) -> Seen:
    """Why what sessions have of their own is no finding, where it is less than a good stage or clock does, or an encoder tells."""
    what, scale, unit = KINDS[run.course.carrier]
    found, least = (f"{scale * x:.3g} {unit}" for x in (run.largest, run.least(encoder_step)))
    why = f"within single sessions {what} would step by {found}"
    if run.course.carrier == DEPTH and encoder_step >= AT_REST:
        return Seen(np.inf, f"{why}, but the encoder reads in steps of {least}", FINER)
    return Seen(np.inf, f"{why}, and good hardware does up to {least} by itself")


def _worth(gain: Gain) -> str:
    return f"explain {np.sqrt(gain.squares):.2g} N rms of {gain.channel}"


def _micrometres(length: float) -> str:
    return f"{1e6 * length:.3g} µm"
