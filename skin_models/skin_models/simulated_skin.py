"""A patch of skin with taxels, from contacts to readings: what the skin node runs.

A contact whose force is known drives the skin by that force, one whose depth is known by the depth:

    force, no effect in the skin     spread over the taxels, then the transfer function of eq 32 on each of them (`Transmission`)
    force, effects in the skin       the depth that gives the force (`Columns`), then as for a depth
    depth                            the model's chain gives applied and sensed force, the sensed force is spread

then the sensors' effects on every taxel. A taxel right under a contact, of the area that the model was measured with, feels what the
model says; the others feel the kernel's share of it. Statically, what the taxels of one contact feel never exceeds what presses.

The memory of the skin belongs to the column under each contact (`skin_models.column`). The column follows its contact as that moves, and
is kept in the air when the contact leaves; of those in the air, the last `MEMORY` are kept.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from skin_models.arrays import numbers
from skin_models.column import NOTHING, Columns, press, skin_of
from skin_models.effect import Effect, Place
from skin_models.errors import ModelError
from skin_models.layout import A201_AREA, Layout
from skin_models.model import Model
from skin_models.signals import DEEPEST, Sample
from skin_models.spread.bending import Bending, Bent
from skin_models.spread.compiled import compiles
from skin_models.spread.contacts import ContactError
from skin_models.spread.field import SpreadField, tangent
from skin_models.spread.footprint import Footprint, Places
from skin_models.spread.kernels import Kernel
from skin_models.spread.noted import kernel_of, spread_width
from skin_models.spread.spreaders import CompiledSpreader, DenseSpreader, Patches
from skin_models.transmission import Transmission
from skin_models.words import counted

MEMORY = 16  # columns that are kept after their contacts have left
HARDEST = 1e6  # N; a greater force is taken for a mistake in the input
__all__ = ["MEMORY", "Presses", "Reading", "SimulatedSkin", "SkinState", "spread_width"]


@dataclass(frozen=True, eq=False)
class Presses:
    """Everything that touches at one instant: `key` tells contacts apart from one sample to the next.

    Forces and depths that are negative do not press. Raises `ContactError` for arrays of different lengths, two contacts of one key, and
    a contact without a finite place, with neither a force nor a depth, or with one that no skin ever meets (1 MN, 100 mm).
    """

    key: tuple[str, ...] = ()
    position: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))  # m
    force: np.ndarray = field(default_factory=lambda: np.empty(0))  # N; NaN: the depth counts
    depth: np.ndarray = field(default_factory=lambda: np.empty(0))  # m; NaN: unknown
    radius: np.ndarray = field(default_factory=lambda: np.empty(0))  # m

    def __post_init__(self) -> None:
        count = len(self.key)
        if len(set(self.key)) < count:
            raise ContactError("two contacts bear the same key: then nobody can tell which of them was where before")
        for name in ("position", "force", "depth", "radius"):
            object.__setattr__(self, name, numbers(getattr(self, name), f"{name} of contacts", ContactError))
        if np.shape(self.position) != (count, 3) or not np.shape(self.force) == np.shape(self.depth) == np.shape(self.radius) == (count,):
            raise ContactError(f"{count} contacts need as many positions (x, y, z), forces, depths and radii")
        if not np.isfinite(self.position).all() or not ((self.radius >= 0.0) & np.isfinite(self.radius)).all():
            raise ContactError("every contact needs a finite position, and a finite radius that is not negative")
        driven = np.where(np.isnan(self.force), self.depth, self.force)
        if not np.isfinite(driven).all() or (self.force > HARDEST).any():
            raise ContactError("every contact needs a finite force up to 1 MN, or a finite depth")
        if (self.depth > DEEPEST).any():
            raise ContactError(f"no contact is {self.depth[self.depth > DEEPEST][0]:g} m deep: depths are in m, up to 100 mm")

    @property
    def patches(self) -> Patches:
        """Where they press, on what radius, and how deep."""
        return Patches(self.position, self.radius, self.depth)

    @classmethod
    def of_forces(cls, position: np.ndarray, force: np.ndarray, key: tuple[str, ...] = ()) -> "Presses":
        """Points at (C, 3) m pressed with forces (C,) N; without keys, told apart by their order."""
        count = len(force)
        keys = tuple(key) or tuple(map(str, range(count)))
        return cls(keys, np.array(position), np.array(force), np.full(count, np.nan), np.zeros(count))

    def faded(self, factor: float) -> "Presses":
        """The same contacts with force and depth scaled."""
        return replace(self, force=self.force * factor, depth=self.depth * factor)


@dataclass(frozen=True, eq=False)
class Reading:
    """One sample, N, compression positive."""

    taxels: np.ndarray  # (T,), what the sensors say
    truth: np.ndarray  # (T,), what reaches them
    force: float  # applied by all contacts
    dispersed: float  # applied less truth: reaches no taxel; can be negative while things move, as in the dispersion model itself
    outside: int  # contacts that no taxel is near


@dataclass(frozen=True, eq=False)
class SkinState:
    """What the skin remembers: the spreader's state, the columns of contacts, states of the sensors' effects, time (s)."""

    spread: Any
    columns: Columns
    sensors: tuple[Any, ...]
    t: float = 0.0


class SimulatedSkin:
    """One model over one layout at one sample period; the state is passed through `step`."""

    def __init__(
        self, model: Model, layout: Layout, dt: float, kernel: Kernel | None = None, tolerance: float = 1e-6, fast: bool = False
    ) -> None:
        """`kernel` defaults to the one that the model's notes describe. Raises `ModelError` for an effect on a taxel that is not there.

        `dt` is the sample period, s. `fast`: use the compiled path where there is one. Then part of the state lives here and not in
        `SkinState`.
        """
        if not 0.0 < dt < np.inf:
            raise ModelError(f"the sample period must be a positive time in s, not {dt}")
        for e in model.effects:
            if e.taxel is not None and e.taxel >= len(layout):
                raise ModelError(f"{e.cause} sits in {e.where}, but the layout has {counted(len(layout), 'taxel')}, counted from taxel_0")
        self.model, self.layout, self.dt = model, layout, dt
        self.kernel = _bent(kernel or kernel_of(model.notes), model.at(Place.SPREAD))
        self._shift = np.sum([e.shift() for e in model.at(Place.SPREAD)] + [(0.0, 0.0)], axis=0)
        self._share = min(model.dispersion.sensed_share, 1.0) if model.dispersion.k1 > 0.0 else 0.0
        self._skin, self._sensors = skin_of(model), model.at(Place.TAXEL)
        self._field = field = SpreadField(layout, self.kernel, self._share, A201_AREA, tolerance)
        self._filter = None if self._skin.effects or not self._share else Transmission(model.dispersion, dt)
        self._spreader = (CompiledSpreader if fast and compiles(self.kernel) else DenseSpreader)(field, self._filter)
        self._footprint = Footprint(Places(layout.positions), layout.positions[:, :2].T, self.kernel)

    def initial(self, seed: int | None = None) -> SkinState:
        """At rest. `seed` drives the sensors' random effects; None leaves those out."""
        states = dict(zip(map(id, self.model.effects), self.model.initial(seed).effects, strict=True))
        return SkinState(self._spreader.initial(), NOTHING, tuple(states[id(e)] for e in self._sensors))

    def step(self, state: SkinState, presses: Presses) -> tuple[SkinState, Reading]:
        """One sample: `state, reading = step(state, presses)`."""
        t = state.t + self.dt
        by_filter = np.isfinite(presses.force) if self._filter is not None else np.zeros(len(presses.key), bool)
        columns, applied, sensed = self._press(state, presses, by_filter, t)
        known = np.where(by_filter, applied, 0.0)
        through = sensed / self._share if self._share else np.zeros_like(sensed)
        spread, truth, outside = self._spreader.step(state.spread, self._patches(presses, columns), known, through)
        sensors, taxels = self._sense(state.sensors, truth, presses, t)
        reading = Reading(taxels, truth, float(applied.sum()), float(applied.sum() - truth.sum()), outside)
        return SkinState(spread, columns, sensors, t), reading

    def _press(self, state: SkinState, presses: Presses, by_filter: np.ndarray, t: float) -> tuple[Columns, np.ndarray, np.ndarray]:
        """Columns after the sample, those in the air first; applied force and sensed force (C,) of every contact."""
        pressed, touching = np.flatnonzero(~by_filter), set(presses.key)
        keys = tuple(key for key in state.columns.keys if key not in touching)[-MEMORY:]
        applied, sensed, air = np.where(by_filter, np.maximum(presses.force, 0.0), 0.0), np.zeros(len(presses.key)), len(keys)
        keys += tuple(presses.key[i] for i in pressed)
        if not keys:
            return NOTHING, applied, sensed
        force, depth = np.zeros(len(keys)), np.zeros(len(keys))
        force[air:], depth[air:] = presses.force[pressed], presses.depth[pressed]
        columns, force, felt = press(self._skin, state.columns.of(self._skin, keys, self.dt), force, depth, t, self.dt)
        applied[pressed], sensed[pressed] = force[air:], felt[air:]
        return columns, applied, sensed

    def _patches(self, presses: Presses, columns: Columns) -> Patches:
        """Where the contacts are. A depth that the spread needs and that was not given is the one found by the column, or F / (k1 + k2)."""
        if self._shift.any() and presses.key:
            presses = replace(presses, position=presses.position + self._across(presses.position))
        if not (self.kernel.deep and np.isnan(presses.depth).any()):
            return presses.patches
        d, found = self.model.dispersion, dict(zip(columns.keys, columns.x, strict=True))
        rests = np.nan_to_num(presses.force) / max(d.k1 + d.k2, 1e-9)
        depth = [found.get(key, x) for key, x in zip(presses.key, rests, strict=True)]
        return replace(presses.patches, depth=np.where(np.isnan(presses.depth), depth, presses.depth))

    def _across(self, position: np.ndarray) -> np.ndarray:
        """Offset of contacts at (C, 3) m from their declared places, along the skin there, (C, 3) m."""
        nearest = self._field.tree.query(position)[1]
        normals, which = np.unique(self.layout.normals[nearest], axis=0, return_inverse=True)
        return np.array([self._shift @ np.array(tangent(normal)) for normal in normals])[which.reshape(-1)]

    def _sense(self, states: tuple[Any, ...], truth: np.ndarray, presses: Presses, t: float) -> tuple[tuple[Any, ...], np.ndarray]:
        """The sensors' effects."""
        depth = float(np.nanmax(presses.depth, initial=0.0)) if presses.depth.size else 0.0
        sample, y, after = Sample(t, depth, 0.0, 0.0, footprint=self._footprint), truth, []
        for e, before in zip(self._sensors, states, strict=True):
            s, y = e.step(before, y, sample, self.dt)
            after.append(s)
        return tuple(after), y


def _bent(kernel: Kernel, effects: tuple[Effect, ...]) -> Kernel:
    """The kernel with the effects of the spread in it."""
    strange = [e.cause for e in effects if not isinstance(e, Bending)]
    if strange:
        raise ModelError(f"{strange[0]} changes the spread in a way that a patch of skin cannot simulate")
    bending = tuple(e for e in effects if not any(e.shift()))  # those that only shift the contact are applied to its position instead
    return Bent(kernel, bending) if bending else kernel
