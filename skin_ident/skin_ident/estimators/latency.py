"""The latency of each channel behind the depth, with a standard error. Converters, filters and drivers all cause delays.

    y(t) = b v(t - d) + k x(t - d) + …,     the column that belongs to d is  -(b a + k v)

The delay d is fitted by Gauss-Newton together with the model's own columns. On a slow sine it cannot be told from a lower damping, b - k d;
the standard error is then large. A delay common to force and taxels comes from the encoder. Relaxation of the skin, which the model lacks,
may look like a delay.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.estimators.dispersion import Shape, recovery_of, settled, shape_of
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.figures import plus_minus
from skin_ident.estimators.prefilter import HEADROOM
from skin_ident.estimators.regression import Block, regress
from skin_ident.estimators.sessions import Session, live_taxels, prepare
from skin_ident.recordings.recording import Recording

ROUNDS = 12  # Gauss-Newton steps at most
CLOSE = 1e-3  # standard errors: a smaller step ends the iteration
MOST = 7  # taxels that are examined; the others have the same electronics
SURE = 4.0  # standard errors, and
LEAST = 0.25  # share of a sampling period, that a delay must exceed to be reported


@dataclass(frozen=True)
class Latency:
    """Delay behind the depth, s, and its standard error, which is infinite where this motion does not identify the delay."""

    seconds: float
    std: float

    def warning(self, channel: str, period: float) -> list[str]:
        """A sentence where the delay is significant (SURE) and large enough to matter (LEAST)."""
        if abs(self.seconds) <= max(SURE * self.std, LEAST * period):
            return []
        when, what = ("later", "lower") if self.seconds > 0 else ("earlier", "higher")
        size = f"{plus_minus(1e3 * abs(self.seconds), 1960 * self.std)} ms"
        return [f"{channel} comes {size} {when} than the depth: its damping b is {what} by k times that, unless the skin itself creeps"]


UNKNOWN = Latency(0.0, float("inf"))


def latencies(recordings: Sequence[Recording], mass: float | str = 0.0) -> dict[str, Latency]:
    """The latency of the load cell and of the MOST taxels that feel most, over all sessions. Raises `FitError` as `fit_dispersion` does."""
    felt = _strongest(recordings)
    sessions, _ = prepare([r.with_taxels(felt, spread=None) for r in recordings])
    shape = shape_of(sessions, mass, False)
    regression, _ = settled(sessions, shape)
    recovery = recovery_of(regression)
    names = ["force"] * shape.force + [f"taxel_{felt[i]}" for i in shape.live]
    return {name: _of_channel(sessions, shape, c, recovery) for c, name in enumerate(names)}


def _strongest(recordings: Sequence[Recording]) -> list[int]:
    """The taxels with the largest covariance with the depth, among those that take part in the fit."""
    live = list(live_taxels(recordings))
    deep = [r for r in recordings if r.depth is not None]
    follow = sum((np.abs(r.taxels[live] @ (r.depth - r.depth.mean())) for r in deep), np.zeros(len(live)))
    return sorted(live[i] for i in np.argsort(-follow, kind="stable")[:MOST])


def _of_channel(sessions: list[Session], shape: Shape, c: int, recovery: float) -> Latency:
    seconds, pair = 0.0, None
    # half a period of the fastest motion: from there on, a channel that is late looks like one that is early
    longest = min(min((s.motion.t[-1] - s.motion.t[0]) / 20, 0.5 * HEADROOM / s.prefilter.edge) for s in sessions)
    for _ in range(ROUNDS):
        try:
            step, std, pair = _step(sessions, shape, c, recovery, seconds, pair)
        except FitError:
            return UNKNOWN
        if not abs(seconds + step) < longest:
            return UNKNOWN
        seconds += step
        if abs(step) < CLOSE * std:
            return Latency(seconds, std)
    return Latency(seconds, std) if abs(step) < std else UNKNOWN


def _step(sessions: list[Session], shape: Shape, c: int, recovery: float, seconds: float, pair: np.ndarray | None):
    """One Gauss-Newton step of the latency, its standard error, and the (b, k) fitted with it. `pair` is (b, k) of the step before."""
    blocks = []
    for s in sessions:
        later = _delayed(s, seconds)
        v, x, a, g = later.columns(recovery).T
        inertial = [a + g] if c == 0 and shape.force and shape.free else []
        weight = shape.mass * (a + g) if c == 0 and shape.force else 0.0
        y = (s.force if c == 0 and shape.force else s.taxels[c - shape.force]) - weight
        b, k = (0.0, 1.0) if pair is None else pair
        columns = np.column_stack([-(b * a + k * v), *inertial, v, x]) if pair is not None else np.column_stack([*inertial, v, x])
        blocks += [Block(y[part], columns[part], s.prefilter.kernel) for part in s.parts]
    fit = regress([blocks])
    if pair is None:
        return _step(sessions, shape, c, recovery, seconds, fit.coefficients[0][-2:])
    return float(fit.coefficients[0][0]), float(np.sqrt(fit.covariance[0, 0])), fit.coefficients[0][-2:]


def _delayed(s: Session, seconds: float) -> Session:
    """The session with its motion delayed by `seconds`."""
    t = s.motion.t
    moved = {name: np.interp(t - seconds, t, getattr(s.motion, name)) for name in "xva"}
    return replace(s, motion=replace(s.motion, **moved))
