"""What the size of a hidden effect is measured against: the dispersion model fitted to the recordings, and their noise."""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.baseline.fitting import fit, tangents
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.baseline.unknowns import unknowns
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.sessions.parting import without_parting
from skin_ident.criticism.sessions.session import Session, prepare
from skin_ident.recordings.mass import known_mass
from skin_ident.recordings.recording import Recording
from skin_models.model import Model


@dataclass(frozen=True)
class Ground:
    """The recordings, also as sessions; the model fitted to all; the noise's RMS (C,) in N; and the model's tangents (U, C, n) on the first
    session."""

    recordings: tuple[Recording, ...]
    sessions: tuple[Session, ...]
    model: Model
    noise: np.ndarray
    tangents: np.ndarray


def ground(recordings: list[Recording]) -> Ground:
    """Fit the dispersion model, and take as noise the residual of the first session that no cause explains, in the common band."""
    sessions = [prepare(r) for r in recordings]
    which = directions(sessions[0])
    start = dispersion_start(sessions, known_mass(recordings[0].declared).kg)
    sessions = [without_parting(s, start.dispersion) for s in sessions]
    model = fit(start, sessions, survey(start, sessions[:1], which).noise).model
    left = survey(model, sessions[:1], which).left_by_everything(sessions[0])
    own = tangents(model, sessions[:1], unknowns(model, sessions[0]))[0]
    return Ground(tuple(recordings), tuple(sessions), model, rms(left, sessions[0].weight), own)


def rms(rows: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Root mean square (C,) of every row (C, n) over the trusted samples (those with weight)."""
    return np.sqrt((rows**2 * weight).sum(axis=1) / np.maximum(weight.sum(axis=1), 1.0))
