"""A ceiling: above a level one channel hardly follows the simulation, while the other channels do.

The quickest touches reach the greatest forces, but no model is fitted to their samples: it knows neither the time of contact nor the jolt
well enough. A ceiling that only these touches reach shows in measured y against simulated m:

    y = m                       m < L
    y = L + s (m - L)           m > L,   s < FLAT

A lag, a delay or backlash makes no such knee: at the same m they read less on the way up than on the way down. A mass that is too large, or
skin that gives way, makes no sharp knee, and the latter shows in the taxels as well.
"""

import numpy as np

from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.estimators.scale import normal_scale
from skin_ident.stretches import runs

GREATEST = 8  # samples of the greatest simulated force whose median reading is the first guess of the level
FAR = 5.0  # noise widths from the guess, from which a sample counts as beyond or below; also the least range of those beyond
FEWEST, VISITS = 8, 3  # least samples beyond, and below; least separate visits beyond
UNSEEN = 0.5  # least share of the samples beyond that no fit has used: a fit may have absorbed the others
FLAT = 0.25  # greatest slope of measured against simulated beyond the level
FOLLOWS = (0.75, 1.3)  # range of that slope below the level
WITHIN, STRAY = 4.0, 0.1  # noise widths from the two lines; greatest share of samples that lie further away
ROUGH = 0.1  # share of the level by which a quick touch below it may miss the line as well
HALF = 0.5  # share of the guess, from which samples up to the guess count as loaded
OTHERS = 1 / 3  # greatest relative deficit of another channel, as a share of this channel's


def find_ceilings(
    names: list[str],
    channels: tuple[str, ...],
    raw: list[np.ndarray],
    simulated: list[np.ndarray],
    unseen: list[np.ndarray],
    n_taxels: int,
) -> list[Symptom]:
    """Channels with a ceiling, from measured and simulated rows (C, N) of each session and masks (N,) of the samples that no fit has used.
    Samples simulated above the level are marked as bad."""
    if len(channels) < 2:
        return []
    y, model, hidden = np.hstack(raw), np.hstack(simulated), np.concatenate(unseen)
    found = []
    for c, channel in enumerate(channels):
        seen = _ceiling(y, model, hidden, c)
        if seen is None:
            continue
        level, slope, beyond = seen
        lost = float(np.max(model[c, beyond] - y[c, beyond]))
        visits = runs(beyond)[0].size
        why = (
            f"beyond {level:.4g} N {channel} follows what the simulation says with a slope of {max(slope, 0.0):.2g} only, in {visits} "
            f"quick touches, by up to {lost:.3g} N too low, while the other channels follow it"
        )
        bad = {(name, channel): m[c] > level for name, m in zip(names, simulated, strict=True) if np.any(m[c] > level)}
        parameters = {"level": quantity(level, "N"), "lost": quantity(1.0 - slope, "1")}
        found.append(Symptom("saturation", sensor_of(channel, n_taxels), (channel,), parameters, {"why": why}, bad))
    return found


def _ceiling(y: np.ndarray, model: np.ndarray, unseen: np.ndarray, c: int) -> tuple[float, float, np.ndarray] | None:
    """Level, slope beyond it and mask (N,) of the samples beyond, of channel `c` of `y` and `model` (C, N); None where there is no
    ceiling."""
    own, said = y[c], model[c]
    guess = float(np.median(own[np.argsort(said)[-GREATEST:]]))
    loaded = (said > HALF * guess) & (said < guess)
    if loaded.sum() < FEWEST:
        return None
    width = normal_scale((own - said)[loaded])
    beyond = said > guess + FAR * width
    below = loaded & unseen & (said < guess - FAR * width)
    enough = min(beyond.sum(), below.sum()) >= FEWEST and runs(beyond)[0].size >= VISITS and np.mean(unseen[beyond]) >= UNSEEN
    if not enough or np.ptp(said[beyond]) < FAR * width:
        return None
    slope, base = np.polyfit(said[beyond], own[beyond], 1)
    if slope > FLAT or not FOLLOWS[0] <= np.polyfit(said[below], own[below], 1)[0] <= FOLLOWS[1]:
        return None
    level = float(base / (1.0 - slope))
    straight = np.where(said > level, base + slope * said, said)
    off = np.abs(own - straight)
    strays = np.mean(off[beyond] > WITHIN * width), np.mean(off[below] > WITHIN * width + ROUGH * level)
    over = np.sum(own > base + slope * float(said.max()) + WITHIN * width)
    if max(strays) > STRAY or over > STRAY * beyond.sum() or not _alone(y, model, beyond, c):
        return None
    return level, float(slope), beyond


def _alone(y: np.ndarray, model: np.ndarray, beyond: np.ndarray, c: int) -> bool:
    """Whether every other channel lacks much less of its simulated force than channel `c`."""
    deficit = np.median((model - y)[:, beyond] / np.maximum(model[:, beyond], 1e-9), axis=1)
    others = np.delete(deficit, c)
    return bool(np.all(others < OTHERS * deficit[c]))
