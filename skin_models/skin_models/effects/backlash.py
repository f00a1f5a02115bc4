"""Backlash: depth is lost at every reversal of the drive.

    plain       tip depth = P[x],  the play operator of half width gap / 2 (`skin_models.operators.play`)
    zeroed      tip depth = P[x] + (gap / 2) zero
    wind-up     tip depth = x + (gap / 2) (zero - z),  z Dahl's bristles over a distance (`skin_models.operators.bristles`)
    encoder     tip depth = x - (gap / 2) (zero - z'),  z' the same z of the path a `lead` later

The drive starts in the middle of its gap. So the zero of depth is there, unless it was found by touching (`zero` = 1: on the way in,
-1: on the way out). A drive that rubs winds up at every reversal until it slips: the same depth is lost, but with a rounded corner. All are
exact for any path that is monotone between samples. Where the encoder hangs on a slack coupling, it is the reading that rests while the
tip turns, and the tip that is ahead. Its crossing of the gap is not read; it is over when the reading moves, and taken to happen a `lead`
before that, and as fast as the reading then moves over a `distance`, which lets the encoder's own trembling pass. A running simulation
cannot look ahead and has no lead.

Sources: M. Nordin and P.-O. Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38 (2002) 1633-1649; P. Dahl, A
Solid Friction Model, TOR-0158, 1968.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skin_models.effect import Dynamic, Place
from skin_models.operators.bristles import bristles, bristles_step
from skin_models.operators.play import play, play_step
from skin_models.parameter import SHAPE, quantity
from skin_models.signals import Motion, Sample


@dataclass(frozen=True)
class Backlash(Dynamic):
    """A gap between encoder and tip."""

    cause: ClassVar[str] = "backlash"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Nordin and Gutman 2002"

    gap: float = quantity("m", 0.0, lower=0.0, upper=5e-3, typical=0.1e-3, scan=(2e-6, 10e-6, 100e-6), doc="whole width of the gap")

    def initial(self, rng=None) -> None:
        """None: the first sample is taken as rest. From then on the state is the tip's depth, m."""
        return None

    def step(self, state, y, s: Sample, dt: float):
        """min(x + gap / 2, max(x - gap / 2, last tip))."""
        tip = play_step(state, y, 0.5 * self.gap)
        return tip, tip

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The play operator over the whole recording."""
        return play(y, 0.5 * self.gap)


@dataclass(frozen=True)
class ZeroedBacklash(Backlash):
    """The same gap with the zero of depth not in its middle: depth is right on the way in, or on the way out."""

    form: ClassVar[str] = "zeroed"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = Backlash

    zero: float = quantity("1", 0.0, lower=-1.0, upper=1.0, role=SHAPE, typical=1.0, doc="where in its gap depth is right: 1 on the way in")

    def step(self, state, y, s: Sample, dt: float):
        """The tip in its gap, and (gap / 2) zero more."""
        state, tip = super().step(state, y, s, dt)
        return state, tip + 0.5 * self.gap * self.zero

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The play operator over the whole recording, and (gap / 2) zero more."""
        return super().batch(y, s) + 0.5 * self.gap * self.zero


@dataclass(frozen=True)
class WindUp(Dynamic):
    """A drive that winds up before it slips. With a distance much longer than the path it equals a softer rig: tried only after the gap."""

    cause: ClassVar[str] = "backlash"
    form: ClassVar[str] = "wind_up"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Dahl 1968"
    proposed: ClassVar[bool] = False
    refines: ClassVar[type] = Backlash

    gap: float = quantity("m", 0.0, lower=0.0, upper=5e-3, typical=0.1e-3, doc="whole depth that is lost")
    distance: float = quantity("m", 1e-5, lower=1e-7, upper=1e-2, role=SHAPE, typical=1e-5, doc="way over which the drive winds up")
    zero: float = quantity("1", 0.0, lower=-1.0, upper=1.0, role=SHAPE, typical=1.0, doc="where in its gap depth is right: 1 on the way in")

    def initial(self, rng=None) -> tuple[float, None]:
        """Not wound up, before the first sample."""
        return 0.0, None

    def step(self, state, y, s: Sample, dt: float):
        """x + (gap / 2) (zero - z)."""
        state = bristles_step(state, y, self.distance)
        return state, y + 0.5 * self.gap * (self.zero - state[0])

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same over the whole recording."""
        return y + 0.5 * self.gap * (self.zero - bristles(y, self.distance))


@dataclass(frozen=True)
class SlackEncoder(Dynamic):
    """An encoder on a slack coupling: its reading loses depth, the tip does not."""

    cause: ClassVar[str] = "backlash"
    form: ClassVar[str] = "encoder"
    places: ClassVar = {"rig": Place.DEPTH}
    source: ClassVar[str] = "Nordin and Gutman 2002, the other way round"
    supple: ClassVar[bool] = True

    gap: float = quantity("m", 0.0, lower=0.0, upper=5e-3, typical=0.1e-3, scan=(2e-6, 20e-6), doc="whole depth that the reading loses")
    distance: float = quantity(
        "m", 3e-6, lower=1e-7, upper=1e-3, role=SHAPE, typical=3e-6, scan=(3e-6,), doc="way of the reading over which the gap is crossed"
    )
    lead: float = quantity("s", 0.0, lower=0.0, upper=0.5, role=SHAPE, typical=0.0, scan=(0.01, 0.04), doc="how long before the reading")
    zero: float = quantity(
        "1", 0.0, lower=-1.0, upper=1.0, role=SHAPE, typical=0.0, scan=(0.0,), doc="where in its gap depth is right: 1 on the way in"
    )

    def initial(self, rng=None) -> tuple[float, None]:
        """In the middle of the gap, before the first sample."""
        return 0.0, None

    def step(self, state, y, s: Sample, dt: float):
        """x - (gap / 2) (zero - z), crossed as soon as the reading moves: nobody can look ahead."""
        state = bristles_step(state, y, self.distance)
        return state, y - 0.5 * self.gap * (self.zero - state[0])

    def batch(self, y: np.ndarray, s: Motion, rng=None) -> np.ndarray:
        """The same over the whole recording, crossed `lead` before the reading moves."""
        now = np.arange(y.size)
        ahead = np.interp(now + self.lead / s.dt, now, y)
        return y - 0.5 * self.gap * (self.zero - bristles(ahead, self.distance))
