"""Contacts driven by force through a skin with effects: all at once, against a root finder for every contact.

The rival is what one writes first: Brent's method on a trial step of the model, contact by contact. Both find the same depths. Processor
time, so that a busy machine changes the numbers little and the ratio hardly at all.
"""

import time
from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from skin_models.column import at_rest, press, skin_of
from skin_models.effects.cyclic_softening import CyclicSoftening
from skin_models.effects.hysteresis import SkinHysteresis
from skin_models.effects.nonlinear_stiffness import PolynomialStiffness
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.layout import grid
from skin_models.materials import material
from skin_models.model import Model, Response, State
from skin_models.signals import Sample
from skin_models.simulated_skin import Presses, SimulatedSkin

DT = 1e-3  # s
SILICONE = material("silicone_4mm").model
MODELS = {
    "relaxation": SILICONE.extended(StressRelaxation.typical("skin")),
    "four effects": SILICONE.extended(StressRelaxation.typical("skin")).extended(SkinHysteresis.typical("skin"))
    .extended(PolynomialStiffness.typical("skin")).extended(CyclicSoftening.typical("skin")),
}  # fmt: skip


def forces(count: int, i: int) -> np.ndarray:
    """What the contacts press with at sample `i`, N."""
    return 3.0 + 2.0 * np.sin(0.01 * i + np.arange(count))


def one_by_one(skin: Model, count: int) -> Callable[[int], np.ndarray]:
    """A step of all contacts by Brent's method; gives the depths."""
    states, x, v = [skin.step(skin.initial(), Sample(-DT, 0.0, 0.0, 0.0), DT)[0]] * count, np.zeros(count), np.zeros(count)

    def step(i: int) -> np.ndarray:
        for k, force in enumerate(forces(count, i)):
            states[k], found = _brent(skin, states[k], x[k], v[k], float(force), i * DT)
            v[k], x[k] = (found - x[k]) / DT, found
        return x.copy()

    return step


def _brent(skin: Model, state: State, x: float, v: float, force: float, t: float) -> tuple[State, float]:
    def trial(depth: float) -> tuple[State, Response]:
        speed = (depth - x) / DT
        return skin.step(state, Sample(t, depth, speed, (speed - v) / DT), DT)

    def excess(depth: float) -> float:
        return trial(depth)[1].force_truth - force if depth > 0.0 else -force

    high = max(x, 1e-6)
    while excess(high) < 0.0:
        high *= 2.0
    found = brentq(excess, 0.0, high, xtol=1e-13, rtol=1e-12)
    return trial(found)[0], found


def at_once(skin: Model, count: int) -> Callable[[int], np.ndarray]:
    """The same by `press`."""
    columns, nothing = at_rest(skin, tuple(map(str, range(count))), DT), np.full(count, np.nan)

    def step(i: int) -> np.ndarray:
        nonlocal columns
        columns, _, _ = press(skin, columns, forces(count, i), nothing, i * DT, DT)
        return columns.x

    return step


def cost(step: Callable[[int], np.ndarray], steps: int) -> tuple[float, np.ndarray]:
    """Processor time per step, us, and the last depths."""
    start = time.process_time()
    for i in range(steps):
        x = step(i)
    return 1e6 * (time.process_time() - start) / steps, x


def whole_skin(model: Model, count: int, steps: int) -> float:
    """Steps per second of 10,000 taxels under `count` moving contacts with this model's skin."""
    skin = SimulatedSkin(model, grid(100, 100, 5e-3), DT, fast=True)
    state, keys, place = skin.initial(), tuple(map(str, range(count))), np.random.default_rng(0).uniform(-0.2, 0.2, (count, 3))
    place[:, 2] = 0.0
    start = time.process_time()
    for i in range(steps):
        moved = place + np.array([0.01 * np.sin(0.01 * i), 0.0, 0.0])
        state, _ = skin.step(state, Presses(keys, moved, forces(count, i), np.full(count, np.nan), np.zeros(count)))
    return steps / (time.process_time() - start)


def main() -> None:
    """Print the tables."""
    print(f"{'us per contact and step':24}{'contacts':>9}{'at once':>10}{'one by one':>12}{'ratio':>8}{'depths differ by':>19}")
    for name, model in MODELS.items():
        for count in (1, 10, 100, 1000):
            skin, steps = skin_of(model), 200
            fast, _ = cost(at_once(skin, count), steps)
            few = max(200 // count, 2)
            slow, _ = cost(one_by_one(skin, min(count, 10)), few)
            slow *= count / min(count, 10)
            gap = np.max(np.abs(cost(at_once(skin, min(count, 10)), few)[1] - cost(one_by_one(skin, min(count, 10)), few)[1]))
            print(f"{name:24}{count:9}{fast / count:10.2f}{slow / count:12.1f}{slow / fast:8.0f}{1e9 * gap:16.1e} nm")
    for name, model in MODELS.items():
        for count in (10, 100):
            print(f"10,000 taxels under {count} contacts, {name}: {whole_skin(model, count, 300):.0f} steps/s")


if __name__ == "__main__":
    main()
