"""Quantization: the spacing of the levels that occur, against the step that rig.yaml declares.

Coarse steps imitate dead zones and relaxation, so this is looked for before any fit.

Where nothing is declared, nobody can say that steps are coarser than they should be. But where the rounding error q / sqrt(12) is larger
than the noise s beneath, the steps bury it, and that shows in the residual, r^2 = s^2 + q^2 / 12.

A stage that only visits round depths shows levels, too, and so does a load cell under equal weights. They stay at a level and then jump, as
a coarse converter's readings do in slow motion. But what a converter reads is on its way to the next level before the reading changes, and
other channels show that, while before a stage moves, they stand. Noise at a threshold makes a reading flicker, and fast motion stays
nowhere. Levels that show none of this are not said to be a converter's.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skin_ident.criticism.search.bounds import raised
from skin_ident.criticism.telemetry.as_read import calm_lines
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.telemetry.units import declared_step
from skin_ident.estimators.scale import white_noise
from skin_ident.recordings.levels import FEWEST_LEVELS

COARSER = 1.25  # times the declared step, beyond any calibration error
UNEVENLY = 1.5  # the same for steps that are not all alike
UNLIKE = 1.9  # times the step of the other taxels: calibrations alone differ by less
FEWEST_ALIKE = 3  # taxels, the fewest of which one can be unlike the others
FEW = 0.05  # levels as a share of the samples, the most that a converter with uneven steps shows
OFTEN = 0.9  # share of the visits to levels that must be to levels visited again and again
AGAIN = 5  # visits to such a level
NARROW = 40.0  # percent of the spacings that may be as narrow as declared: noise at a hold visits two levels side by side
STAY = 4  # samples with one reading, from which a channel stays there
CLEAR = 8.0  # times its error from noise: the least change of another channel to the next reading that shows where it was before
AWAY = 0.15  # of that change, from the middle third of a run to its last third: a third in steady motion, hardly any before a jump
LEAST = 0.25  # of the change that another channel usually makes with the level, below which it does not follow
FEWEST_RUNS = 8  # that show this
MOVING = 0.2  # share of them that must be on their way: a converter also rests
FLICKER = 0.1  # share of the changes that must be returns from a neighbouring level
NEXT = 1.5  # times the narrowest of the usual changes: to a neighbouring level
RESTING = 0.5  # share of the samples in stays, of motion that stays nowhere
BURIED = 2.0  # residual variance, in units of the rounding variance, below which rounding dominates


def uneven_step(y: np.ndarray, digits: np.ndarray, declared: float) -> float | None:
    """Median spacing of the levels to which `y` (N,) returns again and again, for a converter with unequal steps such as one that
    compresses; None where the readings do not do this, or where many levels are no further apart than `declared`. A level is the median of
    the samples with the same `digits` (N,); interpolated samples lie between levels."""
    reading, counts = np.unique(digits[np.diff(digits, prepend=~digits[:1]) != 0], return_counts=True)
    again = counts >= AGAIN
    few = np.count_nonzero(again) <= 2 * FEWEST_LEVELS
    if few or reading.size > FEW * y.size or np.sum(counts[again]) < OFTEN * np.sum(counts):
        return None
    gaps = np.diff(np.sort([np.median(y[digits == d]) for d in reading[again]]))
    return float(np.median(gaps)) if np.percentile(gaps, NARROW) > UNEVENLY * declared else None


def find_quantization(recordings: list) -> list[Symptom]:
    """Channels whose steps are coarser than declared, or, for undeclared taxels, coarser than the other taxels'."""
    declared = _declared(recordings[0])
    found = _unlike(recordings, declared)
    for channel, step in declared.items():
        unit = "m" if channel == "depth" else "N"
        steps = [s for s in _steps(recordings, channel) if s is not None]
        coarse = step and len(steps) == len(recordings) and min(steps) > COARSER * step
        if coarse and _of_a_converter(recordings, channel):
            found.append(_coarse(recordings, channel, float(np.median(steps)), "as rig.yaml declares", {"declared": quantity(step, unit)}))
            continue
        uneven = [uneven_step(*read, step) for read in _rows(recordings, channel)] if step and not coarse else []
        if uneven and None not in uneven and _of_a_converter(recordings, channel):
            against, known = "on average as rig.yaml declares, and unevenly", {"declared": quantity(step, unit)}
            s = _coarse(recordings, channel, float(np.median(uneven)), against, known)
            found.append(replace(s, evidence={**s.evidence, "uneven": True}))
    return found


def is_uneven(s: Symptom) -> bool:
    """Whether the symptom is of a converter with uneven steps."""
    return bool(s.evidence.get("uneven"))


def in_uneven_steps(symptoms: Iterable[Symptom]) -> set[str]:
    """The channels with uneven steps."""
    return {c for s in symptoms if is_uneven(s) for c in s.channels}


