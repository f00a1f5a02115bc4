"""Forces of contacts to forces of taxels, for `SimulatedSkin`: dense numpy with explicit state, or the compiled path in place.

Both take two forces per contact: one that is known and passes through the transfer function of eq 32 taxel by taxel, and one that has
come through the skin already (from `Columns`) and is only spread. Both are applied forces: the field's gain holds the static share.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skin_models.spread.compiled import CompiledSkin, Step
from skin_models.spread.contacts import Contacts
from skin_models.spread.field import Shares, SpreadField
from skin_models.transmission import Transmission


@dataclass(frozen=True, eq=False)
class Patches:
    """Where contacts are: position (C, 3), radius (C,), depth (C,), m."""

    position: np.ndarray
    radius: np.ndarray
    depth: np.ndarray

    def same(self, other: "Patches | None") -> bool:
        """Whether the contacts of `other` stand where these do."""
        names = ("position", "radius", "depth")
        return other is not None and all(np.array_equal(getattr(self, n), getattr(other, n), equal_nan=True) for n in names)


class DenseSpreader:
    """Every taxel at every step; the state is an array that is passed through."""

    def __init__(self, field: SpreadField, transmission: Transmission | None) -> None:
        self._field, self._filter = field, transmission
        self._known: tuple[Patches | None, Shares | None] = (None, None)

    def initial(self) -> np.ndarray:
        """At rest."""
        return np.zeros((0, 0)) if self._filter is None else self._filter.initial(len(self._field.layout))

    def step(self, state: np.ndarray, patches: Patches, known: np.ndarray, through: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
        """State after the sample, force of every taxel (T,) and how many contacts no taxel is near, from forces (C,) N."""
        shares = self._shares(patches)
        truth = self._sum(shares, through)
        if self._filter is not None:
            state, sensed = self._filter.step(state, self._sum(shares, known))
            truth = truth + sensed / self._filter.dispersion.sensed_share
        return state, truth, len(known) - np.unique(shares.contact).size

    def _shares(self, patches: Patches) -> Shares:
        """The shares of the contacts, kept as long as they stand still."""
        if not patches.same(self._known[0]):
            shares = self._field.shares(Contacts(patches.position, np.ones(len(patches.radius)), patches.radius, patches.depth))
            self._known = (patches, shares)
        return self._known[1]

    def _sum(self, shares: Shares, force: np.ndarray) -> np.ndarray:
        total = np.zeros(len(self._field.layout))
        np.add.at(total, shares.taxel, shares.value * force[shares.contact])
        return total


class CompiledSpreader:
    """Only the taxels that are touched; the state lives in the compiled skin and changes in place. One user at a time."""

    def __init__(self, field: SpreadField, transmission: Transmission | None) -> None:
        self._static = CompiledSkin(field)
        self._filtered = None if transmission is None else CompiledSkin(field, transmission)

    def initial(self) -> Any:
        """Put it at rest."""
        for skin in (self._static, self._filtered):
            if skin is not None:
                skin.reset()

    def step(self, state: Any, patches: Patches, known: np.ndarray, through: np.ndarray) -> tuple[Any, np.ndarray, int]:
        """As `DenseSpreader.step`; `state` is not used."""
        truth = 0.0
        if self._filtered is None or np.any(through):
            step = self._advance(self._static, patches, through)
            truth = step.readings.copy()
        if self._filtered is not None:
            step = self._advance(self._filtered, patches, known)
            truth = truth + step.readings
        return state, truth, step.outside

    @staticmethod
    def _advance(skin: CompiledSkin, patches: Patches, force: np.ndarray) -> Step:
        skin.put(patches.position, force, patches.radius, depth=patches.depth)
        return skin.advance(len(force))
