"""A thread that calls at absolute deadlines, so that lateness never adds up."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from rclpy.clock import Clock, JumpHandle, JumpThreshold
from rclpy.duration import Duration


@dataclass(frozen=True)
class TickReport:
    """How well the thread kept its time since the last report."""

    rate: float  # Hz of the clock, achieved
    skipped: int  # deadlines that passed while a tick was still at work
    late_p99: float  # s
    stands: bool = False  # /clock stands still


class Ticking(threading.Thread):
    """Calls `tick()` `rate` times per second of `clock` until told to end. Deadlines that have passed are skipped and counted."""

    def __init__(self, tick: Callable[[], None], rate: float, clock: Clock) -> None:
        """`rate` in Hz of `clock`; nothing happens before `start`."""
        super().__init__(name="ticking", daemon=True)
        self._tick, self._period, self._clock = tick, 1.0 / rate, clock
        self._ending, self._skipped, self._late = False, 0, []
        self._simulating = clock.ros_time_is_active
        self._now = self._simulated if self._simulating else time.monotonic
        self._since = self._now()
        self._news, self._listener = threading.Event(), None  # /clock has moved, and what tells of it

    def run(self) -> None:
        """Sleep until a deadline, tick, and set the next one a period later; by /clock where that is used."""
        sleep, now = self._sleep, self._now
        if self._simulating:
            sleep, self._listener = self._sleep_simulated, self._listening()
        deadline = now()
        while not self._ending:
            sleep(deadline)
            deadline = min(deadline, now())  # a clock that jumped back does not stop the skin
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
        self._news.set()
        if self.is_alive() and threading.current_thread() is not self:
            self.join(timeout=2.0)

    def report(self) -> TickReport:
        """How it went since the last call."""
        late, self._late, skipped, self._skipped = self._late, [], self._skipped, 0
        now, since = self._now(), self._since
        self._since = now
        rate = len(late) / (now - since) if now > since else 0.0
        return TickReport(rate, skipped, float(np.percentile(late, 99)) if late else 0.0, now == since)

    def _sleep(self, deadline: float) -> None:
        delay = deadline - time.monotonic()
        if delay > 0.0:
            time.sleep(delay)

    def _simulated(self) -> float:
        return self._clock.now().nanoseconds * 1e-9

    def _listening(self) -> JumpHandle:
        """Every message on /clock is a jump of the clock. Its own `sleep_until` waits for a time that a reset may have put far ahead."""
        tick = Duration(nanoseconds=1)
        threshold = JumpThreshold(min_forward=tick, min_backward=Duration(nanoseconds=-1), on_clock_change=True)
        return self._clock.create_jump_callback(threshold, post_callback=lambda _: self._news.set())

    def _sleep_simulated(self, deadline: float) -> None:
        """Until /clock says so, or has gone back by more than a period."""
        while not self._ending and 0.0 < deadline - self._simulated() <= 2.0 * self._period:
            self._news.wait(0.1)
            self._news.clear()
