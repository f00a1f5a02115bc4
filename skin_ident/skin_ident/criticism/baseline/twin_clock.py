"""The clock of a twin, set to that of its recording.

No two programs start within a sample of each other, and a fit would turn a delay of a few milliseconds into a wrong damping. What drives
the test is the same in both, so the twin's clock is set by it where both contain it. Otherwise the clock is set by the response; wrong
damping may then hide in the delay, and a warning says so.
"""

import numpy as np
from scipy.interpolate import Akima1DInterpolator
from scipy.signal import correlate, correlation_lags

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.sessions.band import CUTOFF_HZ

COVERED = 0.9  # share of a recording's time that its twin must cover
SAME_MOTION = 0.95  # least correlation of what drives both
COARSEST_S = 1.0 / (4.0 * CUTOFF_HZ)  # s, longest sampling period of a twin: cubics interpolate over a quarter of a period
FARTHER = 1.25  # ratio of amplitudes, twin to recording, above which the motion is in another unit
SAME, NOISE = 0.002, 3.0  # difference of the motions (rms) that is allowed: share of the motion, multiple of its reading noise
LATEST_S = 1.0  # s, largest clock error of a twin, beyond setting both to begin together
LEAST = 0.25  # share of a sampling period, above which a delay is reported
NEARLY_ALL = 0.3  # share of the difference (rms) that may remain after a delay, for the delay to be the whole difference
ROUNDS = 8  # Gauss-Newton steps, to a thousandth of a sample


def on_the_clock_of(recording, twin) -> tuple[np.ndarray, list[str]]:
    """The twin's instants, s, on the recording's clock, and warnings. Raises `DiagnosisError` where the twin is too short or sampled too
    coarsely, or was driven by another motion."""
    if twin.dt > max(recording.dt, COARSEST_S) * 1.001:
        least = 1.0 / COARSEST_S
        raise DiagnosisError(
            f"the twin {twin.name} has {1.0 / twin.dt:.3g} samples per second: {least:.3g} are needed for the comparison, which goes up to "
            f"{CUTOFF_HZ:.3g} Hz"
        )
    by, drive = _told_by_both(recording, twin), _drive(recording)
    t, warnings = _begun(recording, twin, by)
    late = _late(recording, t, *_both(recording, twin, by)) if by else 0.0
    hides = ""
    if by == drive:
        warnings += _same_motion(recording, twin, t - late, by)
    elif not by or abs(late) < max(recording.dt, twin.dt) or not _is_all(recording, t, late, *_both(recording, twin, by)):
        return t, warnings  # no delay is corrected: an error of the twin may also shift its response
    else:
        hides = f"; it has no {drive}, so an error of damping may be hidden by this"
    if abs(late) > LEAST * recording.dt:
        said = f"{twin.name}: its {by} is {late:+.3g} s late against that of {recording.name}"
        warnings.append(f"{said}: its clock is set accordingly{hides}")
    return t - late, warnings


def at(times: np.ndarray, t: np.ndarray, y: np.ndarray) -> np.ndarray:
    """`y`, sampled at `t`, interpolated at other times by Akima's piecewise cubics (J. ACM 17 (1970) 589-602) and held constant beyond its
    ends. Cubics, because straight lines are too crude for a coarsely sampled twin."""
    return Akima1DInterpolator(t, y)(np.clip(times, t[0], t[-1]))


def _begun(recording, twin, by: str) -> tuple[np.ndarray, list[str]]:
    """The twin's instants and warnings. The two clocks are set to begin together if they overlap too little, or if `by` correlates well
    only then."""
    shared = min(recording.t[-1], twin.t[-1]) - max(recording.t[0], twin.t[0])
    length = recording.t[-1] - recording.t[0]
    together = twin.t - twin.t[0] + recording.t[0]
    if shared >= COVERED * length:
        is_another = by and _alike(recording, twin, twin.t, by) < SAME_MOTION < _alike(recording, twin, together, by)
        if not is_another:
            return twin.t, []
    elif twin.t[-1] - twin.t[0] < COVERED * length:
        raise DiagnosisError(f"the twin {twin.name} lasts {np.ptp(twin.t):.3g} s, the recording {recording.name} {length:.3g} s")
    return together, [f"{twin.name}: has another clock than {recording.name}; they are taken to begin together"]


