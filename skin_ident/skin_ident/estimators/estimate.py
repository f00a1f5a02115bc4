"""What every estimator returns: values, a realistic covariance, and a verdict per parameter."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.special import stdtrit

from skin_models.model import Model
from skin_models.parameter import Parameter

IDENTIFIABLE = "identifiable"
WEAK = "weak"
NOT_IDENTIFIABLE = "not identifiable"
NEGATIVE = "negative"  # and surely so, which no skin of the model is
AT_BOUND = "at its bound"
FIXED = "fixed"
HALF_95 = 1.96  # standard errors in half of a 95 % interval
POOR = 0.9  # R² below which a fit is called poor
SILENT = 0.1  # R² below which a channel is reported as hardly explained at all
SHOWN = 8  # most channels that are named in one sentence


@dataclass(frozen=True)
class Verdict:
    """Whether a parameter can be trusted: one of the words above, and a sentence that says why."""

    word: str
    sentence: str


@dataclass(frozen=True)
class Residual:
    """The residual of one channel.

    rmse (N) over the fitted samples, low-passed as fitted; r2; relative_mse = mean squared error / mean square of the measurement, which is
    what the thesis's pairs of MSE and relative MSE imply (section 4.3.2); ar: coefficients of the noise model
    e[n] = sum ar[i] e[n-1-i] + w[n]; noise: std of w.
    """

    rmse: float
    r2: float
    relative_mse: float
    ar: tuple[float, ...]
    noise: float
    unit: str = "N"

    def complaint(self, channel: str) -> list[str]:
        """A warning where the model explains little of the channel."""
        if self.r2 >= POOR:
            return []
        share = f"only {100 * self.r2:.0f} %" if self.r2 > 0.0 else "nothing"
        return [f"{channel}: the model explains {share} of what was measured; its parameters mean little"]


def complaints(residuals: Mapping[str, Residual]) -> list[str]:
    """A warning for every channel of which the model explains little; channels of which it explains hardly anything share one warning."""
    silent = [name for name, r in residuals.items() if r.r2 < SILENT]
    if len(silent) < 2:
        return [w for name, r in residuals.items() for w in r.complaint(name)]
    shown = ", ".join(silent[:SHOWN]) + f" and {len(silent) - SHOWN} more" * (len(silent) > SHOWN)
    rest = [w for name, r in residuals.items() if name not in silent for w in r.complaint(name)]
    return [*rest, f"{shown}: next to nothing of what was measured is explained; the plunger hardly reaches them, if nothing else is wrong"]


@dataclass(frozen=True, eq=False)
class Estimate:
    """The result of a fit. `model` is None for a fit from force to force, which only gives ratios of parameters.

    `parameters` and the rows of `covariance` (P, P) are in the same order; a fixed parameter has zero variance.

    `contributions[p][channel]` is the rms in newtons of the term that p multiplies. `condition` is that of the normal matrix with its
    columns scaled to unit length. `dof` is the effective number of degrees of freedom of the covariance.
    """

    method: str
    model: Model | None
    parameters: tuple[Parameter, ...]
    covariance: np.ndarray
    verdicts: Mapping[str, Verdict]
    residuals: Mapping[str, Residual]
    contributions: Mapping[str, Mapping[str, float]]
    condition: float
    dof: float
    sessions: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    notes: Mapping[str, object] = field(default_factory=dict)

    @property
    def values(self) -> dict[str, float]:
        """Values by name, SI."""
        return {p.name: p.value for p in self.parameters}

    @property
    def std(self) -> dict[str, float]:
        """Standard errors by name, SI."""
        sizes = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return {p.name: float(s) for p, s in zip(self.parameters, sizes, strict=True)}

    @property
    def correlations(self) -> np.ndarray:
        """Correlation matrix (P, P) of the parameters; fixed ones have zeros off the diagonal."""
        size = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        scale = np.where(size > 0, size, 1.0)
        return self.covariance / np.outer(scale, scale) + np.diag((size == 0).astype(float))

    def interval(self, name: str, level: float = 0.95) -> tuple[float, float]:
        """The confidence interval of a parameter at `level`, from Student's t with `dof` degrees of freedom."""
        half = stdtrit(self.dof, 0.5 + level / 2) * self.std[name]
        return self.values[name] - half, self.values[name] + half
