"""The thread that ticks by /clock: it follows jumps both ways, and ends at once where the clock stands still."""

import time

import pytest

pytest.importorskip("rclpy")

from rclpy.clock import ROSClock
from rclpy.time import Time

from skin_models.ros.processes import wait_until
from skin_models.ros.ticking import Ticking


def run_to(clock, start, stop):
    """Let simulated time go from `start` to `stop` (s) in steps of 10 ms."""
    for i in range(round((stop - start) / 0.01) + 1):
        clock.set_ros_time_override(Time(seconds=start + 0.01 * i, clock_type=clock.clock_type))
        time.sleep(0.005)


def test_it_ticks_on_after_a_jump_of_the_clock_and_ends_while_it_stands_still():
    clock = ROSClock()
    clock._set_ros_time_is_active(True)
    clock.set_ros_time_override(Time(seconds=1000.0, clock_type=clock.clock_type))
    ticks = []
    ticking = Ticking(lambda: ticks.append(clock.now().nanoseconds * 1e-9), 20.0, clock)
    ticking.start()
    run_to(clock, 1000.0, 1000.5)
    wait_until(lambda: 6 <= len(ticks) <= 12, 5.0, "ticks")
    for start in (2.0, 5000.0, 4999.0):
        ticks.clear()
        run_to(clock, start, start + 0.5)
        assert 6 <= len(ticks) <= 13 and all(start <= t <= start + 0.5 for t in ticks)
    ticking.report()
    run_to(clock, 4999.5, 5000.0)
    report = ticking.report()
    assert 10.0 <= report.rate <= 25.0 and not report.stands  # of its clock, which is faster than this one
    assert ticking.report().stands
    began = time.monotonic()
    ticking.end()
    assert not ticking.is_alive() and time.monotonic() - began < 0.5