def _alike(recording, twin, t: np.ndarray, by: str) -> float:
    """Largest correlation of the channel `by` in both, with the twin's clock at `t` and shifted by the delay that `_late` finds."""
    ours, theirs = _both(recording, twin, by)
    return float(np.corrcoef(ours, at(recording.t + _late(recording, t, ours, theirs), t, theirs))[0, 1])


def _drive(recording) -> str:
    """What drives a test: the depth, or the force where nobody recorded one."""
    return "force" if recording.depth is None else "depth"


def _told_by_both(recording, twin) -> str:
    """The channel that sets the clock, contained in both and not constant: what drives the test, else the force, else a taxel; "" if there
    is none."""
    names = dict.fromkeys([_drive(recording), "force", *(f"taxel_{i}" for i in range(len(recording.taxels)))])
    moving = (name for name in names if all(y is not None and np.ptp(y) > 0.0 for y in _both(recording, twin, name)))
    return next(moving, "")


def _both(recording, twin, name: str) -> list[np.ndarray | None]:
    return [r.depth if name == "depth" else r.channels.get(name) for r in (recording, twin)]


def _late(recording, t: np.ndarray, ours: np.ndarray, theirs: np.ndarray) -> float:
    """Delay of the twin, whose instants are `t`, against the recording, s.

    First the whole-sample lag of largest correlation; from there y(t) = y_twin(t + d) by Gauss-Newton, both signals standardised to zero
    mean and unit variance. 0 where the result lies beyond `LATEST_S`.
    """
    y, theirs, dt = *((x - np.mean(x)) / np.std(x) for x in (ours, theirs)), recording.dt
    alike = correlate(np.interp(recording.t, t, theirs), y)
    lags = correlation_lags(y.size, y.size)
    near = np.abs(lags) * dt <= LATEST_S
    late, edge = dt * float(lags[near][np.argmax(alike[near])]), int(np.ceil(LATEST_S / dt))
    inside = slice(edge, -edge) if y.size > 4 * edge else slice(None)
    for _ in range(ROUNDS):
        moved = at(recording.t + late, t, theirs)
        off, slope = (y - moved)[inside], np.gradient(moved, dt)[inside]
        step = float(off @ slope) / max(float(slope @ slope), 1e-300)
        late += step
        if abs(step) < 1e-3 * dt:
            break
    return late if abs(late) <= LATEST_S + dt else 0.0


def _is_all(recording, t: np.ndarray, late: float, ours: np.ndarray, theirs: np.ndarray) -> bool:
    """Whether a delay removes nearly all of the difference between two responses; wrong damping would leave more."""
    before, after = (float(np.std(ours - at(recording.t + d, t, theirs))) for d in (0.0, late))
    return after < NEARLY_ALL * before


def _same_motion(recording, twin, t: np.ndarray, by: str) -> list[str]:
    """A warning where the driving signals differ slightly; raises `DiagnosisError` where they are of another motion or in another unit."""
    ours, theirs = _both(recording, twin, by)
    theirs = at(recording.t, t, theirs)
    r, size = float(np.corrcoef(ours, theirs)[0, 1]), float(np.std(theirs) / np.std(ours))
    if r < SAME_MOTION:
        raise DiagnosisError(f"the twin {twin.name} is not of the same motion as {recording.name}: their {by}s correlate by {r:.2f}")
    if not 1.0 / FARTHER < size < FARTHER:
        raise DiagnosisError(f"the {by} of the twin {twin.name} is {size:.3g} times that of {recording.name}: is its unit right?")
    off, noise = float(np.sqrt(np.mean((ours - theirs) ** 2))), float(np.std(np.diff(ours - theirs))) / np.sqrt(2.0)
    if by == "force" or off <= max(SAME * float(np.std(ours)), NOISE * noise, recording.step(by) or 0.0):
        return []
    return [
        f"{twin.name}: its depth differs from that of {recording.name} by {1e6 * off:.3g} µm rms: its answer is that to another "
        "motion, and the difference counts as its error; simulate the motion that was recorded"
    ]
