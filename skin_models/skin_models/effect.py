"""What an effect is: one departure of the real testbed from the dispersion model, at one place of the chain.

    encoder depth ─ DEPTH ─► tip depth ─ SKIN ─ contact rule ─ SURFACE ─┬─► applied force ─ LOAD_CELL ─► force
                                                                        └─► sensed force × SPREAD ─ TAXEL ─► taxels

An effect takes the signal that passes its place and returns it changed. The signal `y` is

    DEPTH      depth of the plunger                          scalar, or (N,)     m
    SKIN       sensed and dispersed force, in contact        (2,),   or (2, N)   N
    SURFACE    the same, after the contact rule (no pulling) (2,),   or (2, N)   N
    LOAD_CELL  applied force                                 scalar, or (N,)     N, compression positive
    SPREAD     share of the sensed force on every taxel      (T,),   or (T, N)
    TAXEL      sensed force of every taxel                   (T,),   or (T, N)   N, compression positive

A clock has no place of its own: an effect of the clock acts at the place of the channel that is late.

Effects are either `Memoryless` (a function of the present) or `Dynamic` (explicit state, exact or convergent stepping); both come as
one sample at a time and as a whole recording, and the two agree. A class is abstract or final: nobody overrides an effect.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from itertools import product
from typing import Any, ClassVar

import numpy as np

from skin_models.errors import ModelError
from skin_models.parameter import AMPLITUDE, SHAPE, check_parameters, parameters_of, scan_of
from skin_models.signals import Motion, Sample


class Place(Enum):
    """Where in the chain an effect acts; see the diagram above."""

    DEPTH = "depth"
    SKIN = "skin"
    SURFACE = "surface"
    LOAD_CELL = "load_cell"
    SPREAD = "spread"
    TAXEL = "taxel"


@dataclass(frozen=True)
class Effect(ABC):
    """One cause at one place.

    `where` is the word a finding uses: skin, rig, load_cell, taxel (all alike), taxel_3 (one of them) or clock. `places` maps the words a
    class accepts to its place in the chain; the key "taxel" stands for "taxel_<i>" as well.
    """

    cause: ClassVar[str]
    places: ClassVar[Mapping[str, Place]]
    source: ClassVar[str]  # where in the literature the form comes from
    linear: ClassVar[bool] = False  # in its amplitudes: then `regressors` gives what each of them multiplies
    finds_taxels: ClassVar[bool] = False  # uses the positions of the taxels: the footprint of a sample or a motion
    form: ClassVar[str] = ""  # tells several forms of one cause at one place apart; the plainest has none
    refines: ClassVar[type | None] = None  # the form that this one equals when it is small; it is tried as its replacement
    proposed: ClassVar[bool] = True  # False: it can be simulated, but no diagnosis proposes it as a cause
    only_if_shown: ClassVar[bool] = False  # proposed only where recordings themselves show the cause: elsewhere it stands in for others
    supple: ClassVar[bool] = False  # bends into other causes: one alone of its own cause, and no part of what noise is told from

    where: str

    def __post_init__(self) -> None:
        if not isinstance(self.where, str):
            raise ModelError(f"{self.cause} needs a place such as {next(iter(self.places))!r}, not {self.where!r}")
        self.place  # noqa: B018 - raises for a place this effect does not know
        check_parameters(self)

    @property
    def key(self) -> tuple[str, str]:
        """Cause and where it sits: what findings name, and what several instances of one cause at one place share."""
        return self.cause, self.where

    @property
    def place(self) -> Place:
        """Where in the chain it acts. Raises `ModelError` for a `where` this effect cannot have."""
        word = "taxel" if self.taxel is not None else self.where
        if word not in self.places:
            raise ModelError(f"{self.cause} cannot sit in {self.where!r}, only in {', '.join(self.places)}")
        return self.places[word]

    @property
    def taxel(self) -> int | None:
        """Index of the one taxel it acts on, or None."""
        head, _, tail = self.where.partition("_")
        return int(tail) if head == "taxel" and tail.isdecimal() else None

    @property
    def rows(self) -> Any:
        """Which rows of a (T, N) taxel signal it acts on."""
        return slice(None) if self.taxel is None else slice(self.taxel, self.taxel + 1)

    def mine(self, y: Any) -> Any:
        """The rows of `y` that it acts on: all, or those of its one taxel."""
        return y if self.taxel is None else y[self.rows]

    def put_back(self, y: Any, mine: Any) -> Any:
        """`y` with its own rows replaced by `mine`; `y` itself stays as it was."""
        if self.taxel is None:
            return mine
        whole = np.array(y, float)
        whole[self.rows] = mine
        return whole

    @property
    def values(self) -> dict[str, float]:
        """Parameter values by name."""
        return {p.name: p.value for p in parameters_of(self)}

    def with_values(self, **values: float) -> "Effect":
        """A copy with other parameter values. Raises `ModelError` outside the bounds."""
        return replace(self, **values)

    def absent(self) -> "Effect":
        """The same effect with size zero: the identity."""
        return self.with_values(**{p.name: 0.0 for p in parameters_of(self) if p.role == AMPLITUDE})

    @classmethod
    def typical(cls, where: str, **values: float) -> "Effect":
        """An example of ordinary size, for pictures, tests and the start of a fit."""
        usual = {p.name: p.typical for p in parameters_of(cls) if not np.isnan(p.typical)}
        return cls(where=where, **{**usual, **values})

    def regressors(self, y: np.ndarray, s: Motion) -> dict[str, np.ndarray]:
        """What each amplitude multiplies, by name, at the present shape: `batch(y, s)` = y + sum of amplitude times regressor.

        Shapes as `y`. Raises `ModelError` for an effect that is not linear in its amplitudes.
        """
        if not self.linear:
            raise ModelError(f"{self.cause} is not linear in its size, so it has no regressors")
        absent, sizes = self.absent(), {p.name: p.typical for p in parameters_of(self) if p.role == AMPLITUDE}
        return {name: (absent.with_values(**{name: size}).batch(y, s) - y) / size for name, size in sizes.items()}

    @classmethod
    def shapes(cls, s: Motion) -> Iterator[dict[str, float]]:
        """Yields the settings of the SHAPE parameters on which a proposal of this cause is profiled: the product of their grids.

        Yields nothing for an effect that is not proposed, or has a SHAPE parameter without a grid.
        """
        if not cls.proposed:
            return
        names = [p.name for p in parameters_of(cls) if p.role == SHAPE]
        grids = [scan_of(cls, name) for name in names]
        for values in product(*grids):
            yield dict(zip(names, values, strict=True))

    @abstractmethod
    def initial(self, rng: np.random.Generator | None = None) -> Any:
        """State at rest, before the first sample."""

    @abstractmethod
    def step(self, state: Any, y: Any, s: Sample, dt: float) -> tuple[Any, Any]:
        """One sample: `state, y = step(state, y, s, dt)`. `state` is never changed in place."""

    @abstractmethod
    def batch(self, y: np.ndarray, s: Motion, rng: np.random.Generator | None = None) -> np.ndarray:
        """A whole recording from rest; equal to stepping through it. `y` is not changed in place."""


class Memoryless(Effect):
    """An effect that depends on the present sample alone: its subclasses write `apply` once, for scalars and arrays alike."""

    @abstractmethod
    def apply(self, y: Any, s: Sample | Motion) -> Any:
        """The changed signal. Must work elementwise along the last axis."""

    def initial(self, rng: np.random.Generator | None = None) -> None:
        """None: there is nothing to remember."""
        return None

    def step(self, state: None, y: Any, s: Sample, dt: float) -> tuple[None, Any]:
        """`apply` on one sample."""
        return None, self.apply(y, s)

    def batch(self, y: np.ndarray, s: Motion, rng: np.random.Generator | None = None) -> np.ndarray:
        """`apply` on the whole recording."""
        return self.apply(y, s)


class Dynamic(Effect):
    """An effect with memory: subclasses write `initial`, `step` and `batch`."""
