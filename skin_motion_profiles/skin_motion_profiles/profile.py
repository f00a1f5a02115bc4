"""What a profile is: named parameters, and the motion that follows from them.

    sine = Sine(amplitude_mm=0.3, frequency_hz=0.5, periods=4)
    x, v, a = sine.trajectory().sample(t)

A new profile is one new file in `skin_motion_profiles.profiles`: a final frozen dataclass with a `kind` and `pieces`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from skin_motion_profiles.entry import Entry
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import number
from skin_motion_profiles.moves import hold, line
from skin_motion_profiles.trajectory import Piece, State, Trajectory

MM = 1e-3


@dataclass(frozen=True)
class Profile(Entry, ABC):
    """A motion that is known before it begins."""

    @abstractmethod
    def pieces(self, start: float) -> Iterable[Piece]:
        """The motion. `start` (m) is where the plunger is before it. Only relative profiles begin there, others at a depth of their own."""

    def trajectory(self, start: float = 0.0) -> Trajectory:
        """The motion as a function of time; `start` (m) matters to relative profiles only."""
        pieces = tuple(self.pieces(start))
        if not pieces:
            raise ProfileError(f"{self.kind} does not move and does not last: give it a way or a time")
        return Trajectory(pieces)

    @property
    def duration(self) -> float:
        """Length of the motion from the surface, s."""
        return self.trajectory().duration

    def sample(self, t: Any) -> State:
        """State (m, m/s, m/s^2) at times `t` (s)."""
        return self.trajectory().sample(t)


@dataclass(frozen=True)
class Moving(Profile, ABC):
    """A profile made of straight lines and rests."""

    acceleration_mm_s2: float = number("mm/s^2, acceleration at both ends of every line", 100.0, lower=0.1, upper=1e5)

    def line(self, a_mm: float, b_mm: float, speed_mm_s: float) -> tuple[Piece, ...]:
        """A straight line between two depths in mm."""
        return line(a_mm * MM, b_mm * MM, speed_mm_s * MM, self.acceleration_mm_s2 * MM)

    def rest(self, at_mm: float, duration: float) -> tuple[Piece, ...]:
        """A rest at a depth in mm."""
        return hold(at_mm * MM, duration)


def speed(doc: str = "mm/s, speed of every line", default: Any = 1.0) -> Any:
    """The parameter that most profiles call `speed_mm_s`."""
    return number(doc, default, lower=1e-3, upper=1e3)


def seconds(doc: str, default: Any) -> Any:
    """A time that may be zero."""
    return number(f"s, {doc}", default, lower=0.0, upper=1e5)


def check_presses(label: str, name: str, depths_mm: Iterable[float], base_mm: float) -> None:
    """Raise `ProfileError` for a depth (mm) at which a press goes up from a base in the air or at the surface: its sign is wrong."""
    wrong = next((at for at in depths_mm if at < base_mm <= 0.0), None)
    if wrong is not None:
        above = f"{name} = {wrong:g} lies in the air, above base_mm = {base_mm:g}"
        raise ProfileError(f"{label}: {above}: depths are positive into the skin; for a motion in the air give a base_mm above it")


def depth(doc: str, default: Any = None) -> Any:
    """A depth below the surface (negative in the air)."""
    return number(f"mm, {doc}", default, lower=-150.0, upper=150.0)
