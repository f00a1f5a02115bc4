"""Saturation: samples pile up at one level, whatever came before, while the model goes on above it. Alternatively the model moves while the
channel stands at the level without the noise that it has elsewhere: a first model may itself be bent down to the level, by the clipping or
by other errors."""

from collections.abc import Sequence

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.estimators.scale import normal_scale

FEWEST_VISITS = 2  # separate times at the level
FEWEST_SAMPLES = 10  # samples at the level, in all
PILED = 4.0  # times as many samples at the level as, on average, at each of the five levels below it
BELOW = 0.9  # share of the driving force's range, up to which the taxel's line is fitted to it
BEYOND = 2.0  # noise widths by which the simulation must exceed the level,
NOISY = 2.0  # unless the noise, and the model's movement within a visit, exceed so many converter steps


def find_saturation(
    names: list[str],
    channels: tuple[str, ...],
    raw: list[np.ndarray],
    simulated: list[np.ndarray],
    n_taxels: int,
    steps: Sequence[float] = (),
) -> list[Symptom]:
    """Channels clipped at a level, from measured and simulated rows (C, N) of each session. They are read in `steps`, where known (else 0).
    The clipped samples are marked as bad."""
    steps = steps or [0.0] * len(channels)
    found = []
    for c, channel in enumerate(channels):
        y, model = np.concatenate([r[c] for r in raw]), np.concatenate([m[c] for m in simulated])
        level, at = _pile(y, steps[c])
        width = normal_scale(y - model - np.median(y - model))
        if level is None or _visits(at) < FEWEST_VISITS:
            continue
        if np.median(model[at] - y[at]) < BEYOND * max(width, 1e-9) and not _stands(y, model, at):
            continue
        why = f"{int(at.sum())} samples of {channel} stay at {level:.4g} N in {_visits(at)} touches while the load goes on rising"
        bad = {(name, channel): r[c] >= y[at].min() for name, r in zip(names, raw, strict=True) if np.any(r[c] >= y[at].min())}
        found.append(Symptom("saturation", sensor_of(channel, n_taxels), (channel,), {"level": quantity(level, "N")}, {"why": why}, bad))
    return found


def find_saturated_drive(recordings: list, believed: list[np.ndarray]) -> list[Symptom]:
    """Saturation of the force that drives tests without depth, `believed` (N,) after repair of its spikes. The taxel that moves most serves
    as the model: its line against the force is fitted below the level."""
    taxels, force = np.concatenate([r.taxels for r in recordings], axis=1), np.concatenate(believed)
    below = force < force.min() + BELOW * np.ptp(force)
    taxel = int(np.argmax(taxels.std(axis=1)))
    if not below.any() or np.ptp(taxels[taxel, below]) <= 0.0:
        return []
    line = np.polyfit(taxels[taxel, below], force[below], 1)
    predicted = [np.polyval(line, r.taxels[taxel])[None] for r in recordings]
    step = max(r.step("force") or 0.0 for r in recordings)
    return find_saturation([r.name for r in recordings], ("force",), [y[None] for y in believed], predicted, len(taxels), (step,))


def _pile(y: np.ndarray, step: float) -> tuple[float | None, np.ndarray]:
    """The topmost level, N (None unless more samples are there than a smooth distribution would have), and the mask of the samples at it.
    Readings that were interpolated between uneven stamps lie between levels a `step` apart and count for the nearest one."""
    top = float(y.max())
    at = y >= top - 1e-9 * max(abs(top), 1.0)
    near = y[y >= top - 0.1 * (top - y.min())]
    levels, counts = np.unique(np.round((near - top) / step) if step > 0.0 else near, return_counts=True)
    usual = float(np.mean(counts[-6:-1])) if levels.size > 5 else float("inf")
    return (top, at) if at.sum() >= max(FEWEST_SAMPLES, PILED * usual) else (None, at)


def _stands(y: np.ndarray, model: np.ndarray, at: np.ndarray) -> bool:
    """Whether the samples `at` the level lack the noise that all others have (from second differences of the residual), though the model
    moves in each visit."""
    off = ~at[:-2] & ~at[1:-1] & ~at[2:]
    if not off.any():
        return False
    noise = normal_scale(np.diff(y - model, 2)[off]) / np.sqrt(6.0)
    visits = np.split(model[at], np.flatnonzero(np.diff(np.flatnonzero(at)) > 1) + 1)
    moved = np.sqrt(np.mean(np.concatenate([(v - v.mean()) ** 2 for v in visits])))
    return min(noise, moved) > NOISY * float(np.median(np.diff(np.unique(y)))) and moved > noise


def _visits(at: np.ndarray) -> int:
    return int(np.sum(np.diff(at.astype(int), prepend=0) == 1))
