"""How large a hidden effect is: what the plain two-branch model cannot absorb of it, over the noise."""

import numpy as np


def visible(record, base, every):
    """What is left (N) of force (T,) and taxels (T, n) after a least-squares fit of the plain model, each channel with its own numbers.

    `base`: the bare skin pressed along what the encoder says, on a grid `every` times as fine as the samples.
    """
    u, w, on, use = _sampled(base, every)
    return _left(record.force, on * u, on * w, use), np.column_stack([_left(y, u, w, use) for y in record.taxels.T])


def visible_in_array(record, base, every, shares):
    """The same for the taxels with one stiffness and damping for all, spread as declared."""
    u, w, _, use = _sampled(base, every)
    n, share = shares.size, np.repeat(shares, u.size)
    left = _left(record.taxels.T.ravel(), share * np.tile(u, n), share * np.tile(w, n), np.tile(use, n))
    return np.zeros(u.size), left.reshape(n, -1).T


def added(wrong, sound, clean, stiffness):
    """What a wrong record has of error beyond a sound one, as `visible` has it: errors of force and depth, the latter by `stiffness` (N/m),
    and of taxels, each as the RMS of the excess. A step that is a thousandth coarser rounds otherwise, and adds nothing.
    """
    force, taxels = zip(*(_errors(r, clean, stiffness) for r in (wrong, sound)), strict=True)
    return _excess(*force), _excess(*taxels)


def _errors(record, clean, stiffness):
    return record.force - clean.force + stiffness * (record.x - clean.x), record.taxels - clean.taxels


def _excess(wrong, sound):
    return np.sqrt(np.maximum(np.mean(wrong**2, axis=0) - np.mean(sound**2, axis=0), 0.0))[None]


def _sampled(base, every):
    """Surface depth, speed, contact, and the samples that count: those next to a touchdown depend on its place between samples."""
    touching = base.touching[::every]
    down = np.flatnonzero(np.diff(touching.astype(int)) > 0)
    use = np.ones(touching.size, bool)
    for shift in (-1, 0, 1, 2):
        use[np.clip(down + shift, 0, use.size - 1)] = False
    return base.u[::every], base.w[::every], touching, use


def _left(y, u, w, use):
    """Residual of y on u and w, 0 where samples do not count."""
    columns = np.column_stack([u, w]) * use[:, None]
    scale = np.sqrt(np.mean(columns**2, 0)) + 1e-15
    y = y * use
    return y - columns @ (np.linalg.lstsq(columns / scale, y, rcond=None)[0] / scale)


def rms(y, axis=0):
    """Root mean square."""
    return np.sqrt(np.mean(np.square(y), axis=axis))


def find_amplitude(size_at, wanted, tries=9, tolerance=0.05, limit=float("inf")):
    """The amplitude with size_at(a) = wanted: secants in the logarithm, kept inside what is bracketed; the nearest if out of reach."""
    tried = []
    for _ in range(tries):
        a = min(_next(tried), limit) if tried else 1.0
        if any(a == before for before, _ in tried):
            break
        miss = float(np.log(max(size_at(a), 1e-6) / wanted))
        tried.append((a, miss))
        if abs(miss) < tolerance:
            break
    return min(tried, key=lambda pair: abs(pair[1]))[0]


def _next(tried):
    below = max((np.log(a) for a, miss in tried if miss < 0), default=-np.inf)
    above = min((np.log(a) for a, miss in tried if miss > 0), default=np.inf)
    a, miss = np.log(tried[-1][0]), tried[-1][1]
    slope = 1.0
    if len(tried) > 1 and tried[-2][0] != tried[-1][0]:
        slope = np.clip((miss - tried[-2][1]) / (a - np.log(tried[-2][0])), 0.4, 5.0)
    guess = a + float(np.clip(-miss / slope, -1.5, 1.5))
    if below < above and not below < guess < above:
        guess = 0.5 * (below + above) if np.isfinite(below + above) else guess
    return float(np.exp(guess))
