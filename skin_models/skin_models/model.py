"""The chain: dispersion model, spread over taxels, and any effects, simulated as one.

`Model.simulate` runs a whole recording, `Model.step` one sample with explicit state; both are the same chain (see `skin_models.effect`
for its places), and both give truth (what the skin did) beside measured (what the sensors say).
"""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from skin_models.arrays import numbers
from skin_models.dispersion import Dispersion, Surface
from skin_models.effect import Effect, Place
from skin_models.errors import ModelError
from skin_models.signals import Motion, Sample
from skin_models.spread.bending import Bending, in_order
from skin_models.spread.footprint import Footprint, Places
from skin_models.spread.kernels import Kernel
from skin_models.spread.noted import kernel_of
from skin_models.words import counted

_PRESSED = Surface(0.0, True)
_TELLING = 1e-3  # relative to the share right under a contact: a taxel that felt less does not determine its own gain


@dataclass(frozen=True)
class Response:
    """What a simulation gives: arrays (N,) and (T, N), or scalars and (T,) for one sample; N, compression positive."""

    force: Any
    taxels: Any
    force_truth: Any
    taxels_truth: Any


@dataclass(frozen=True)
class Model:
    """A testbed: one specimen of skin, its taxels, and every effect that departs from the plain dispersion model.

    `shares` is each taxel's share of the sensed force: 1 for a taxel under the plunger, less beside it; empty for a material test
    without taxels. Effects act in the order of the chain's places, and at one place in the order given (those of the spread by their
    `rank`). `positions` (T, 2), m, are those of the taxels relative to the contact for which the shares hold; empty where they are not
    known. With them a contact may move across the skin (`lateral` of a sample or a motion), and effects of the spread can act.
    """

    dispersion: Dispersion
    shares: tuple[float, ...] = (1.0,)
    effects: tuple[Effect, ...] = ()
    name: str = "dispersion"
    source: str = ""
    notes: dict[str, Any] = field(default_factory=dict, hash=False, compare=False)
    positions: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        shares, positions = numbers(self.shares, "shares of the taxels"), numbers(self.positions, "positions of the taxels")
        if self.positions and positions.shape != (len(self.shares), 2):
            raise ModelError(
                f"a model of {counted(len(self.shares), 'taxel')} needs as many positions (x, y) or none, not {len(self.positions)}"
            )
        if not np.isfinite(positions).all():
            raise ModelError("positions of the taxels must be finite")
        if len(set(map(tuple, self.positions))) < len(self.positions):
            raise ModelError(f"{_twins(self.positions)} are at the same place")
        if not np.all(np.isfinite(shares) & (shares >= 0.0)):
            raise ModelError(f"shares of the taxels must be finite and not negative, not {shares.tolist()}")
        if len({id(e) for e in self.effects}) < len(self.effects):  # each effect has a state of its own
            object.__setattr__(self, "effects", tuple(map(copy, self.effects)))
        for e in self.effects:
            if e.taxel is not None and e.taxel >= len(self.shares):
                raise ModelError(
                    f"{e.cause} sits in {e.where}, but the model has {counted(len(self.shares), 'taxel')}, counted from taxel_0"
                )

    def at(self, place: Place) -> tuple[Effect, ...]:
        """The effects at one place of the chain."""
        return self._by_place[place]

    @cached_property
    def _by_place(self) -> dict[Place, tuple[Effect, ...]]:
        places = [e.place for e in self.effects]
        return {place: tuple(e for e, where in zip(self.effects, places, strict=True) if where is place) for place in Place}

    def extended(self, effect: Effect) -> "Model":
        """The same model with one more effect."""
        return replace(self, effects=(*self.effects, effect))

    def without(self, effect: Effect) -> "Model":
        """The same model with `effect` taken out."""
        return replace(self, effects=tuple(e for e in self.effects if e is not effect))

    def having(self, key: tuple[str, str]) -> tuple[Effect, ...]:
        """The effects that carry one cause at one place (`Effect.key`), in the order given."""
        return tuple(e for e in self.effects if e.key == key)

    def lacking(self, *keys: tuple[str, str]) -> "Model":
        """The same model without the effects that carry any of some causes at their places (`Effect.key`)."""
        return replace(self, effects=tuple(e for e in self.effects if e.key not in keys))

    def listed_as(self, i: int, parameter: str) -> str:
        """A parameter of effect `i` as named in tables: cause.where.name, with name_2, … from the second of one cause and place on."""
        keys = [e.key for e in self.effects[: i + 1]]
        number = keys.count(keys[i])
        return ".".join((*keys[i], parameter)) + (f"_{number}" if number > 1 else "")

    def simulate(self, s: Motion, seed: int | None = None) -> Response:
        """The response to a measured or planned depth. `seed` drives the effects that are random; None leaves those out."""
        if seed is None:
            return self.trace(s).response
        rngs = {id(e): rng for e, rng in zip(self.effects, self._generators(seed), strict=True)}
        return self._run(s, lambda e, y, context: e.batch(y, context, rngs[id(e)]), Motion.at_depth, self.dispersion.surface).response

    def initial(self, seed: int | None = None) -> "State":
        """The state at rest, for `step`."""
        return State(tuple(e.initial(rng) for e, rng in zip(self.effects, self._generators(seed), strict=True)))

    def step(self, state: "State", s: Sample, dt: float) -> tuple["State", Response]:
        """One sample, `dt` s after the last: `state, response = step(state, sample, dt)`. `state` is not changed: a step can be tried.

        Raises `ModelError` unless time advances.
        """
        if not dt > 0.0:
            raise ModelError(f"a sample must come later than the one before, not {dt} s later")
        after = _Stepper(self.effects, state, dt)
        response = self._run(s, after.act, after.moved, lambda tip: after.met(self.dispersion, tip)).response
        return State(tuple(after.states), after.shift, after.surface), response

    def _generators(self, seed: int | None) -> list[np.random.Generator | None]:
        """One random generator per effect, so that the numbers of one do not depend on the others."""
        return [None if seed is None else np.random.default_rng([seed, i]) for i in range(len(self.effects))]

    def trace(self, s: Motion) -> "Run":
        """A simulation that keeps the signals between its places, for `bent` and `again`."""
        s = self._laid(s)
        tip = self._tip(s)
        signals = s.once("run", (self, id(self.notes)), lambda: self._from_tip(s, tip, _in_batch, self.dispersion.surface).signals)
        return Run(s, tip, *signals)

    def _tip(self, s: Motion) -> Motion:
        """The motion of the tip. Models with the same DEPTH effects get one and the same object, so they share what it caches, too."""
        bends = self.at(Place.DEPTH)
        return s.once("tip", bends, lambda: s.at_depth(self._through(Place.DEPTH, s.x, s, _in_batch))) if bends else s

    def bent(self, run: "Run", e: Effect) -> Response:
        """The response of `extended(e).simulate`, at the cost of recomputing only what lies downstream of the place of `e`."""
        past = {Place.SKIN: run.skin, Place.SURFACE: run.surface, Place.LOAD_CELL: run.response.force, Place.TAXEL: run.response.taxels}
        if e.place in past:
            return self._behind(run, e.place, e.batch(past[e.place], run.tip))
        return self.extended(e).again(run, e.place)

    def again(self, run: "Run", place: Place) -> Response:
        """The response of `simulate` to the motion of `run`, at the cost of recomputing only what lies downstream of `place`.

        `run` must come from a model that differs from this one only in shares or effects at `place`.
        """
        if place is Place.DEPTH:
            return self.simulate(run.motion)
        if place is Place.SPREAD:
            return self._from_spread(run, self._spread(run.tip, np.ones_like(run.response.force_truth), _in_batch), _in_batch).response
        return self._behind(run, place, self._through(place, self._into(run, place), run.tip, _in_batch))

    def _into(self, run: "Run", place: Place) -> np.ndarray:
        """The signal that enters a place."""
        if place is Place.SKIN:
            return self.dispersion.branches(run.tip)
        if place is Place.SURFACE:
            return self._pressing(run, run.skin)
        return run.response.force_truth if place is Place.LOAD_CELL else run.response.taxels_truth

    def _behind(self, run: "Run", place: Place, y: np.ndarray) -> Response:
        """The response where `y` is the output of a place, and everything upstream of it is as in `run`."""
        if place is Place.SKIN:
            return self._from_skin(run, y, _in_batch).response
        if place is Place.SURFACE:
            return self._from_surface(run, y, _in_batch).response
        return replace(run.response, **{"force" if place is Place.LOAD_CELL else "taxels": y})

    def _run(self, s: Any, act: Callable, moved: Callable, met: Callable) -> "Run":
        """The chain itself, for one sample or a recording.

        `act(effect, y, s)` applies an effect, `moved(s, x)` is `s` at depth `x`, `met(s)` is the contact rule.
        """
        s = self._laid(s)
        return self._from_tip(s, moved(s, self._through(Place.DEPTH, s.x, s, act)), act, met)

    def _from_tip(self, s: Any, tip: Any, act: Callable, met: Callable) -> "Run":
        skin = self._through(Place.SKIN, self.dispersion.branches(tip), tip, act)
        return self._from_skin(Run(s, tip, _PRESSED if _pressed(tip) else met(tip)), skin, act)

    def _from_skin(self, run: "Run", skin: Any, act: Callable) -> "Run":
        # `Run(…)` and not `replace` here and below: these lines run for every single sample.
        surface = self._through(Place.SURFACE, self._pressing(run, skin), run.tip, act)
        return self._from_surface(Run(run.motion, run.tip, run.contact, skin), surface, act)

    def _pressing(self, run: "Run", skin: Any) -> Any:
        """The skin's forces that press on the surface, (2,) or (2, N): zero out of contact, and without a pull unless `pressed`."""
        return (skin if _pressed(run.tip) else self.dispersion.unpulled(skin)) * run.contact.touched

    def _from_surface(self, run: "Run", surface: Any, act: Callable) -> "Run":
        applied = surface.sum(axis=0) + self.dispersion.inertial(run.tip) * run.contact.touched
        force = self._through(Place.LOAD_CELL, applied, run.tip, act)
        run = Run(run.motion, run.tip, run.contact, run.skin, surface, None, Response(force, None, applied, None))
        return self._from_spread(run, self._spread(run.tip, np.ones_like(applied), act), act)

    def _spread(self, tip: Any, ones: Any, act: Callable) -> Any:
        """The share of every taxel, with the effects of the spread; each sees the footprint as those before it left it."""
        plain = np.array(self.shares, float) if tip.lateral is None else self._gains
        shares = np.broadcast_to(plain[:, None], (plain.size, ones.size)) if np.ndim(ones) == 1 else np.multiply.outer(plain, ones)
        if tip.lateral is not None:
            shares = shares * tip.footprint.shape()
        for e in in_order(self.at(Place.SPREAD)):
            shares = act(e, shares, tip)
            if isinstance(e, Bending):
                tip = replace(tip, footprint=e.bent(tip.footprint, tip.x))
        return shares

    def _laid(self, s: Any) -> Any:
        """`s` with the footprint of this model's taxels, as far as their positions are known."""
        if not self.positions:
            if s.lateral is not None:
                raise ModelError("a contact that moves across the skin needs a model with the positions of its taxels")
            return s
        if s.lateral is None and isinstance(s, Sample) and not self._finds_taxels:
            return s  # for speed: no effect would use the footprint
        offset = self._places.positions.T
        if s.lateral is not None:
            lateral = np.asarray(s.lateral, float)
            if lateral.shape != (2, *np.shape(s.x)):
                raise ModelError(f"a contact that moves needs a place (x, y) for every sample, not an array of shape {lateral.shape}")
            offset = offset.reshape(2, -1, *([1] * (lateral.ndim - 1))) - lateral[:, None]
        return replace(s, footprint=Footprint(self._places, offset, self._kernel))

    @cached_property
    def _finds_taxels(self) -> bool:
        return any(e.finds_taxels for e in self.effects)

    @cached_property
    def _places(self) -> Places:
        return Places(np.array(self.positions, float))

    @cached_property
    def _kernel(self) -> Kernel:
        return kernel_of(self.notes)

    @cached_property
    def _gains(self) -> np.ndarray:
        """The share that every taxel would have right under a contact, (T,): its share divided by the kernel at its place.

        A taxel that felt too little for that (`_TELLING`) gets the value of the one nearest to the contact.
        """
        felt = self._kernel.shape(self._kernel.distance(*self._places.positions.T))
        gains = np.array(self.shares) / np.maximum(felt, 1e-300)
        return np.where(felt > _TELLING, gains, gains[np.argmax(felt)])

    def _from_spread(self, run: "Run", shares: Any, act: Callable) -> "Run":
        sensed = shares * (run.surface[0] + self.dispersion.free(run.contact))
        taxels = self._through(Place.TAXEL, sensed, run.tip, act)
        response = Response(run.response.force, taxels, run.response.force_truth, sensed)
        return Run(run.motion, run.tip, run.contact, run.skin, run.surface, shares, response)

    def _through(self, place: Place, y: Any, context: Any, act: Callable) -> Any:
        for e in self.at(place):
            y = act(e, y, context)
        return y


