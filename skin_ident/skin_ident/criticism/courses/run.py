"""A course fitted to sessions, and the size above which it is more than good hardware does."""

from dataclasses import dataclass, field, replace

import numpy as np

from skin_ident.criticism.courses.carriers import DELAY, DEPTH
from skin_ident.criticism.courses.kinds import Course
from skin_ident.criticism.courses.left_by_tare import Tare
from skin_ident.criticism.said import Said

SLIP = 0.3  # share of the sampling period that a delay must reach: a buffer slips by whole samples
AT_REST = 2.5e-6  # m, position error of a good stage at rest: half of its accuracy (thesis 3.1)
LEAST_SCORE = 30.0  # score, squared whitened units, that a course must exceed: a few free moments find as much in any noise

Moments = dict[str, np.ndarray]  # moments of steps or knots by session, s


def least_depth(encoder_step: float) -> float:
    """The smallest error of depth that counts, m: what a good stage does at rest, or the encoder's step."""
    return max(AT_REST, encoder_step)


@dataclass(frozen=True)
class Run:
    """A course fitted to sessions: its `score` (gain less `charge`), the `charge` for amplitudes and moments, its `largest` amplitude, its
    `values` (C, N) N and words `said` by session, the sampling `period`, s, the `tare` where it is a constant zero, and by session the
    `moments` of its steps, s, and their `amplitudes`."""

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

    def joined(self, other: "Run") -> "Run":
        """With the same course in the sessions of `other`, too."""
        both = {name: getattr(self, name) | getattr(other, name) for name in ("values", "said", "moments", "amplitudes")}
        return replace(self, **both, largest=max(self.largest, other.largest))

    @property
    def is_empty(self) -> bool:
        """Whether no session has any of it."""
        return not any(np.any(z) for z in self.amplitudes.values())

    @property
    def size(self) -> float:
        """RMS of its values in the session where it is largest, N. An amplitude alone says little where nothing is pressed."""
        return max(float(np.sqrt(np.mean(v**2))) for v in self.values.values())

    def least(self, encoder_step: float) -> float:
        """The smallest amplitude that is more than a good stage, encoder or clock does, in the unit of the amplitudes."""
        return {DEPTH: least_depth(encoder_step), DELAY: SLIP * self.period}.get(self.course.carrier, 0.0)

    @property
    def of_the_tare(self) -> bool:
        """Whether it is a zero error that a tare leaves, which belongs to the baseline."""
        return self.tare is not None and self.largest <= (1.0 + 1e-9) * self.tare.leaves

    @property
    def within_a_step(self) -> bool:
        """Whether it is a zero no larger than one step of the converter."""
        return self.tare is not None and self.largest <= (1.0 + 1e-9) * self.tare.step

    def worth(self, encoder_step: float) -> bool:
        """Whether it explains enough and is larger than what good hardware does."""
        return self.score > LEAST_SCORE and self.largest >= self.least(encoder_step)
