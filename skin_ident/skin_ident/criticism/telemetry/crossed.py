"""A stretch of a session in which two channels are written in each other's columns, as by a logger that was restarted.

Where readings y_i, y_j follow the model's u_i, u_j, the product (y_i - y_j)(u_i - u_j) is positive apart from noise; where they are
exchanged it is negative. The stretch with the lowest sum of it is tested: there both channels must fit far better exchanged than as they
are, and all others must agree with the model. A contact that moved does not look like this: it would change the shares of other taxels as
well, or not exchange the two exactly.
"""

from collections.abc import Iterator

import numpy as np

from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.other_units import slope
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.vocabulary import EXCHANGED

LEAST_S, LONG_S = 0.2, 1.0  # s, shortest stretch; s, from which a stretch is long
FOLLOWS = 0.3  # greatest residual of the exchanged channels, as a share of that as they are
FAR, FARTHER = 3.0, 10.0  # least residual as they are, in units of that elsewhere: in a long stretch; in a short one
WITH = 3.0  # greatest residual of other channels, in units of that elsewhere
LOUD, LESS = 2.0, 0.6  # for a pair to be tested: least residual in units of its median, and greatest ratio of the exchanged residual to it
TURNS = 3  # alternations between finding the stretch and fitting the slopes outside it, as the model was fitted to both


def find_crossed(sessions: list[Session], rest: list[np.ndarray]) -> list[Symptom]:
    """Stretches in which two channels are exchanged, from the residuals (C, N), N, of sessions at full rate."""
    return [symptom for i, j in _suspected(sessions, rest) for symptom in _of_pair(sessions, rest, i, j)]


def _suspected(sessions: list[Session], rest: list[np.ndarray]) -> Iterator[tuple[int, int]]:
    """Pairs of channels that, in averages over `LEAST_S`, somewhere have a residual far above the usual and fit better exchanged. An array
    has too many pairs to test them all sample by sample."""
    y = np.concatenate([_averages(s.raw, s) for s in sessions], axis=1)
    model = y - np.concatenate([_averages(e, s) for s, e in zip(sessions, rest, strict=True)], axis=1)
    for i in range(len(y) - 1):
        as_is = np.hypot(y[i] - model[i], y[i + 1 :] - model[i + 1 :])
        exchanged = np.hypot(y[i] - model[i + 1 :], y[i + 1 :] - model[i])
        loud = as_is > LOUD * np.median(as_is, axis=1, keepdims=True)
        for j in np.flatnonzero(np.any(loud & (exchanged < LESS * as_is), axis=1)):
            yield i, i + 1 + int(j)


def _averages(rows: np.ndarray, s: Session) -> np.ndarray:
    """Means (C, W) of rows (C, N) over windows of `LEAST_S`."""
    n = max(round(LEAST_S / s.motion.dt), 1)
    whole = rows[:, : rows.shape[1] // n * n] if rows.shape[1] >= n else rows
    return whole.reshape(len(rows), -1, min(n, rows.shape[1])).mean(axis=2)


def _of_pair(sessions: list[Session], rest: list[np.ndarray], i: int, j: int) -> Iterator[Symptom]:
    """Stretches in which channels `i` and `j` are exchanged, found alternately with the factors by which the model is off elsewhere."""
    y = [s.raw[[i, j]] for s in sessions]
    model = [m - e[[i, j]] for m, e in zip(y, rest, strict=True)]
    crossed, slopes = [np.zeros(m.shape[1], bool) for m in y], np.ones((2, 1))
    for _ in range(TURNS):
        crossed = [_stretch(m, slopes * u) for m, u in zip(y, model, strict=True)]
        slopes = _slopes(y, model, crossed)
    elsewhere = np.sqrt(np.mean([_left(m - slopes * u, ~mask) ** 2 for m, u, mask in zip(y, model, crossed, strict=True)], axis=0))
    for s, m, u, e, mask in zip(sessions, y, model, rest, crossed, strict=True):
        seconds = mask.sum() * s.motion.dt
        if seconds < LEAST_S:
            continue
        far = FAR if seconds >= LONG_S else FARTHER
        as_is, exchanged = _left(m - slopes * u, mask), _left(m - (slopes * u)[::-1], mask)
        others = np.delete(e, [i, j], axis=0)
        alone = bool(np.all(_left(others, mask) < WITH * np.maximum(_left(others, ~mask), 1e-12)))
        if alone and np.all(as_is > far * elsewhere) and np.all(exchanged < FOLLOWS * as_is):
            yield _symptom(s, s.channels[i], s.channels[j], mask)


def _stretch(y: np.ndarray, model: np.ndarray) -> np.ndarray:
    """Mask (N,) of the run of samples with the greatest sum of -(y_i - y_j)(u_i - u_j), if that is positive, for measured and modelled rows
    (2, N), N."""
    total = np.concatenate([[0.0], np.cumsum(-np.diff(y, axis=0)[0] * np.diff(model, axis=0)[0])])
    before = np.minimum.accumulate(total)
    end = int(np.argmax(total - before))
    start = int(np.argmin(total[: end + 1]))
    at = np.arange(y.shape[1])
    return (at >= start) & (at < end)


def _slopes(y: list[np.ndarray], model: list[np.ndarray], crossed: list[np.ndarray]) -> np.ndarray:
    """Factors (2, 1) by which each of the two channels reads what the model says where they are not exchanged."""
    outside = [np.array([m[:, ~mask], u[:, ~mask]]) for m, u, mask in zip(y, model, crossed, strict=True)]
    return np.array([[slope(m, u)] for m, u in zip(*np.concatenate(outside, axis=2), strict=True)])


def _left(rows: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Root mean square (C,) of rows (C, N) within a mask."""
    return np.sqrt(np.mean(rows[:, mask] ** 2, axis=1)) if mask.any() else np.zeros(len(rows))


def _symptom(s: Session, one: str, other: str, mask: np.ndarray) -> Symptom:
    t = s.motion.t[mask]
    start, seconds = float(t[0]), float(t[-1] - t[0])
    why = (
        f"{one} and {other} are exchanged in {s.name} from {start:.1f} s on for {seconds:.3g} s: each follows there what the model says of "
        "the other, and every other channel agrees with the model"
    )
    evidence = {"why": why, "kind": EXCHANGED, "pieces": [{"session": s.name, "start": start, "seconds": seconds}]}
    where = sensor_of("force", s.n_taxels) if "force" in (one, other) else "taxel"
    bad = {(s.name, channel): mask for channel in (one, other)}
    return Symptom("data_error", where, (one, other), {"lasts": quantity(seconds, "s")}, evidence, bad)
