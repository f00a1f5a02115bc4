"""Whether what a fit leaves in contact is noise. In the air no model is asked for, so what it leaves there is noise alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.figures import figures
from skin_ident.estimators.regression import Block, Regression
from skin_ident.recordings.levels import steps_of

LACKS = 5.0  # times the noise: coarse depths and fast turns alone leave up to 3 times the noise of a sound rig
AIR = 1e-6  # share of the greatest depth up to which low-passed rows are of free air
EXACT = 1e-6  # share of what was measured below which there is no noise: made, not measured
FEWEST = 50  # rows that there must be in the air, and in contact


@dataclass(frozen=True)
class LeftOver:
    """RMS (N) of what a fit leaves in one channel: in contact, and as noise."""

    channel: str
    contact: float
    noise: float

    @property
    def times(self) -> float:
        """Contact over noise."""
        return self.contact / self.noise

    @property
    def lacking(self) -> bool:
        """Whether it is far more than noise."""
        return self.times > LACKS

    @property
    def words(self) -> str:
        """Its size, in words."""
        said = f"what is left of {self.channel} in contact, {figures(self.contact)} N rms, is {self.times:.0f} times the noise"
        return f"{said} ({figures(self.noise)} N, in the air)"


def left_over(
    names: Sequence[str], regression: Regression, blocks: Sequence[Sequence[Block]], raw: Sequence[Sequence[np.ndarray]], depth: int
) -> LeftOver | None:
    """The channel whose residual exceeds its noise most; None where too little was recorded in the air to know the noise.

    `raw` are the readings of every channel at full rate, by session: noise below the steps of a converter is not seen in the air. The
    column `depth` of the first channel's blocks is zero there. Visits to the air that are shorter than the low-pass are looked at before
    it, where the noise is larger.
    """
    for narrow in (True, False):
        air = _in_the_air([_rows(b, narrow)[1][:, depth] for b in blocks[0]])
        if min(sum(a.sum() for a in air), sum((~a).sum() for a in air)) >= FEWEST:
            each = zip(names, blocks, regression.coefficients, raw, strict=True)
            found = [_channel(name, [_rows(b, narrow) for b in own], c, air, y) for name, own, c, y in each]
            return max(filter(None, found), key=lambda f: f.times, default=None)
    return None


def _rows(block: Block, narrow: bool) -> tuple[np.ndarray, np.ndarray]:
    return block.narrow if narrow else (block.y, block.columns)


def _in_the_air(depths: Sequence[np.ndarray]) -> list[np.ndarray]:
    """A mask (n,) of every session's rows in which no sample is of contact."""
    least = AIR * max(float(np.abs(x).max()) for x in depths)
    return [np.abs(x) <= least for x in depths]


def _channel(name: str, rows: Sequence[tuple[np.ndarray, np.ndarray]], c: np.ndarray, air: Sequence[np.ndarray], raw) -> LeftOver | None:
    """What is left of a channel with coefficients `c`; None for one without noise. A model that has memory may leave more in the air than
    was measured there."""
    measured, left = [y for y, _ in rows], [y - h @ c for y, h in rows]
    noise = max(min(_noise(left, air), _noise(measured, air)), _rounding(raw))
    return LeftOver(name, _rms([e[~a] for e, a in zip(left, air, strict=True)]), noise) if noise > EXACT * _rms(measured) else None


def _noise(rows: Sequence[np.ndarray], air: Sequence[np.ndarray]) -> float:
    """RMS in the air about the zero of every session."""
    free = [e[a] for e, a in zip(rows, air, strict=True) if a.any()]
    return _rms([e - e.mean() for e in free])


def _rounding(raw: Sequence[np.ndarray]) -> float:
    """RMS of rounding to a converter's steps; 0 where there are none."""
    return max(steps_of(np.array([y]))[0] for y in raw) / 12.0**0.5


def _rms(parts: Sequence[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.square(np.concatenate(parts)))))
