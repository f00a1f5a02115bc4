"""A recorded twin: someone else's simulation of the same motion, criticised in place of a model.

The twin's channels P are the prediction of the baseline, unchanged. To name causes, a surrogate D stands in for the twin: the dispersion
model fitted to the twin's channels. What the surrogate does not reproduce is added unchanged:

    simulated = D'(depth) + (P - D(depth)),        D' = D with corrections.

Without correction this is exactly P. A cause corrects D and so, to first order, the twin. Changed parameters of D say by how much the
twin's stiffness, damping or shares are wrong (`parameters`). The gain of a channel is one of them and is not fitted beforehand, so that a
wrong gain of the twin is reported.
"""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.baseline.fitting import fit, noise_of
from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.baseline.twin_clock import at, on_the_clock_of
from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.sessions.session import Session
from skin_ident.recordings.repeated import same
from skin_models.model import Model
from skin_models.words import counted


@dataclass(frozen=True, eq=False)
class Twins:
    """The surrogate of all twins; the sessions with the twins' channels in place of the measured ones (`said`; weight 0 where a twin has no
    samples); warnings by session."""

    surrogate: Model
    said: list[Session]
    warnings: list[list[str]]

    def beyond(self, surrogate: Model) -> list[np.ndarray]:
        """What each twin's channels contain beyond this surrogate, (C, N) N."""
        return [s.raw - simulated(surrogate, s) for s in self.said]

    @property
    def known(self) -> list[np.ndarray]:
        """Where each twin has samples: weights 1 or 0, (C, n)."""
        return [s.weight for s in self.said]


def read_twins(sessions: list[Session], recordings: list, twins: list, mass: float) -> Twins:
    """Read the twins of `sessions` and fit their surrogate. `mass` is that of the skin, kg.

    Raises `DiagnosisError` where a twin does not belong to its recording.
    """
    pairs = list(zip(recordings, _matched(recordings, twins), strict=True))
    said = [_said(s, r, twin) for s, (r, twin) in zip(sessions, pairs, strict=True)]
    surrogate = _surrogate([s for s, _ in said], mass, [twin.name for _, twin in pairs])
    return Twins(surrogate, [s for s, _ in said], [more for _, more in said])


def _matched(recordings: list, twins: list) -> list:
    """The twin of every recording: by name where all names agree, else in order."""
    if len(twins) != len(recordings):
        given = f"{counted(len(recordings), 'recording')}, but {counted(len(twins), 'twin')}"
        raise DiagnosisError(f"{given}: give one simulated twin for each, in the same order")
    by_name = {t.name: t for t in twins}
    return [by_name[r.name] for r in recordings] if {r.name for r in recordings} == set(by_name) else list(twins)


def _said(session: Session, recording, twin) -> tuple[Session, list[str]]:
    """The session with the twin's channels in place of the measured ones, including stuck ones, with weight 0 where the twin has no
    samples; and warnings."""
    missing = [c for c in session.channels if c not in twin.channels]
    beyond = [c for c in twin.channels if c.startswith("taxel") and c not in recording.channels]
    if missing or beyond:
        what = " and ".join([*(f"{c} is missing" for c in missing), *(f"{c} is too many" for c in beyond)])
        raise DiagnosisError(f"the twin {twin.name} must carry the channels of {recording.name} ({', '.join(session.channels)}): {what}")
    _answers(recording, twin)
    if same(recording, twin):
        raise DiagnosisError(f"the twin {twin.name} holds the very samples of {recording.name}: give a simulation of that motion")
    t, warnings = on_the_clock_of(recording, twin)
    raw = np.array([at(session.motion.t, t, twin.channels[c]) for c in session.channels])
    known = (session.t >= t[0]) & (session.t <= t[-1])
    weight = np.tile(known.astype(float), (len(raw), 1))
    warnings += [f"{twin.name} (the twin): {w}" for w in twin.warnings]
    return replace(session, raw=raw, bridged=raw, measured=session.band.thin(raw), weight=weight, stuck={}), warnings


def _answers(recording, twin) -> None:
    """Raise `DiagnosisError` where the depth, the force or all taxels of a twin are constant although those of the recording are not."""
    rows = {"depth": (recording.depth, twin.depth), "force": (recording.force, twin.force), "taxels": (recording.taxels, twin.taxels)}
    for what, (ours, theirs) in rows.items():
        if ours is None or theirs is None or not ours.size:
            continue
        moves, still = np.any(np.ptp(ours, axis=-1) > 0.0), np.all(np.ptp(theirs, axis=-1) == 0.0)
        if moves and still:
            raise DiagnosisError(f"the {what} of the twin {twin.name} never changes: leave it out, or give what a simulator recorded")


def _surrogate(sessions: list[Session], mass: float, names: list[str]) -> Model:
    start = dispersion_start(sessions, mass)
    noise = noise_of(start, sessions)
    found = fit(start, sessions, noise).model
    return replace(found, name="twin", source=f"dispersion model fitted to the simulated twin {', '.join(names)}")
