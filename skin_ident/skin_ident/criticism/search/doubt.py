"""What training sessions speak for and others leave in doubt: no finding, and nothing that may be called excluded either."""

import numpy as np

from skin_ident.criticism.courses.carriers import DELAY, DEPTH, DRIVE, SLOPE, ZERO
from skin_ident.criticism.courses.course import Run
from skin_ident.criticism.search.named import Seen

REPEATED = "the same motions recorded twice more: what comes again is no chance"
QUIET = "the same motions recorded again with a quieter channel, or rests long enough to see how its noise wanders"
KINDS = {
    ZERO: "its zero",
    SLOPE: "its gain",
    DELAY: "the delay",
    DEPTH: "the zero of depth",
    DRIVE: "the zero of the driving force",
}


def unproven() -> Seen:
    """Why what explains much of training is no finding, where held-out sessions are predicted hardly better."""
    return Seen(np.inf, "training sessions speak for it, but held-out ones are predicted hardly better with it", REPEATED)


def wandering(run: Run) -> Seen:
    """Why what single sessions would have of their own is no finding, where the blocks between are not predicted by it."""
    what = KINDS.get(run.course.carrier, "it")
    why = f"within single sessions {what} would wander by {run.size:.2g} N rms, but fitted to every other block it does not predict those"
    return Seen(np.inf, f"{why} between: noise that wanders does as much", QUIET)
