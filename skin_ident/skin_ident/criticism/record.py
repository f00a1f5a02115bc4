"""Faults of the record, found before the search for causes and kept out of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from skin_ident.criticism.array.spreading import with_believed_spread
from skin_ident.criticism.baseline.fitting import fit, noise_of
from skin_ident.criticism.baseline.residual import damping, placed, simulated, stiffness
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.sessions.cutoff import Common, common_to
from skin_ident.criticism.sessions.parting import meeting
from skin_ident.criticism.sessions.session import Session, motion_under, prepare, weighed_as, with_lines
from skin_ident.criticism.sessions.thinner import thinner
from skin_ident.criticism.telemetry.ceiling import find_ceilings
from skin_ident.criticism.telemetry.clock import find_clock_faults
from skin_ident.criticism.telemetry.copied import copies_among, emptied, find_copies
from skin_ident.criticism.telemetry.crossed import find_crossed
from skin_ident.criticism.telemetry.dead import find_dead_taxels
from skin_ident.criticism.telemetry.encoder import find_encoder_faults
from skin_ident.criticism.telemetry.lines import find_interference, searched
from skin_ident.criticism.telemetry.more_than_applied import find_more_than_applied
from skin_ident.criticism.telemetry.outliers import Said, find_outliers
from skin_ident.criticism.telemetry.pieces import find_pieces
from skin_ident.criticism.telemetry.pile_up import find_saturated_drive, find_saturation
from skin_ident.criticism.telemetry.quantization import depth_resolution, depth_step, find_quantization, in_uneven_steps, is_uneven
from skin_ident.criticism.telemetry.stalled import find_stalled
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.telemetry.units import find_unit_faults
from skin_ident.stretches import runs
from skin_models.model import Model

TREND = 25  # samples of the running median that is taken for the true force
LOST = 0.5  # share of all samples in which a taxel must be dead to be given up
HARMLESS = 3  # samples of depth that may be bridged by a straight line with an error well below the noise in the band


@dataclass(frozen=True)
class Inspected:
    """Symptoms in the order of inspection, and `sessions` without the samples that they rule out.

    `whole` are the same sessions with clipped samples and silent taxels left in, to judge the gain of a model that simulates these faults.
    """

    symptoms: tuple[Symptom, ...]
    sessions: list[Session]
    whole: list[Session]

    @property
    def dead(self) -> tuple[Symptom, ...]:
        """Symptoms of the taxels that are left out of the search: silent from the first sample on, or given up."""
        return tuple(s for s in self.symptoms if s.cause == "dead_taxel" and s.channels[0] in self.sessions[0].stuck)

    @property
    def given_up(self) -> tuple[str, ...]:
        """Taxels that lived for a while and are left out of the search."""
        return tuple(s.channels[0] for s in self.dead if s.bad)

    def carrying(self, beyond: list[np.ndarray], weights: list[np.ndarray]) -> "Inspected":
        """The same with what each session's twin contains beyond the model, (C, N), and with weight only where the twin has samples (C, n).
        A stuck channel keeps its constant reading."""

        def all_of(sessions: list[Session]) -> list[Session]:
            each = zip(sessions, beyond, weights, strict=True)
            return [replace(s, beyond=b * s.answers[:, None], weight=s.weight * w) for s, b, w in each]

        return replace(self, sessions=all_of(self.sessions), whole=all_of(self.whole))

    def weighed_as(self, other: Session) -> "Inspected":
        """The same with the mass as in a session (see `session.weighed_as`)."""
        return replace(self, sessions=weighed_as(self.sessions, other), whole=weighed_as(self.whole, other))


def inspect(recordings: list) -> Inspected:
    """Inspect the records themselves, then the residual of a first fit at full rate."""
    early = _in_the_records(recordings)
    copies = copies_among(early, recordings[0])
    mended = _spread_again([mended_depth(emptied(r, copies), early) for r in recordings], early)
    common = common_to(mended, depth_step(mended))
    sessions, first, predicted = _first_look(mended, early, common)
    crossed = find_crossed(sessions, [s.raw - m for s, m in zip(sessions, predicted, strict=True)])
    if crossed:
        early = [*early, *crossed]
        sessions, first, predicted = _first_look(mended, early, common)
    stepped = any((s.cause, s.where) == ("quantization", "rig") for s in early)
    late = _in_residuals(first, predicted, mended, sessions, [s for s in early if s.cause == "data_error"], stepped)
    early, late = _between_levels(early, late)
    dead = {c for s in early if s.cause == "dead_taxel" for c in s.channels}
    early = [s for s in early if s.cause != "quantization" or not dead & set(s.channels)]
    symptoms = (*early, *(s for s in late if not dead & set(s.channels)))
    return _without(symptoms, _spread_again(mended, symptoms), common, copies)


def _in_the_records(recordings: list) -> list[Symptom]:
    """Symptoms that show without any model. Converter steps of a channel in a wrong unit are not reported."""
    units, dead = find_unit_faults(recordings), find_dead_taxels(recordings)
    return [
        *find_clock_faults(recordings),
        *find_copies(recordings),
        *find_stalled(recordings),
        *units,
        *find_more_than_applied(recordings, tuple(c for u in units for c in u.channels)),
        *dead,
        *(s for s in find_quantization(recordings) if not any(set(s.channels) & set(u.channels) for u in units)),
        *find_encoder_faults(recordings, dead),
        *_in_the_drive(recordings),
    ]


def _first_look(recordings: list, symptoms: list[Symptom], common: Common) -> tuple[list[Session], Model, list[np.ndarray]]:
    """The sessions without the samples that `symptoms` rule out, in their `common` band, a first model, and its prediction (C, N), N."""
    stuck = _stuck(symptoms)
    sessions = [replace(prepare(r, bad_samples(r, symptoms), common), stuck=stuck) for r in recordings]
    return sessions, *_first_fit(sessions)


def _without(symptoms: tuple[Symptom, ...], recordings: list, common: Common, copies: tuple[str, ...]) -> Inspected:
    """The recordings as sessions without the samples that `symptoms` rule out. `copies` are taxels that repeat another one and count as
    silent. What is silent reads zero there: a constant that moves by one step of the converter from one session to the next would be an
    enormous error beside noise of nothing."""
    clipped = [s for s in symptoms if s.cause == "saturation"]
    whole = [prepare(r, bad_samples(r, [s for s in symptoms if s not in clipped]), common) for r in recordings]
    lost = _given_up(symptoms, recordings)
    stuck = dict.fromkeys((*_stuck(symptoms), *copies, *lost), 0.0)
    if not clipped and not stuck:
        return Inspected(symptoms, whole, whole)
    hard = frozenset(c for s in clipped if "lost" not in s.parameters for c in s.channels)
    believed = [s for s in symptoms if not set(s.channels) & set(lost)]
    silent = [emptied(r, tuple(stuck)) for r in recordings]
    searched = [replace(prepare(r, bad_samples(r, believed), common), stuck=stuck, clipped=hard) for r in silent]
    return Inspected(symptoms, searched, whole)


def _given_up(symptoms: Sequence[Symptom], recordings: list) -> tuple[str, ...]:
    """Taxels that are dead for so long that the search leaves them out. If it did not, their dead samples would be lost in all channels,
    since the noise model is joint. Not in sessions with a spread over places, which needs all taxels."""
    every = LOST * sum(map(len, recordings)) if recordings[0].spread is None else np.inf
    dead = (s for s in symptoms if s.cause == "dead_taxel" and s.bad)
    return tuple(s.channels[0] for s in dead if sum(map(np.count_nonzero, s.bad.values())) > every)


def _between_levels(early: list[Symptom], late: list[Symptom]) -> tuple[list[Symptom], list[Symptom]]:
    """Early and late symptoms, corrected for channels with uneven converter steps. Their outliers are jumps from one level to the next;
    these samples are not trusted either, but belong to the quantization. A pile-up at the topmost level is what is read up to the next
    level, and no saturation."""
    uneven = in_uneven_steps(early)
    jumps = {s.channels[0]: s for s in late if s.cause == "outliers" and s.channels[0] in uneven}
    told = [replace(q, bad=jumps[q.channels[0]].bad) if is_uneven(q) and q.channels[0] in jumps else q for q in early]
    return told, [s for s in late if s.cause not in ("outliers", "saturation") or s.channels[0] not in uneven]


def _spread_again(recordings: list, symptoms) -> list:
    return with_believed_spread(recordings, [bad_samples(r, symptoms) for r in recordings])


def _stuck(symptoms) -> dict[str, float]:
    """Taxels that are silent from the first sample on, with their constant readings, N."""
    return {s.channels[0]: s.parameters["level"]["value"] for s in symptoms if s.cause == "dead_taxel" and not s.bad}


def _in_the_drive(recordings: list) -> list[Symptom]:
    """Faults of the force that drives a test without depth, since no simulation predicts it: spikes against its running median, and a level
    at which it stays while a taxel goes on."""
    if recordings[0].depth is not None:
        return []
    forces = [r.force[None] for r in recordings]
    rest = [y - median_filter(y, (1, TREND)) for y in forces]
    at_rest = [np.ones(len(r), bool) for r in recordings]  # a force that is held constant is not frozen
    said = [Said(r.name, e, y, j, recording=r) for r, e, y, j in zip(recordings, rest, forces, at_rest, strict=True)]
    step = max(r.step("force") or 0.0 for r in recordings)
    spikes = find_outliers(("force",), said, recordings[0].dt, (step,))
    return [*spikes, *find_saturated_drive(recordings, [mended_depth(r, spikes).force for r in recordings])]


def _in_residuals(
    first: Model, predicted: list[np.ndarray], recordings: list, sessions: list[Session], errors: list[Symptom], stepped: bool
) -> list[Symptom]:
    """Symptoms in the residual of the `first` fit (measured less `predicted`) at full rate, beside the `errors` of the data that are known.
    Depth may be read in coarse steps (`stepped`). Outliers are bridged before the rest is searched for."""
    wrong = [bad_samples(r, errors) for r in recordings]
    raw = [np.where(b, m, s.raw) for s, m, b in zip(sessions, predicted, wrong, strict=True)]
    rest = [y - m for y, m in zip(raw, predicted, strict=True)]
    channels, n, dt = sessions[0].channels, sessions[0].n_taxels, recordings[0].dt
    jumps = [meeting(motion_under(s, first.dispersion), first.dispersion) for s in sessions]
    names = [s.name for s in sessions]
    steps = tuple(np.max([s.steps for s in sessions], axis=0))
    said = [Said(r.name, e, y, j, r.depth, r) for r, e, y, j in zip(recordings, rest, raw, jumps, strict=True)]
    outliers = find_outliers(channels, said, dt, steps, depth_resolution(recordings))
    believed = _beside(raw, recordings, outliers)
    clipped = find_saturation(names, channels, believed, predicted, n, steps)
    clipped += [s for s in find_ceilings(names, channels, believed, predicted, jumps, n) if s.channels not in {c.channels for c in clipped}]
    told = {(s.cause, c) for s in errors for c in s.channels} | {("outliers", c) for s in outliers for c in s.channels}
    told |= {("saturation", c) for s in (*outliers, *clipped) for c in s.channels}
    pieces = [s for s in find_pieces(first, sessions, rest) if (s.cause, s.channels[0]) not in told]
    rest = _beside(rest, recordings, [*outliers, *pieces])
    alike = searched(recordings)
    beside = [rest[i] - _of_quick_depth(first, sessions[i], recordings[i]) for i in alike]
    residuals, motion = ([rows[i] for i in alike] for rows in (rest, predicted))
    lines = find_interference([names[i] for i in alike], channels, residuals, motion, recordings[alike[0]].dt, n, stepped, beside)
    return [*outliers, *pieces, *clipped, *lines]


def _of_quick_depth(model: Model, s: Session, recording) -> np.ndarray:
    """What the depth does more quickly than a simulation in the common band sees, as the skin answers to it in contact: (C, N) N."""
    if s.drive is not None:
        return np.zeros_like(s.raw)
    quick, here = np.where(s.motion.x > 0.0, recording.depth - s.motion.x, 0.0), placed(model, s)
    rate = np.gradient(quick, recording.dt)
    return np.array([stiffness(here, c) * quick + damping(here, c) * rate for c in s.channels])


def _beside(rows: list[np.ndarray], recordings: list, symptoms: list[Symptom]) -> list[np.ndarray]:
    """Rows (C, N) of each recording, bridged over the samples that symptoms rule out."""
    return [with_lines(y, bad_samples(r, symptoms)) for y, r in zip(rows, recordings, strict=True)]


def _first_fit(sessions: list[Session]) -> tuple[Model, list[np.ndarray]]:
    """A first model and its simulation of every session (C, N), N, at full rate."""
    few = thinner(sessions)
    start = dispersion_start(few)
    first = fit(start, few, noise_of(start, few), 4).model
    return first, [simulated(first, s) for s in sessions]


def mended_depth(recording, symptoms: list[Symptom]):
    """The recording with its depth bridged where the encoder was wrong, and also its force where that drives the test."""
    for channel in ("depth", "force") if recording.depth is None else ("depth",):
        for mask in _masks(recording.name, channel, symptoms):
            recording = recording.with_channels({channel: with_lines(getattr(recording, channel)[None], mask[None])[0]})
    return recording


def _masks(name: str, channel: str, symptoms) -> list[np.ndarray]:
    return [mask for s in symptoms for (session, c), mask in s.bad.items() if session == name and c == channel]


def bad_samples(recording, symptoms) -> np.ndarray:
    """Mask (C, N) of samples that are not trusted. Where the depth is wrong for long, no channel can be compared, so that counts for all
    channels."""
    channels = [c for c in recording.channels if c != "force" or recording.depth is not None]
    bad = np.zeros((len(channels), len(recording)), bool)
    for c, channel in enumerate(channels):
        own = recording.own(channel)
        for mask in _masks(recording.name, channel, symptoms):
            bad[c] |= mask if own is None else own.ringing(mask, recording.dt)
    for mask in _masks(recording.name, "depth", symptoms):
        for a, b in zip(*runs(mask), strict=True):
            if b - a > HARMLESS:
                bad[:, a:b] = True
    return bad
