"""The thread that samples: absolute deadlines, so that lateness never adds up."""

import threading
import time
from collections.abc import Callable

from skin_testbed_driver.scheduling import be_punctual, be_urgent
from skin_testbed_driver.statistics import LoopStatistics


class SamplingThread(threading.Thread):
    """Calls `tick(stamp)` once per period until told to end.

    A rig that owns its time gets every sample, one period after the last. In real time it catches up after a delay, because everybody
    else lives by the wall clock. At another `time_scale` others live by /clock, and simulated time itself is late. For hardware the stamp
    is the clock's reading, and samples whose time has passed are skipped.
    """

    def __init__(
        self,
        tick: Callable[[int], None],
        clock: Callable[[], int],
        period: float,
        statistics: LoopStatistics,
        owned: int | None = None,
        time_scale: float = 1.0,
        priority: int = 0,
        complain: Callable[[str], object] = print,
    ) -> None:
        """`clock()` in ns. `owned`: stamp (ns) of the first sample of a rig that owns its time, else None.

        `priority` > 0 asks for real-time scheduling; `complain(sentence)` hears where that is not to be had.
        """
        super().__init__(name="sampling", daemon=True)
        self._tick, self._clock, self._statistics = tick, clock, statistics
        self._period, self._wall_period, self._owned = period, period / time_scale, owned
        self._real_time = time_scale == 1.0
        self._priority, self._complain = priority, complain
        self._ending = False

    def run(self) -> None:
        """Sample until `end`: sleep to a deadline, tick, and set the next one a period later."""
        self._hurry()
        deadline = time.monotonic()
        while not self._ending:
            delay = deadline - time.monotonic()
            if delay > 0.0:
                time.sleep(delay)
            self._statistics.tick(time.monotonic(), deadline)
            self._tick(self._stamp())
            deadline = self._after(deadline)

    def end(self) -> None:
        """End after the present sample, and wait for that."""
        self._ending = True
        if self.is_alive() and threading.current_thread() is not self:
            self.join()

    def _hurry(self) -> None:
        be_punctual()
        if not self._priority:
            return
        try:
            be_urgent(self._priority)
        except (AttributeError, OSError) as error:
            self._complain(f"no real-time priority for sampling ({error}): it needs CAP_SYS_NICE or an rtprio limit; going on without")

    def _stamp(self) -> int:
        if self._owned is None:
            return self._clock()
        stamp = self._owned
        self._owned += round(1e9 * self._period)
        return stamp

    def _after(self, deadline: float) -> float:
        deadline += self._wall_period
        late = time.monotonic() - deadline
        if self._owned is not None:
            return deadline if self._real_time else deadline + max(late, 0.0)
        missed = max(int(late / self._wall_period), 0)
        self._statistics.skip(missed)
        return deadline + missed * self._wall_period
