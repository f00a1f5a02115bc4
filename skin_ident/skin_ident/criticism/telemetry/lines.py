"""Interference: a line in the residual's spectrum, at full rate, at the same frequency in every session, or in several.

Each residual's periodogram is divided by its own smooth background (a running median). A line stands where the mean over sessions of the
normalised power exceeds what exponential statistics allow (R. A. Fisher, Tests of significance in harmonic analysis, 1929). It is reported
where it goes on while the plunger rests, or where nothing in the motion accounts for it (see `motion_lines`). A hump is not a line, unless
it is very tall and goes on at rest: a tone whose amplitude and phase wander looks like that. A line in two sessions or more that others
lack may come from a motion that only these have. Such a line must go on at rest, or stand very tall where the motion hardly moves.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.signal import zoom_fft
from scipy.stats import gamma

from skin_ident.criticism.pattern import in_sessions, when
from skin_ident.criticism.telemetry.bursts import COMING, coming, envelope
from skin_ident.criticism.telemetry.motion_lines import LONE_LINE, goes_on_at_rest, is_of_motion, over_background
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_models.words import counted

CHANCE = 1e-4  # chance of one false line per channel
TALLER = 3.0  # least height of a line, in units of what chance makes
UNLIKE = 3.0  # times the smaller of two heights that a line in both may count as
SEEN = 5.0  # least height over its background in more than `MOST_SESSIONS` of the sessions: a few motions may have the same speed
MOST_SESSIONS = 2 / 3  # share of the sessions that may have a line of their motion
DRIFT = 5  # bins by which a line may differ from session to session
BESIDE = 2, 12  # bins: nearest and farthest of those that a line is compared with to tell it from a hump
HUMP = 1e-5  # chance that a hump passes for a line, given that its highest bin is tested
BURST_HZ = 1.0  # half width of the band in which bursts are looked for
SAME_RATE = 0.01  # relative difference of sampling periods, within which sessions are searched together
SHORT = 0.5  # share of the usual length below which a session is left out: all are cut to the length of the shortest
FEWEST_CYCLES = 24  # cycles in a session, the fewest for a line
LOWEST_HZ = 0.3  # lowest frequency: below, the motion itself leaves lines in a residual
AROUND, LONELY = 30, 0.15  # bins around a line, with sidebands from bursts; the median there must stay below this share of its height
MOST = 6  # candidates per channel that are tested, the tallest first
LEFT = 0.5  # share of its amplitude that a line must keep in the residual of the extended model
NEAR = 0.15  # share of its frequency by which a line may wander
FINE = 101  # frequencies of the fine grid from DRIFT bins below to DRIFT bins above


@dataclass(frozen=True)
class Line:
    """A line's frequency (Hz), amplitude (N, mean over the record), and height as a multiple of its background."""

    frequency: float
    amplitude: float
    tall: float


@dataclass(frozen=True)
class _Rows:
    """One channel of all sessions at full rate, a row (N,) of each: measured less simulated, simulated, and measured less simulated beside
    what the depth does more quickly (see `find_interference`). Sampled every `dt` s."""

    left: list[np.ndarray]
    predicted: list[np.ndarray]
    beside: list[np.ndarray]
    dt: float

    def of(self, some: list[int]) -> "_Rows":
        """The rows of some sessions alone."""
        return _Rows(*([rows[i] for i in some] for rows in (self.left, self.predicted, self.beside)), self.dt)

    @property
    def shortest(self) -> int:
        """Number of samples of the shortest row."""
        return min(e.size for e in self.left)

    @property
    def frequency(self) -> np.ndarray:
        """Frequencies, Hz, of the periodograms."""
        return np.fft.rfftfreq(self.shortest, self.dt)

    @property
    def asked(self) -> np.ndarray:
        """Mask of the frequencies at which lines are looked for."""
        return _asked(self.shortest, self.dt)

    @cached_property
    def over_backgrounds(self) -> list[np.ndarray]:
        """Periodograms of what is left divided by their backgrounds, each cut to the length of the shortest row."""
        return [over_background(e[: self.shortest]) for e in self.left]

    def by_chance(self, sessions: int) -> float:
        """Height over the background, averaged over sessions, that the tallest frequency reaches by chance."""
        return (sessions > 1) - float(np.log(CHANCE / self.shortest)) / sessions


def searched(recordings: list) -> list[int]:
    """Indices of the sessions that are searched together: those of the rate that most have, without any that are much shorter than the
    others."""
    groups = [[i for i, r in enumerate(recordings) if abs(r.dt / one.dt - 1.0) < SAME_RATE] for one in recordings]
    alike = max(groups, key=lambda group: (len(group), sum(len(recordings[i]) for i in group)))
    usual = np.median([len(recordings[i]) for i in alike])
    return [i for i in alike if len(recordings[i]) >= SHORT * usual]


