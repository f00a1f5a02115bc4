"""The record's own faults, found before the search for causes and kept out of it."""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.fitting import fit
from skin_ident.criticism.residual import residual, simulated
from skin_ident.criticism.session import Session, meeting, prepare
from skin_ident.criticism.start import dispersion_start
from skin_ident.criticism.telemetry.copied import find_copies, find_unit_changes
from skin_ident.criticism.telemetry.dead import find_dead_taxels
from skin_ident.criticism.telemetry.lines import find_interference
from skin_ident.criticism.telemetry.outliers import find_outliers
from skin_ident.criticism.telemetry.pile_up import find_saturation
from skin_ident.criticism.telemetry.quantization import find_quantization
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.whitening import fit_whitener
from skin_models.model import Model


@dataclass(frozen=True)
class Inspected:
    """Symptoms in the order of looking, and the sessions without the samples that they rule out."""

    symptoms: tuple[Symptom, ...]
    sessions: list[Session]

    @property
    def spoiled(self) -> bool:
        """Whether the record is wrong in a way that no fit should see."""
        return any(s.cause == "data_error" for s in self.symptoms)


def inspect(recordings: list) -> Inspected:
    """Look at the records themselves, then at what a first fit leaves at full rate."""
    symptoms = [*find_copies(recordings), *find_unit_changes(recordings), *find_dead_taxels(recordings), *find_quantization(recordings)]
    sessions = [prepare(r) for r in recordings]
    first = _first_fit(sessions)
    raw = [s.raw for s in sessions]
    predicted = [simulated(first, s) for s in sessions]
    rest = [y - m for y, m in zip(raw, predicted, strict=True)]
    channels, n = sessions[0].channels, sessions[0].n_taxels
    names = [s.name for s in sessions]
    dead = {c for s in symptoms if s.cause == "dead_taxel" for c in s.channels}
    jumps = [meeting(s.motion, first.dispersion) for s in sessions]
    late = [*find_outliers(names, channels, rest, raw, jumps, n), *find_saturation(channels, raw, predicted, n)]
    late += find_interference(channels, rest, recordings[0].dt, n)
    symptoms += [s for s in late if not dead & set(s.channels)]
    bad = {r.name: _bad_samples(r.name, sessions[0].channels, len(r), symptoms) for r in recordings}
    return Inspected(
        tuple(symptoms), [prepare(r, bad[r.name]) if bad[r.name].any() else s for r, s in zip(recordings, sessions, strict=True)]
    )


def _first_fit(sessions: list[Session]) -> Model:
    start = dispersion_start(sessions)
    noise = fit_whitener([residual(start, s) for s in sessions], [s.weight for s in sessions])
    return fit(start, sessions, noise, 4).model


def _bad_samples(name: str, channels: tuple[str, ...], n: int, symptoms: list[Symptom]) -> np.ndarray:
    bad = np.zeros((len(channels), n), bool)
    for symptom in symptoms:
        for (session, channel), mask in symptom.bad.items():
            if session == name:
                bad[channels.index(channel)] |= mask
    return bad
