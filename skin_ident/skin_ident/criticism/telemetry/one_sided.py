"""Spikes to one side: an electrode that discharges, a contact that opens for one sample. They need not reach beyond the noise.

Symmetric noise jumps as often up and back as down and back. Where nearly all excursions beyond a level are to one side, by far more than
chance, something is added to the noise. Skewed noise has more of them to one side, too, but the more the lower the level is. Spikes are
few, and a lower level adds none.
"""

import numpy as np
from scipy.stats import binom

from skin_ident.criticism.telemetry.excursions import excursions
from skin_ident.criticism.telemetry.tails import TAIL_CHANCE
from skin_ident.stretches import runs, without

LEVELS = (0.5, 0.7, 1.0)  # shares of the noise's reach, at which excursions are counted by side
LOWER = 2.0**-0.5  # ratio of the lower level to which each is compared
FEW = 0.1  # largest ratio of the excursions to the other side
SAME = 1.7  # largest ratio of the surplus at the lower level to that at the level


def one_sided(e: list[np.ndarray], y: list[np.ndarray], limit: float) -> list[np.ndarray] | None:
    """Masks (N,) of the excursions to one side in residuals `e` [(N,), …] of measurements `y`, where noise has none such; else None.
    `limit` is how far noise reaches."""
    for level in (share * limit for share in LEVELS):
        far = [excursions(a, b, level) for a, b in zip(e, y, strict=True)]
        up, down = _by_side(e, far)
        more, fewer = max(up, down), min(up, down)
        if fewer > FEW * more or binom.sf(more - 1, more + fewer, 0.5) > TAIL_CHANCE:
            continue
        lower = _by_side(e, [excursions(a, b, LOWER * level) for a, b in zip(e, y, strict=True)])
        if abs(lower[0] - lower[1]) <= SAME * (more - fewer):
            return [_to(1.0 if up > down else -1.0, f, row) for f, row in zip(far, e, strict=True)]
    return None


def _to(side: float, far: np.ndarray, row: np.ndarray) -> np.ndarray:
    return without(far, lambda a, _: side * (row[a] - row[a - 1]) < 0.0)


def _by_side(e: list[np.ndarray], far: list[np.ndarray]) -> tuple[int, int]:
    """How many excursions `far` go up and how many down."""
    rises = np.concatenate([row[begin] - row[begin - 1] for row, begin in zip(e, (runs(f)[0] for f in far), strict=True)])
    return int(np.sum(rises > 0.0)), int(np.sum(rises < 0.0))
