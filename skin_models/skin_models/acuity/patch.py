"""The numbers behind the picture: bound on the position and smallest force, over a patch."""

from dataclasses import dataclass, field

import numpy as np

from skin_models.design import Design, detectable_force, localisation_bound
from skin_models.errors import ModelError
from skin_models.layout import Layout
from skin_models.spread.kernels import Gaussian

SIDE = 121  # places along the longer side of the patch
EDGE = 0.95  # of the worst error: where the worst one inside the patch is below this, it is reported too
FELT = 1e3  # N; what needs more is not felt


@dataclass(frozen=True, eq=False)
class Patch:
    """What is designed: taxels under a skin of the spread `kernel`, noise of a reading (N), and the contact to be located (N).

    `share` of the force is what an A201 taxel right under it feels. Raises `ModelError` for a force that is not positive.
    """

    layout: Layout
    kernel: Gaussian
    noise: float
    force: float
    share: float
    name: str
    design: Design = field(init=False)  # a single row cannot tell one side from the other: it locates along x alone

    def __post_init__(self) -> None:
        if not (np.isfinite(self.force) and self.force > 0.0):
            raise ModelError(f"the contact to be located must press with a positive force in N, not {self.force}")
        flat = np.ptp(self.layout.positions[:, 1]) < 1e-9
        design = Design(self.layout, self.kernel, self.noise, self.share, along="x" if flat else "xy")
        object.__setattr__(self, "design", design)


@dataclass(frozen=True, eq=False)
class Map:
    """Error (m) and smallest force (N) at places x (X,), y (Y,), m: arrays (Y, X); and which of them are `inside`, half a pitch or more
    from the outer taxels, where the error is that of a grid without end.

    The error is infinite where it would exceed the patch, the force where it would exceed 1 kN: nothing can be told there.
    """

    x: np.ndarray
    y: np.ndarray
    error: np.ndarray
    force: np.ndarray
    inside: np.ndarray

    def sentence(self) -> str:
        """The patch in one line. The patch is what lies between the outer taxels."""
        return f"{self._located()}; forces {self._felt()}"

    def _located(self) -> str:
        told = np.isfinite(self.error)
        if not told.any():
            return "located nowhere"
        worst = f"not at all in {100 * np.mean(~told):.0f} % of them"
        if told.all():
            worst = f"{1e3 * self.error.max():.3g} mm at the worst{self._edge()}"
        return f"located to {1e3 * np.median(self.error[told]):.3g} mm in the middle of all places, {worst}"

    def _edge(self) -> str:
        """Where the worst error lies near the edge, words that say so, with the worst one inside; else empty."""
        inner = self.error[self.inside].max(initial=0.0)
        return f", near the edge ({1e3 * inner:.3g} mm away from it)" if 0.0 < inner < EDGE * self.error.max() else ""

    def _felt(self) -> str:
        felt = np.isfinite(self.force)
        anywhere = f"from {self.force.max():.3g} N at any" if felt.all() else f"none in {100 * np.mean(~felt):.0f} % of all places"
        return f"from {self.force.min():.3g} N are felt at the best place, {anywhere}"


def looked_at(patch: Patch) -> Map:
    """Both maps over the patch; a single taxel and a row get half a spread around them."""
    p, margin = patch.layout.positions[:, :2], 0.5 * patch.kernel.width
    low, high = p.min(axis=0), p.max(axis=0)
    thin = high - low < margin
    low, high = np.where(thin, low - margin, low), np.where(thin, high + margin, high)
    step = (high - low).max() / (SIDE - 1)
    x, y = (np.linspace(a, b, max(round((b - a) / step) + 1, 2)) for a, b in zip(low, high, strict=True))
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    shape = (y.size, x.size)
    error = localisation_bound(patch.design, places, patch.force).reshape(shape)
    force = detectable_force(patch.design, places).reshape(shape)
    from_edge = [np.inf * np.ones(u.size) if t else np.minimum(u - a, b - u) for u, a, b, t in zip((x, y), low, high, thin, strict=True)]
    inside = np.minimum(from_edge[0], from_edge[1][:, None]) >= 0.5 * patch.layout.pitch
    error, force = (np.where(values < most, values, np.inf) for values, most in ((error, np.hypot(*(high - low))), (force, FELT)))
    return Map(x, y, error, force, inside)
