"""Whether something systematic is left when every named cause is in the model.

A general linear predictor, the richest set of directions of the catalogue, is fitted to the training residual and applied to held-out
sessions. Both its residual and that without it are taken after allowing for what training leaves uncertain. If the predictor helps,
something systematic is left for which no cause was found.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.gates.gate import bootstrap_fall, rmse_fall
from skin_ident.criticism.gates.resolution import left_by_steps
from skin_ident.criticism.gates.uncertain import beside_uncertainty
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.sessions.session import Session

SYSTEMATIC = 0.03  # relative fall of the whitened held-out mean square that the predictor must reach,
SYSTEMATIC_RMSE = 0.05  # and of the plain RMSE, in the channel that gains most
ENOUGH_S = 40.0  # s of held-out data; with less, that fall must be larger in proportion: a dozen seconds of noise look like anything
SHADOW = 0.01  # share of the mean square that the named causes explained, below which the rest is their own imperfect form


@dataclass(frozen=True)
class Rest:
    """What the general predictor gains on held-out data: relative fall of the whitened mean square (`fall`) and its lower 99 % bound, plain
    RMSE (N) `before` and `after` in the channel that gains most, the `resolution` (N) that steps of converter and encoder leave open, and
    the length of the held-out data, `seconds`."""

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
        """Whether the rest is systematic, given that the named causes lowered a mean square by `explained` (N^2)."""
        if not self.seconds:
            return False
        least = max(1.0, ENOUGH_S / self.seconds) * SYSTEMATIC_RMSE
        sure = self.lower > 0.0 and self.fall > SYSTEMATIC and self.after < (1.0 - least) * self.before
        return sure and self.before**2 - self.after**2 > max(SHADOW * explained, self.resolution**2)


def systematic_rest(last: Survey, train: list[Session], held: list[Session], encoder_step: float = 0.0) -> Rest:
    """Fit the general predictor to the training residual and test it on `held`. If `held` is empty, the training session with most compared
    data is tested and left out of the fit, unless it is the only one. The gain is zero if no sample is compared.

    An encoder with step `encoder_step` (m) leaves a force error that repeats at the depths to which all sessions return.
    """
    held = held or [max(reversed(train), key=lambda s: s.seconds)]
    seconds = sum(s.seconds for s in held)
    if not seconds:
        return Rest(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    fitted = [s for s in train if s not in held] or train
    z = last.richest(fitted)
    before = [residual(last.model, s) for s in held]
    after = [e - np.tensordot(z, last.directions_of(s)[0], 1) for e, s in zip(before, held, strict=True)]
    before, after = (beside_uncertainty(e, last.model, fitted, held, last.noise) for e in (before, after))
    fall, lower = bootstrap_fall(*([last.noise.apply(e, s) for e, s in zip(es, held, strict=True)] for es in (before, after)), held)
    rms, _ = rmse_fall(before, after, held)
    c = int(np.argmax(1.0 - rms[1] / np.maximum(rms[0], 1e-300)))
    open_to = left_by_steps(last.model, held[0].channels[c], held, encoder_step)
    return Rest(fall, lower, float(rms[0, c]), float(rms[1, c]), open_to, seconds)
