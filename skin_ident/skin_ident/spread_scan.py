"""A static spread scan: what one taxel feels when the plunger presses beside it, at several depths (as thesis Table 4-10)."""

from dataclasses import dataclass, field

import numpy as np

from skin_ident.recordings.declared import Declared
from skin_models.errors import SkinError


class SpreadScanError(SkinError):
    """A spread scan whose numbers cannot be used."""


@dataclass(frozen=True)
class SpreadScan:
    """Sensed force over depth and distance.

    depth     (D,)    m, indentation depth of each row, positive
    distance  (R,)    m, from the taxel's centre to the plunger's axis, increasing; negative on the other side
    force     (D, R)  N, sensed force, compression positive; NaN where a measurement was lost
    direction         x or y, along which the plunger was moved; empty where it is not known

    Raises `SpreadScanError` for shapes that do not match, distances that do not increase and rows with fewer than 3 forces.
    """

    depth: np.ndarray
    distance: np.ndarray
    force: np.ndarray
    name: str = "spread scan"
    direction: str = ""
    declared: Declared = field(default_factory=Declared, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("depth", "distance", "force"):
            object.__setattr__(self, name, np.array(getattr(self, name), float))
        if self.depth.ndim != 1 or self.distance.ndim != 1 or self.force.shape != (self.depth.size, self.distance.size):
            sizes = f"{self.depth.size} depths and {self.distance.size} distances"
            raise SpreadScanError(f"{self.name}: force has shape {self.force.shape}, but there are {sizes}")
        if not (self.depth.size and np.all(np.isfinite(self.depth)) and np.all(self.depth > 0.0)):
            raise SpreadScanError(f"{self.name}: every depth must be a positive number")
        if self.distance.size < 3 or not np.all(np.diff(self.distance) > 0.0):  # also false for NaN
            raise SpreadScanError(f"{self.name}: it needs 3 or more distances, increasing from column to column")
        if np.any(np.isinf(self.force)) or np.any(np.isfinite(self.force).sum(axis=1) < 3):
            raise SpreadScanError(f"{self.name}: every depth needs 3 or more finite forces")
