"""A course fitted to sessions, and what it must be to be more than good hardware does."""

from dataclasses import dataclass, field

import numpy as np

from skin_ident.criticism.courses.carriers import DELAY, DEPTH
from skin_ident.criticism.courses.kinds import Course
from skin_ident.criticism.courses.left_by_tare import Tare
from skin_ident.criticism.said import Said

SLIP = 0.3  # of a sample's period: a buffer slips by whole ones
AT_REST = 2.5e-6  # m, half of a good stage's accuracy (thesis 3.1)
LEAST = 30.0  # likelihood gain: what a few free moments find in any noise

Moments = dict[str, np.ndarray]  # s, by session


def least_depth(encoder_step: float) -> float:
    """How far off a good stage is at rest, or how finely its encoder tells, m."""
    return max(AT_REST, encoder_step)


@dataclass(frozen=True)
class Run:
    """A course fitted to sessions: its likelihood score, what that was charged for amplitudes and moments, its largest amplitude, its
    values (C, N) N and its words by session, the period of their samples, s, what a tare leaves of it, where it is a zero, and by session
    the moments of its steps, s, and amplitudes."""

    course: Course
    score: float
    charge: float
    largest: float
    values: dict[str, np.ndarray]
    said: dict[str, Said]
    period: float
    tare: Tare | None = None
    moments: Moments = field(default_factory=dict)
    amplitudes: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def size(self) -> float:
        """What it changes in the session where that is most (RMS), N: an amplitude says little where nothing is pressed."""
        return max(float(np.sqrt(np.mean(v**2))) for v in self.values.values())

    def least(self, encoder_step: float) -> float:
        """What a good stage does at rest, or its encoder cannot tell, or a good clock does, in the unit of the amplitudes."""
        return {DEPTH: least_depth(encoder_step), DELAY: SLIP * self.period}.get(self.course.carrier, 0.0)

    @property
    def of_the_tare(self) -> bool:
        """Whether it is a zero as a tare leaves it, which belongs to the baseline."""
        return self.tare is not None and self.largest <= (1.0 + 1e-9) * self.tare.leaves

    @property
    def within_a_step(self) -> bool:
        """Whether it is a zero no larger than a step of the converter."""
        return self.tare is not None and self.largest <= (1.0 + 1e-9) * self.tare.step

    def worth(self, encoder_step: float) -> bool:
        """Whether it explains anything, and is more than good hardware does."""
        return self.score > LEAST and self.largest >= self.least(encoder_step)