def no_finer(excluded: list[dict[str, Any]], recordings: list) -> list[dict[str, Any]]:
    """The entries of what is excluded, where quantization is excluded only above the step that could be told from the declared one: the
    levels show nothing finer."""
    n, declared = len(recordings[0].taxels), _declared(recordings[0])
    told = {sensor_of(channel, n): COARSER * step for channel, step in declared.items() if step}
    told.setdefault("taxel", min((least for where, least in told.items() if where.startswith("taxel")), default=0.0))

    def bounded(e: dict[str, Any]) -> dict[str, Any]:
        return raised(e, told.get(e["where"], 0.0))

    return [bounded(e) if e["cause"] == "quantization" and "where" in e else e for e in excluded]


def undeclared_steps(recordings: list) -> dict[str, float]:
    """Spacing of the levels, N, of every channel that sits on levels in all sessions and has no declared step."""
    each = {c: _steps(recordings, c) for c, step in _declared(recordings[0]).items() if not step and c != "depth"}
    return {c: float(np.median(steps)) for c, steps in each.items() if steps and None not in steps and _of_a_converter(recordings, c)}


def find_buried(recordings: list, channels: tuple[str, ...], rests: list[np.ndarray], calm: list[np.ndarray]) -> list[Symptom]:
    """Channels without a declared step whose rounding error exceeds their noise, from residuals (C, N) at full rate and masks (N,) of the
    samples to use."""
    found = []
    for channel, step in undeclared_steps(recordings).items():
        if channel not in channels:
            continue
        lines = calm_lines(channel, channels.index(channel), recordings, rests, calm)
        left = np.concatenate([line.e[~line.jumps] for line in lines])
        if left.size and float(np.mean(left**2)) < BURIED * step**2 / 12.0:
            why = f"the levels of {channel} are {step:.3g} N apart, and rounding to them is more than its noise; rig.yaml declares no step"
            where = sensor_of(channel, len(recordings[0].taxels))
            found.append(Symptom("quantization", where, (channel,), {"step": quantity(step, "N")}, {"why": why}))
    return found


def _unlike(recordings: list, declared: dict[str, float | None]) -> list[Symptom]:
    """Taxels without declared steps that are coarser than all others, also relative to the noise beneath them: a taxel of wider range has
    more of both."""
    names = [c for c in recordings[0].channels if c.startswith("taxel") and not declared[c]]
    each = {c: _steps(recordings, c) for c in names}
    steps = {c: float(np.median(s)) for c, s in each.items() if None not in s}
    if len(steps) < FEWEST_ALIKE:
        return []
    usual = float(np.median(list(steps.values())))
    coarse = [c for c, step in steps.items() if step > UNLIKE * usual and _of_a_converter(recordings, c)]
    if not coarse:
        return []
    beside_noise = {c: step / max(_beneath(recordings, c, step), 1e-300) for c, step in steps.items()}
    alike = float(np.median(list(beside_noise.values())))
    alone = [c for c in coarse if beside_noise[c] > UNLIKE * alike]
    known, against = {"usual": quantity(usual, "N")}, "as those of the other taxels, and no step is declared"
    return [_coarse(recordings, c, steps[c], against, known) for c in alone]


def _beneath(recordings: list, channel: str, step: float) -> float:
    """White noise of a channel beneath its steps, N rms: s^2 = r^2 - q^2 / 12."""
    r = float(np.median([white_noise(row) for row, _ in _rows(recordings, channel)]))
    return float(np.sqrt(max(r**2 - step**2 / 12.0, 0.0)))


def _coarse(recordings: list, channel: str, step: float, against: str, known: dict[str, dict[str, Any]]) -> Symptom:
    """The symptom of steps wider than the `known` ones, which are keyed by their source, and described by `against`."""
    ((expected, unit),) = ((q["value"], q["unit"]) for q in known.values())
    evidence = {**known, "why": f"the levels of {channel} are {step / expected:.1f} times as far apart {against}"}
    return Symptom("quantization", sensor_of(channel, len(recordings[0].taxels)), (channel,), {"step": quantity(step, unit)}, evidence)


def _declared(recording) -> dict[str, float | None]:
    steps = {c: declared_step(recording, c) for c in recording.channels}
    return {"force": None, **steps, "depth": recording.declared.encoder_step or None}


