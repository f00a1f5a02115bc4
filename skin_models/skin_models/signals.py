"""What an effect may look at: time and the motion of the plunger, sampled at one rate."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from skin_models.arrays import numbers
from skin_models.errors import ModelError

if TYPE_CHECKING:
    from skin_models.spread.footprint import Footprint

GRAVITY = 9.80665  # m/s^2, standard acceleration of free fall
DEEPEST = 0.1  # m; no skin is as thick, so a greater depth is most likely one in mm
KEPT, ROOM = 12, 400_000  # greatest number of cached results of one kind; and of samples in all of these together


@dataclass(frozen=True)
class Sample:
    """One instant: time (s), indentation depth (m, positive into the skin, zero at the surface), speed (m/s), acceleration (m/s^2).

    `lateral` (2,): where on the skin the contact is, m, from the place to which the model's shares belong; None: there. `footprint`: where
    the taxels lie under it; a model that knows their positions sets it.
    """

    t: float
    x: float
    v: float
    a: float
    lateral: np.ndarray | None = None
    footprint: Optional["Footprint"] = None


@dataclass(frozen=True)
class Motion:
    """A whole recording of the above: arrays of shape (N,), evenly sampled every `dt` seconds.

    `pressed`: the force on the skin was prescribed, and the depth follows from it; there is then no contact to be made or lost.
    `lateral` (2, N) and `footprint` as in a sample.
    """

    t: np.ndarray
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    dt: float
    pressed: bool = False
    lateral: np.ndarray | None = None
    footprint: Optional["Footprint"] = None
    memory: dict[str, dict[Hashable, Any]] = field(init=False, repr=False, compare=False, default_factory=dict)  # see `once`

    def __len__(self) -> int:
        return self.t.size

    def __getitem__(self, i: int) -> Sample:
        lateral = None if self.lateral is None else self.lateral[:, i]
        return Sample(self.t[i], self.x[i], self.v[i], self.a[i], lateral, self.footprint and self.footprint.at(i))

    def once(self, kind: str, key: Hashable, work: Callable[[], Any]) -> Any:
        """The result of `work` for these samples, cached: the latest results of each `kind` are kept by their `key`.

        A fit asks for the same ones again and again while other parameters change. A result must not be changed in place.
        """
        known = self.memory.setdefault(kind, {})
        known[key] = answer = known.pop(key) if key in known else work()
        if len(known) > max(1, min(KEPT, ROOM // len(self))):
            del known[next(iter(known))]
        return answer

    def at_depth(self, x: np.ndarray) -> "Motion":
        """The same instants at another depth. The speed changes by the backward difference of the shift, as it does sample by sample."""
        if x is self.x:
            return self
        shift = x - self.x
        return replace(self, x=x, v=self.v + np.diff(shift, prepend=shift[0]) / self.dt)


def motion(t, x, v=None, a=None) -> Motion:
    """A `Motion` from samples; speed and acceleration are central differences of the depth unless they are known.

    Raises `ModelError` where the samples are not finite, not evenly spaced (0.1 % of the period), fewer than three or of unlike number.
    """
    t, x = numbers(t, "times of a motion"), numbers(x, "depths of a motion")
    if t.ndim != 1 or t.shape != x.shape or t.size < 3:
        raise ModelError(f"a motion needs matching time and depth of at least 3 samples, not {t.shape} and {x.shape}")
    dt = (t[-1] - t[0]) / (t.size - 1)
    if not (dt > 0 and np.all(np.isfinite(x)) and np.max(np.abs(np.diff(t) - dt)) <= 1e-3 * dt):
        raise ModelError("a motion must be finite and evenly sampled: resample the recording first")
    v = _rate_of(x, v, dt)
    return Motion(t, x, v, _rate_of(v, a, dt), dt)


def _rate_of(y: np.ndarray, known: Any, dt: float) -> np.ndarray:
    """The rate of change of `y`: the one that is known, or central differences."""
    if known is None:
        return np.gradient(y, dt)
    known = numbers(known, "speed and acceleration")
    if known.shape != y.shape or not np.isfinite(known).all():
        raise ModelError(f"speed and acceleration must be finite and as many as the {y.size} depths")
    return known
