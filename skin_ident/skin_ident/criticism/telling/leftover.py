"""What is still wrong when every named cause is in the model.

A general predictor, the richest set of directions that the catalogue offers, is fitted to the training residual and asked to predict the
residual of held-out sessions, both beside what training leaves uncertain. If it can, something systematic is left that no cause has been
given for.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates.gate import bootstrap_fall, rmse_fall
from skin_ident.criticism.gates.resolution import AT_FEW_DEPTHS, RESOLVED, unread_force
from skin_ident.criticism.gates.uncertain import beside_uncertainty
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.sessions.session import Session

SYSTEMATIC = 0.03  # fall of the whitened held-out mean square that a general predictor must reach
SYSTEMATIC_RMSE = 0.05  # and of the plain error, in the channel that gains most
ENOUGH_S = 40.0  # of held-out data; of less, as many times more must fall: a dozen seconds of noise look like anything
SHADOW = 0.01  # of what the named causes explained: a remainder below is their own imperfect form


@dataclass(frozen=True)
class Rest:
    """What a general predictor gains on held-out data: fall of the whitened mean square, its lower 99 % bound, and plain RMSE (N) in the
    channel that gains most; `resolution` (N) is what the steps of converter and encoder leave open; `seconds` were held out."""

    fall: float
    lower: float
    before: float
    after: float
    resolution: float
    seconds: float

    @property
    def as_json(self) -> dict[str, float | str]:
        """As `systematic_rest` in findings.json has it."""
        return {
            "fall_of_mean_square": self.fall,
            "lower_bound": self.lower,
            "rmse_before": self.before,
            "rmse_after": self.after,
            "unit": "N",
        }

    def is_systematic(self, explained: float) -> bool:
        """Whether the rest deserves the word `unexplained`, next to causes that made a mean square fall by `explained` (N^2)."""
        if not self.seconds:
            return False
        least = max(1.0, ENOUGH_S / self.seconds) * SYSTEMATIC_RMSE
        sure = self.lower > 0.0 and self.fall > SYSTEMATIC and self.after < (1.0 - least) * self.before
        return sure and self.before**2 - self.after**2 > max(SHADOW * explained, self.resolution**2)


def systematic_rest(last: Survey, train: list[Session], held: list[Session], encoder_step: float = 0.0) -> Rest:
    """Fit the general predictor to the training residual and try it on `held` (that training session of which most is compared, where there
    is none). Where nothing of it is compared, nothing is said to be left.

    An encoder that steps by `encoder_step` (m) leaves a force open, and at the depths that every session returns to the same one each time.
    """
    held = held or [max(reversed(train), key=lambda s: s.seconds)]
    seconds = sum(s.seconds for s in held)
    if not seconds:
        return Rest(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    fitted = [s for s in train if s not in held] or train
    _, _, z, _ = last.richest(fitted)
    before = [residual(last.model, s) for s in held]
    after = [e - np.tensordot(z, last.directions_of(s)[0], 1) for e, s in zip(before, held, strict=True)]
    before, after = (beside_uncertainty(e, last.model, fitted, held, last.noise) for e in (before, after))
    fall, lower = bootstrap_fall(*([last.noise.apply(e, s) for e, s in zip(es, held, strict=True)] for es in (before, after)), held)
    rms, _ = rmse_fall(before, after, held)
    c = int(np.argmax(1.0 - rms[1] / np.maximum(rms[0], 1e-300)))
    unread = np.sqrt(AT_FEW_DEPTHS) * unread_force(last.model, held[0].channels[c], held, encoder_step)
    open_to = np.hypot(RESOLVED * max(s.steps[c] for s in held), unread)
    return Rest(fall, lower, float(rms[0, c]), float(rms[1, c]), float(open_to), seconds)
