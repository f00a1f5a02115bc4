"""How many steps per second spread and transfer function take on one core, beside what one would take instead.

    ./skin bench spread

All rows of one block see the same taxels (5 mm apart) and the same moving contacts. Rates are steps per second of processor time, so that
a busy machine does not decide. MuJoCo's rows are there if `pip install mujoco` was run; they are simulators of bodies and do more than
skin, but they are what people use for taxels: the last column says how many taxels respond to ten contacts (a vertex of the tactile
sensor only if a ball has reached it: nothing spreads).
"""

import time
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from skin_models.layout import A201_AREA, Layout, grid
from skin_models.materials import material
from skin_models.spread.compiled import CompiledSkin, compiles
from skin_models.spread.contacts import Contacts
from skin_models.spread.field import SpreadField
from skin_models.spread.kernels import Gaussian
from skin_models.transmission import Transmission

SKIN = material("silicone_4mm")
KERNEL = Gaussian(width=SKIN.spread_width)
PITCH, DT = 5e-3, 1e-3
SHARE = SKIN.model.dispersion.sensed_share


def rate(step: Callable[[int], object], seconds: float = 1.0) -> float:
    """Steps per second of processor time, after a warm-up."""
    for i in range(20):
        step(i)
    start, i = time.process_time(), 20
    while (spent := time.process_time() - start) < seconds:
        for _ in range(10):
            step(i)
            i += 1
    return (i - 20) / spent


def moving(layout: Layout, count: int, steps: int = 1000) -> tuple[np.ndarray, np.ndarray]:
    """Contacts crossing the patch at 0.1 m/s and bouncing off its edge: positions (steps, C, 3), forces (C,)."""
    rng, half = np.random.default_rng(0), layout.positions[:, :2].max()
    path = rng.uniform(-half, half, (count, 2)) + rng.normal(0, 0.1, (count, 2)) * DT * np.arange(steps)[:, None, None]
    folded = half - np.abs((path + half) % (4 * half) - 2 * half)
    return np.concatenate([folded, np.zeros((steps, count, 1))], axis=2), rng.uniform(1, 5, count)


def ours(layout: Layout, position: np.ndarray, force: np.ndarray) -> tuple[Callable, Callable]:
    """The compiled path, through its Python interface."""
    skin = CompiledSkin(SpreadField(layout, KERNEL, SHARE, A201_AREA), Transmission(SKIN.model.dispersion, DT))

    def step(i: int):
        skin.put(position[i % len(position)], force)
        return skin.advance(len(force))

    return step, lambda: int(np.count_nonzero(skin.advance(0).readings > 1e-3))


def plain(layout: Layout, position: np.ndarray, force: np.ndarray) -> tuple[Callable, Callable]:
    """This package without a C compiler."""
    field, through = SpreadField(layout, KERNEL, SHARE, A201_AREA), Transmission(SKIN.model.dispersion, DT)
    held = {"state": through.initial(len(layout))}

    def step(i: int):
        taxels = field.spread(Contacts(position[i % len(position)], force)).taxels
        held["state"], held["y"] = through.step(held["state"], taxels)

    return step, lambda: int(np.count_nonzero(held["y"] > 1e-3))


def _first_order() -> tuple[float, float]:
    """Pole and gain of the first-order filter that the two rivals below are given."""
    d = SKIN.model.dispersion
    pole = np.exp(-DT * (d.k1 + d.k2) / (d.b1 + d.b2))
    return pole, 1.0 - pole


def dense(layout: Layout, position: np.ndarray, force: np.ndarray) -> tuple[Callable, Callable]:
    """Dense numpy: every taxel times every contact, and a first-order filter."""
    xy, y, (pole, gain) = layout.positions[:, :2], np.zeros(len(layout)), _first_order()

    def step(i: int):
        d = xy[:, None, :] - position[i % len(position), None, :, :2]
        np.add(pole * y, gain * (np.exp(-(d**2).sum(axis=2) / KERNEL.width**2) @ force), out=y)

    return step, lambda: int(np.count_nonzero(y > 1e-3))


def tree(layout: Layout, position: np.ndarray, force: np.ndarray) -> tuple[Callable, Callable]:
    """k-d tree and numpy, and a first-order filter on every taxel."""
    points, y, (pole, gain) = cKDTree(layout.positions), np.zeros(len(layout)), _first_order()
    reach = KERNEL.reach(1e-6)

    def step(i: int):
        near = points.query_ball_point(position[i % len(position)], reach)
        contact = np.repeat(np.arange(len(force)), [len(n) for n in near])
        taxel = np.concatenate(near).astype(int)
        r2 = ((layout.positions[taxel] - position[i % len(position), contact]) ** 2).sum(axis=1)
        fed = np.bincount(taxel, np.exp(-r2 / KERNEL.width**2) * force[contact], y.size)
        np.add(pole * y, gain * fed, out=y)

    return step, lambda: int(np.count_nonzero(y > 1e-3))


def block(side: int, contacts: int) -> None:
    """One size: a table of all that run at it."""
    layout = grid(side, side, PITCH)
    position, force = moving(layout, contacts)
    rivals = {"dense numpy, first order": dense, "k-d tree and numpy, first order": tree, "this package, numpy": plain}
    fast = {"this package, compiled": ours} if compiles(KERNEL) else {}
    first = None
    for name, make in {**fast, **rivals}.items():
        step, responding = make(layout, position, force)
        reached = rate(step)
        first = first or reached
        print(f"{side * side:8d} {contacts:9d}  {name:36s} {reached:12,.0f} {reached / first:8.3f} {responding():11d}")


def bodies() -> None:
    """MuJoCo's three ways to have taxels, under ten balls."""
    try:
        from mujoco_taxels import WAYS, rate_of
    except ImportError:
        print("           MuJoCo is not installed (pip install mujoco): its rows are left out")
        return
    for name, scene in WAYS.items():
        taxels, reached, responding = rate_of(scene)
        print(f"{taxels:8d} {10:9d}  {name:36s} {reached:12,.0f} {'':8s} {responding:11d}")


def main() -> None:
    """Print the table."""
    print(f"{'taxels':>8s} {'contacts':>9s}  {'':36s} {'steps/s':>12s} {'ratio':>8s} {'responding':>11s}")
    for side, contacts in ((24, 10), (32, 10), (100, 10), (316, 100)):  # 24 x 24 = 576: the patch that SkinSim was shown with
        block(side, contacts)
    bodies()


if __name__ == "__main__":
    main()
