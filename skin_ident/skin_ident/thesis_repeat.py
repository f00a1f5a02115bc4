"""The thesis's experiments, repeated on a simulation of its rig and identified again: Tables 4-4, 4-5 and 4-7, and its validation.

The specimen has the parameters of Table 4-5; load cell, FlexiForce, converter and encoder are those of chapter 3. The motion is the sine
x = A sin(B t) + C from the surface to the depth that Tables 4-4 and 4-5 together imply (`thesis_dispersion`).
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.dispersion import FREE, fit_dispersion
from skin_ident.estimators.estimate import Estimate
from skin_ident.estimators.sinusoid import as_sinusoids
from skin_ident.estimators.transfer_function import TransferFunction
from skin_ident.recordings.recording import Recording
from skin_ident.thesis_dispersion import FreeMass
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.sensors.flexiforce import FlexiForce
from skin_models.sensors.load_cell import LoadCell
from skin_models.signals import Motion, motion
from skin_models.thesis.tables import estimates, transfer_functions

NAMES = ("b1", "k1", "b2", "k2")
DT = 0.01  # s, section 3.2.2
ENCODER = 5e-6 / 3  # m: the stage's accuracy of 5 um as three standard deviations
IDEAL = FlexiForce(hysteresis=0.0, drift=0.0, noise=3e-3)
AS_SOLD = FlexiForce(hysteresis=0.02, drift=0.03, noise=3e-3)
LOAD_CELL = LoadCell(noise=2e-3)
PERIOD = 16.0  # s, of the sine
DEEPEST = {2: 0.3e-3, 4: 1.0e-3, 6: 1.5e-3}  # m, largest depth of the validation by thickness (mm), section 4.3.2
SPEED = 1e-3  # m/s, of the validation's moves
TRIALS = 3
PRINTED = {2: 0.0370, 4: 0.0628, 6: 0.0173}  # relative mean squared errors of the validation
PRINTED_FRUBBER = 0.155


def specimen(case: FreeMass) -> Dispersion:
    """The skin of Table 4-5."""
    return Dispersion(m=case.known, **{name: e.value for name, e in estimates("4-5", f"{case.thickness_mm}mm").items() if name in NAMES})


def sine(case: FreeMass, share: float = 0.95) -> Motion:
    """Four periods of the identification motion about its mean depth, with `share` of its amplitude."""
    t, w = np.arange(round(4 * PERIOD / DT)) * DT, 2 * np.pi / PERIOD
    a = share * case.amplitude
    return Motion(t, case.amplitude + a * np.sin(w * t), a * w * np.cos(w * t), -a * w**2 * np.sin(w * t), DT)


def random_moves(thickness_mm: int, seed: int) -> Motion:
    """Straight moves at 1 mm/s between 20 random depths, each held for a second."""
    rng = np.random.default_rng([thickness_mm, seed])
    knots = np.concatenate([[0.0], rng.uniform(0.05, 1.0, 20) * DEEPEST[thickness_mm], [0.0]])
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(knots)) / SPEED + 1.0)])
    moves = np.column_stack([times[:-1], times[:-1] + np.abs(np.diff(knots)) / SPEED]).ravel()
    t = np.arange(int(times[-1] / DT)) * DT
    return motion(t, np.interp(t, moves, np.repeat(knots, 2)[1:-1]))


def recorded(skin: Dispersion, s: Motion, seed: int, taxel: FlexiForce) -> Recording:
    """The recording that the rig of chapter 3 makes of a skin under the motion `s`."""
    response = Model(skin, (1.0,)).simulate(s)
    return Recording(
        name=f"trial {seed}",
        t=s.t,
        depth=s.x + ENCODER * np.random.default_rng(seed).normal(size=s.t.size),
        force=LOAD_CELL.sensor().measure(response.force, DT, seed).force,
        taxels=taxel.sensor().measure(response.taxels[0], DT, seed + 1).force[None],
    )


def recovered(case: FreeMass, taxel: FlexiForce = IDEAL) -> Estimate:
    """Table 4-5 from `TRIALS` trials of the sine."""
    return fit_dispersion([recorded(specimen(case), sine(case), 10 * seed, taxel) for seed in range(TRIALS)], case.known)


def free_and_fixed(case: FreeMass) -> tuple[Estimate, Estimate]:
    """One trial, whose force contains the constant that Table 4-4 calls a mass, fitted as in Table 4-4 (mass free) and 4-5 (mass fixed)."""
    free = estimates("4-4", f"{case.thickness_mm}mm")
    skin = Dispersion(m=free["m"].value, **{name: free[name].value for name in NAMES})
    s = sine(case)
    whole = skin.m * (s.a - 9.80665) + (skin.b1 + skin.b2) * s.v + (skin.k1 + skin.k2) * s.x  # no loss of contact: as eq 27 is fitted
    response = LOAD_CELL.sensor().measure(whole, DT, 1).force, IDEAL.sensor().measure(skin.b1 * s.v + skin.k1 * s.x, DT, 2).force
    noise = ENCODER * np.random.default_rng(1).normal(size=s.t.size)
    r = Recording(f"{case.thickness_mm} mm", s.t, s.x + noise, response[0], response[1][None])
    parts, motions, _ = as_sinusoids([r])
    return fit_dispersion(parts, FREE, motions), fit_dispersion(parts, case.known, motions)


def validation(case: FreeMass, runs: int = 10) -> np.ndarray:
    """Relative mean squared errors (runs,) of the sensed force under random moves, predicted by a model that was fitted to a sine with the
    same taxel (of data-sheet quality)."""
    out, skin = [], specimen(case)
    for seed in range(runs):
        fit = fit_dispersion([recorded(skin, sine(case), 10 * seed, AS_SOLD)], case.known)
        moves = random_moves(case.thickness_mm, seed)
        measured = recorded(skin, moves, 10 * seed + 5, AS_SOLD).taxels[0]
        predicted = fit.model.simulate(moves).taxels[0]
        out.append(np.mean((measured - predicted) ** 2) / np.mean(measured**2))
    return np.array(out)


def averages(case: FreeMass, runs: int = 10) -> np.ndarray:
    """The same (runs,), as the thesis did it: predicted by the averages of Table 4-5, for a sample drawn with the scatter of its samples,
    and with another taxel."""
    out, spread = [], estimates("4-5", f"{case.thickness_mm}mm")
    for seed in range(runs):
        rng, moves = np.random.default_rng([case.thickness_mm, seed, 1]), random_moves(case.thickness_mm, seed)
        drawn = {name: max(0.1 * spread[name].value, rng.normal(spread[name].value, spread[name].std)) for name in NAMES}
        measured = recorded(Dispersion(m=case.known, **drawn), moves, seed, FlexiForce.drawn(rng, 3e-3)).taxels[0]
        predicted = Model(specimen(case), (1.0,)).simulate(moves).taxels[0]
        out.append(np.mean((measured - predicted) ** 2) / np.mean(measured**2))
    return np.array(out)


@dataclass(frozen=True)
class Frubber:
    """Relative mean squared errors of predicting experiment 3 (1 mm/s) by experiment 2 (1 mm/s), by 1 (0.25 mm/s), and by their average."""

    same_speed: float
    slower: float
    average: float


def frubber() -> Frubber:
    """The errors of Table 4-7's transfer functions on the same random force without noise: the effect of the choice of speed alone."""
    one, two, three = (np.array([f.b1, f.k1, f.b1 + f.b2, f.k1 + f.k2]) for f in transfer_functions())
    u = np.maximum(0.0, Model(Dispersion(m=0.0, b1=0.0, k1=6e3, b2=0.0, k2=0.0), (1.0,)).simulate(random_moves(4, 1)).taxels[0])

    def simulated(theta: np.ndarray) -> np.ndarray:
        return TransferFunction(tuple(theta[:2]), tuple(theta[2:])).simulate(u, DT)

    truth = simulated(three)
    errors = [float(np.mean((simulated(theta) - truth) ** 2) / np.mean(truth**2)) for theta in (two, one, (one + two) / 2)]
    return Frubber(*errors)
