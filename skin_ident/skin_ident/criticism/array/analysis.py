"""Analysis of an array: what the ratios of the taxels show once everything else is in the model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.gains import Gains, gains
from skin_ident.criticism.array.judgement import Judgement, unlike
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.scatter import with_scatter
from skin_ident.criticism.array.trying import Shown, Tried, tried
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.session import Session
from skin_models.model import Model

FAR = 0.25  # relative error of the shares that no calibration error reaches,
BEYOND = 5.0  # nor this many times the declared error of calibrations
UNKNOWN = 100.0  # times the largest share, standard error of the share of a dead taxel
DOUBTED = 0.1  # relative standard error added to the share of a taxel in which another fault was found
BENDING = ("saturation", "dead_zone", "hysteresis", "lag", "gain_error", "drift", "crosstalk", "nonlinear_stiffness")


@dataclass(frozen=True, eq=False)
class ArrayCriticism:
    """The result. `judgement` compares causes alone; `tried` are those that were sure enough to be tried on held-out data, with a
    judgement of their own beside each other if they are two; `left` judges what is left beside a single one of these; `unlike` is the
    relative difference of the training shares from the declared layout."""

    layout: Layout
    measured: Gains
    judgement: Judgement
    tried: tuple[Tried, ...] = ()
    left: Judgement | None = None
    unlike: float = 0.0

    @property
    def unexplained(self) -> bool:
        """Whether the ratios are wrong by more than any calibration error, or by far more than the declared one, and no cause has been
        named for it."""
        declared = self.layout.gain_std
        far = FAR if declared is None else min(FAR, BEYOND * declared)
        return not self.named and self.judgement.named is not None and self.unlike > far

    @property
    def named(self) -> tuple[Tried, ...]:
        """The causes that are sure and passed their test."""
        return tuple(t for t in self.tried if t.passed)


def analyse(
    model: Model,
    layout: Layout,
    sessions: list[Session],
    held: list[int],
    noise: Whitener,
    doubted: list[int],
    thickness_mm: float | None,
    dead: Sequence[int] = (),
) -> ArrayCriticism:
    """Judge the shares of the training sessions under the extended `model`; `held` are indices of held-out sessions.

    `doubted` are taxels in which another fault was found and whose share is less certain; of `dead` ones it is unknown.
    """
    if any(e.cause == "spread_depth" for e in model.effects):  # its initial width and its growth cannot be told apart
        layout = replace(layout, width_declared=False)
    measured = with_scatter(_granted(_without(dead, gains(model, sessions, noise), layout), doubted), layout)
    shown = Shown(model, layout, measured, sessions, held, noise, thickness_mm)
    judgement, train = shown.judged(), shown.train
    off = unlike(layout.of(train), measured.of(train), judgement.nothing)
    return ArrayCriticism(layout, measured, judgement, *tried(shown, judgement), off)


def _without(dead: Sequence[int], measured: Gains, layout: Layout) -> Gains:
    """The shares as if nothing was known of dead taxels: they are put where the layout expects them, with an error larger than any
    share."""
    if not len(dead):
        return measured
    value, covariance, plain = measured.value.copy(), measured.covariance.copy(), Family(layout).shares({})
    seen = np.delete(np.arange(value.shape[1]), dead)
    level = np.sum(plain[:, seen] * value[:, seen], axis=1) / np.maximum(np.sum(plain[:, seen] ** 2, axis=1), 1e-300)
    value[:, dead] = level[:, None] * plain[:, dead]
    covariance[:, dead, :] = covariance[:, :, dead] = 0.0
    covariance[:, dead, dead] = (UNKNOWN * np.abs(value).max()) ** 2
    return replace(measured, value=value, covariance=covariance)


def _granted(measured: Gains, doubted: list[int]) -> Gains:
    if not doubted:
        return measured
    more = np.zeros(measured.covariance.shape)
    for i in doubted:
        more[:, i, i] = (DOUBTED * measured.value[:, i]) ** 2
    return replace(measured, covariance=measured.covariance + more)


def doubted_taxels(named) -> list[int]:
    """The taxels for which the search has named something that changes their static share."""
    places = {n.where for n in named if n.cause in BENDING}
    return sorted(int(w.partition("_")[2]) for w in places if w.startswith("taxel_"))