def _twins(positions: tuple) -> str:
    """The first two taxels that share a place, by name."""
    j = next(j for j, place in enumerate(positions) if place in positions[:j])
    return f"taxel_{positions.index(positions[j])} and taxel_{j}"


def _pressed(s: Any) -> bool:
    """Whether the force on the skin was prescribed, and there is no contact to be made or lost."""
    return getattr(s, "pressed", False)


def _in_batch(e: Effect, y: np.ndarray, s: Motion) -> np.ndarray:
    return e.batch(y, s, None)


@dataclass(frozen=True)
class Run:
    """The signals of one simulation, place by place (see `skin_models.effect`)."""

    motion: Any
    tip: Any
    contact: Any
    skin: Any = None
    surface: Any = None
    shares: Any = None
    response: Response | None = None

    @property
    def signals(self) -> tuple[Any, ...]:
        """All but the motion and that of the tip: what `trace` caches with the motion."""
        return self.contact, self.skin, self.surface, self.shares, self.response


@dataclass(frozen=True)
class State:
    """Everything a model remembers from one sample to the next."""

    effects: tuple[Any, ...]
    shift: float | None = None  # m, by how much the DEPTH effects moved the last sample
    surface: Surface | None = None


class _Stepper:
    """Collects the new states while the chain runs over one sample."""

    def __init__(self, effects: tuple[Effect, ...], before: State, dt: float) -> None:
        self.index = {id(e): i for i, e in enumerate(effects)}
        self.states = list(before.effects)
        self.before, self.shift, self.surface, self.dt = before, before.shift, before.surface, dt

    def act(self, e: Effect, y: Any, s: Sample) -> Any:
        """What an effect makes of a signal at this sample."""
        i = self.index[id(e)]
        self.states[i], y = e.step(self.before.effects[i], y, s, self.dt)
        return y

    def moved(self, s: Sample, x: float) -> Sample:
        """The sample at depth `x`, to which the DEPTH effects moved it; its speed grows by the backward difference of that shift."""
        self.shift = x - s.x
        last = self.shift if self.before.shift is None else self.before.shift
        if x is s.x and isinstance(last, float) and last == 0.0:  # one contact, and nothing acts there
            return s
        return replace(s, x=x, v=s.v + (self.shift - last) / self.dt)

    def met(self, dispersion: Dispersion, tip: Sample) -> Surface:
        """The skin's surface under the tip."""
        self.surface = dispersion.meet(self.before.surface, tip, self.dt)
        return self.surface
