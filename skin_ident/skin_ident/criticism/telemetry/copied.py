"""Copies: blocks that repeat digit for digit, sessions that are identical, columns that hold the same numbers.

Noise does not repeat. A window of many changing samples that occurs twice was copied, whatever the clock or the encoder says at that time,
if there is noise of several converter steps in it (see `repeats`). Through coarser steps the same motion and hum give the same numbers
again, and the depth must tell: either it moved otherwise meanwhile, or it moved and repeats as well, and does so only where the forces do.
A channel was copied if it equals another one whenever they change.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from skin_ident.criticism.telemetry.repeats import LIVELY, Repeat, repeats_of
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.telemetry.tails import smallest_step
from skin_ident.estimators.scale import normal_scale, white_noise
from skin_ident.recordings.digits import digits_of, nearest
from skin_ident.stretches import changed, marked, runs

VALUES = 12  # fewest different values that a column must hold
FEW, LIKELY = 64, 0.8  # samples at which two columns are compared first, and the share that must be equal there
EQUAL = 0.98  # share of equal samples from which a column is a copy, among those at which a reading changes
WHOLE = 0.9  # share of a session from which a stretch is the session
DEPTHS = 4  # fewest different depths in a stretch: the encoder repeats itself in a hold, whatever the forces do
ELSEWHERE = 0.05  # share of its range by which the depth must differ between a stretch and its repetition in one channel
NOISY = 2.0  # converter steps: white noise above it has three bits in every reading, so that no window of it occurs twice
SOME = 0.8  # the same where all channels repeat and no depth tells more; hum through coarse steps looks like half a step of noise
AROUND = 24  # samples on either side of a stretch, which may be too short to tell how large the noise is
BEFORE = 4  # readings from which the next is foretold: two for hum, two for the motion
COLUMN, SESSION = "copied column", "copied session"  # kinds of copies


def find_copies(recordings: list) -> list[Symptom]:
    """Blocks that occur twice, within a session or in two, in all channels or in one; and columns that repeat another."""
    together = _blocks(recordings)
    known = {r.name: np.zeros(len(r), bool) for r in recordings}
    for symptom in together:
        for (name, _), mask in symptom.bad.items():
            known[name] |= mask
    whole = any(s.evidence["kind"] == SESSION for s in together)
    alone = [] if whole or len(recordings[0].channels) < 2 else _channel_blocks(recordings, known)
    return [*together, *alone, *_columns(recordings)]


def _blocks(recordings: list) -> list[Symptom]:
    """Stretches that repeat in all channels, with a moving depth that either repeats as well or is clearly different, or in noise of a
    channel."""
    again = repeats_of([np.array([r.read(c) for c in r.channels]).T for r in recordings])
    again = [r for r in again if r.is_rare and _is_copied_whole(recordings, r)]
    return _copies(recordings, again, tuple(recordings[0].channels))


def _channel_blocks(recordings: list, known: dict[str, np.ndarray]) -> Iterator[Symptom]:
    """Stretches that repeat in one channel alone, outside those `known` (N,) to repeat in all."""
    for channel in recordings[0].channels:
        read = [_as_read(r, channel) for r in recordings]
        kept = [at[~known[r.name][at]] for r, (at, _) in zip(recordings, read, strict=True)]
        again = repeats_of([digits[~known[r.name][at]][:, None] for r, (at, digits) in zip(recordings, read, strict=True)])
        again = [_on_grid(r, kept[r.at], kept[r.source]) for r in again]
        steps = [_step(r, channel) for r in recordings] if again else []
        again = [r for r in again if _is_copied(recordings, r, channel, steps[r.at])]
        yield from _copies(recordings, again, (channel,))


def _is_copied_whole(recordings: list, again: Repeat) -> bool:
    """Whether a stretch that repeats in all channels, more often than chance explains, was copied."""
    here = recordings[again.at]
    if _is_session(recordings, again) or _moved_otherwise(recordings, again, next(iter(here.channels))):
        return True
    if _with_its_motion(recordings, again) and not _is_made_again(recordings, again):
        return True
    least = NOISY if here.depth is not None else SOME
    return any(_of_noise(here, again, c, least * _step(here, c)) for c in here.channels)


def _is_copied(recordings: list, again: Repeat, channel: str, step: float) -> bool:
    """Whether a stretch that repeats in one channel, which reads in these steps, was copied. Many short copies make short windows recur so
    often that chance seems to explain the long ones as well; but it explains none of noise, as long as the depth does not repeat."""
    if again.is_rare and _moved_otherwise(recordings, again, channel):
        return True
    return (again.is_rare or not _with_its_depth(recordings, again)) and _of_noise(recordings[again.at], again, channel, NOISY * step)


def _step(recording, channel: str) -> float:
    """The step of the readings of a channel, N: the converter's, or the smallest that occurs."""
    return recording.step(channel) or smallest_step(recording.channels[channel])