def _rows(recordings: list, channel: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """Samples and digits of a channel in every recording that has it."""
    return [(r.depth if channel == "depth" else r.channels[channel], r.read(channel)) for r in _having(recordings, channel)]


def _steps(recordings: list, channel: str) -> list[float | None]:
    return [r.step(channel) for r in _having(recordings, channel)]


def _having(recordings: list, channel: str) -> list:
    """The recordings that have a channel, or a depth."""
    return [r for r in recordings if channel in r.channels or (channel == "depth" and r.depth is not None)]


def _of_a_converter(recordings: list, channel: str) -> bool:
    """Whether the levels of a channel are a converter's, rather than those at which a stage stopped."""
    having = _having(recordings, channel)
    runs_of = [_Runs.of(y, digits) for y, digits in _rows(recordings, channel)]
    if sum(runs.returns for runs in runs_of) > FLICKER * sum(runs.lengths.size for runs in runs_of):
        return True
    shown = [runs.on_the_way(*other) for r, runs in zip(having, runs_of, strict=True) for other in _others(r, channel)]
    away = np.concatenate([np.empty(0), *shown])
    if away.size >= FEWEST_RUNS:
        return bool(np.mean(away > AWAY) > MOVING)
    return sum(runs.rest for runs in runs_of) < RESTING * sum(map(len, having))


def _others(recording, channel: str) -> list[tuple[np.ndarray, float]]:
    """Depth, load cell and the taxel that varies most, without the channel itself, each with its steps or 0."""
    taxels = [f"taxel_{i}" for i in np.argsort(-np.std(recording.taxels, axis=1))]
    rows = {name: y for name, y in {"depth": recording.depth, **recording.channels}.items() if name != channel and y is not None}
    beside = [name for name in ("depth", "force") if name in rows] + [name for name in taxels if name in rows][:1]
    return [(rows[name], recording.step(name) or 0.0) for name in beside]


@dataclass(frozen=True)
class _Runs:
    """Runs of equal readings of a channel (R,): their first samples, lengths, digits and levels."""

    begins: np.ndarray
    lengths: np.ndarray
    digits: np.ndarray
    levels: np.ndarray

    @classmethod
    def of(cls, y: np.ndarray, digits: np.ndarray) -> "_Runs":
        """The runs in samples and digits (N,)."""
        begins = np.flatnonzero(np.diff(digits, prepend=~digits[:1]) != 0)
        lengths = np.diff(begins, append=y.size)
        return cls(begins, lengths, digits[begins], y[begins + lengths // 2])

    @property
    def rest(self) -> int:
        """Samples in stays."""
        return int(np.sum(self.lengths[self.lengths >= STAY]))

    @property
    def returns(self) -> int:
        """Visits to a neighbouring level that are too short for a stay and go back to where they came from."""
        apart = np.abs(np.diff(self.levels))
        if not apart.size:
            return 0
        near = apart[1:] < NEXT * np.percentile(apart, 10.0)
        return int(np.sum(near & (self.digits[2:] == self.digits[:-2]) & (self.lengths[1:-1] < STAY)))

    def on_the_way(self, other: np.ndarray, step: float) -> np.ndarray:
        """How far another channel (N,), which has a `step` or 0, is on its way before the reading changes: for every run but the first, its
        change from the middle third to the last third, relative to that to the middle of the next run.

        Left out are runs where noise hides this, and where the channel does not follow the level, as in the air. A channel that settles
        after a jump goes back from the first third on; that is no way to the next level, and counts as 0.
        """
        runs = 1 + np.flatnonzero(self.lengths[1:-1] > 1)
        if not runs.size:
            return np.empty(0)
        sums = np.concatenate([[0.0], np.cumsum(other - np.mean(other))])

        def mean(begins: np.ndarray, ends: np.ndarray) -> np.ndarray:
            return (sums[ends] - sums[begins]) / (ends - begins)

        ends, thirds = self.begins + self.lengths, self.lengths // 3
        middles = mean(self.begins + thirds, ends - thirds)
        goes, follows = np.diff(middles), np.diff(self.levels)
        follows = follows * (np.sum(goes * follows) / np.sum(follows**2))  # changes as they would be with the level
        came, goes, follows = follows[runs - 1], goes[runs], follows[runs]
        n, third, middle = self.lengths[runs], np.maximum(thirds[runs], 1), middles[runs]
        error = white_noise(other) * np.sqrt(1.0 / third + 1.0 / (n - 2 * thirds[runs]))
        clear = (np.abs(goes) > np.maximum(CLEAR * error, step)) & (goes * follows > LEAST * follows**2)
        settles = (middle - mean(self.begins[runs], self.begins[runs] + third)) * came < 0.0
        away = np.where(settles, 0.0, mean(ends[runs] - third, ends[runs]) - middle)
        return away[clear] / goes[clear]


def depth_resolution(recordings: list) -> float:
    """Resolution of the depth, m: its steps, or steps that would be as loud as its white noise (sqrt(12) standard deviations), if they are
    larger."""
    noises = [white_noise(r.depth) for r in recordings if r.depth is not None]
    return max(depth_step(recordings), np.sqrt(12.0) * max(noises, default=0.0))


def depth_step(recordings: list) -> float:
    """Steps of the depth, m: as seen, or as declared where they are not seen; 0 without a depth."""
    declared, steps = recordings[0].declared.encoder_step, _steps(recordings, "depth")
    seen = any(steps) and _of_a_converter(recordings, "depth")
    return max((step or declared if seen else declared for step in steps), default=0.0)
