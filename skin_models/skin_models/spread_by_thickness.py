"""An estimate of how wide silicone spreads a force at thicknesses where nobody measured it, from other numbers of the thesis.

The width c of the spread was scanned at 4 mm alone (section 4.3.4, 5.25 mm). A taxel of 9.53 mm under a plunger of 9.9 mm senses the
overlap of two even discs: without any spread in the skin, a Gaussian fitted to that overlap has 5.19 mm. So hardly a millimetre of width is
the skin's own, and c cannot be less than that of the discs at any thickness. There are two ways to estimate c at another thickness:

    share     the share of the force that misses the taxel right under the plunger, k2 / (k1 + k2), was measured at 2, 4 and 6 mm. The
              skin's own Gaussian is the one that gives this share when seen through both discs. At 4 mm it gives c = 5.55 mm.
    layer     an elastic layer has no other length than its thickness: the skin's own width, found from the scan, grows in proportion.

The value takes from the share how the own width grows with thickness, and from the scan how large it is at 4 mm. Its standard deviation
combines that of the scan (over the depths of Table 4-8), that of the measured stiffnesses, and half the difference between the two ways.
These part beyond 4 mm: at 6 mm they give 7.3 and 5.3 mm, and the value is 5.6 mm.

Frubber's 4.17 mm is narrower than the discs themselves and follows from neither: something swallows small forces there, as a dead zone does
(section 4.3.4 sees only noise at 1 mm). No estimate is given for other thicknesses of Frubber.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.optimize import curve_fit

from skin_models.errors import ModelError
from skin_models.layout import A201_AREA, A201_DIAMETER
from skin_models.materials import Material, material, silicone
from skin_models.spread.finite import Finite
from skin_models.spread.kernels import Gaussian
from skin_models.thesis.tables import table

PLUNGER_DIAMETER = 9.9e-3  # m, thesis section 3.3.3
SCANNED = "silicone_4mm"
DISTANCES = 1e-3 * np.array([0.0, 1.0, *range(3, 13)])  # m, of the scan, Table 4-10
OWN_WIDTHS = 1e-3 * np.array([0.25, 0.4, 0.6, 0.8, 1.0, 1.3, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.5, 8.5, 11.0, 15.0, 20.0, 30.0])  # m


@dataclass(frozen=True)
class Width:
    """c of the spread, m, with its standard deviation, and what either way of estimating it gives."""

    value: float
    std: float
    by_share: float
    by_layer: float


def silicone_spread(thickness: float, extrapolate: bool = False) -> Width:
    """c of silicone of any thickness (m) under the thesis's plunger and taxel; see the module for how.

    Raises `ModelError` at any other thickness than 4 mm unless `extrapolate`, and in any case where `silicone` has nothing to say.
    """
    scanned = material(SCANNED)
    if math.isclose(thickness, scanned.thickness, rel_tol=1e-3):
        return Width(scanned.spread_width, _scan_std(), scanned.spread_width, scanned.spread_width)
    skin = silicone(thickness, extrapolate)
    if not extrapolate:
        raise ModelError(
            f"the spread of silicone was measured at 4 mm, not at {thickness * 1e3:g} mm: pass extrapolate=True to estimate it from "
            "the force that misses the taxel"
        )
    share, spread = _share(skin), _share_std(skin)
    low, value, high = (_seen(_own_by_share(p) * _scale(scanned)) for p in (share + spread, share, share - spread))
    by_share, by_layer = _seen(_own_by_share(share)), _seen(_own(scanned.spread_width) * thickness / scanned.thickness)
    return Width(value, math.hypot(_scan_std(), (high - low) / 2.0, (by_share - by_layer) / 2.0), by_share, by_layer)


def with_spread(skin: Material) -> Material:
    """The material of silicone with its estimated spread, in the notes of its model too, so that a patch of skin uses it."""
    width = silicone_spread(skin.thickness, extrapolate=True).value
    notes = {**skin.model.notes, "spread_width": {"value": width, "unit": "m"}}
    return replace(skin, spread_width=width, model=replace(skin.model, notes=notes))


def _scan_std() -> float:
    """Standard deviation of c over the depths from 0.4 mm on, m."""
    return 1e-3 * float(np.std([cell.value for cell in table("4-8").column("c")[3:]], ddof=1))


def _share(skin: Material) -> float:
    return skin.model.dispersion.sensed_share


def _share_std(skin: Material) -> float:
    """Of k1 / (k1 + k2), from the two stiffnesses."""
    d, share = skin.model.dispersion, _share(skin)
    return share * (1.0 - share) * math.hypot(skin.std["k1"] / d.k1, skin.std["k2"] / d.k2)


@lru_cache(maxsize=1)
def _through_discs() -> tuple[np.ndarray, np.ndarray]:
    """For every own width: the share that reaches the taxel under the plunger, and the c that a scan would fit, m."""
    found = []
    for own in OWN_WIDTHS:
        kernel = Finite(Gaussian(width=float(own)), A201_DIAMETER / 2.0, PLUNGER_DIAMETER / 2.0)
        found.append((A201_AREA / kernel.area, _fitted(kernel)))
    share, seen = np.array(found).T
    return share, seen


def _fitted(kernel: Finite) -> float:
    """c of a Gaussian with free height, fitted as the thesis did."""
    shape = kernel.shape(DISTANCES)
    (_, c), _ = curve_fit(lambda r, a, c: a * np.exp(-((r / c) ** 2)), DISTANCES, shape, p0=(1.0, 5e-3))
    return abs(float(c))


def _own_by_share(share: float) -> float:
    """The own width (m) at which this share reaches the taxel; the least of the table where even the discs alone pass less."""
    return float(np.interp(share, _through_discs()[0][::-1], OWN_WIDTHS[::-1]))


def _scale(scanned: Material) -> float:
    """Ratio of the own width found from the scan to that found from the share, at the scanned thickness."""
    return _own(scanned.spread_width) / _own_by_share(_share(scanned))


def _seen(own: float) -> float:
    return float(np.interp(own, OWN_WIDTHS, _through_discs()[1]))


def _own(seen: float) -> float:
    return float(np.interp(seen, _through_discs()[1], OWN_WIDTHS))
