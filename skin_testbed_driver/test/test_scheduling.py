"""What the driver asks of the scheduler, and what it leaves alone."""

import os
import subprocess
import sys

import pytest

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks Linux")
TELL = """
import os, threading
from skin_testbed_driver.scheduling import be_punctual
{before}
waiting = threading.Event()
thread = threading.Thread(target=waiting.wait, daemon=True)
thread.start()
be_punctual()
for task in (threading.get_native_id(), thread.native_id):
    slack = open(f"/proc/{{task}}/timerslack_ns").read().strip()
    print(slack, os.sched_getscheduler(task), os.getpriority(os.PRIO_PROCESS, task))
"""


def told(before: str) -> list[list[str]]:
    """Slack (ns), policy and niceness of two threads afterwards."""
    result = subprocess.run([sys.executable, "-c", TELL.format(before=before)], capture_output=True, text=True, check=True)
    assert not result.stderr
    return [line.split() for line in result.stdout.splitlines()]


@linux
def test_every_thread_wakes_without_slack_and_keeps_its_niceness():
    assert told("os.nice(3)") == [["1", str(os.SCHED_OTHER), str(os.nice(0) + 3)]] * 2


@linux
def test_a_policy_that_the_user_chose_stays():
    before = "os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))"
    assert {policy for _, policy, _ in told(before)} == {str(os.SCHED_BATCH)}
