"""Decimates sessions for the search: the common band needs only a fraction of a fast record's rate.

A search simulates every session thousands of times. The comparison ends at 8 Hz, and the depth that effects see at 20 Hz: of a record of 1
kHz four samples in five only cost time. Telemetry and figures use the full rate.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.session import Session
from skin_ident.recordings.readings import before_thinning

ENOUGH_HZ = 200.0  # sampling rate that a search needs
BELIEVED = 0.999  # weight, interpolated between two samples of the record's band, from which both are trusted


def thinner(sessions: list[Session]) -> list[Session]:
    """The sessions decimated for a search, to `ENOUGH_HZ` or the next higher rate that keeps one sample in a whole number."""
    every = [one_in(s) for s in sessions]
    slowest = max(max(k * s.motion.dt, s.band.slowest) for k, s in zip(every, sessions, strict=True))
    return [s if k == 1 else _thinner(s, k, slowest) for k, s in zip(every, sessions, strict=True)]


def one_in(session: Session) -> int:
    """Decimation factor of the session."""
    return max(1, int(1.0 / (ENOUGH_HZ * session.motion.dt) + 1e-6))


def at_every_sample(rows: np.ndarray, few: Session, session: Session) -> np.ndarray:
    """`rows` (C, n) of the decimated session `few`, interpolated at all samples of the recorded one, (C, N)."""
    return rows if few.motion.t.size == session.motion.t.size else np.array([np.interp(session.motion.t, few.motion.t, y) for y in rows])


def with_own_of_few(session: Session, few: Session) -> Session:
    """The recorded session with what was found to be particular to its decimated version `few`."""
    beyond, course = (None if y is None else at_every_sample(y, few, session) for y in (few.beyond, few.course))
    return session.with_own_of(replace(few, beyond=beyond, course=course))


def _thinner(s: Session, every: int, slowest: float) -> Session:
    """The session decimated by `every`, in a band of the same cut-off."""
    kept = {name: getattr(s.motion, name)[::every] for name in ("t", "x", "v", "a")}
    m = replace(s.motion, dt=s.motion.dt * every, **kept)
    band = Band(m.dt, s.band.cutoff, slowest)
    raw, bridged = _decimated(s.raw, every), _decimated(s.bridged, every)
    t = band.times(m.t)
    weight = np.array([np.interp(t, s.t, w) for w in s.weight]) > BELIEVED
    drive = None if s.drive is None else s.drive[::every]  # already low-passed to the band that effects see
    beyond = None if s.beyond is None else _decimated(s.beyond, every)
    rows = {"raw": raw, "bridged": bridged, "measured": band.thin(bridged), "weight": weight.astype(float), "beyond": beyond}
    return replace(s, motion=m, band=band, t=t, drive=drive, **rows)


def _decimated(rows: np.ndarray, every: int) -> np.ndarray:
    """One in `every` samples of `rows` (C, N), low-passed so that nothing aliases into the band of the depth; ends extended."""
    padded, taps = before_thinning(rows, every)
    windows = np.lib.stride_tricks.sliding_window_view(padded, taps.size, axis=1)[:, ::every]
    return windows @ taps
