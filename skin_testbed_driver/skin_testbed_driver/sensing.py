"""From a rig's reading to what is published: volts to newtons, offsets, speed, and the status of every taxel.

A value that cannot be trusted is NaN. A sensor is *stuck* if it repeats one raw value, digit for digit, for `stuck_time` while what
presses on it changes: real converters never do that under a changing load.
"""

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from skin_testbed_driver.calibration import Calibration
from skin_testbed_driver.rig import Reading

# The statuses of TaxelArray.
OK, SATURATED, STALE, STUCK, DEAD, UNCALIBRATED = range(6)

LOAD_CELL_FULL_SCALE = 9.99  # V, NI 9201 (thesis, section 3.1)
TAXEL_FULL_SCALE = 4.99  # V, Phidgets 1120 (section 3.3.1)
_STUCK_DEPTH = 5e-5  # m, by how much the plunger has to move in the skin before a load cell that shows no change is stuck
_STUCK_FORCE = 1.0  # N, and by how much the force has to change before a taxel is


class Sample(NamedTuple):  # the immutable kind of object that is quickest to make
    """One published sample: m, m/s, N, V; compression positive; taxel arrays are (T,)."""

    depth: float
    speed: float
    force: float
    force_voltage: float  # of a rig that measures N: what eq. 25 would have it be
    taxel_force: np.ndarray
    taxel_voltage: np.ndarray
    taxel_status: np.ndarray
    position: float  # m, of the stage
    load: float  # N, on the load cell before any tare: what the limit counts; infinite where the cell is saturated
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


class StuckCell:
    """Whether the load cell repeats its raw value while the plunger goes deeper.

    Only its way into the skin counts: on the way out skin that recovers slowly parts from the plunger, and there is nothing to feel.
    """

    def __init__(self, samples: int) -> None:
        """`samples` repeats are needed."""
        self._samples = samples
        self._last, self._repeats = math.nan, 0
        self._least, self._advance = 0.0, 0.0

    def add(self, raw: float, depth: float) -> bool:
        """Take one more value and the depth (m) at which it was taken."""
        depth = max(depth, 0.0)  # in the air a quiet cell may well repeat itself
        if raw != self._last:
            self._last, self._repeats, self._least, self._advance = raw, 0, depth, 0.0
            return False
        self._repeats += 1
        self._least = min(self._least, depth)
        self._advance = max(self._advance, depth - self._least)
        return self._repeats >= self._samples and self._advance > _STUCK_DEPTH


class StuckTaxels:
    """Which taxels repeat their raw value while the load goes farther than `_STUCK_FORCE` from where it was when that began.

    Long repeats are rare: so only the sample at which each taxel last changed is kept, and checked once the longest repeat may be enough.
    """

    def __init__(self, count: int, samples: int) -> None:
        """`samples` repeats are needed."""
        self._samples, self._now = samples, 0
        self._check = 0 if count else math.inf  # no taxel can be suspected before this sample
        self._last, self._new = np.full(count, np.nan), np.empty(count, bool)
        self._since = np.zeros(count, int)  # the sample at which each began to repeat itself
        self._loads: deque[float] = deque(maxlen=samples + 1)
        self._start, self._farthest = np.zeros(count), np.zeros(count)  # N, of the suspects: load at `_since`, greatest change from it

    def add(self, raw: np.ndarray, load: float) -> np.ndarray | None:
        """Take one more sample (T,) and the load (N); gives booleans (T,), or None for no taxel at all."""
        self._now += 1
        self._loads.append(load)
        new = np.not_equal(raw, self._last, self._new)
        self._last = raw
        np.copyto(self._since, self._now, where=new)
        return self._suspects(load) if self._now >= self._check else None

    def _suspects(self, load: float) -> np.ndarray | None:
        repeats = self._now - self._since
        longest = int(repeats.max())
        self._check = self._now + max(self._samples - longest, 0)
        if longest < self._samples:
            return None
        begin = repeats == self._samples
        if begin.any():
            loads = np.array(self._loads)
            self._start[begin] = loads[0]
            self._farthest[begin] = np.fmax.reduce(np.abs(loads - loads[0]))
        np.fmax(self._farthest, np.abs(load - self._start), self._farthest)  # fmax: a load may be NaN for a while
        stuck = (repeats >= self._samples) & (self._farthest > _STUCK_FORCE)
        return stuck if stuck.any() else None


