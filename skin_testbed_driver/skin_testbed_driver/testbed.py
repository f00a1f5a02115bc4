"""The driver without ROS: a rig, what it senses, how it moves, and what stops it. One `tick` per sample.

`tick` belongs to the sampling thread; everything else may be called from any thread. Times are s of the driver's clock.
"""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skin_models.errors import SkinError
from skin_models.words import counted
from skin_testbed_driver.calibration import Calibration
from skin_testbed_driver.motion import Activity, Motion
from skin_testbed_driver.rig import Reading, Rig, RigError
from skin_testbed_driver.safety import HOW_TO_RESET, CommandError, Guard, Limits, Stop
from skin_testbed_driver.sensing import Sample, Sensing
from skin_testbed_driver.taring import Offsets, Taring
from skin_testbed_driver.trajectory import Trajectory
from skin_testbed_driver.zeroing import Outcome, Zeroing, ZeroSettings

# The zero lies some 20 um in the skin, where the force has risen by the threshold of the search; a stage rests a few um beside its target.
_IN_THE_AIR = -1e-4  # m, depth above which the plunger may still touch the skin
_WAITING = "waiting for the first reading of the encoder and of the load cell"


@dataclass(frozen=True)
class Status:
    """What the driver tells others about itself; see DriverState."""

    activity: Activity
    reason: str
    zeroed: bool
    tared: bool
    zero_count: int
    tare_count: int


