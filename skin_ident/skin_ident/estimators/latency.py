"""By how much each channel comes later than the depth, with a standard error: converters, filters and drivers delay, each in its own way.

    y(t) = b v(t - d) + k x(t - d) + …,     the column that belongs to d is  -(b a + k v)

fitted by Gauss and Newton beside the model's own columns. On a slow sine it looks like a lower damping, b - k d: the standard error says
so. A delay common to force and taxels is a matter of the encoder; relaxation of the skin, which the model lacks, may look like one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.estimators.dispersion import Shape, recovery_of, settled, shape_of
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.figures import plus_minus
from skin_ident.estimators.prefilter import HEADROOM
from skin_ident.estimators.regression import Block, regress
from skin_ident.estimators.sessions import Session, prepare
from skin_ident.recordings.recording import Recording

ROUNDS = 12
CLOSE = 1e-3  # of its standard error: a step below this changes nothing
MOST = 7  # taxels that are looked at; the rest have the same electronics
SURE = 4.0  # standard errors, and
LEAST = 0.25  # of a sampling period, from which a delay is said to be there


@dataclass(frozen=True)
class Latency:
    """Seconds behind the depth, and their standard error; infinite where this motion does not tell."""

    seconds: float
    std: float

    def warning(self, channel: str, period: float) -> list[str]:
        """A sentence where it is there beyond doubt and matters."""
        if abs(self.seconds) <= max(SURE * self.std, LEAST * period):
            return []
        when, what = ("later", "lower") if self.seconds > 0 else ("earlier", "higher")
        size = f"{plus_minus(1e3 * abs(self.seconds), 1960 * self.std)} ms"
        return [f"{channel} comes {size} {when} than the depth: its damping b is {what} by k times that, unless the skin itself creeps"]


UNKNOWN = Latency(0.0, float("inf"))


def latencies(recordings: Sequence[Recording], mass: float | str = 0.0) -> dict[str, Latency]:
    """The latency of every channel (of the few that feel most) over all sessions. Raises `FitError` as `fit_dispersion` does."""
    felt = _strongest(recordings)
    sessions, _ = prepare([r.with_taxels(felt, spread=None) for r in recordings])
    shape = shape_of(sessions, mass, False)
    regression, _ = settled(sessions, shape)
    recovery = recovery_of(regression)
    names = ["force"] * shape.force + [f"taxel_{felt[i]}" for i in shape.live]
    return {name: _of_channel(sessions, shape, c, recovery) for c, name in enumerate(names)}


def _strongest(recordings: Sequence[Recording]) -> list[int]:
    """The taxels that follow the depth most."""
    follow = sum((np.abs(r.taxels @ (r.depth - r.depth.mean())) for r in recordings if r.depth is not None), np.zeros(1))
    return sorted(np.argsort(-follow, kind="stable")[:MOST].tolist()) if follow.size > 1 else list(range(len(recordings[0].taxels)))


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
    """By how much the latency is still wrong, its standard error, and (b, k) as they are fitted beside it."""
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
    """The session with its motion `seconds` later."""
    t = s.motion.t
    moved = {name: np.interp(t - seconds, t, getattr(s.motion, name)) for name in "xva"}
    return replace(s, motion=replace(s.motion, **moved))
