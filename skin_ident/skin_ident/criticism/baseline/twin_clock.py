"""When a twin says what it says, on the clock of its recording.

No two programs begin within a sample of each other, and of a delay of some milliseconds a fit makes another damping. What drives the test
is the same in both: where both tell it, the twin's clock is set by that. A twin that does not tell it is set by what it answers; damping
that is wrong hides in that, which is said.
"""

import numpy as np
from scipy.interpolate import Akima1DInterpolator
from scipy.signal import correlate, correlation_lags

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.sessions.band import CUTOFF_HZ

COVERED = 0.9  # of a recording's time that its twin must cover
SAME_MOTION = 0.95  # correlation of what drives both
COARSEST_S = 1.0 / (4.0 * CUTOFF_HZ)  # from one sample of a twin to the next: cubics bridge a quarter of a period
FARTHER = 1.25  # times as far, which no simulated motion goes
SAME, NOISE = 0.002, 3.0  # of the motion (rms), and times the noise of reading it, by which the two may differ
LATEST_S = 1.0  # by which a twin's clock may be off, beside clocks that begin together
LEAST = 0.25  # of a sampling period, from which that is said
NEARLY_ALL = 0.3  # of what two answers differ by (rms), the most that a delay leaves which is all of it
ROUNDS = 8  # of Gauss and Newton, to a thousandth of a sample


def on_the_clock_of(recording, twin) -> tuple[np.ndarray, list[str]]:
    """The twin's instants, s, on the recording's clock, and warnings. Raises `DiagnosisError` where the twin is shorter, or what drove
    both was not the same."""
    if twin.dt > max(recording.dt, COARSEST_S) * 1.001:
        least = 1.0 / COARSEST_S
        raise DiagnosisError(
            f"the twin {twin.name} says something {1.0 / twin.dt:.3g} times a second: {least:.3g} are needed for what is compared, up to "
            f"{CUTOFF_HZ:.3g} Hz"
        )
    by, drive = _told_by_both(recording, twin), _drive(recording)
    t, warnings = _begun(recording, twin, by)
    late = _late(recording, t, *_both(recording, twin, by)) if by else 0.0
    hides = ""
    if by == drive:
        warnings += _same_motion(recording, twin, t - late, by)
    elif not by or abs(late) < max(recording.dt, twin.dt) or not _is_all(recording, t, late, *_both(recording, twin, by)):
        return t, warnings  # what the twin gets wrong moves its answer, too
    else:
        hides = f", for it tells no {drive}: damping that is wrong may hide in that"
    if abs(late) > LEAST * recording.dt:
        said = f"{twin.name}: its {by} comes {late:+.3g} s beside that of {recording.name}"
        warnings.append(f"{said}: its clock is set by that{hides}")
    return t - late, warnings


def at(times: np.ndarray, t: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What was sampled at `t` at other times, held beyond its ends: by Akima's piecewise cubics (J. ACM 17 (1970) 589-602), for a twin
    that is sampled coarsely is no chain of straight lines."""
    return Akima1DInterpolator(t, y)(np.clip(times, t[0], t[-1]))


def _begun(recording, twin, by: str) -> tuple[np.ndarray, list[str]]:
    """The twin's instants. Clocks that have nothing to do with each other are taken to begin together; so are those by which what is told
    `by` both does not go together, where it does from beginnings on."""
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
    """How well what is told `by` both correlates where the twin's clock is `t`, or later or earlier by as much as it may be off."""
    ours, theirs = _both(recording, twin, by)
    return float(np.corrcoef(ours, at(recording.t + _late(recording, t, ours, theirs), t, theirs))[0, 1])


def _drive(recording) -> str:
    """What drives a test: the depth, or the force where nobody recorded one."""
    return "force" if recording.depth is None else "depth"


def _told_by_both(recording, twin) -> str:
    """What sets the clock, of what both tell: what drives the test, the force, or a taxel."""
    names = dict.fromkeys([_drive(recording), "force", *(f"taxel_{i}" for i in range(len(recording.taxels)))])
    moving = (name for name in names if all(y is not None and np.ptp(y) > 0.0 for y in _both(recording, twin, name)))
    return next(moving, "")


def _both(recording, twin, name: str) -> list[np.ndarray | None]:
    return [r.depth if name == "depth" else r.channels.get(name) for r in (recording, twin)]


def _late(recording, t: np.ndarray, ours: np.ndarray, theirs: np.ndarray) -> float:
    """By how many seconds something comes later in the twin, whose instants are `t`.

    First the lag at which they correlate most, in whole samples; from there y(t) = y_twin(t + d) by Gauss and Newton, both of them of no
    mean and of one size.
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
    """Whether a delay is nearly all by which two answers differ: of damping that is wrong, more is left."""
    before, after = (float(np.std(ours - at(recording.t + d, t, theirs))) for d in (0.0, late))
    return after < NEARLY_ALL * before


def _same_motion(recording, twin, t: np.ndarray, by: str) -> list[str]:
    """A warning where what drove both differs by a little; raises `DiagnosisError` where it is another, or in another unit."""
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
        f"{twin.name}: its depth differs from that of {recording.name} by {1e6 * off:.3g} µm rms: what it answers is the answer to another "
        "motion, and the difference is told as its error; simulate the motion that was recorded"
    ]
