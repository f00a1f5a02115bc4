"""A thread that calls at absolute deadlines, so that lateness never adds up."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from rclpy.clock import Clock
from rclpy.duration import Duration


@dataclass(frozen=True)
class TickReport:
    """How well the thread kept its time since the last report."""

    rate: float  # Hz, achieved
    skipped: int  # deadlines that passed while a tick was still at work
    late_p99: float  # s


class Ticking(threading.Thread):
    """Calls `tick()` `rate` times per second of `clock` until told to end. Deadlines that have passed are skipped and counted."""

    def __init__(self, tick: Callable[[], None], rate: float, clock: Clock) -> None:
        """`rate` in Hz of `clock`; nothing happens before `start`."""
        super().__init__(name="ticking", daemon=True)
        self._tick, self._period, self._clock = tick, 1.0 / rate, clock
        self._ending, self._skipped, self._late, self._since = False, 0, [], time.monotonic()

    def run(self) -> None:
        """Sleep until a deadline, tick, and set the next one a period later; by /clock where that is used."""
        sleep, now = (self._sleep_simulated, self._simulated) if self._clock.ros_time_is_active else (self._sleep, time.monotonic)
        deadline = now()
        while not self._ending:
            deadline = min(deadline, now() + 2.0 * self._period)  # a clock that jumped back does not stop the skin
            sleep(deadline)
            self._late.append(now() - deadline)
            self._tick()
            deadline += self._period
            missed = int((now() - deadline) / self._period)
            if missed > 0:
                self._skipped += missed
                deadline += missed * self._period

    def end(self) -> None:
        """End after the present tick, and wait for that."""
        self._ending = True
        if self.is_alive() and threading.current_thread() is not self:
            self.join(timeout=2.0)

    def report(self) -> TickReport:
        """How it went since the last call."""
        late, self._late, skipped, self._skipped = self._late, [], self._skipped, 0
        now, since = time.monotonic(), self._since
        self._since = now
        return TickReport(len(late) / max(now - since, 1e-9), skipped, float(np.percentile(late, 99)) if late else 0.0)

    def _sleep(self, deadline: float) -> None:
        delay = deadline - time.monotonic()
        if delay > 0.0:
            time.sleep(delay)

    def _simulated(self) -> float:
        return self._clock.now().nanoseconds * 1e-9

    def _sleep_simulated(self, deadline: float) -> None:
        """Follow /clock, in pieces short enough to notice the end."""
        while not self._ending and (delay := deadline - self._simulated()) > 0.0:
            self._clock.sleep_for(Duration(seconds=min(delay, 0.1)))