def _as_read(recording, channel: str) -> tuple[np.ndarray, np.ndarray]:
    """For each reading of a channel the sample (M,) beside which it was taken, and its digits (M,). Without times of its own the readings
    are the recording's samples."""
    own = recording.own(channel)
    if own is None:
        return np.arange(len(recording)), recording.read(channel)
    return nearest(own.t, recording.t), digits_of(own.y)


def _on_grid(again: Repeat, at: np.ndarray, source: np.ndarray) -> Repeat:
    """A repeat found among readings, in samples of the two recordings: `at` and `source` are the samples beside their readings."""
    here, there = at[again.start : again.start + again.length], source[again.origin : again.origin + again.length]
    length = min(here[-1] - here[0], there[-1] - there[0]) + 1
    return replace(again, start=int(here[0]), origin=int(there[0]), length=int(length))


def _with_its_depth(recordings: list, again: Repeat) -> bool:
    """Whether the depth, where there is one, repeats digit for digit, too. A depth that nearly repeats is only the same motion made
    again."""
    at, source = recordings[again.at], recordings[again.source]
    if at.depth is None or source.depth is None:
        return True
    here, there = _places(again)
    return np.array_equal(at.read("depth", here), source.read("depth", there))


def _is_session(recordings: list, again: Repeat) -> bool:
    """Whether it is a session that repeats another one, with its depth. Neither hum nor a coarse converter lasts from end to end."""
    return again.source != again.at and again.length >= WHOLE * len(recordings[again.at]) and _with_its_depth(recordings, again)


def _with_its_motion(recordings: list, again: Repeat) -> bool:
    """Whether there is a depth that moves in the stretch and repeats digit for digit, too."""
    at, source, (here, _) = recordings[again.at], recordings[again.source], _places(again)
    if at.depth is None or source.depth is None:
        return False
    return np.unique(at.read("depth", here)).size >= DEPTHS and _with_its_depth(recordings, again)


def _is_made_again(recordings: list, again: Repeat) -> bool:
    """Whether a depth that repeats is only the same motion made again, as by a stepper or where the depth is commanded: well outside the
    stretch it repeats at the same lag while the forces do not, or the motion is made a third time. It is a reason for coarse forces to
    repeat, then, and no evidence that they were copied."""
    at, source, late = recordings[again.at], recordings[again.source], again.start - again.origin
    if again.at == again.source and again.length >= 2 * late:
        return True
    first, last = max(late, 0), min(len(at), len(source) + late)
    depth = at.read("depth", slice(first, last))
    same = depth == source.read("depth", slice(first - late, last - late))
    same[max(again.start - AROUND - first, 0) : again.start + again.length + AROUND - first] = False
    moves = np.cumsum(changed(depth))
    for begin, end in zip(*runs(same), strict=True):
        if moves[end - 1] - moves[begin] >= LIVELY:
            here, there = slice(first + begin, first + end), slice(first + begin - late, first + end - late)
            if not all(np.array_equal(at.read(c, here), source.read(c, there)) for c in at.channels):
                return True
    return False


def _moved_otherwise(recordings: list, again: Repeat, channel: str) -> bool:
    """Whether the depth (without one, another channel) differed while this channel changed. Otherwise a converter that is coarse beside the
    noise may repeat its readings, because the motion repeats or because the plunger does not touch."""
    at, source = recordings[again.at], recordings[again.source]
    others = [c for c in at.channels if c != channel]
    pairs = [(at.depth, source.depth)] if at.depth is not None else [(at.channels[c], source.channels[c]) for c in others]
    here, there = _places(again)
    changes = changed(at.read(channel, here))
    apart = [(one[here] - other[there])[changes] / max(np.ptp(one), 1e-300) for one, other in pairs]
    return any(2.0 * np.std(d) + abs(np.mean(d)) > ELSEWHERE for d in apart)


def _of_noise(recording, again: Repeat, channel: str, least: float) -> bool:
    """Whether there is more noise than `least`, several converter steps, in and around the stretch, which does not repeat even where the
    motion does."""
    around = recording.channels[channel][max(again.start - AROUND, 0) : again.start + again.length + AROUND]
    return min(white_noise(around), _unforeseen(around)) > least


def _unforeseen(y: np.ndarray) -> float:
    """Scale of what the `BEFORE` readings before each of y (N,) do not foretell, in its unit: noise, but not hum, which near half the
    sampling rate looks like noise in differences."""
    known = sliding_window_view(y - np.mean(y), BEFORE + 1)
    before, now = np.column_stack([known[:, :-1], np.ones(len(known))]), known[:, -1]
    return normal_scale(now - before @ np.linalg.lstsq(before, now, rcond=None)[0])


