"""Which skin lies on the rig: two Kelvin-Voigt branches side by side, the taxel's and the one that leads past it."""

from dataclasses import dataclass

import numpy as np

# thickness mm: k1, b1, k2, b2 (N/m, N s/m), mass kg, depth limit m, spread width m. Thesis Table 4-5, section 4.3.2, Table 4-8.
SILICONE = {
    2: (25042.0, 1330.0, 1603.0, 590.2, 0.000216, 0.00030, 0.0046),
    4: (9619.0, 939.5, 2766.0, 629.2, 0.000432, 0.00100, 0.00525),
    6: (4338.0, 248.6, 5600.0, 758.3, 0.000648, 0.00150, 0.0060),
}
CALIBRATION = (9.408, 13.75, 10.34, 13.51)  # N/V of four taxels, thesis Table 3-1


@dataclass(frozen=True)
class Specimen:
    """One piece of skin with its taxels. `positions` (n, 2) in m, relative to the plunger's axis; `width` is c of exp(-(r/c)^2)."""

    thickness_mm: int
    k1: float
    b1: float
    k2: float
    b2: float
    mass: float
    depth_max: float
    width: float
    positions: np.ndarray
    slopes: np.ndarray

    @property
    def stiffness(self) -> float:
        return self.k1 + self.k2

    @property
    def damping(self) -> float:
        return self.b1 + self.b2

    @property
    def fraction(self) -> float:
        """Part of an added skin force that goes to a taxel under the plunger."""
        return self.k1 / (self.k1 + self.k2)

    def shares(self, shift=(0.0, 0.0)) -> np.ndarray:
        """Part of the taxel branch that each taxel carries with the plunger off by `shift` (m)."""
        away = np.hypot(*(self.positions - np.asarray(shift)).T)
        return np.exp(-((away / self.width) ** 2))


def draw_specimen(rng, thickness_mm=None, n_taxels=1, layout=None, variation=0.08) -> Specimen:
    """A unit off the shelf: parameters of the thesis with log-normal unit-to-unit variation."""
    thickness_mm = int(thickness_mm or rng.choice(list(SILICONE)))
    k1, b1, k2, b2, mass, deep, width = SILICONE[thickness_mm]
    k1, b1, k2, b2 = np.array([k1, b1, k2, b2]) * np.exp(variation * rng.standard_normal(4))
    places = _positions(rng, n_taxels, layout or rng.choice(["row_14mm", "row_5mm", "aside"]))
    slopes = rng.choice(CALIBRATION, n_taxels) * (1 + 0.02 * rng.standard_normal(n_taxels))
    return Specimen(thickness_mm, k1, b1, k2, b2, mass, deep, width, places, slopes)


def _positions(rng, n_taxels, layout) -> np.ndarray:
    if n_taxels == 1:
        return np.zeros((1, 2))
    pitch = 0.014 if layout == "row_14mm" else 0.005
    # taxel_0 is among those that feel the plunger: right on it all others of a wide row would be silent
    row = (np.arange(n_taxels) - rng.uniform(0.35, 0.6 if layout == "row_14mm" else 1.2)) * pitch
    aside = rng.uniform(0.001, 0.003) if layout == "aside" else 0.0
    return np.round(np.column_stack([row, np.full(n_taxels, aside)]), 5)
