"""A printed result beside the same result recomputed from the printed data it came from."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from skin_models.thesis.printed import Printed, halves, values


@dataclass(frozen=True)
class Disagreement:
    """An entry that does not follow from the data printed beside it."""

    table: str
    entry: str
    printed: str
    recomputed: str
    why: str
    within_rounding: bool  # the printed digits of the data leave room for the printed result


@dataclass(frozen=True)
class Comparison:
    """`slack` is how far the recomputed value can move while its inputs still round to their printed digits."""

    table: str
    entry: str
    printed: Printed
    recomputed: float
    slack: float
    note: str = ""

    @property
    def agrees(self) -> bool:
        """The recomputed value rounds to the printed digits."""
        return self.printed.agrees(self.recomputed)

    @property
    def within_rounding(self) -> bool:
        """Data that round to the printed ones can give the printed result."""
        return self.printed.agrees(self.recomputed, self.slack)

    def disagreement(self) -> Disagreement:
        """What to tell about an entry that does not agree."""
        if self.within_rounding:
            why = f"its inputs are printed rounded, which alone moves the result by up to {self.slack:.2g}"
        else:
            why = self.note or f"not explained: rounding of its inputs moves the result by {self.slack:.2g} at most"
        return Disagreement(self.table, self.entry, str(self.printed), f"{self.recomputed:.6g}", why, self.within_rounding)


def compare(
    table: str, entry: str, printed: Printed, function: Callable[[np.ndarray], float], inputs: list[Printed], note: str = ""
) -> Comparison:
    """Recompute a printed result as `function(inputs)`.

    The slack is the first-order worst case, sum over the inputs of |f(x + h_i) - f(x)| with h_i half a unit of the last digit.
    """
    x, h = values(inputs), halves(inputs)
    value = function(x)
    slack = sum(abs(function(x + step) - value) for step in np.diag(h))
    return Comparison(table, entry, printed, float(value), float(slack), note)


def disagreements_of(comparisons: Iterable[Comparison]) -> list[Disagreement]:
    """Those that do not agree."""
    return [c.disagreement() for c in comparisons if not c.agrees]