class Sensing:
    """Everything between a reading and a sample, with its memory."""

    def __init__(self, calibration: Calibration, zero: float, period: float, speed_samples: int = 2, stuck_time: float = 0.5) -> None:
        """`zero`: stage position (m) of depth zero; `period`: of the samples (s)."""
        count, repeats = calibration.taxels.size, max(round(stuck_time / period), 2)
        self.calibration, self.zero = calibration, zero
        self.force_offset, self._taxel_offset, self._tared = 0.0, np.zeros(count), False
        self._speed = Differentiator(speed_samples, period)
        self._stuck_cell, self._stuck_taxels = StuckCell(repeats), StuckTaxels(count, repeats)
        self._all_calibrated = bool(np.isfinite(calibration.taxels).all())
        self._all_ok = np.zeros(count, np.uint8)
        self._all_ok.flags.writeable = False  # every good sample shares it

    def sample(self, r: Reading) -> Sample:
        """The sample of one reading."""
        depth = r.position - self.zero
        volts = not math.isnan(r.load_cell_voltage)
        voltage = r.load_cell_voltage if volts else r.force / self.calibration.load_cell
        load = self.calibration.force(voltage) if volts else r.force
        stuck = self._stuck_cell.add(r.load_cell_voltage if volts else r.force, depth)
        untared, status = self._taxel(r, load)
        saturated = abs(r.load_cell_voltage) >= LOAD_CELL_FULL_SCALE
        load = math.nan if stuck else math.copysign(math.inf, load) if saturated else load
        force = math.nan if saturated else load - self.force_offset
        taxels = untared - self._taxel_offset if self._tared else untared
        # In the order of its fields: names would be looked up again for every sample.
        return Sample(
            depth, self._speed.add(depth), force, voltage, taxels, r.taxel_voltage, status,
            r.position, load, untared, r.force_truth, r.taxels_truth,
        )  # fmt: skip

    @property
    def taxel_offset(self) -> np.ndarray:
        """What is subtracted from the taxels, N, (T,)."""
        return self._taxel_offset

    @taxel_offset.setter
    def taxel_offset(self, offset: np.ndarray) -> None:
        """What is subtracted from the taxels, N, (T,)."""
        self._taxel_offset, self._tared = offset, bool(offset.any())

    def move_zero(self, depth: float) -> None:
        """Call the present `depth` (m) zero."""
        self.zero += depth
        self._speed.clear()

    def _taxel(self, r: Reading, load: float) -> tuple[np.ndarray, np.ndarray]:
        """Force (N) and status of every taxel."""
        volts = r.taxel_voltage.size > 0
        raw, full = (r.taxel_voltage, TAXEL_FULL_SCALE) if volts else (r.taxel_force, math.inf)
        stuck = self._stuck_taxels.add(raw, load)
        force = self.calibration.taxel_force(raw) if volts else raw
        # NaN is not below anything, so a silent taxel has to pass the closer look, too.
        if stuck is None and self._all_calibrated and np.maximum.reduce(raw, initial=-math.inf) < full:
            return force, self._all_ok
        status = np.zeros(raw.size, np.uint8)
        status[np.isnan(force)] = UNCALIBRATED
        status[raw >= full] = SATURATED
        if stuck is not None:
            status[stuck] = STUCK
        status[np.isnan(raw)] = STALE
        return np.where(status == OK, force, np.nan), status