class Testbed:
    """See the module's docstring. `start_depth` is the depth (m) that the plunger is taken to be at before the surface was found."""

    __test__ = False  # pytest: this is no test

    def __init__(
        self,
        rig: Rig,
        calibration: Calibration,
        limits: Limits,
        sample_rate: float = 100.0,
        start_depth: float = -0.002,
        speed_samples: int = 2,
    ) -> None:
        """Open the rig. Raises `RigError`."""
        self.rig, self.limits, self.period = rig, limits, 1.0 / sample_rate
        self._lock = threading.Lock()
        _open(rig, sample_rate)
        self._guard = Guard(limits, rig.travel)
        self._sensing = Sensing(calibration, 0.0, self.period, speed_samples)
        self._start_depth, self._begun = start_depth, False
        self._resuming = False  # True: the axis gets no command until its position is known
        self._motion = Motion(limits, start_depth)
        self._motion.stop(Stop(_WAITING, lost=True), 0.0)
        self._job, self._done = None, None
        self._zeroed = self._tared = False
        self._zero_count = self._tare_count = 0
        self._next = 0.0  # time of the next sample: the axis has been told where to be by then
        self._last: Sample | None = None
        self._status_of: tuple = ()  # what `_status` was made from

    def tick(self, t: float) -> Sample | None:
        """Take the sample of time `t`, check it, and command the axis for the next one. None until the rig has answered first."""
        with self._lock:
            self._next = t + self.period
            reading = self._read(t)
            if not self._begun and not self._begin_with(reading, t):
                return None
            sample = self._last = self._sensing.sample(reading)
            if self._resuming and not math.isnan(sample.depth):
                self._motion.stand(sample.depth, t)
                self._resuming = False
            if self.rig.moves:
                self._watch(sample, t)
            self._work(sample, t)
            if self.rig.moves and not self._resuming:
                self._command()
        return sample

    def prepare(self) -> None:
        """Call this when the sample of the last tick is out."""
        with self._lock:
            self.rig.prepare()

    def resume(self) -> None:
        """Call this before the first tick after a pause: others may have moved the axis, which is to rest where it is now."""
        with self._lock:
            self._resuming = self._begun

    def _begin_with(self, r: Reading, t: float) -> bool:
        """Whether the first reading is there: it says where the stage is. Raises `RigError` for a rig that contradicts its layout."""
        for name in ("taxel_voltage", "taxel_force"):
            values = getattr(r, name)
            if not isinstance(values, np.ndarray) or values.dtype != np.float64 or values.ndim != 1:
                raise RigError(f"the rig's {name} must be an array of float64, one per taxel: np.array(values, float)")
        taxels, places = max(r.taxel_voltage.size, r.taxel_force.size), len(self.rig.layout)
        if taxels != places:
            raise RigError(f"the rig reads {counted(taxels, 'taxel')}, its layout has {places}: what is not known is NaN, not left out")
        self._begun = not math.isnan(r.position) and not (math.isnan(r.force) and math.isnan(r.load_cell_voltage))
        if self._begun:
            self._sensing.zero = r.position - self._start_depth if self.rig.moves else 0.0
            self._motion.reset(self._start_depth, t)
        return self._begun

    def _watch(self, sample: Sample, t: float) -> None:
        target, _ = self._motion.advance(t)
        stop = self._guard.check(sample.position, sample.depth, target, sample.load)
        if stop is not None:
            self._stop(stop)

    def status(self) -> Status:
        """The present state: the same object as long as it is the same state."""
        with self._lock:
            stopped = self._motion.stopped
            activity = self._motion.activity(self._next)
            if self._job is not None and activity is Activity.READY:
                activity = Activity.MOVING
            zeros = (self._zeroed, self._tared, self._zero_count, self._tare_count)
            now = (activity, stopped, *zeros)
            if now != self._status_of:
                self._status_of = now
                self._status = Status(activity, stopped.reason if stopped else "", *zeros)
            return self._status

    def follow(self, command: Callable[[float], Trajectory]) -> None:
        """Follow the trajectory `command(now)`. One that cannot be followed stops the driver. Raises `CommandError`."""
        with self._lock:
            self._must_move()
            if self._motion.stopped is not None:
                raise CommandError(f"the driver is stopped ({self._motion.stopped.reason}): {HOW_TO_RESET}")
            try:
                if self._job is not None:
                    raise CommandError("zeroing or taring is under way")
                self._motion.follow(command(self._next), self._next)
            except CommandError as error:
                self._stop(Stop(f"command refused: {error}"))
                raise

    def stop(self, reason: str) -> None:
        """Brake to rest and stay stopped because of `reason`."""
        with self._lock:
            self._stop(Stop(reason))

    def reset(self) -> None:
        """End a stop. Raises `CommandError` while the plunger moves, or while what stopped it would do so again."""
        with self._lock:
            if not self._begun:
                raise CommandError(_WAITING)
            if self._motion.stopped is None:
                return
            last = self._last
            again = self._guard.check(last.position, last.depth, last.depth, last.load)
            if again is not None:
                raise CommandError(again.reason)
            self._motion.reset(last.depth, self._next)

    def zero(self, settings: ZeroSettings, done: Callable[[Outcome], None]) -> None:
        """Find the surface; `done(outcome)` comes from the sampling thread. Raises `CommandError` unless the driver is ready."""
        self._must_move()
        self._begin(Zeroing(settings), self._zero_found, done)

    def tare(self, duration: float, done: Callable[[Outcome], None]) -> None:
        """Measure the offsets for `duration` (s), as `zero`. Raises `CommandError` where the plunger may touch the skin."""
        if self.rig.moves and self._last is not None and self._last.depth > _IN_THE_AIR:
            depth = 1e3 * self._last.depth
            where = f"{depth:.3f} mm in the skin" if depth > 0.0 else f"only {-depth:.3f} mm above the surface and may touch the skin"
            raise CommandError(f"the plunger is {where}: retract it to {-1e3 * _IN_THE_AIR:g} mm above or more (free_air does), then tare")
        self._begin(Taring(max(round(duration / self.period), 1)), self._tare_found, done)

    def cancel(self) -> None:
        """End zeroing or taring: brake, and be ready again. Raises `CommandError` where neither is under way."""
        with self._lock:
            if self._job is None:
                raise CommandError("neither zeroing nor taring is under way")
            self._motion.rest(self._next)
            self._end_job(Outcome("cancelled"))

    def place(self, x: float, y: float) -> None:
        """Bring another point of the skin (m) under the plunger. Raises `CommandError` while they touch, `RigError` without motor."""
        with self._lock:
            if not all(map(math.isfinite, (x, y))):
                raise CommandError("the place is not a finite number")
            if self._last is not None and self._last.depth > 0.0:
                raise CommandError(f"the plunger is {1e3 * self._last.depth:.3f} mm in the skin")
            self.rig.place(x, y)

    def reset_tare(self) -> None:
        """Subtract nothing."""
        with self._lock:
            self._set_offsets(Offsets(0.0, np.zeros_like(self._sensing.taxel_offset)), tared=False)

    def at_rest(self) -> bool:
        """Whether the axis has nothing more to do."""
        with self._lock:
            return self._motion.at_rest(self._next)

    def offsets(self) -> Offsets:
        """What is subtracted now."""
        with self._lock:
            return Offsets(self._sensing.force_offset, self._sensing.taxel_offset)

    def close(self) -> None:
        """Release the rig."""
        with self._lock:
            self._end_job(Outcome("the driver was closed"))
            self.rig.close()

    def _must_move(self) -> None:
        if not self.rig.moves:
            raise CommandError("this rig replays a recording: it cannot be moved")

    def _read(self, t: float) -> Reading:
        try:
            return self.rig.read()
        except RigError as error:
            self._stop(Stop(str(error), lost=True))
            return Reading(math.nan, taxel_voltage=np.full(len(self.rig.layout.names), np.nan))

    def _command(self) -> None:
        try:
            if self._motion.stopped is not None and self._motion.stopped.lost:
                self.rig.halt()
            else:
                depth, speed = self._motion.at(self._next)
                self.rig.command(depth + self._sensing.zero, speed)
        except RigError as error:
            self._stop(Stop(str(error), lost=True))

    def _stop(self, stop: Stop) -> None:
        self._motion.stop(stop, self._next)
        self._end_job(Outcome(f"stopped: {stop.reason}"))

    def _begin(self, job, found: Callable, done: Callable[[Outcome], None]) -> None:
        with self._lock:
            if self._job is not None:
                raise CommandError("zeroing or taring is under way")
            if self._motion.stopped is not None:
                raise CommandError(f"the driver is stopped ({self._motion.stopped.reason}): {HOW_TO_RESET}")
            if self._motion.activity(self._next) is not Activity.READY:
                raise CommandError("the plunger is moving: wait until it rests")
            self._job, self._found, self._done = job, found, done

    def _work(self, sample: Sample, t: float) -> None:
        if self._job is None:
            return
        outcome = self._job.step(self._motion, sample, self._next)
        if outcome is not None:
            if outcome.value is not None:
                self._found(outcome.value)
            self._end_job(outcome)

    def _end_job(self, outcome: Outcome) -> None:
        done, self._job, self._done = self._done, None, None
        if done is not None:
            done(outcome)

    def _zero_found(self, depth: float) -> None:
        self._sensing.move_zero(depth)
        self._last = self._last._replace(depth=self._last.depth - depth)
        self._motion.shift(-depth)
        self._zeroed = True
        self._zero_count += 1

    def _tare_found(self, offsets: Offsets) -> None:
        self._set_offsets(offsets, tared=True)

    def _set_offsets(self, offsets: Offsets, tared: bool) -> None:
        self._sensing.force_offset, self._sensing.taxel_offset = offsets.force, offsets.taxels
        self._tare_count += self._tared or tared
        self._tared = tared


def _open(rig: Rig, sample_rate: float) -> None:
    """Open the rig. Raises `RigError` whatever is wrong: drivers of hardware have errors of their own."""
    try:
        rig.open(sample_rate)
    except SkinError:
        raise
    except Exception as error:
        raise RigError(f"the rig cannot be opened: {type(error).__name__}: {error}") from error
