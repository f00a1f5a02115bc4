"""Explicit, position-based force control along a force profile (the thesis's future work, section 5.2).

The speed of the position controller below is made of a feedforward of the wanted rate and an answer to the error,

    v = (F_d' + w (F_d - F)) / k,

with the skin's stiffness k. On a skin F = k x this gives an error that decays with rate w, and none in the end: the depth itself is
the integrator. The sampled loop answers after a delay T; w T <= 1/2 keeps it free of overshoot on a spring.

Source: B. Siciliano and L. Villani, Robot Force Control, Kluwer 1999, section 2.4 (force control with an inner position loop).
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from skin_motion_profiles.control import Controlled
from skin_motion_profiles.fields import number, numbers
from skin_motion_profiles.profile import MM, seconds
from skin_motion_profiles.trajectory import Piece, State


@dataclass(frozen=True)
class ExplicitForce(Controlled):
    """From contact through `forces_n`, one ramp and one hold each, by the measured force."""

    kind: ClassVar[str] = "explicit_force"
    example: ClassVar = {"forces_n": [5.0, 2.0, 8.0], "stiffness_n_mm": 12.0, "deepest_mm": 1.5}

    forces_n: tuple[float, ...] = numbers("N, forces to hold, in order", ..., lower=0.0, upper=1e4)
    stiffness_n_mm: float = number("N/mm, stiffness of the skin; too low a guess overshoots", lower=1e-3, upper=1e5)
    ramp_n_s: float = number("N/s, rate between two forces", 5.0, lower=1e-3, upper=1e5)
    hold_s: float = seconds("at every force", 3.0)
    bandwidth_rad_s: float = number("rad/s, rate w at which an error decays", 3.0, lower=0.01, upper=100.0)

    @property
    def duration(self) -> float:
        """Time of all ramps and holds, s."""
        return float(self._corners[0][-1])

    @property
    def _corners(self) -> tuple[np.ndarray, np.ndarray]:
        """Times (s) and forces (N) between which the target is linear."""
        times, forces = [0.0], [self.contact_n]
        for a, b in pairwise((self.contact_n, *self.forces_n)):
            times += [times[-1] + abs(b - a) / self.ramp_n_s, times[-1] + abs(b - a) / self.ramp_n_s + self.hold_s]
            forces += [b, b]
        return np.array(times), np.array(forces)

    def target(self, t: float) -> tuple[float, float]:
        """Force (N) and rate (N/s) at time `t` (s): ramps at `ramp_n_s` and holds in turn, from contact."""
        times, forces = self._corners
        i = min(max(int(np.searchsorted(times, t, side="right")) - 1, 0), times.size - 2)
        span = times[i + 1] - times[i]
        rate = (forces[i + 1] - forces[i]) / span if span > 0.0 and t < times[-1] else 0.0
        return float(np.interp(t, times, forces)), float(rate)

    def answer(self, t: float, state: State, force: float, age: float) -> tuple[Piece, ...]:
        """Go on with v = (F_d' + w (F_d - F)) / k; F_d is that of the moment at which `force` was measured."""
        (wanted, _), (_, rate) = self.target(t - age), self.target(t)
        return self.change_speed(state, (rate + self.bandwidth_rad_s * (wanted - force)) / (self.stiffness_n_mm / MM))

    def slowest_sampling(self) -> float:
        """1 / (2 w), s: the delay up to which a spring is not overshot."""
        return 0.5 / self.bandwidth_rad_s