def not_searched(recordings: list) -> str:
    """Why lines could not be looked for, or not in all sessions; "" where they were."""
    together = searched(recordings)
    shortest = min((recordings[i] for i in together), key=len)
    if not _asked(len(shortest), shortest.dt).any():
        return f"the sessions are too short: a line shows where each of them holds {FEWEST_CYCLES} cycles of it"
    left = [r.name for i, r in enumerate(recordings) if i not in together]
    where = when(left, [r.name for r in recordings])
    return f"not looked for {where}: sessions of one rate, and of about one length, are searched together" if left else ""


def _asked(samples: int, dt: float) -> np.ndarray:
    """Mask of the frequencies of a periodogram of so many samples, `dt` s apart, at which lines are looked for."""
    frequency, seconds = np.fft.rfftfreq(samples, dt), samples * dt
    return (frequency >= max(LOWEST_HZ, FEWEST_CYCLES / seconds)) & (frequency <= frequency[-1] - 2.0 / seconds)


def find_interference(
    names: list[str],
    channels: tuple[str, ...],
    residuals: list[np.ndarray],
    predicted: list[np.ndarray],
    dt: float,
    n_taxels: int,
    stepped: bool = False,
    beside: list[np.ndarray] | None = None,
) -> list[Symptom]:
    """Periodic disturbances, one symptom per channel, from measured less simulated and simulated rows (C, N) at full rate of the sessions
    `names`.

    Where depth is read in such coarse steps (`stepped`) that they make lines of their own, only lines that go on at rest count. A line must
    also be in the residuals `beside` what the depth does more quickly than a simulation in the common band sees: a stage that vibrates
    is no disturbance of a sensor.
    """
    found = []
    for c, channel in enumerate(channels):
        rows, there = _Rows(*([e[c] for e in each] for each in (residuals, predicted, beside or residuals)), dt), names
        lines = _lines(rows, stepped)
        if not lines and (some := _of_some(rows)):
            rows, there = rows.of(some), [names[i] for i in some]
            lines = _lines(rows, stepped, strict=True)
        if lines:
            found.append(_symptom(channel, lines, in_sessions(there, names), n_taxels, len(there)))
    return found


def _of_some(rows: _Rows) -> list[int]:
    """Indices of the sessions that share the tallest line which two or more have and others lack."""
    if len(rows.left) <= 2:
        return []
    tall = np.array([maximum_filter1d(row, DRIFT) for row in rows.over_backgrounds]) * rows.asked
    limit, shared = TALLER * rows.by_chance(1), np.sort(tall, axis=0)[-2]
    some = np.flatnonzero(tall[:, np.argmax(shared)] > limit)
    return some.tolist() if 1 < some.size < len(tall) else []


def is_left(symptom: Symptom, row: list[np.ndarray], dts: list[float]) -> bool:
    """Whether a line remains in the residuals e (N,), N, of the extended model, one for each session, sampled every `dts` s. If named
    causes explain it, the motion had brought it. True for symptoms without an amplitude."""
    if "amplitude" not in symptom.parameters:
        return True
    return _stands_in(row, *(symptom.parameters[name]["value"] for name in ("frequency", "amplitude")), dts)


def _stands_in(row: list[np.ndarray], frequency: float, amplitude: float, dts: list[float]) -> bool:
    """Whether a line keeps most of its amplitude in the residuals e (N,), one for each session, sampled every `dts` s."""
    left = [_amplitude(e, frequency, dt) for e, dt in zip(row, dts, strict=True)]
    return float(np.median(left)) > LEFT * amplitude


def between_lines(rests: list[np.ndarray], channels: tuple[str, ...], symptoms: Iterable[Symptom], dts: list[float]) -> list[np.ndarray]:
    """Residuals (C, N) of every session, sampled every `dts` s, without the bands around the lines of these symptoms: correlation of
    neighbouring samples there is not the channel's noise."""
    out = [e.copy() for e in rests]
    for s in symptoms:
        if s.cause == "interference" and s.channels[0] in channels:
            c = channels.index(s.channels[0])
            for e, dt in zip(out, dts, strict=True):
                e[c] = _less(e[c], np.array(s.evidence["lines"]), dt)
    return out


def _less(e: np.ndarray, lines: np.ndarray, dt: float) -> np.ndarray:
    spectrum, frequency = np.fft.rfft(e), np.fft.rfftfreq(e.size, dt)
    near = np.abs(frequency - lines[:, None]) <= np.maximum(NEAR * lines, DRIFT * frequency[1])[:, None]
    return np.fft.irfft(np.where(near.any(axis=0), 0.0, spectrum), e.size)


def _amplitude(e: np.ndarray, frequency: float, dt: float) -> float:
    """Amplitude of a line in e (N,), mean over the record."""
    taper = np.hanning(e.size)
    return 2.0 * float(np.abs(np.sum((e - e.mean()) * taper * np.exp(-2j * np.pi * frequency * dt * np.arange(e.size))))) / taper.sum()