def _places(again: Repeat) -> tuple[slice, slice]:
    """The slices of the repetition and of its source."""
    return tuple(slice(start, start + again.length) for start in (again.start, again.origin))


def _copies(recordings: list, again: list[Repeat], channels: tuple[str, ...]) -> list[Symptom]:
    """One symptom for each session that is a copy from end to end, and one for all shorter stretches in the others."""
    whole = {r.at: r for r in again if r.length >= WHOLE * len(recordings[r.at])}
    shorter = [r for r in again if r.at not in whole]
    return [_copy(recordings, some, channels) for some in (*([r] for r in whole.values()), shorter) if some]


def _copy(recordings: list, again: list[Repeat], channels: tuple[str, ...]) -> Symptom:
    """One symptom for all stretches, described by the longest."""
    first = max(again, key=lambda r: r.length)
    r, source = recordings[first.at], recordings[first.source]
    whole = first.length >= WHOLE * len(r)
    alone = f" in {channels[0]} alone" if len(channels) < len(r.channels) else ""
    if whole:
        why = f"{r.name} is a copy of {source.name}{alone}: {first.length} of its {len(r)} samples are the same digit for digit"
    else:
        since = f"{first.length} samples of {r.name} from {r.t[first.start]:.2f} s on"
        why = f"{since} repeat {source.name} from {source.t[first.origin]:.2f} s on, digit for digit{alone}"
        why += f"; so do {len(again) - 1} more" if len(again) > 2 else "; so does another stretch" if len(again) == 2 else ""
    parameters = {"from": quantity(r.t[first.start], "s"), "length": quantity(first.length * r.dt, "s")}
    bad = {} if whole else {(r.name, c): _repeated(r, k, again) for k, r in enumerate(recordings) for c in channels}
    evidence = {"why": why, "kind": SESSION if whole else "repeated block", "session": r.name}
    where = sensor_of(channels[0], len(r.taxels))
    return Symptom("data_error", where, channels, parameters, evidence, {key: mask for key, mask in bad.items() if mask.any()})


def _repeated(recording, k: int, again: list[Repeat]) -> np.ndarray:
    """Mask (N,) of the samples of recording `k` that repeat earlier ones."""
    return marked(len(recording), ((r.start, r.start + r.length) for r in again if r.at == k))


def _columns(recordings: list) -> list[Symptom]:
    """Channels that hold the same numbers, one symptom for each group, placed at the first channel that repeats another."""
    groups: list[tuple[np.ndarray, dict[str, float]]] = []
    for channel in recordings[0].channels:
        y = np.concatenate([r.read(channel) for r in recordings])
        if np.unique(y).size < VALUES:
            continue
        changes = changed(y)
        equal = next(((names, share) for first, names in groups if (share := _equal(y, first, changes)) > EQUAL), None)
        if equal:
            equal[0][channel] = equal[1]
        else:
            groups.append((y, {channel: 1.0}))
    found = []
    for _, group in groups:
        names, same = list(group), list(group)[1:]
        if same:
            share = group[same[0]]
            hold = f"{', '.join(same[:8])} {'holds' if len(same) == 1 else 'hold'}"
            why = f"{hold} the same numbers as {names[0]} in {100 * share:.3g} % of the samples at which they change, and "
            why += "is judged no further" if len(same) == 1 else "are judged no further"
            where = sensor_of(same[0], len(recordings[0].taxels))
            found.append(Symptom("data_error", where, (names[0], *same), {}, {"why": why, "kind": COLUMN, "copies": len(same)}))
    return found


def copies_among(symptoms: Iterable[Symptom], recording) -> tuple[str, ...]:
    """The taxels that only repeat another channel, digit for digit: they carry no information of their own. Empty for a test that force
    drives if that would leave no taxel, as the force is no channel to be judged there."""
    copies = tuple(c for s in symptoms if s.evidence.get("kind") == COLUMN for c in s.channels[1:])
    return copies if recording.depth is not None or len(copies) < len(recording.taxels) else ()


def emptied(recording, copies: tuple[str, ...]):
    """The recording with zeros in these taxels, so that no signal is judged or fitted twice."""
    return recording.with_channels(dict.fromkeys(copies, np.zeros(len(recording)))) if copies else recording


def _equal(a: np.ndarray, b: np.ndarray, changes: np.ndarray) -> float:
    """Share of samples in which two rows (N,) are equal, among those at which either changes: at rest coarse taxels hold the same number.
    0 where a small sample of the `changes` (N,) of the first already shows that it is low."""
    few = np.flatnonzero(changes)
    few = few[:: max(few.size // FEW, 1)]
    return float(np.mean((a == b)[changes | changed(b)])) if np.mean(a[few] == b[few]) > LIKELY else 0.0
