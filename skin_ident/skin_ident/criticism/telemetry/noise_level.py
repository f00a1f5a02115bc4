"""Noise: not what rig.yaml declares, in level, in colour, or because it grows with the load.

The noise is the residual of the extended model, at the channel's own readings and away from contact made or lost, less its own running
median: slow parts may be the model's. A channel is judged only where its level is declared (`force_noise_n`, `taxel_noise_n`). The level is
widened by the converter's step q and by u, the rms error of the simulation from errors of the depth, through stiffness and damping (or of
the force, where that drives the test), or from what all channels share of such errors:

    expected^2 = declared^2 + q^2 / 12 + u^2.

Noise that is less than `OTHER_LEVEL` times as loud as expected still counts as too loud in one channel if the others are as declared, and
in a taxel if most of the others are too loud. A declared level says nothing about colour or load: noise measured in air may be declared
truly and still wander. So colour and growth are compared with those of the other channels with a declared level, and a channel is odd if it
is unlike most of them. So is one whose noise is louder than declared by a slow part that theirs lack (see `slow_part`), also in the air,
where no model is at fault.

An encoder error as large as the declared noise makes any noise coloured and load-dependent; then only the level is judged, and everything
once more in the air, where errors of the depth do nothing. Noise read through steps as wide as itself shows now as nothing, now as a whole
step; then only a level that is too high counts.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter

from skin_ident.criticism.baseline.residual import simulated
from skin_ident.criticism.sessions.read_again import read_again
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.as_read import calm_lines
from skin_ident.criticism.telemetry.noise_look import FEWEST, SLOW, Look, spread
from skin_ident.criticism.telemetry.slow_part import AVERAGED_S
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_models.model import Model

SLOW_S = 2.0  # s, window of the running median
OTHER_LEVEL = 1.5  # factor by which the level must exceed, or fall below, the expected one
LOUDER = 1.35  # factor from which it is too loud where others are as declared
# Correlation of neighbouring samples above which a channel is odd, if that of the others is below the second. An amplifier's own low-pass
# makes as much as 0.8.
COLOURED, WHITE = 0.88, 0.25
QUICK = 0.25  # rms of the slow part of the others over their expected noise, below which one that has it is odd
SWAYS, RESTS = 1.4, 1.1  # times the expected noise, slow part included: a channel is odd above the first, if others are below the second
GROWN, STEADY = 1.6, 1.25  # growth with the load: a channel is odd above the first, if that of the others is below the second
NOISE_SEEN = (
    f"looked for and not seen: found where it is {OTHER_LEVEL:g} times as large as declared or more, or so much smaller; and where, in "
    f"one channel and not in another, it is {LOUDER:g} times as large, neighbouring samples are alike (correlation above {COLOURED:g}), a "
    f"slow part beside it has {SLOW:g} times its size or makes it {SWAYS:g} times as large, or a load makes it {GROWN:g} times as large"
)
SWAYING, REPEATED = "slow", "minutes in the air, twice: a drift comes back alike, or goes on, and noise does neither"
AROUND_S = 0.3  # s around a sample in which the plunger's greatest speed counts
SEED = 0  # any fixed number, so that the same record gives the same result


def find_noise(
    recordings: list, channels: tuple[str, ...], residuals: list[np.ndarray], believed: list[np.ndarray], unread: Callable[[], np.ndarray]
) -> list[Symptom]:
    """Channels whose noise is not as declared, from residuals (C, N) at full rate and masks (C, N) of the samples to use.

    `unread` gives the rms error (C,), N, of the simulation from errors of the driving signal (`by_drive`). It is costly, and called only
    where a level is declared.
    """
    levels = {c: level for c, channel in enumerate(channels) if (level := declared_noise(recordings[0], channel))}
    errors = unread() if levels else np.zeros(0)
    looks = [_looked(channels[c], c, level, errors[c], recordings, residuals, believed) for c, level in levels.items()]
    found = []
    for look in looks:
        others = [other for other in looks if other is not look]
        why = _unlike(look, others) or (_unlike(look.in_air, [other.in_air for other in others]) if look.is_drowned else None)
        if why:
            kind, sentence, parameters = why
            text, where = f"the noise of {look.channel} {sentence}", sensor_of(look.channel, len(recordings[0].taxels))
            rivals = {"alternatives": (("drift", where),), "apart": REPEATED} if kind == SWAYING else {}
            found.append(Symptom("noise", where, (look.channel,), parameters, {"why": text, "kind": kind}, **rivals))
    return found


def _looked(
    channel: str, c: int, level: float, error: float, recordings: list, residuals: list[np.ndarray], believed: list[np.ndarray]
) -> Look:
    """The noise of row `c` of the residuals, at the channel's own readings; `error` is the rms error, N, of the simulation from the driving
    signal."""
    lines = calm_lines(channel, c, recordings, residuals, [b[c] for b in believed])
    periods = [r.dt if line.own is None else line.own.period for line, r in zip(lines, recordings, strict=True)]
    step = max(r.step(channel) or 0.0 for r in recordings)
    calm, whole = [~line.jumps for line in lines], [line.e for line in lines]
    rows = [_quick(line.e, period) for line, period in zip(lines, periods, strict=True)]
    loads = [line.y - line.e for line in lines]
    steps, period = np.array([step / np.sqrt(12.0), error]), float(np.median(periods))
    return Look(channel, level, steps, rows, whole, loads, calm, period)


def at_leisure(s: Session) -> np.ndarray:
    """Mask (N,) of the slower half of a session: where the plunger is fast, jitter of time stamps and corners of its path make errors that
    are not noise of a channel."""
    fastest = maximum_filter1d(np.abs(s.motion.v), 2 * int(0.5 * AROUND_S / s.motion.dt) + 1)
    return fastest <= np.median(fastest)


def by_drive(
    model: Model, sessions: list[Session], recordings: list, residuals: list[np.ndarray], believed: list[np.ndarray]
) -> np.ndarray:
    """The rms error (C,), N, of each simulated channel from errors of the depth, or of the force that drives a test, over samples of masks
    (N,): the change that another realisation of the driving noise and steps makes, or more, if the `residuals` (C, N) of several channels
    share more in that proportion."""
    rng, steps = np.random.default_rng(SEED), [_encoder_step(r) / np.sqrt(12.0) for r in recordings]
    again = [read_again(s, _unread(s, step) * rng.standard_normal(len(s.motion))) for s, step in zip(sessions, steps, strict=True)]
    changes = [(simulated(model, b) - simulated(model, a))[:, calm] for a, b, calm in zip(sessions, again, believed, strict=True)]
    unread = np.array([spread(row) if row.size else 0.0 for row in np.concatenate(changes, axis=1)])
    rows = [np.array([_quick(row, r.dt)[calm] for row in e]) for e, r, calm in zip(residuals, recordings, believed, strict=True)]
    return _with_shared(unread, np.concatenate(rows, axis=1))


def _unread(s: Session, step: float) -> float:
    """Standard deviation of one reading's error: of the depth, m, whose steps leave `step` m rms, or of the force that drives the test,
    N."""
    return float(np.hypot(step, s.depth_noise)) if s.drive is None else s.drive_noise / s.band.passes


def _with_shared(unread: np.ndarray, e: np.ndarray) -> np.ndarray:
    """`unread` (C,), or what residuals e (C, n) share between channels if that is more. An error z times a_c in channel c makes covariances
    a_c a_o z^2, and the ratio a_c / a_o is known from `unread`."""
    if e.shape[1] == 0 or len(unread) < 2 or not unread.all():
        return unread
    shared = e @ e.T / e.shape[1] * np.divide.outer(unread, unread)
    others = ~np.eye(len(unread), dtype=bool)
    return np.sqrt(np.maximum(unread**2, [np.median(row[other]) for row, other in zip(shared, others, strict=True)]))


_Unlike = tuple[str, str, dict[str, dict[str, Any]]]  # kind, sentence and numbers of a finding


def _unlike(look: Look, others: list[Look]) -> _Unlike | None:
    """The first respect in which the noise differs from its declaration, or from that of most `others` with a declared level."""
    if look.e.size < FEWEST:
        return None
    peers = [o for o in others if o.is_its_own] if look.is_its_own else []
    steady = [o.times_under_load for o in peers if o.would_grow(look.growth) > GROWN]
    grows = bool(steady) and look.times_under_load > GROWN and np.median(steady) < STEADY
    slow_of_others = [o.slow_part.rms / o.expected for o in peers if o.slow_part]
    wanders = bool(peers) and look.colour > COLOURED and np.median([o.colour for o in peers]) < WHITE
    is_slow = look.is_slow_in_part and bool(slow_of_others) and np.median(slow_of_others) < QUICK
    sways = look.sways > SWAYS and bool(others) and np.median([o.sways or np.inf for o in others]) < RESTS
    as_declared = bool(peers) and np.median([o.times_expected for o in peers]) < look.times_expected / LOUDER
    alone = as_declared and look.times_expected_idle > LOUDER  # not because it alone carries the load
    louder = LOUDER if alone or _most_are_too_loud(look, others) else OTHER_LEVEL
    return (
        (_growing(look) if grows else None)
        or (_wandering(look) if wanders else None)
        or (_slow(look) if is_slow else None)
        or _of_another_level(look, louder)
        or (_swaying(look) if sways else None)
    )


def _most_are_too_loud(look: Look, others: list[Look]) -> bool:
    """Whether `look` is of a taxel, and most of the other taxels are too loud: then less is enough for this one, too."""
    taxels = [o.times_expected > OTHER_LEVEL for o in others if o.channel != "force" and o.e.size >= FEWEST]
    return look.channel != "force" and 2 * sum(taxels) > len(taxels)


def _growing(look: Look) -> _Unlike:
    idle, loaded, _ = look.idle_and_loaded
    said = f"grows with the load, from {idle:.3g} N in the third of the samples with the least to {loaded:.3g} N in that with the most"
    numbers = {
        "times_under_load": quantity(loaded / idle, "1"),
        "white": quantity(idle, "N"),
        "proportional": quantity(min(look.growth, 1.0), "1"),
    }
    return "growth", f"{said}, where that of another channel does not; {look.declared}", numbers


def _wandering(look: Look) -> _Unlike:
    tau = -look.period / float(np.log(min(look.colour, 0.9999)))
    alike = f"neighbouring samples are alike (correlation {look.colour:.2f}), as those of another channel are not, over about {tau:.2g} s"
    size, over = quantity(spread(look.e), "N"), quantity(tau, "s")
    numbers = {"correlation_of_neighbours": quantity(look.colour, "1"), "coloured": size, "tau": over}
    return "correlation", f"wanders: {alike}; {look.declared}", numbers


def _slow(look: Look) -> _Unlike:
    part = look.slow_part
    scatter = f"averages over {AVERAGED_S:g} s scatter by {part.rms:.3g} N beside white noise of {part.quick:.3g} N"
    numbers = {"white": quantity(part.quick, "N"), "coloured": quantity(part.rms, "N"), "tau": quantity(part.tau, "s")}
    return "correlation", f"wanders: {scatter}, in the air as well, and those of another channel do not; {look.declared}", numbers


def _swaying(look: Look) -> _Unlike:
    said = f"with its slow part is {look.sways:.2g} times what is expected, in the air as well, and that of another channel is not"
    quick = spread(look.e)
    slow = float(np.sqrt(max(look.slow**2 - quick**2, 0.0)))
    numbers = {"times_expected": quantity(look.sways, "1"), "white": quantity(quick, "N"), "coloured": quantity(slow, "N")}
    return SWAYING, f"{said}: it wanders over seconds; {look.declared}", numbers


def _of_another_level(look: Look, louder: float) -> _Unlike | None:
    """A finding where the noise is more than `louder` times the expected level, or quieter than expected. Quieter is judged without the
    encoder's part and including slow noise, and not where steps bury the noise."""
    measured, at_rest = spread(look.e), 0.0 if look.is_buried else float(np.hypot(look.level, look.steps[0]))
    ratio = look.times_expected
    if ratio <= louder and OTHER_LEVEL * max(measured, look.slow) >= at_rest:
        return None
    steps = f", {look.expected:.3g} N together with the steps of converter and encoder" if look.expected > 1.05 * look.level else ""
    numbers = {"times_expected": quantity(ratio, "1"), "white": quantity(measured, "N")}
    return "level", f"is {measured:.3g} N{look.where}, {ratio:.2g} times what is expected: {look.declared}{steps}", numbers


def declared_noise(recording, channel: str) -> float | None:
    """The declared noise of a channel, N; None for a taxel that is left in volts."""
    if channel == "force":
        return recording.declared.force_noise_n
    i = int(channel.rpartition("_")[2])
    return recording.declared.of_taxel("taxel_noise_n", i) if recording.taxel_units[i] == "N" else None


def _encoder_step(recording) -> float:
    return 0.0 if recording.depth is None else max(recording.declared.encoder_step, recording.step("depth") or 0.0)


def _quick(e: np.ndarray, dt: float) -> np.ndarray:
    return e - median_filter(e, 2 * int(0.5 * SLOW_S / dt) + 1)