def _lines(rows: _Rows, doubtful: bool, *, strict: bool = False) -> list[Line]:
    """The lines in one channel, the tallest first, without those that the motion brings, or a stage that vibrates (see
    `find_interference`).

    Where the motion brings one line, it may bring lower ones that no simple function of it shows. From then on, and from the start where
    the motion is `doubtful`, only lines that go on at rest count. A `strict` search also requires of all others that they stand very tall
    and that the motion hardly moves there.
    """
    each, sessions, dt = rows.over_backgrounds, len(rows.left), rows.dt
    moved = rows.left, rows.predicted
    width = np.mean(each, axis=0)
    near = [maximum_filter1d(row, DRIFT) for row in each]
    ratio = np.median(near, axis=0) if sessions > 2 else _in_both(each)
    ratio[np.mean(np.array(near) > SEEN, axis=0) <= MOST_SESSIONS] = 0.0
    ratio, limit = ratio * rows.asked, rows.by_chance(sessions)
    lines = []
    for _ in range(MOST):
        i = int(np.argmax(ratio))
        tall = float(ratio[i])
        if tall <= TALLER * limit:
            break
        i += int(np.argmax(width[i : i + DRIFT]))
        line = _line(rows.left, rows.frequency[i], tall, dt)
        alone = np.median(width[max(i - AROUND, 0) : i + AROUND + 1]) < LONELY * tall
        stays = _stands_in(rows.beside, line.frequency, line.amplitude, [dt] * sessions)
        tone = stays and (_narrow(each, i) or _in_bursts(rows.left, line.frequency, dt))
        at_rest = stays and (tone or tall > LONE_LINE) and goes_on_at_rest(*moved, line.frequency, line.amplitude, dt)
        if tone or at_rest:
            told = not doubtful and (tall > LONE_LINE or not strict)
            if at_rest or (alone and told and not is_of_motion(*moved, line.frequency, line.amplitude, tall, dt, strict=strict)):
                lines.append(line)
            else:
                doubtful = True
        ratio[max(i - AROUND, 0) : i + AROUND + 1] = 0.0
    return lines


def _in_both(each: list[np.ndarray]) -> np.ndarray:
    """Height of the lines that both of two sessions have: the geometric mean, but at most `UNLIKE` times the smaller one. In one of them
    the background may be the higher, because more is wrong with it. Of a lone session, its own heights."""
    smaller, larger = np.min(each, axis=0), np.max(each, axis=0)
    return np.minimum(np.sqrt(smaller * larger), UNLIKE * smaller)


def _narrow(each: list[np.ndarray], i: int) -> bool:
    """Whether bin `i` of the normalised periodograms is a line, and not the top of a hump such as a ringing frame makes.

    The highest bin is compared with those next to it by the chance of such a maximum, combined over sessions (Fisher's method).
    """
    logs = 0.0
    for row in each:
        j = max(i - DRIFT, 0) + int(np.argmax(row[max(i - DRIFT, 0) : i + DRIFT + 1]))
        beside = np.concatenate([row[max(j - BESIDE[1], 1) : max(j - BESIDE[0], 1)], row[j + BESIDE[0] + 1 : j + BESIDE[1] + 1]])
        logs += max(float(row[j] / (np.median(beside) / np.log(2.0)) - np.log(2 * DRIFT + 1)), 0.0)
    return bool(gamma.sf(logs, len(each)) < HUMP)


def _in_bursts(rows: list[np.ndarray], frequency: float, dt: float) -> bool:
    """Whether the signal near a frequency comes and goes as no noise does."""
    return float(np.median([coming(envelope(e, frequency, dt, BURST_HZ)) for e in rows])) > COMING


def _line(rows: list[np.ndarray], near: float, tall: float, dt: float) -> Line:
    """The line near a frequency, located on a finer grid than the periodogram's."""
    reach = DRIFT / (min(e.size for e in rows) * dt)
    grid = np.linspace(near - reach, near + reach, FINE)
    each = [
        2.0 * np.abs(zoom_fft((e - e.mean()) * np.hanning(e.size), [grid[0], grid[-1]], FINE, fs=1.0 / dt, endpoint=True)) for e in rows
    ]
    each = [a / np.sum(np.hanning(e.size)) for a, e in zip(each, rows, strict=True)]
    return Line(float(grid[np.argmax(np.sum(np.square(each), axis=0))]), float(np.median([a.max() for a in each])), tall)


def _symptom(channel: str, lines: list[Line], where: dict[str, Any], n_taxels: int, sessions: int) -> Symptom:
    first = lines[0]
    stands = f"a line at {first.frequency:.3g} Hz in the spectrum is {first.tall:.0f} times the background of {channel}"
    others = ", ".join(f"{q.frequency:.3g} Hz ({q.amplitude:.2g} N)" for q in lines[1:])
    there = where.get("pattern", f"in {counted(sessions, 'session')}")
    why = f"{stands} {there}" + (f"; so do lines at {others}" if others else "")
    parameters = {"frequency": quantity(first.frequency, "Hz"), "amplitude": quantity(first.amplitude, "N")}
    evidence = {"why": why, "lines": [q.frequency for q in lines], **where}
    return Symptom("interference", sensor_of(channel, n_taxels), (channel,), parameters, evidence)
