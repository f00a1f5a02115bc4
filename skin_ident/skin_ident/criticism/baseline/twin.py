"""A recorded simulated twin: what someone else's simulator said for the same motion, as the simulation that is criticised.

The twin's channels P are the baseline's prediction as they stand. To speak of causes, a surrogate D, the dispersion model fitted to the
twin's own channels, stands in for it, and what the surrogate does not hold of the twin is carried along unchanged:

    simulated = D'(depth) + (P - D(depth)),        D' = D with corrections.

With no correction that is P, to the last digit. A cause corrects D and so, to first order, the twin; numbers of D that change say by how
much the twin's stiffness, damping or shares are wrong (`parameters`). A scale of a channel is such a number, and not fitted beforehand:
a twin whose gain is wrong shall be told so.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import Akima1DInterpolator
from scipy.signal import correlate, correlation_lags

from skin_ident.criticism.baseline.fitting import fit, noise_of
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.sessions.session import Session
from skin_ident.recordings.repeated import same
from skin_models.model import Model
from skin_models.words import counted

COVERED = 0.9  # of a recording's time that its twin must cover
SAME_MOTION = 0.95  # correlation of the two depths
LATEST_S = 1.0  # by which a twin's clock may be off
LEAST = 0.25  # of a sampling period, from which that is said
ROUNDS = 8


@dataclass(frozen=True, eq=False)
class Twins:
    """The surrogate of all twins; by session what its twin says beyond that, (C, N) N, and where it says something, (C, n); warnings."""

    surrogate: Model
    beyond: list[np.ndarray]
    known: list[np.ndarray]
    warnings: list[list[str]]


def read_twins(sessions: list[Session], recordings: list, twins: list, mass: float) -> Twins:
    """What the twins of `sessions` say. `mass` is that of the skin, kg.

    Raises `DiagnosisError` where a twin does not belong to its recording.
    """
    pairs = list(zip(recordings, _matched(recordings, twins), strict=True))
    said = [_said(s, r, twin) for s, (r, twin) in zip(sessions, pairs, strict=True)]
    surrogate = _surrogate([s for s, _ in said], mass, [twin.name for _, twin in pairs])
    return Twins(surrogate, [_beyond(surrogate, s) for s, _ in said], [s.weight for s, _ in said], [more for _, more in said])


def _matched(recordings: list, twins: list) -> list:
    """The twin of every recording: by name where all names agree, else in order."""
    if len(twins) != len(recordings):
        given = f"{counted(len(recordings), 'recording')}, but {counted(len(twins), 'twin')}"
        raise DiagnosisError(f"{given}: give one simulated twin for each, in the same order")
    by_name = {t.name: t for t in twins}
    return [by_name[r.name] for r in recordings] if {r.name for r in recordings} == set(by_name) else list(twins)


def _said(session: Session, recording, twin) -> tuple[Session, list[str]]:
    """The session with the twin's channels in place of the measured ones, also of those that are stuck, weight 0 where the twin says
    nothing; and warnings."""
    missing = [c for c in session.channels if c not in twin.channels]
    if missing or len(twin.taxels) != session.n_taxels:
        raise DiagnosisError(f"the twin {twin.name} must carry the channels of {recording.name}: {', '.join(session.channels)}")
    if same(recording, twin):
        raise DiagnosisError(f"the twin {twin.name} holds the very samples of {recording.name}: give what a simulation said of that motion")
    t, warnings = _clock(recording, twin)
    late = _late(recording, twin, t)
    if abs(late) > LEAST * recording.dt:
        what = "force" if recording.depth is None else "depth"
        warnings.append(f"{twin.name}: its {what} comes {1e3 * late:+.3g} ms beside that of {recording.name}: its clock is set by that")
    t = t - late
    _same_motion(recording, twin, t)
    raw = np.array([_at(session.motion.t, t, twin.channels[c]) for c in session.channels])
    known = (session.t >= t[0]) & (session.t <= t[-1])
    weight = np.tile(known.astype(float), (len(raw), 1))
    return replace(session, raw=raw, bridged=raw, measured=session.band.thin(raw), weight=weight, stuck={}), warnings


def _clock(recording, twin) -> tuple[np.ndarray, list[str]]:
    """The twin's instants on the recording's clock. Clocks that have nothing to do with each other are taken to begin together."""
    shared = min(recording.t[-1], twin.t[-1]) - max(recording.t[0], twin.t[0])
    length = recording.t[-1] - recording.t[0]
    if shared >= COVERED * length:
        return twin.t, []
    if twin.t[-1] - twin.t[0] < COVERED * length:
        raise DiagnosisError(f"the twin {twin.name} lasts {np.ptp(twin.t):.3g} s, the recording {recording.name} {length:.3g} s")
    return twin.t - twin.t[0] + recording.t[0], [f"{twin.name}: has another clock than {recording.name}; they are taken to begin together"]


def _driven(recording, twin) -> tuple[str, np.ndarray, np.ndarray] | None:
    """What drives the test, as both tell it: the depth, or the force where the recording has none. None where not both tell of it."""
    what = "force" if recording.depth is None else "depth"
    ours, theirs = getattr(recording, what), getattr(twin, what)
    return None if ours is None or theirs is None or np.ptp(ours) == 0.0 or np.ptp(theirs) == 0.0 else (what, ours, theirs)


def _late(recording, twin, t: np.ndarray) -> float:
    """By how many seconds what drives the test comes later in the twin, where both tell: no two programs begin within a sample.

    First the lag at which they correlate most, in whole samples; from there x(t) = x_twin(t + d) by Gauss and Newton.
    """
    driven = _driven(recording, twin)
    if driven is None:
        return 0.0
    _, ours, theirs = driven
    x, dt = ours - ours.mean(), recording.dt
    alike = correlate(np.interp(recording.t, t, theirs - theirs.mean()), x)
    lags = correlation_lags(x.size, x.size)
    near = np.abs(lags) * dt <= LATEST_S
    late, edge = dt * float(lags[near][np.argmax(alike[near])]), int(np.ceil(LATEST_S / dt))
    inside = slice(edge, -edge) if x.size > 4 * edge else slice(None)
    for _ in range(ROUNDS):
        moved = _at(recording.t + late, t, theirs)
        off, speed = (ours - moved)[inside], np.gradient(moved, dt)[inside]
        step = float(off @ speed) / max(float(speed @ speed), 1e-300)
        late += step
        if abs(step) < 1e-3 * dt:
            break
    return late


def _at(times: np.ndarray, t: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What was sampled at `t` at other times, held beyond its ends: by Akima's piecewise cubics (J. ACM 17 (1970) 589-602), for a twin
    that is sampled coarsely is no chain of straight lines."""
    return Akima1DInterpolator(t, y)(np.clip(times, t[0], t[-1]))


def _same_motion(recording, twin, t: np.ndarray) -> None:
    """Raise `DiagnosisError` where both tell what was done, and it was not the same."""
    driven = _driven(recording, twin)
    if driven is None:
        return
    what, ours, theirs = driven
    r = float(np.corrcoef(ours, np.interp(recording.t, t, theirs))[0, 1])
    if r < SAME_MOTION:
        raise DiagnosisError(f"the twin {twin.name} is not of the same motion as {recording.name}: their {what}s correlate by {r:.2f}")


def _surrogate(sessions: list[Session], mass: float, names: list[str]) -> Model:
    start = dispersion_start(sessions, mass)
    noise = noise_of(start, sessions)
    found = fit(start, sessions, noise).model
    return replace(found, name="twin", source=f"dispersion model fitted to the simulated twin {', '.join(names)}")


def _beyond(surrogate: Model, said: Session) -> np.ndarray:
    """What the twin says beyond its surrogate, (C, N)."""
    return said.raw - simulated(surrogate, said)
