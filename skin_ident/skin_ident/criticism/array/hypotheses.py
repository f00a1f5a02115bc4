"""What could be wrong with the shares, with prior probabilities and sizes.

Beside every cause stands a background that nobody is to blame for: small errors of calibrations, stiffness that varies over the skin, and a
width that is only roughly known from the thickness of the skin. Each is a mixture of a narrow and a wide distribution. So shares that agree
with the declaration to a fraction of a per cent do not leave room for an error of several per cent, and shares that scatter do.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from skin_ident.criticism.array.family import IN_ORDER
from skin_ident.criticism.array.layout import MEASURED_AT, Layout
from skin_ident.criticism.vocabulary import Key

# Relative error of calibrations where none is declared: pairs of standard deviation and prior probability.
SCATTER = ((0.002, 0.9), (0.01, 0.05), (0.03, 0.05))
# Relative difference of the skin's stiffness between sessions, at one place or several: the same pairs.
PLACES = ((0.002, 0.5), (0.02, 0.5))
EXACT, ROUGH = 0.01, 0.15  # relative standard deviation of a width that is known, and of one that is only expected
# Usual size of each cause: prior standard deviations, the shift in m, the others relative.
SHIFT, GAIN, LEAK, COMMON = 1e-3, 0.15, 0.05, 0.1
REPEAT, WIDTH, POWER, RATIO = 0.06, 0.2, 0.5, 0.2
TAIL, FALL = 0.2, 0.3
AXIS = 0.05  # rad
CHANGE = 0.1  # prior probability that the gain of some taxel is not the same in all sessions


@dataclass(frozen=True)
class Hypothesis:
    """A cause at a place, its prior probability, and prior standard deviations of the entries that it sets free."""

    cause: str
    where: str
    prior: float
    free: dict[str, float]

    @property
    def key(self) -> Key:
        """Cause and place."""
        return self.cause, self.where


NOTHING = Hypothesis("", "", 0.5, {})


@dataclass(frozen=True)
class Background:
    """One component of the background mixture: its probability `weight`, and relative standard deviations of calibrations, of the width,
    and of the skin's stiffness from session to session."""

    weight: float
    scatter: float
    width: float
    places: float

    @property
    def at_one_level(self) -> bool:
        """Whether the skin is taken to be equally stiff in all sessions."""
        return self.places == PLACES[0][0]

    @property
    def alone(self) -> dict[str, float]:
        """Prior standard deviations of what is free, beside the calibrations, where nothing is wrong."""
        return {"width": self.width, "scale": self.places}

    def and_with(self, *several: Hypothesis) -> dict[str, float]:
        """Prior standard deviations of everything that is free under one or several hypotheses, beside the calibrations."""
        free = {name: std for h in several for name, std in h.free.items()}
        return {**self.alone, **{name: float(np.hypot(std, self.width * (name == "width"))) for name, std in free.items()}}


def hypotheses(layout: Layout, suspects: list[int], repeats: list[str]) -> tuple[Hypothesis, ...]:
    """Every cause that this layout can show. `suspects` are taxels that may have a gain error, `repeats` pairs of which one taxel may
    repeat the other (`repeat_3_2`)."""
    n = len(layout.taxels)
    shifts = {f"shift_{a}": SHIFT for a in range(len(layout.axes))}
    listed = [Hypothesis("off_centre", "rig", 0.15, shifts)]
    listed += [Hypothesis("gain_error", f"taxel_{i}", 0.15 / n, {f"gain_{i}": GAIN}) for i in suspects]
    listed += [Hypothesis("crosstalk", "taxel", 0.05, {"leak": LEAK}), Hypothesis("crosstalk", "taxel", 0.05, {"common": COMMON})]
    listed += [Hypothesis("crosstalk", "taxel", 0.02, {name: LEAK}) for name in IN_ORDER]
    listed += [Hypothesis("crosstalk", f"taxel_{r.split('_')[1]}", 0.1 / (n * (n - 1)), {r: REPEAT}) for r in repeats]
    listed += [Hypothesis("spread_shape", "skin", 0.015, free) for free in ({"power": POWER}, {"tail": TAIL, "fall": FALL})]
    if layout.width_declared:
        listed.append(Hypothesis("spread_width", "skin", 0.05, {"width": WIDTH}))
    if layout.several_contacts and len(layout.axes) > 1:
        listed.append(Hypothesis("off_centre", "rig", 0.05, {**shifts, "axis": AXIS}))
    if len(layout.axes) > 1:
        listed += [Hypothesis("anisotropy", "skin", 0.01, free) for free in ({"ratio": RATIO}, {"ratio": RATIO, "turn": RATIO})]
    return tuple(listed)


def backgrounds(layout: Layout, thickness_mm: float | None) -> Iterator[Background]:
    """The components of the mixture: all combinations of calibration error, width and stiffness."""
    scatter = SCATTER if layout.gain_std is None else ((layout.gain_std, 1.0),)
    for (gain, w), (width, v), (places, u) in product(scatter, _widths(layout, thickness_mm), PLACES):
        yield Background(w * v * u, gain, width, places)


def _widths(layout: Layout, thickness_mm: float | None) -> tuple[tuple[float, float], ...]:
    if layout.width_declared:
        return ((EXACT, 1.0),)
    return ((EXACT, 0.5), (ROUGH, 0.5)) if thickness_mm in (None, MEASURED_AT) else ((ROUGH, 1.0),)
