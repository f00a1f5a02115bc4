"""Rows that a logger wrote repeatedly while its time stamps went on: every column stands still, and then leaps at once.

A plunger at rest stands still, too, and coarse converters show the same row for long. But it then starts no faster than a stage can. If the
signal leaps by several times the longest step that the motion has otherwise, the plunger moved while the rows stood still.

Where moves are rare, that longest step is no more than a flicker of the encoder, and every move is a leap. So the plunger must also be seen
to move, in smaller steps, for as long before the rows stood or after they leapt: one that only rests, jumps and rests again may have done
just that.
"""

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, quantity
from skin_ident.stretches import marked, runs
from skin_models.words import counted

FEWEST = 8  # samples that repeat one row, the fewest of a stretch
LEAPS = 5.0  # times the step that `USUAL` percent of the samples do not exceed
USUAL = 99.9  # percentile of the steps
TRAVEL = 0.1  # of the leap, the least that the motion beside it goes
ONE_STEP = 0.3  # of this travel, the most of a single step


def find_stalled(recordings: list) -> list[Symptom]:
    """One symptom for all stretches of all sessions; their samples are marked as bad."""
    stretches = [(r, a, b) for r in recordings for a, b in _stalls(r)]
    if not stretches:
        return []
    first, a, b = max(stretches, key=lambda s: s[2] - s[1])
    why = f"all columns of {first.name} repeat one row for {(b - a) * first.dt:.2f} s from {first.t[a]:.2f} s on, and then jump"
    why += f", as at {counted(len(stretches) - 1, 'other time')}" if len(stretches) > 1 else ""
    channels = (*first.channels, *(["depth"] if first.depth is not None else []))
    bad = {(r.name, c): marked(len(r), ((a, b) for q, a, b in stretches if q is r)) for r in recordings for c in channels}
    parameters = {"from": quantity(first.t[a], "s"), "length": quantity((b - a) * first.dt, "s")}
    evidence = {"why": why, "kind": "repeated rows", "stretches": len(stretches)}
    return [Symptom("data_error", "clock", channels, parameters, evidence, {key: mask for key, mask in bad.items() if mask.any()})]


def _stalls(recording) -> list[tuple[int, int]]:
    """The first repeated sample and the end (exclusive) of every stretch."""
    moves = recording.depth if recording.depth is not None else recording.force
    steps = np.abs(np.diff(np.vstack([*([] if recording.depth is None else [recording.depth]), *recording.channels.values()])))
    leap = LEAPS * np.percentile(np.abs(np.diff(moves)), USUAL)
    ends = [(int(a) + 1, int(b) + 1) for a, b in zip(*runs(np.all(steps == 0.0, axis=0)), strict=True) if b - a >= FEWEST]
    leaps = [(a, b) for a, b in ends if b < len(recording) and abs(moves[b] - moves[b - 1]) > leap > 0.0]
    return [(a, b) for a, b in leaps if _amid_motion(np.diff(moves), a, b, [end for _, end in leaps])]


def _amid_motion(changes: np.ndarray, a: int, b: int, ends: list[int]) -> bool:
    """Whether a signal with these changes (N - 1,) moves in small steps before or after samples `a` to `b` repeat a row. Leaps at the
    `ends` of other stretches are left out."""
    leap, others = abs(changes[b - 1]), changes.copy()
    others[np.array(ends) - 1] = 0.0
    around = [part for part in (others[max(2 * a - b - 1, 0) : a - 1], others[b : 2 * b - a]) if part.size]
    longest = [float(np.abs(part).max()) for part in around]
    gone = [float(abs(part.sum())) for part in around]
    if max(longest, default=0.0) * LEAPS > leap:
        return False
    return any(travel > TRAVEL * leap and most < ONE_STEP * travel for travel, most in zip(gone, longest, strict=True))
