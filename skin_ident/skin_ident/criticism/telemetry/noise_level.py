"""Noise: not what rig.yaml declares, in level, in colour, or because it grows with the load.

Looks at what the extended model leaves of what was read, far from contact made or lost, less its own running median: what is slow may be
the model's. Speaks only where a level is declared (`force_noise_n`, `taxel_noise_n`, as white noise), and widens it by the converter's step
q and by u, rms of what errors of the depth do to the simulation, through stiffness and damping (or those of the force, where that drives
the test), or of what all channels share of them:

    expected^2 = declared^2 + q^2 / 12 + u^2.

An encoder that adds as much as was declared makes any noise coloured and load-dependent; then only the level is looked at. And noise is
read through steps as wide as itself now as nothing, now as a whole step; then only a level that is too high is.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.read_again import read_again
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.as_read import AsRead, calm_lines
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_models.model import Model

SLOW_S = 2.0  # of the running median
OTHER_LEVEL = 1.5  # times as much, or as little, as expected
COLOURED = 0.5  # correlation of neighbouring samples of noise that should have none
GROWN = 1.6  # times the spread in the air, in the third of the samples with the greatest load
BURIED = 0.5  # of the noise declared, which rounding to a converter's steps is (rms) where they are 1.7 times as wide as it
SEEN = (
    f"looked for and not seen: it shows where it is {OTHER_LEVEL:g} times as loud as declared or more, or so much quieter, where "
    f"neighbouring samples are alike (correlation above {COLOURED:g}), or where a load makes it {GROWN:g} times as loud"
)
FEWEST = 300  # samples that a verdict needs
AROUND_S = 0.3  # within which the plunger's greatest speed counts
SEED = 0  # any: the same record is told the same


def find_noise(
    recordings: list, channels: tuple[str, ...], residuals: list[np.ndarray], believed: list[np.ndarray], unread: Callable[[], np.ndarray]
) -> list[Symptom]:
    """Channels whose noise is not as declared, from residuals (C, N) at full rate and masks (C, N) of the samples to look at.

    `unread` gives what errors of what drives the test do to the simulation, (C,) N rms (`by_drive`): dear, and asked only where a level is
    declared.
    """
    levels = {c: level for c, channel in enumerate(channels) if (level := _declared(recordings[0], channel))}
    errors, n_taxels, found = unread() if levels else np.zeros(0), len(recordings[0].taxels), []
    for c, level in levels.items():
        channel = channels[c]
        lines = calm_lines(channel, c, recordings, residuals, [b[c] for b in believed])
        periods = [r.dt if line.own is None else line.own.period for line, r in zip(lines, recordings, strict=True)]
        steps = np.array([(recordings[0].step(channel) or 0.0) / np.sqrt(12.0), errors[c]])
        why = _unlike(level, steps, lines, periods)
        if why:
            kind, sentence, parameters = why
            text = f"the noise of {channel} {sentence}"
            found.append(Symptom("noise", sensor_of(channel, n_taxels), (channel,), parameters, {"why": text, "kind": kind}))
    return found


def at_leisure(s: Session) -> np.ndarray:
    """Mask (N,) of the slower half of a session: where the plunger hurries, stamps that tremble and corners of its way make errors that are
    no noise of a channel."""
    fastest = maximum_filter1d(np.abs(s.motion.v), 2 * int(0.5 * AROUND_S / s.motion.dt) + 1)
    return fastest <= np.median(fastest)


def by_drive(
    model: Model, sessions: list[Session], recordings: list, residuals: list[np.ndarray], believed: list[np.ndarray]
) -> np.ndarray:
    """What errors of the depth, or of the force that drives a test, do to what is simulated of each channel, (C,) N rms, over samples of
    masks (N,): the difference that a further draw of its noise and steps makes, or more, where `residuals` (C, N) of several channels share
    more in that proportion."""
    rng, step = np.random.default_rng(SEED), _encoder_step(recordings[0]) / np.sqrt(12.0)
    again = [read_again(s, _unread(s, step) * rng.standard_normal(len(s.motion))) for s in sessions]
    changes = [(simulated(model, b) - simulated(model, a))[:, calm] for a, b, calm in zip(sessions, again, believed, strict=True)]
    unread = np.array([_spread(row) if row.size else 0.0 for row in np.concatenate(changes, axis=1)])
    rows = [np.array([_quick(row, r.dt)[calm] for row in e]) for e, r, calm in zip(residuals, recordings, believed, strict=True)]
    return _with_shared(unread, np.concatenate(rows, axis=1))


def _unread(s: Session, step: float) -> float:
    """The errors of one reading of the depth whose steps leave `step`, m rms, or of the force that drives the test, N rms."""
    return float(np.hypot(step, s.depth_noise)) if s.drive is None else s.drive_noise / s.band.passes


def _with_shared(unread: np.ndarray, e: np.ndarray) -> np.ndarray:
    """What is `unread` (C,) of the channels, or what residuals e (C, n) share with others, if that is more: an error z times a_c
    in each channel makes covariances of a_c a_o z^2, of which a_c / a_o is known."""
    if e.shape[1] == 0 or len(unread) < 2 or not unread.all():
        return unread
    shared = e @ e.T / e.shape[1] * np.divide.outer(unread, unread)
    others = ~np.eye(len(unread), dtype=bool)
    return np.sqrt(np.maximum(unread**2, [np.median(row[other]) for row, other in zip(shared, others, strict=True)]))


_Unlike = tuple[str, str, dict[str, dict[str, Any]]]  # kind, sentence and numbers of what is unlike the declaration


def _unlike(level: float, steps: np.ndarray, lines: list[AsRead], periods: list[float]) -> _Unlike | None:
    """The first thing that is unlike a declared `level`, N, under the loads that are simulated (a reading is high by its noise, too),
    beside what `steps` of the converter and the encoder do, N."""
    rows = [_quick(line.e, period) for line, period in zip(lines, periods, strict=True)]
    loads, believed = [line.y - line.e for line in lines], [~line.jumps for line in lines]
    e, y = (np.concatenate([r[b] for r, b in zip(of, believed, strict=True)]) for of in (rows, loads))
    if e.size < FEWEST:
        return None
    expected, declared = float(np.hypot(level, np.hypot(*steps))), f"rig.yaml declares white noise of {level:.3g} N"
    buried, encoder_adds = steps[0] >= BURIED * level, steps[1] >= 0.5 * level
    found = None
    if not (buried or encoder_adds):
        found = _growing(e, y, expected, declared) or _wandering(e, rows, believed, periods[0], declared)
    at_rest = 0.0 if buried else float(np.hypot(level, steps[0]))  # where an encoder adds nothing; of buried noise nothing is expected
    return found or _of_another_level(_spread(e), level, expected, at_rest, declared)


def _growing(e: np.ndarray, y: np.ndarray, expected: float, declared: str) -> _Unlike | None:
    """Noise e (n,), N, that is louder under the greatest loads y (n,), N, than under the least."""
    low, high = np.percentile(y, [33.0, 67.0])
    idle, loaded = max(_spread(e[y <= low]), 0.5 * expected), _spread(e[y >= high])
    if not (high > low + expected and loaded > GROWN * idle):
        return None
    share = np.sqrt(loaded**2 - idle**2) / max(float(np.mean(np.abs(y[y >= high]))), 1e-9)
    said = f"grows with the load, from {idle:.3g} N in the third of the samples with the least to {loaded:.3g} N in that with the most"
    numbers = {
        "times_under_load": quantity(loaded / idle, "1"),
        "white": quantity(idle, "N"),
        "proportional": quantity(min(share, 1.0), "1"),
    }
    return "growth", f"{said}; {declared}, the same at any load", numbers


def _wandering(e: np.ndarray, rows: list[np.ndarray], believed: list[np.ndarray], period: float, declared: str) -> _Unlike | None:
    """Noise e (n,), N, whose neighbours are alike in the `rows` (N,) of sessions, a `period` (s) apart."""
    colour = float(np.median([_neighbours(r, b) for r, b in zip(rows, believed, strict=True)]))
    if colour <= COLOURED:
        return None
    tau = -period / float(np.log(min(colour, 0.9999)))
    said = f"wanders: neighbouring samples are alike (correlation {colour:.2f}, where white noise has none), over about {tau:.2g} s"
    numbers = {"correlation_of_neighbours": quantity(colour, "1"), "coloured": quantity(_spread(e), "N"), "tau": quantity(tau, "s")}
    return "correlation", f"{said}; {declared}", numbers


def _of_another_level(measured: float, level: float, expected: float, at_rest: float, declared: str) -> _Unlike | None:
    """Noise that is clearly louder than is `expected`, N, or quieter than is expected `at_rest`."""
    ratio = measured / expected
    if ratio <= OTHER_LEVEL and OTHER_LEVEL * measured >= at_rest:
        return None
    steps = f", {expected:.3g} N together with the steps of converter and encoder" if expected > 1.05 * level else ""
    numbers = {"times_expected": quantity(ratio, "1"), "white": quantity(measured, "N")}
    return "level", f"is {measured:.3g} N, {ratio:.2g} times what is expected: {declared}{steps}", numbers


def _declared(recording, channel: str) -> float | None:
    """What is declared of a channel, N; of a taxel that is left in volts nothing is."""
    if channel == "force":
        return recording.declared.force_noise_n
    i = int(channel.rpartition("_")[2])
    return recording.declared.of_taxel("taxel_noise_n", i) if recording.taxel_units[i] == "N" else None


def _encoder_step(recording) -> float:
    declared = (recording.declared.encoder_step_um or 0.0) * 1e-6
    return 0.0 if recording.depth is None else max(declared, recording.step("depth") or 0.0)


def _quick(e: np.ndarray, dt: float) -> np.ndarray:
    return e - median_filter(e, 2 * int(0.5 * SLOW_S / dt) + 1)


def _spread(e: np.ndarray) -> float:
    return float(np.mean(np.abs(e)) * np.sqrt(np.pi / 2.0))  # a mean, not a median: quantized noise has few levels


def _neighbours(e: np.ndarray, believed: np.ndarray) -> float:
    pairs = believed[1:] & believed[:-1]
    a, b = e[1:][pairs], e[:-1][pairs]
    return float(a @ b / max(np.sqrt((a @ a) * (b @ b)), 1e-300))
