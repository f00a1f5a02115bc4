"""A load cell that was not tared, in a test that its force drives: no simulation predicts that force, so its zero shows elsewhere.

Taxels answer to what presses. Where the driving force rests at its least, f, and they feel nothing all the same,

    |S(f)| <= IDLE |g f|,      g = (S(h) - S(f)) / (h - f),

S the sum of the taxels and h the greatest force, nothing presses, and f is what the load cell reads of nothing. About a true preload they
feel their share of it, S(f) = g f.
"""

import numpy as np

from skin_ident.criticism.pattern import in_sessions
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.estimators.scale import white_noise

TARED = 0.1  # share of its range within which the least driving force is about zero
SLIGHT, SURE = 0.005, 5.0  # a zero is told from this share of the range on, if the taxels would answer to it by as many widths of noise
IDLE = 0.15  # share of the answer to a preload, up to which taxels feel nothing
LEAST, MOST = 2.0, 95.0  # percentiles that stand for minimum and maximum
RESTS = 3.0  # widths of noise within which a force rests
APART = "a recording with the depth, or one that begins and ends in the air"


def starts_far_from_zero(force: np.ndarray) -> bool:
    """Whether the least of a driving force (N,) is not about zero."""
    least, most = np.percentile(force, [100.0 - MOST, MOST])
    return abs(least) > TARED * (most - least)


def tared(recordings: list) -> tuple[list, tuple[Symptom, ...]]:
    """The recordings with the driving force counted from where the taxels feel nothing, and the symptom, if that was not its zero."""
    zeros = [_reads_of_nothing(r) for r in recordings]
    untared = [i for i, zero in enumerate(zeros) if zero]
    if not untared:
        return recordings, ()
    names, zero = [recordings[i].name for i in untared], float(np.median([zeros[i] for i in untared]))
    why = f"where no taxel feels anything the load cell reads {zero:.4g} N: it was not tared, or the taxels were tared under a load"
    evidence = {"why": why, "put_right": True, **in_sessions(names, [r.name for r in recordings])}
    taxels = [sensor_of(f"taxel_{i}", len(recordings[0].taxels)) for i in range(len(recordings[0].taxels))]
    rivals = tuple(("force_offset", taxel) for taxel in taxels)
    symptom = Symptom("force_offset", "load_cell", ("force",), {"offset": quantity(zero, "N")}, evidence, alternatives=rivals, apart=APART)
    return [r.lowered({"force": zero}) if zero else r for r, zero in zip(recordings, zeros, strict=True)], (symptom,)


def _reads_of_nothing(r) -> float:
    """What the load cell reads of nothing, N; 0 where it drives nothing, was tared, or always felt a load."""
    if r.depth is not None or r.force is None or not len(r.taxels):
        return 0.0
    felt, noise = np.sum(r.taxels, axis=0), _noise(r.force)
    zero, most = np.percentile(r.force, [LEAST, MOST])
    for _ in range(3):
        low = np.abs(r.force - zero) <= RESTS * noise
        zero = float(np.median(r.force[low])) if low.any() else zero
    if not abs(zero) > max(SLIGHT * (most - zero), noise) or most - zero <= RESTS * noise:
        return 0.0
    high = r.force >= most
    idle, pressed = float(np.median(felt[low])), float(np.median(felt[high]))
    answer = abs((pressed - idle) / (float(np.median(r.force[high])) - zero) * zero)
    return zero if answer > SURE * _noise(felt) and abs(idle) <= IDLE * answer else 0.0


def _noise(y: np.ndarray) -> float:
    """Width of the white noise in readings (N,), and at least the smallest difference of two."""
    apart = np.abs(np.diff(y))
    return max(white_noise(y), float(np.min(apart[apart > 0.0], initial=np.ptp(y))))
