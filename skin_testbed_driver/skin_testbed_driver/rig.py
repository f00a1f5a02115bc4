"""What a rig is: an axis that presses a plunger into skin, a load cell on it, and taxels below. A new rig is one file.

The driver calls, once per sample and always from one thread,

    reading = rig.read()                 what the sensors say now
    rig.command(position, velocity)      where the axis must be at the next sample, and how fast

Positions are those of the stage, m, growing towards the skin; the driver subtracts the zero. A reading never lies: what is not known
is NaN, and the driver stops or marks it.
"""

import math
from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np

from skin_models.errors import SkinError
from skin_models.layout import Layout


class RigError(SkinError):
    """The rig cannot be opened, read or commanded."""


NOTHING = np.empty(0)  # of a signal that a rig does not have


class Reading(NamedTuple):  # the immutable kind of object that is quickest to make
    """One synchronous sample. A rig gives volts or newtons, whichever its hardware knows; the other stays NaN or empty.

    Compression is positive. The two truths are known to a simulation only.
    """

    position: float  # m, of the stage
    load_cell_voltage: float = math.nan  # V
    force: float = math.nan  # N
    taxel_voltage: np.ndarray = NOTHING  # V, (T,) or empty
    taxel_force: np.ndarray = NOTHING  # N, (T,) or empty
    force_truth: float | None = None  # N
    taxels_truth: np.ndarray | None = None  # N, (T,)


class Rig(ABC):
    """The interface. `layout` and `travel` are valid once the rig is open."""

    layout: Layout
    travel: tuple[float, float]  # m, stage positions that the axis can reach
    # True where time belongs to the rig (simulation, replay): every sample is exactly one period after the last, however late the
    # driver's thread wakes. False for hardware: the driver reads its clock at every sample.
    owns_time: bool = False
    # False for a recording: it cannot be commanded, its positions count from the surface already, and nothing in it is a danger.
    moves: bool = True

    @abstractmethod
    def open(self, sample_rate: float) -> None:
        """Get ready to be read at `sample_rate` (Hz). Raises `RigError`."""

    @abstractmethod
    def read(self) -> Reading:
        """The sample of this instant. Must not block. Raises `RigError` when the rig is lost."""

    @abstractmethod
    def command(self, position: float, velocity: float) -> None:
        """Be at `position` (m) with `velocity` (m/s) one period from now. Raises `RigError` when the rig is lost."""

    def prepare(self) -> None:  # noqa: B027  (hardware goes on by itself)
        """Called when a sample is out and the next command is known: a simulation computes the next reading now, not when it is due."""

    def place(self, x: float, y: float) -> None:
        """Begin to bring the point (x, y) m of the skin's frame under the plunger. Raises `RigError` where no motor does that."""
        raise RigError("this rig has no motorised x-y stage: move it by hand, then call the profile server's service proceed")

    def placed(self) -> tuple[float, float] | None:
        """The point of the skin (m) that is under the plunger now; None where nobody knows."""
        return None

    def facts(self) -> dict[str, Any]:
        """What `rig.yaml` may say of this rig: encoder_step_um, force_step_n, taxel_step_n, plunger_diameter_mm, …"""
        return {}

    def halt(self) -> None:  # noqa: B027  (a rig without a brake has nothing to do)
        """Stop the axis by its own means, for when its position is not known. A rig that has a brake or an enable line uses it."""

    def close(self) -> None:  # noqa: B027
        """Release what `open` took. The axis stands still afterwards."""
