"""Faults of the encoder: the depth jumps, or stands still, and the force does not respond.

A real step dx changes the force by k dx at least, and by more with damping. Suppose the depth departs from its own trend within one sample
by more than its steps and its noise. If no channel shows a third of k dx nearby, the encoder was wrong and not the plunger. Where noise is
wider than a step, some samples are far out by chance and no force responds: then there must be more of them than its tail would leave.
"""

from collections.abc import Collection

import numpy as np
from scipy.ndimage import maximum_filter1d, median_filter, percentile_filter

from skin_ident.criticism.telemetry.excursions import fill_clusters, held, paired
from skin_ident.criticism.telemetry.symptom import Symptom, quantity
from skin_ident.criticism.telemetry.tails import reach, smallest_step, stands_apart
from skin_ident.estimators.scale import normal_scale
from skin_ident.stretches import runs

TREND = 9  # samples of the running median that gives the true speed
AROUND, MOST = 101, 0.8  # samples in which noise may be louder than elsewhere, and the share of them that tells how loud
STEPS = 6.0  # encoder steps that a jump must exceed
SEEN = 0.3  # share of k dx that a real step would show
NEAR = 3  # samples within which a channel would show it
CLEAR = 5.0  # noise widths by which k dx must stand out for a channel to show it
FROZEN = 5  # samples, shortest run at one depth
FEWEST = 2  # faults that make a finding


def find_encoder_faults(recordings: list, dead: Collection[Symptom] = ()) -> list[Symptom]:
    """Spikes, drop-outs and frozen runs of the depth, where a force or a taxel tells what really happened. A taxel does not count while it
    is `dead`."""
    if recordings[0].depth is None:
        return []
    stiffness = {c: _stiffness(recordings, c) for c in recordings[0].channels}
    declared = recordings[0].declared.encoder_step
    levels = [r.step("depth") or 0.0 for r in recordings]
    step = max(declared, *levels) if declared else max(*levels, smallest_step(np.concatenate([r.depth for r in recordings])))
    departed = [_detrended(r.depth) for r in recordings]
    evened = [_evened(d, step) for d in departed]
    limits = _limits(evened, STEPS * step)
    masks = [
        _faults(d, _unseen(r, d, stiffness, dead) & (e > limits[0]), e > limits[1], r.depth)
        for r, d, e in zip(recordings, departed, evened, strict=True)
    ]
    count = int(sum(m.sum() for m in masks))
    if sum(runs(m)[0].size for m in masks) < FEWEST:
        return []
    total = sum(m.size for m in masks)
    largest = max(float(np.max(np.abs(d)[m[1:]], initial=0.0)) for d, m in zip(departed, masks, strict=True))
    jumps = f"{count} of {total} samples of the depth jump by up to {1e6 * largest:.3g} µm, or stand still"
    why = f"{jumps}, while the forces say that the plunger did not"
    bad = {(r.name, "depth"): m for r, m in zip(recordings, masks, strict=True) if m.any()}
    rate = sum(runs(m)[0].size for m in masks) / sum(m.size * r.dt for r, m in zip(recordings, masks, strict=True))
    parameters = {"rate": quantity(rate, "1/s"), "size": quantity(largest, "m")}
    return [Symptom("outliers", "rig", ("depth",), parameters, {"why": why, "count": count}, bad)]


def _limits(departed: list[np.ndarray], least: float) -> tuple[float, float]:
    """Two limits on a departure from the trend: above the first it exceeds noise and `least` (a few steps); above the second it may be a
    jump. If noise reaches further than steps, the second is where departures outnumber the tail of noise, or infinite if nowhere."""
    noise = reach(np.concatenate(departed))
    if noise <= least:
        return least, least
    return noise, stands_apart(noise, lambda level: sum(np.count_nonzero(np.abs(d) > level) for d in departed)) or np.inf


def _stiffness(recordings: list, channel: str) -> float:
    """Slope of a channel against depth in contact, N/m, median over sessions; 0 for a channel that never changes."""
    slopes = []
    for r in recordings:
        y, x = r.channels[channel], r.depth
        touching = x > 0.0
        if touching.sum() > 20 and np.ptp(x[touching]) > 0.0 and np.ptp(y) > 0.0:
            slopes.append(float(np.cov(x[touching], y[touching])[0, 1] / np.var(x[touching], ddof=1)))
    return float(np.median(slopes)) if slopes else 0.0


def _detrended(y: np.ndarray) -> np.ndarray:
    """Change from sample to sample (N-1,) less its own running median."""
    d = np.diff(y)
    return d - median_filter(d, TREND)


def _evened(departed: np.ndarray, step: float) -> np.ndarray:
    """Sizes of the departures (N-1,), made smaller where there is more noise than usual, and than a `step`: noise that grows with the load,
    or comes in bursts, has far samples that are no jumps."""
    size = np.abs(departed)
    usual = max(float(np.quantile(size, MOST)), step)
    return size * usual / np.maximum(percentile_filter(size, 100.0 * MOST, AROUND), usual)


def _faults(departed: np.ndarray, silent: np.ndarray, far: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Mask (N,) of samples that jump away and back, and of runs that stand still and then jump, where `silent` (N-1,) says that a large
    departure shows in no channel, and `far` (N-1,) that it may be a jump."""
    if not silent.any():
        return np.zeros(x.size, bool)
    mask = paired(np.concatenate([[0.0], np.cumsum(departed)]), departed, np.flatnonzero(silent & far))
    for a, b in zip(*held(x, FROZEN), strict=True):
        if silent[b - 1] and not mask[b]:
            mask[a:b] = True
    return fill_clusters(mask)


def _unseen(recording, departed: np.ndarray, stiffness: dict[str, float], dead: Collection[Symptom]) -> np.ndarray:
    """Mask (N-1,) of samples in contact where some channel would have shown a step of this size, and none did."""
    x = recording.depth
    touching = np.minimum(median_filter(x, 2 * TREND + 1)[1:], median_filter(x, 2 * TREND + 1)[:-1]) > 0.0
    would, did = np.zeros(departed.size, bool), np.zeros(departed.size, bool)
    for channel, y in recording.channels.items():
        dy = _detrended(y)
        expected = abs(stiffness[channel]) * np.abs(departed)
        clear = expected > CLEAR * max(normal_scale(dy), recording.step(channel) or smallest_step(y))
        for lost in (s.bad[recording.name, channel] for s in dead if (recording.name, channel) in s.bad):
            clear &= ~lost[1:]
        would |= clear
        did |= clear & (maximum_filter1d(np.abs(dy), 2 * NEAR + 1) > SEEN * expected)
    return touching & would & ~did
