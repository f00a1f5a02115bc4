"""Tells lines that the motion itself brings into a residual from lines that it cannot have brought.

A periodic motion leaves its harmonics in the residual of any skin that is not linear, and a coarse encoder its steps at constant speed.
Curvature, friction, backlash or contact give lines where simple functions of the simulated force and of its rate have lines. But a line
that goes on while the plunger rests came from elsewhere, whatever the motion does at other times.
"""

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import detrend
from scipy.stats import f as f_distribution

BY_DEPTH = 0.4  # share of a line's amplitude up to which the simulation may move near its frequency
NEAR = 3  # bins to either side
TALL = 20.0  # height over the background from which a function of the motion has a line of its own
LONE_LINE = 100.0  # height over the background of a line that a motion without a line of its own cannot have made
SEVERAL, ABOVE = 3, 8.0  # sessions, in each of which the line must stand so many times as tall as any function of the motion
CYCLES, LEAST_S = 8, 2.0  # cycles of a line in a window at rest, and the window's least length
STILL = 0.25  # share of the line's amplitude by which the simulation may move in such a window (standard deviation)
BESIDE = np.array([-4, -3, -2, 2, 3, 4])  # bins of such a window that a line is compared with
FEWEST = 2  # windows at rest that the test needs
CHANCE = 1e-4  # chance that noise at rest has as much power at the line
SLOW = 0.02  # share of the greatest rate of the force below which its sign is smoothed


def goes_on_at_rest(rows: list[np.ndarray], predicted: list[np.ndarray], frequency: float, amplitude: float, dt: float) -> bool:
    """Whether a line stands over the frequencies beside it (F-test) in those windows of the residuals in which the simulation rests."""
    size = round(max(LEAST_S, CYCLES / frequency) / dt)
    still = [
        detrend(e[k : k + size])
        for e, m in zip(rows, predicted, strict=True)
        for k in range(0, e.size - size + 1, size)
        if np.std(detrend(m[k : k + size])) < STILL * amplitude
    ]
    if len(still) < FEWEST:
        return False
    at = frequency + np.concatenate([[0.0], BESIDE]) / (size * dt)
    at = at[(at > 0.0) & (at < 0.5 / dt)]
    turns = np.exp(-2j * np.pi * dt * np.outer(np.arange(size), at)) * np.hanning(size)[:, None]
    power = np.mean(np.abs(np.array(still) @ turns) ** 2, axis=0)
    free = 2 * len(still)
    return bool(f_distribution.sf(power[0] / np.mean(power[1:]), free, 0.5 * free * (at.size - 1)) < CHANCE)


def is_of_motion(
    rows: list[np.ndarray], predicted: list[np.ndarray], frequency: float, amplitude: float, tall: float, dt: float, *, strict: bool = False
) -> bool:
    """Whether the motion may have brought a line: the simulated rows (N,) move as much near its frequency, or a function of them has a line
    there.

    Movement alone is excused where no function of the motion has a line: if the residual's line is as `tall` (times its background) as
    `LONE_LINE`, or if it stands, in each of `SEVERAL` sessions or more, `ABOVE` times as tall in the residuals `rows` (N,) as in any
    function of the motion. A `strict` answer excuses nothing. "Near" is as far as the lines of a residual may differ from session to
    session, where periodic motions of different speed may meet.
    """
    n = min(m.size for m in predicted)
    i = round(frequency * n * dt)
    near = slice(max(i - NEAR, 0), i + NEAR + 1)
    moves = float(np.median([_amplitudes(m[:n])[near].max() for m in predicted]))
    of_motion = [[np.max(over_background(y)[near]) for y in _made_of(m[:n])] for m in predicted if np.ptp(m[:n]) > 0.0]
    heights = [np.max(over_background(e[:n])[near]) for e, m in zip(rows, predicted, strict=True) if np.ptp(m[:n]) > 0.0]
    alone = len(heights) >= SEVERAL and all(h > ABOVE * max(own) for h, own in zip(heights, of_motion, strict=True))
    excused = not strict and (tall >= LONE_LINE or alone)
    return (moves > BY_DEPTH * amplitude and not excused) or _has_line(of_motion)


def _has_line(of_motion: list[list]) -> bool:
    """Whether the same function of the motion is tall in half of the sessions or more."""
    return bool(of_motion) and bool(np.any(np.median(of_motion, axis=0) > TALL))


def over_background(e: np.ndarray) -> np.ndarray:
    """Periodogram of e (N,) over its background: its own running median, scaled to the mean of an exponential distribution."""
    n = e.size
    power = np.abs(np.fft.rfft((e - e.mean()) * np.hanning(n))) ** 2
    return power / np.maximum(median_filter(power, 101) / np.log(2.0), 1e-300)


def _made_of(force: np.ndarray) -> list[np.ndarray]:
    """Functions of a force (N,) such as curvature, contact, friction and backlash may add to it, each with a scale of its own."""
    y = force / np.max(np.abs(force))
    rate = np.gradient(y)
    way = np.tanh(rate / (SLOW * np.max(np.abs(rate))))
    return [y, y**2, y**3, y**4, np.maximum(y - 0.5, 0.0), np.abs(y - np.median(y)), rate * np.abs(rate), np.abs(rate), way, way * y]


def _amplitudes(e: np.ndarray) -> np.ndarray:
    """Amplitude of a line in each bin of e (N,)."""
    taper = np.hanning(e.size)
    return 2.0 * np.abs(np.fft.rfft((e - e.mean()) * taper)) / np.sum(taper)
