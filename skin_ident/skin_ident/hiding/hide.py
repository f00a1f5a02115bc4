"""Hide one effect in recordings, at a size given in units of their own noise.

The size is the RMS of the visible change over the RMS of the noise, in the common band and in the channel where this ratio is largest. The
visible change is the part that the model's own parameters cannot imitate. Where they imitate more than nine tenths, as for the gain of a
lone taxel, the whole change is taken instead, and the truth says so.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.baseline.residual import stiffness
from skin_ident.criticism.sessions.session import stacked
from skin_ident.criticism.vocabulary import word_of
from skin_ident.hiding.apply import applied, changed
from skin_ident.hiding.drawing import ANYTHING, draw, scaled
from skin_ident.hiding.errors import HidingError
from skin_ident.hiding.ground import Ground, ground, rms
from skin_ident.recordings.recording import Recording
from skin_models.effect import Effect
from skin_models.parameter import parameters_of

IMITATED = 0.1  # where less than this share of the change is visible, the whole change is measured
REACHED = 0.9  # the size reached must be between this share of the size asked for and its inverse
PRECISE = 0.01  # relative tolerance of the bisection for the amplitude
DRAWS = 30  # effects that are drawn before hiding fails
FACTOR = 1e4  # an effect is scaled by about this factor at most, up or down


@dataclass(frozen=True)
class Hidden:
    """The truth about a hidden effect. `change` and `visible` are RMS over noise by channel: of the whole change, and of the part that the
    model cannot imitate."""

    effect: Effect
    size: float
    seed: int
    change: dict[str, float]
    visible: dict[str, float]

    @property
    def hardly_seen(self) -> str:
        """Where the model's own parameters imitate nearly all of it, a sentence saying how little can be seen, and why; else empty."""
        if not self.imitated:
            return ""
        return (
            f"of its {self.size:.3g} times the noise only {max(self.visible.values()):.2g} can be seen in these recordings: a fit takes up "
            "the rest with the model's own parameters, so that nobody may be able to find it"
        )

    @property
    def where(self) -> str:
        """Its place in the words of findings."""
        return word_of(self.effect.where)

    @property
    def imitated(self) -> bool:
        """Whether the model's own parameters can imitate nearly all of it, so that nobody can find it in these recordings."""
        return max(self.visible.values()) < IMITATED * max(self.change.values())

    def as_dict(self) -> dict:
        """The content of truth.json."""
        parameters = {p.name: {"value": p.value, "unit": p.unit} for p in parameters_of(self.effect)}
        return {
            "cause": self.effect.cause,
            "where": self.where,
            "form": self.effect.form,
            "parameters": parameters,
            "size": self.size,
            "seed": self.seed,
            "change_over_noise": self.change,
            "visible_over_noise": self.visible,
        }


def hide(
    recordings: list[Recording], cause: str = ANYTHING, where: str = ANYTHING, size: float = 1.0, seed: int = 0, on: Ground | None = None
) -> tuple[list[Recording], Hidden]:
    """The recordings with an effect hidden in them, and the truth. `on`, where given, is their `ground`, which then need not be computed.

    Raises `HidingError` for a cause that the recordings cannot carry, or not at that size.
    """
    check_size(size)
    on = on or ground(recordings)
    rng = np.random.default_rng([seed, 5])
    for _ in range(DRAWS):
        found = _sized(draw(on.sessions[0], cause, where, rng), size, seed, on)
        if found is not None:
            pairs = zip(on.recordings, on.sessions, strict=True)
            return [applied(found.effect, r, s, on.model, seed + i) for i, (r, s) in enumerate(pairs)], found
    what = "none of the causes drawn can" if cause == ANYTHING else f"{cause}{'' if where == ANYTHING else f' in {where}'} cannot"
    raise HidingError(f"{what} be made {size:g} times as large as the noise of these recordings, within what is physically possible")


def check_size(size: float) -> None:
    """Raises `HidingError` for a size that is not positive or is too large."""
    if not 0.0 < size < 1e4:
        raise HidingError(f"a size is positive and below 10000, in units of the noise, not {size:g}")


def _sized(effect: Effect, size: float, seed: int, on: Ground) -> Hidden | None:
    """The effect scaled to `size` on the first recording; None where its bounds or the motion do not let it become so large."""
    change, visible = _measure(effect, seed, on)
    whole = bool(visible.max() < IMITATED * change.max())

    def at(times: float) -> float:
        every, left = _measure(scaled(effect, times), seed, on)
        return float((every if whole else left).max())

    fixed = scaled(effect, 2.0) == effect
    best = effect if fixed else scaled(effect, _solved(at, size))
    change, visible = _measure(best, seed, on)
    reached = float((change if whole else visible).max())
    if reached <= 0.0 or (not fixed and not REACHED * size < reached < size / REACHED):
        return None
    channels = on.sessions[0].channels
    return Hidden(best, reached, seed, *(dict(zip(channels, map(float, x), strict=True)) for x in (change, visible)))


def _solved(at: Callable[[float], float], size: float) -> float:
    """The factor at which `at` gives `size`, by bisection. The change may also grow with a smaller factor: a clipping level changes more
    the lower it is."""
    step = 4.0 if at(4.0) >= at(0.25) else 0.25
    weak = strong = 1.0
    while at(strong) < size and 1.0 / FACTOR < strong < FACTOR:
        weak, strong = strong, strong * step
    while at(weak) > size and 1.0 / FACTOR < weak < FACTOR:
        weak, strong = weak / step, weak
    while abs(strong / weak - 1.0) > PRECISE:
        middle = float(np.sqrt(weak * strong))
        weak, strong = (middle, strong) if at(middle) < size else (weak, middle)
    return strong


def _measure(effect: Effect, seed: int, on: Ground) -> tuple[np.ndarray, np.ndarray]:
    """RMS over noise (C,) in the first recording: of the whole change, and of its visible part."""
    first, session = on.recordings[0], on.sessions[0]
    after = changed(effect, first, session, on.model, seed)
    change = stacked(after)[1] - session.raw
    if after.depth is not first.depth:  # an error of the depth counts as the force that it would make
        each = [stiffness(on.model, channel) for channel in session.channels]
        change = change + np.outer(each, after.depth - first.depth)
    change = session.band.thin(change) / on.noise[:, None]
    return rms(change, session.weight), rms(change - _imitated(change, on), session.weight)


def _imitated(change: np.ndarray, on: Ground) -> np.ndarray:
    weight = on.sessions[0].weight
    J = on.tangents / on.noise[:, None]
    z = np.linalg.lstsq((J * weight).reshape(len(J), -1).T, (change * weight).ravel(), rcond=1e-10)[0]
    return np.tensordot(z, J, 1)
