"""Zeros of many growing functions at once: secants, kept within a bracket."""

from collections.abc import Callable

import numpy as np

ROUNDS = 200
ALIKE = 1e-10  # of `size`: a value that counts as zero
PATIENCE = 3  # rounds in which secants must have halved the bracket
FAR = 1e9  # no upper end yet
NARROW = 1e-13  # relative: a bracket that holds a jump, not a zero


def growing_root(
    f: Callable[[np.ndarray], np.ndarray], low: np.ndarray, start: np.ndarray, slope: np.ndarray, size: np.ndarray, highest: float
) -> tuple[np.ndarray, np.ndarray]:
    """x (C,) with f(x) = 0, and the slopes (C,) there, for f: (C,) -> (C,) that grows with x from -`size` at `low`, or is flat at first.

    The search goes from `start` along `slope`, then along secants. A step that would leave the bracket found so far goes to its middle, and
    one from where f is still flat is at least twice as long as the way from `low`. Where f jumps across zero, x is the place just below the
    jump; where f stays negative beyond `highest`, x is the first place tried there. The last call of `f` is the one at the x returned.
    """
    value = f(start)
    shot = start - value / slope
    if not (shot > low).all():
        return _search(f, low, start, value, slope, size, highest)
    found = f(shot)
    if (np.abs(found) <= ALIKE * size).all():  # most often the slope is that of the last sample, and this is all
        return shot, slope
    return _search(f, low, shot, found, slope, size, highest)


def _search(f: Callable, low, x, value, slope, size: np.ndarray, highest: float) -> tuple[np.ndarray, np.ndarray]:
    """The same from `x` with f(x) = `value`, for functions that bend or jump."""
    high, width = np.full(x.shape, FAR), FAR
    for i in range(ROUNDS):
        below = value < 0.0
        low, high, reach = np.where(below, np.maximum(low, x), low), np.where(below, high, np.minimum(high, x)), x - low
        done = (np.abs(value) <= ALIKE * size) | (below & (x > highest))
        if done.all():
            break
        trial = _secant(x, value, slope, low, high, np.where(below & (value <= -size), 2.0 * reach, 0.0))
        if i % PATIENCE == PATIENCE - 1:  # where secants have not halved the bracket by now, its middle does
            trial = np.where((high - low > 0.5 * width) & (high < FAR), 0.5 * (low + high), trial)
            width = high - low
        trial = np.where(done, x, np.where(high - low <= NARROW * high, low, trial))
        if np.array_equal(trial, x):
            break
        last, before = x, value
        x, value = trial, f(trial)
        moved = x != last
        secant = (value - before) / np.where(moved, x - last, 1.0)
        slope = np.where(moved & (secant > 0.0), secant, slope)
    return x, slope


def _secant(x: np.ndarray, value: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray, least: np.ndarray) -> np.ndarray:
    """The secant's zero where it lies inside the bracket, else its middle; `least` is the shortest step upwards."""
    trial = np.where(least > 0.0, x + np.maximum(-value / slope, least), x - value / slope)
    inside = (trial > low) & (trial < high)
    return np.where(inside, trial, np.where(high < FAR, 0.5 * (low + high), 2.0 * x + 1e-9))
