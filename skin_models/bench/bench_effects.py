"""Every effect over a recording of 60,000 samples: the whole at once, against the loop over samples that one would write instead.

The loop is timed on its first 3,000 samples and scaled; best of several runs each. A last column says whether the goal of 10 ms is met.
"""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from skin_models.catalogue import effects
from skin_models.effect import Effect, Place
from skin_models.signals import Motion, motion
from skin_models.spread.footprint import Footprint, Places
from skin_models.spread.kernels import Gaussian

SAMPLES, LOOPED, GOAL = 60_000, 3_000, 10.0  # ms


def recording() -> Motion:
    """A minute of presses at 1 kHz with the noise of an encoder, which is what makes hysteresis slow: a reversal at every other sample."""
    t = np.arange(SAMPLES) * 1e-3
    noise = np.random.default_rng(0).normal(0.0, 1e-6, SAMPLES)
    places = Places(np.array([[3e-3, 1e-3]]))
    s = motion(t, 1e-3 * (0.8 + np.sin(2.0 * np.pi * 0.5 * t)) + noise)
    return replace(s, footprint=Footprint(places, places.positions.T, Gaussian(width=5.25e-3)))


def signal(place: Place, s: Motion) -> np.ndarray:
    """What passes that place: one depth, two branches, one force, or one taxel."""
    spring = 8e3 * np.maximum(s.x, 0.0)
    if place is Place.DEPTH:
        return s.x
    if place in (Place.SKIN, Place.SURFACE):
        return np.array([spring, 0.4 * spring])
    if place is Place.SPREAD:
        return np.ones((1, SAMPLES))
    return spring if place is Place.LOAD_CELL else spring[None]


def best(run: Callable[[], object], times: int) -> float:
    """Shortest of several runs, ms of processor time: what else runs here counts little."""
    spent = []
    for _ in range(times):
        start = time.process_time()
        run()
        spent.append(time.process_time() - start)
    return 1e3 * min(spent)


def loop(e: Effect, y: np.ndarray, s: Motion) -> None:
    """The first samples one by one."""
    state = e.initial(np.random.default_rng(0))
    for i in range(LOOPED):
        state, _ = e.step(state, y[..., i], s[i], s.dt)


def main() -> None:
    """Print the table."""
    s, slow = recording(), []
    print(f"{SAMPLES} samples{'':24}{'at once':>10}{'loop':>12}{'ratio':>9}")
    for cls in effects():
        word = next(iter(cls.places))
        e = cls.typical(word)
        y = signal(e.place, s)
        whole = best(lambda e=e, y=y: e.batch(y, s, np.random.default_rng(0)), 7)
        looped = best(lambda e=e, y=y: loop(e, y, s), 1) * SAMPLES / LOOPED
        slow += [cls.__name__] if whole > GOAL else []
        label = f"{cls.cause}{cls.form and f' ({cls.form})'}, {word}"
        print(f"{label:38}{whole:7.2f} ms{looped:9.0f} ms{looped / whole:9.0f}  {'' if whole <= GOAL else 'over the goal of 10 ms'}")
    print(f"{len(effects()) - len(slow)} of {len(effects())} effects within {GOAL:g} ms{': not ' + ', '.join(slow) if slow else ''}")


if __name__ == "__main__":
    main()
