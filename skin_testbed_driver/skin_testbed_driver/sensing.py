"""From a rig's reading to what is published: volts to newtons, offsets, speed, and the status of every taxel.

A value that cannot be trusted is NaN. A sensor is *stuck* if it repeats one raw value, digit for digit, for `stuck_time` while what
presses on it changes: real converters never do that under a changing load.
"""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from skin_testbed_driver.calibration import Calibration
from skin_testbed_driver.rig import Reading

# The statuses of TaxelArray.
OK, SATURATED, STALE, STUCK, DEAD, UNCALIBRATED = range(6)

LOAD_CELL_FULL_SCALE = 9.99  # V, NI 9201 (thesis, section 3.1)
TAXEL_FULL_SCALE = 4.99  # V, Phidgets 1120 (section 3.3.1)
_STUCK_DEPTH = 5e-5  # m, by how much the plunger has to move in the skin before a load cell that shows no change is stuck
_STUCK_FORCE = 1.0  # N, and by how much the force has to change before a taxel is


@dataclass(frozen=True)
class Sample:
    """One published sample: m, m/s, N, V; compression positive; taxel arrays are (T,)."""

    depth: float
    speed: float
    force: float
    force_voltage: float
    taxel_force: np.ndarray
    taxel_voltage: np.ndarray
    taxel_status: np.ndarray
    position: float  # m, of the stage
    load: float  # N, on the load cell before any tare: what the limit counts
    taxel_untared: np.ndarray  # N, (T,)
    force_truth: float | None = None
    taxels_truth: np.ndarray | None = None


class Differentiator:
    """Speed as the slope of the least-squares line through the last `size` depths, delayed by half their span; NaN until there are two."""

    def __init__(self, size: int, period: float) -> None:
        """`size` samples, `period` seconds apart. Two samples are the finite difference of the thesis (section 3.2.2)."""
        self._depths: deque[float] = deque(maxlen=max(size, 2))
        self._period = period

    def add(self, depth: float) -> float:
        """Take one more depth (m), and give the speed (m/s)."""
        self._depths.append(depth)
        n = len(self._depths)
        if n < 2:
            return math.nan
        if n == 2:
            return (self._depths[1] - self._depths[0]) / self._period
        centre = 0.5 * (n - 1)
        slope = sum((i - centre) * x for i, x in enumerate(self._depths))
        return slope * 12.0 / (n * (n * n - 1) * self._period)

    def clear(self) -> None:
        """Forget, because the zero has moved."""
        self._depths.clear()


class Stuckness:
    """Which of several signals repeat their raw value while what drives them goes farther than `change` from where it was."""

    def __init__(self, change: np.ndarray, samples: int) -> None:
        """`change` (n,), in the unit of each signal's drive; `samples` repeats are needed."""
        self._change, self._samples = change, samples
        self._last = np.full(change.size, np.nan)
        self._repeats = np.zeros(change.size, int)
        self._start, self._farthest = np.zeros(change.size), np.zeros(change.size)

    def add(self, raw: np.ndarray, drive: np.ndarray) -> np.ndarray:
        """Take one more sample (n,) and what drives it (n,); gives booleans (n,)."""
        same = raw == self._last
        new = ~same
        self._last = raw
        self._repeats += 1
        self._repeats[new], self._farthest[new] = 0, 0.0
        np.copyto(self._start, drive, where=new)
        np.fmax(self._farthest, np.abs(drive - self._start), self._farthest)  # fmax: a drive may be NaN for a while
        if self._repeats.max() < self._samples:
            return new & same  # none
        return (self._repeats >= self._samples) & (self._farthest > self._change)


class Sensing:
    """Everything between a reading and a sample, with its memory."""

    def __init__(self, calibration: Calibration, zero: float, period: float, speed_samples: int = 2, stuck_time: float = 0.5) -> None:
        """`zero`: stage position (m) of depth zero; `period`: of the samples (s)."""
        count, repeats = calibration.taxels.size, max(round(stuck_time / period), 2)
        self.calibration, self.zero = calibration, zero
        self.force_offset, self.taxel_offset = 0.0, np.zeros(count)
        self._speed = Differentiator(speed_samples, period)
        # The load cell first: the plunger's depth drives it, and the load drives the taxels.
        self._stuck = Stuckness(np.array([_STUCK_DEPTH] + count * [_STUCK_FORCE]), repeats)

    def sample(self, r: Reading) -> Sample:
        """The sample of one reading."""
        depth = r.position - self.zero
        volts = not math.isnan(r.load_cell_voltage)
        load = self.calibration.force(r.load_cell_voltage) if volts else r.force
        stuck = self._repeating(r, r.load_cell_voltage if volts else r.force, depth, load)
        load = math.nan if stuck[0] else load
        saturated = abs(r.load_cell_voltage) >= LOAD_CELL_FULL_SCALE
        untared, status = self._taxel(r, stuck[1:])
        return Sample(
            depth=depth, speed=self._speed.add(depth), force=math.nan if saturated else load - self.force_offset,
            force_voltage=r.load_cell_voltage, taxel_force=untared - self.taxel_offset, taxel_voltage=r.taxel_voltage,
            taxel_status=status, position=r.position, load=load, taxel_untared=untared,
            force_truth=r.force_truth, taxels_truth=r.taxels_truth,
        )  # fmt: skip

    def move_zero(self, depth: float) -> None:
        """Call the present `depth` (m) zero."""
        self.zero += depth
        self._speed.clear()

    def _repeating(self, r: Reading, load_cell: float, depth: float, load: float) -> np.ndarray:
        raw, drive = np.empty(self.taxel_offset.size + 1), np.empty(self.taxel_offset.size + 1)
        raw[0], raw[1:] = load_cell, r.taxel_voltage if r.taxel_voltage.size else r.taxel_force
        # In the air a quiet cell may well repeat itself.
        drive[0], drive[1:] = max(depth, 0.0), load
        return self._stuck.add(raw, drive)

    def _taxel(self, r: Reading, stuck: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        volts = r.taxel_voltage.size > 0
        raw = r.taxel_voltage if volts else r.taxel_force
        force = self.calibration.taxel_force(raw) if volts else raw
        status = np.zeros(raw.size, np.uint8)
        status[np.isnan(force)] = UNCALIBRATED
        if volts:
            status[raw >= TAXEL_FULL_SCALE] = SATURATED
        status[stuck] = STUCK
        status[np.isnan(raw)] = STALE
        return np.where(status == OK, force, np.nan), status
